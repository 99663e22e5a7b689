"""What is published says the same everywhere: the recipe, the checksums, the version."""

import hashlib
import importlib.util
import re
import tomllib
from pathlib import Path

import pytest

from fecontact.common.version import VERSION

ROOT = Path(__file__).parents[2]
#: Names that the channel of conda has for packages.
CONDA = {"gmsh": "python-gmsh", "matplotlib": "matplotlib-base"}


@pytest.fixture(scope="module")
def release():
    spec = importlib.util.spec_from_file_location("release", ROOT / "docs" / "release" / "release.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def requirement(text):
    name, bound = re.fullmatch(r"([\w-]+)\s*(>=[\d.]+)?", text).groups()
    return CONDA.get(name, name), bound


def listed(text, section):
    """Requirements under a heading of the recipe's requirements."""
    block = text.partition(f"  {section}:\n")[2]
    return {requirement(line) for line in re.match(r"((?:    - .*\n)+)", block)[1].replace("    - ", "").splitlines()}


def test_the_recipe_needs_what_the_package_needs(release):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    recipe = release.RECIPE.read_text(encoding="utf-8")
    python = ("python", project["project"]["requires-python"])
    needed = {requirement(text) for text in project["project"]["dependencies"]} | {python}
    assert listed(recipe, "run") == needed
    assert listed(recipe, "host") == {requirement(text) for text in project["build-system"]["requires"]} | {
        python,
        ("pip", None),
    }
    assert f"license: {project['project']['license']}\n" in recipe
    assert f"fecontact = {project['project']['scripts']['fecontact']}\n" in recipe


def test_the_recipe_is_filled_in(release):
    assert release.version() == VERSION
    made = release.recipe(VERSION, "0" * 64)
    assert f'version: "{VERSION}"' in made
    assert f"fecontact-{VERSION}.tar.gz" in made
    assert "sha256: " + "0" * 64 in made


def test_checksums(release, tmp_path):
    file = tmp_path / "a.whl"
    file.write_bytes(b"wheel")
    assert release.checksums([file]) == {"a.whl": hashlib.sha256(b"wheel").hexdigest()}


def test_nothing_is_uploaded_unless_asked(release, tmp_path, monkeypatch):
    """The commands that are run, with stand-ins for the programs."""
    commands = []

    def stand_in(command, check):
        assert check
        commands.append([str(part) for part in command])
        if "build" in command:
            tmp_path.mkdir(exist_ok=True)
            for name in (f"fecontact-{VERSION}.tar.gz", f"fecontact-{VERSION}-py3-none-any.whl"):
                (tmp_path / name).write_bytes(name.encode())

    monkeypatch.setattr(release.subprocess, "run", stand_in)
    release.main(["--out", str(tmp_path)])
    assert [command[2:4] for command in commands] == [["build", "--outdir"], ["twine", "check"]]
    sums = (tmp_path / "SHA256SUMS").read_text().splitlines()
    assert [line.split()[1] for line in sums] == [
        f"fecontact-{VERSION}-py3-none-any.whl",
        f"fecontact-{VERSION}.tar.gz",
    ]
    assert sums[1].split()[0] in (tmp_path / "meta.yaml").read_text()
    release.main(["--out", str(tmp_path), "--upload"])
    files = [str(tmp_path / line.split()[1]) for line in sums]
    assert commands[-1][2:] == ["twine", "upload", *files]
