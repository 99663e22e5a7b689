"""Wheel and source as a person gets them: built, installed in clean environments, used (make package)."""

import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import threading
import zipfile
from email.parser import BytesParser
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from fecontact.common.version import VERSION

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.timeout(900)  # pip unpacks half a gigabyte

PYTHONS = ("3.11", "3.12", "3.13")
#: Largest size of an environment with what the package needs and nothing else, MB; with MKL it would be 1400.
BARE = 600
USE = """
import importlib.util
import fecontact as fc
plate = fc.ElasticBody(
    fc.shapes.block((4.0, 4.0, 2.0), (6, 6, 3)), fc.Material(E=70e3, nu=0.33), contact="top", supports={"bottom": "xyz"}
)
ball = fc.RigidBody(fc.Sphere(10.0)).placed((2.0, 2.0, 2.0))
result = fc.Scene([plate, ball], [fc.Contact(plate, ball)]).solve(forces={ball: (0, 0, -100.0)}, accuracy=0.1)
assert abs(result.contacts[0].max_pressure / 1061 - 1) < 0.04, result
print(importlib.util.find_spec("pypardiso") is not None)
"""


def clean():
    """The environment without what could lead back to the checkout."""
    return {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}


def run(*command, cwd):
    done = subprocess.run([str(part) for part in command], cwd=cwd, env=clean(), capture_output=True, text=True)
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def interpreter(version):
    """An interpreter of a version, on the path or among those of pyenv, whose shims may lead nowhere."""
    name = f"python{version}"
    for path in (shutil.which(name), *sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/{name}"))):
        if path and subprocess.run([path, "--version"], capture_output=True, check=False).returncode == 0:
            return path
    return None


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder with the source archive, and the wheel that was built from it."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--outdir", folder, ROOT, cwd=folder)
    return folder


@pytest.fixture(scope="module")
def wheel(built):
    (path,) = built.glob("*.whl")
    return path


class Quiet(SimpleHTTPRequestHandler):
    """Files of a folder, without a line for each."""

    def log_message(self, *arguments):
        """Nothing."""


@pytest.fixture(scope="module")
def index(built, tmp_path_factory):
    """Address of an index on this machine, simple pages with digests (PEP 503), that has this package alone."""
    root = tmp_path_factory.mktemp("index")
    page = root / "simple" / "fecontact"
    page.mkdir(parents=True)
    links = ""
    for file in built.iterdir():
        shutil.copy(file, page)
        links += f'<a href="{file.name}#sha256={hashlib.sha256(file.read_bytes()).hexdigest()}">{file.name}</a>\n'
    (page / "index.html").write_text(f"<!DOCTYPE html>\n{links}")
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=root)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/simple"
        server.shutdown()


@pytest.fixture(scope="module", params=PYTHONS)
def environment(request, index, tmp_path_factory):
    """A new environment in which the package is installed by its name, from an index: its folder of programs."""
    python = interpreter(request.param)
    if python is None:
        pytest.skip(f"python{request.param} is not on this machine")
    folder = tmp_path_factory.mktemp(f"python{request.param}")
    run(python, "-m", "venv", folder / "env", cwd=folder)
    pip(folder / "env" / "bin", f"fecontact=={VERSION}", index)
    yield folder / "env" / "bin"
    shutil.rmtree(folder)


def pip(programs, what, index):
    pins = ROOT / "constraints" / "pinned.txt"
    command = ("-m", "pip", "install", "--quiet", "--constraint", pins, "--extra-index-url", index, what)
    run(programs / "python", *command, cwd=programs)


def test_names_and_contents(built, wheel):
    (source,) = built.glob("*.tar.gz")
    assert wheel.name == f"fecontact-{VERSION}-py3-none-any.whl"
    assert source.name == f"fecontact-{VERSION}.tar.gz"
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {"fecontact/py.typed", "fecontact/examples/knee.py", "fecontact/meshes/bracket.step"} <= names
    assert not [name for name in names if name.endswith(".pyc") or name.split("/")[0] in ("tests", "docs")]
    assert wheel.stat().st_size < 3e6
    with tarfile.open(source) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    assert {"README.md", "LICENSE", "Makefile", "docs/conf.py", "tests/unit/test_docs.py", "meshes/MESHES.md"} <= inside
    assert source.stat().st_size < 10e6


def test_the_description_has_no_links_that_lead_nowhere(wheel):
    with zipfile.ZipFile(wheel) as archive:
        metadata = BytesParser().parsebytes(archive.read(f"fecontact-{VERSION}.dist-info/METADATA"))
    text = str(metadata.get_payload())
    assert metadata["Version"] == VERSION
    assert "pip install" in text
    assert "](docs" not in text
    assert "](https" in text


def test_the_index_takes_wheel_and_source(built):
    """As `twine check --strict` does before an upload; the client is an extra, `release`."""
    pytest.importorskip("twine")
    files = [path for path in built.iterdir() if path.suffix in (".whl", ".gz")]
    assert run(sys.executable, "-m", "twine", "check", "--strict", *files, cwd=built).count("PASSED") == 2


def test_citation_and_changelog_name_the_version():
    assert f"version: {VERSION}" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"## [{VERSION}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_bare(environment, tmp_path):
    assert run(environment / "fecontact", "--version", cwd=tmp_path).strip() == f"fecontact {VERSION}"
    assert "knee" in run(environment / "fecontact", "examples", "list", cwd=tmp_path)
    run(environment / "fecontact", "examples", "copy", "bracket", cwd=tmp_path)
    assert (tmp_path / "bracket.step").exists()
    assert run(environment / "python", "-c", USE, cwd=tmp_path).strip() == "False"
    # nothing that is slow to load, or that a machine without a display lacks, before it is needed
    loaded = run(environment / "python", "-c", "import sys, fecontact; print(*sys.modules)", cwd=tmp_path).split()
    assert not {"gmsh", "matplotlib", "scipy", "meshio", "osqp"} & set(loaded)
    files = (path for path in environment.parent.rglob("*") if path.is_file() and not path.is_symlink())
    assert sum(path.stat().st_size for path in files) < 1e6 * BARE


def test_with_extras(environment, index, tmp_path):
    if not run(environment / "python", "--version", cwd=tmp_path).startswith(f"Python {PYTHONS[0]}"):
        pytest.skip("extras are tried with one Python")
    pip(environment, f"fecontact[fast,qp,amg,xdmf,view]=={VERSION}", index)
    assert run(environment / "python", "-c", USE, cwd=tmp_path).strip() == "True"
    run(environment / "python", "-c", "import pyamg, h5py, quadprog, pyvista", cwd=tmp_path)
