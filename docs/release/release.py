"""Build what is published, check it, write checksums and the conda recipe; with --upload hand it to the index.

python docs/release/release.py            wheel, source, SHA256SUMS and recipe in out/release
python docs/release/release.py --upload   the same, then `twine upload`, which asks for what it needs
"""

from __future__ import annotations

import argparse
import hashlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
OUT = ROOT / "out" / "release"
RECIPE = Path(__file__).with_name("meta.yaml")


def version() -> str:
    """The version, which changelog and citation must name too."""
    found = re.search(
        r'"([^"]+)"', (ROOT / "fecontact/common/version.py").read_text(encoding="utf-8").split("VERSION")[1]
    )
    assert found, "fecontact/common/version.py names no version"
    for file, line in (("CHANGELOG.md", f"## [{found[1]}]"), ("CITATION.cff", f"version: {found[1]}")):
        if line not in (ROOT / file).read_text(encoding="utf-8"):
            raise SystemExit(f"{file} has no line with {line!r}: write it before the release.")
    return found[1]


def checksums(files: list[Path]) -> dict[str, str]:
    """SHA-256 of files by their names."""
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


def recipe(release: str, digest: str) -> str:
    """The conda recipe of a source archive."""
    text = RECIPE.read_text(encoding="utf-8")
    return text.replace("VERSION", release).replace("DIGEST", digest)


def built(out: Path) -> list[Path]:
    """Source archive and the wheel made from it, in an empty folder, checked as the index checks them."""
    shutil.rmtree(out, ignore_errors=True)
    subprocess.run([sys.executable, "-m", "build", "--outdir", out, ROOT], check=True)
    files = sorted(path for path in out.iterdir() if path.suffix in (".whl", ".gz"))
    subprocess.run([sys.executable, "-m", "twine", "check", "--strict", *files], check=True)
    return files


def main(arguments: list[str] | None = None) -> None:
    """Build, check, write, and upload if asked to."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--upload", action="store_true", help="hand wheel and source to the index by twine")
    parser.add_argument("--out", type=Path, default=OUT, help="folder, emptied first")
    given = parser.parse_args(arguments)
    release, files = version(), built(given.out)
    sums = checksums(files)
    listed = "".join(f"{digest}  {name}\n" for name, digest in sums.items())
    (given.out / "SHA256SUMS").write_text(listed, encoding="utf-8")
    digest = sums[f"fecontact-{release}.tar.gz"]
    (given.out / "meta.yaml").write_text(recipe(release, digest), encoding="utf-8")
    print(f"{listed}wrote {given.out}")
    if given.upload:
        subprocess.run([sys.executable, "-m", "twine", "upload", *files], check=True)


if __name__ == "__main__":
    main()
