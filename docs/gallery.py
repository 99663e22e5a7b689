"""Run the examples of docs/gallery.md: keep what they print for the site, and draw the gallery's pictures anew.

python docs/gallery.py                            every example; what it prints goes to docs/generated/printed
python docs/gallery.py --pictures --only bricks   these; their pictures go to docs/images/gallery
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "gallery.md"
IMAGES = ROOT / "docs" / "images" / "gallery"
PRINTED = ROOT / "docs" / "generated" / "printed"
#: Pictures wider than this are made smaller, pixels.
WIDEST = 1200
RUN = re.compile(r"^Run: \[`python examples/(\w+)\.py([^`]*)`\].*$", flags=re.MULTILINE)


@dataclass(frozen=True)
class Entry:
    """A section of the page: an example, its arguments, and the pictures that are shown of it."""

    script: str
    arguments: tuple[str, ...]
    pictures: tuple[str, ...]

    @property
    def printed(self) -> Path:
        """Where what it prints is kept."""
        return PRINTED / f"{'_'.join([self.script, *self.arguments])}.txt"


def entries(page: str) -> Iterator[Entry]:
    """Read the sections of the page."""
    for section in re.split(r"^(?=## )", page, flags=re.MULTILINE)[1:]:
        if found := RUN.search(section):
            pictures = re.findall(r"\]\(images/gallery/(.+?)\.png\)", section)
            yield Entry(found[1], tuple(found[2].split()), tuple(pictures))


def run(entry: Entry, with_pictures: bool) -> None:
    """Run an example in a folder of its own; keep what it prints and, where asked for, its pictures."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(ROOT / "examples" / f"{entry.script}.py"), *entry.arguments]
        printed = subprocess.run(command, cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout
        entry.printed.parent.mkdir(parents=True, exist_ok=True)
        entry.printed.write_text(printed.strip("\n") + "\n", encoding="utf-8")
        print(f"== {' '.join([entry.script, *entry.arguments])}\n{printed}", flush=True)
        for picture in entry.pictures if with_pictures else ():
            save_smaller(Path(folder) / "out" / f"{picture}.png", IMAGES / f"{picture}.png")


def save_smaller(source: Path, target: Path) -> None:
    """Copy a picture, no wider than `WIDEST`, with a palette: drawings need no more than 256 colours."""
    target.parent.mkdir(parents=True, exist_ok=True)
    picture = Image.open(source).convert("RGB")
    picture.thumbnail((WIDEST, WIDEST))
    picture.quantize(256).save(target, optimize=True)


def with_listings(page: str) -> str:
    """The page as the site shows it: with each example's docstring, code and, if it was run here, what it prints."""
    shown = {entry.printed.stem: entry for entry in entries(page)}

    def listed(match: re.Match[str]) -> str:
        entry = shown["_".join([match[1], *match[2].split()])]
        code = (ROOT / "examples" / f"{entry.script}.py").read_text(encoding="utf-8")
        about = (ast.get_docstring(ast.parse(code)) or "").partition("\n\n")[2].partition("Run: ")[0].strip()
        parts = [about, folded(f"The code, {entry.script}.py", "python", code)]
        if entry.printed.exists():
            parts.append(folded("What it prints", "text", entry.printed.read_text(encoding="utf-8")))
        return "\n\n".join(part for part in [*parts, match[0]] if part)

    return RUN.sub(listed, page)


def folded(title: str, language: str, text: str) -> str:
    """A listing that is opened by a click."""
    return f"<details><summary>{title}</summary>\n\n````{language}\n{text.rstrip()}\n````\n\n</details>"


def main(only: list[str] | None, with_pictures: bool) -> None:
    """Run the examples of the page, or those of the names `only`."""
    for entry in entries(PAGE.read_text(encoding="utf-8")):
        if only is None or entry.script in only:
            run(entry, with_pictures)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    known = sorted({entry.script for entry in entries(PAGE.read_text(encoding="utf-8"))})
    parser.add_argument("--only", nargs="+", choices=known, metavar="NAME", help="examples to run")
    parser.add_argument("--pictures", action="store_true", help="draw the pictures of the page anew")
    given = parser.parse_args()
    main(given.only, given.pictures)
