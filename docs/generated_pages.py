"""Pages of the site that are made, not written. They lie in docs/generated, which is not in git.

`make docs` calls `prepare` before the pages are read: the chapters of the verification come from the record of the last
run, two measured pages that take some seconds are measured, and the others, unless they were made in this checkout, say
which command makes them.
"""

from __future__ import annotations

import json
from contextlib import redirect_stdout
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).parent
FOLDER = HERE / "generated"
#: Written by `make test`, `make verification` and whatever else runs `tests/verification` with `--figures`.
RECORD = HERE.parent / "out" / "verification.json"
#: Measured pages: title, and the script that writes the page; `make pages` runs them all.
MEASURED = {
    "accuracy": ("Accuracy and time: two spheres", "docs/accuracy.py"),
    "half_space": ("Half-spaces: errors and times", "docs/half_space_page.py"),
    "adaptive": ("Accuracy on demand: error, unknowns and time", "tests/benchmarks/bench_accuracy.py"),
    "outlines": ("Outlines and recovered pressures against the truth", "tests/benchmarks/bench_outlines.py"),
    "solvers": ("Solvers: hard cases, iterations and time", "docs/solvers.py"),
    "baselines": ("Comparison with penalties and load increments", "docs/baselines_page.py"),
}

#: Those that the site measures itself, by `measure` of their scripts.
QUICK = ("half_space", "baselines")


def write(name: str, text: str) -> Path:
    """Write the page docs/generated/NAME.md, unless it is there already as it is: it need not be read anew then."""
    path = FOLDER / f"{name}.md"
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")
    return path


def prepare(quick: tuple[str, ...] = QUICK) -> None:
    """Make what the site lacks."""
    for name, (title, script) in MEASURED.items():
        if (FOLDER / f"{name}.md").exists():
            continue
        if name in quick:
            with redirect_stdout(None):
                import_module(Path(script).stem).measure()
        else:
            write(name, f"# {title}\n\nNot measured in this checkout: `python {script}` (or `make pages`) does so.\n")
    verification()


def verification() -> None:
    """Write the chapters of the verification, or how to come by them."""
    pages = {"verification": "# Chapters\n\nNo run is recorded in this checkout: `make verification` records one.\n"}
    if RECORD.exists():
        import manual  # draws pictures of the tests, and needs what they need

        pages = manual.pages(json.loads(RECORD.read_text(encoding="utf-8")))
        manual.draw(RECORD.stat().st_mtime)
    for old in (FOLDER / "verification").glob("*.md"):
        if f"verification/{old.stem}" not in pages:
            old.unlink()
    for name, text in pages.items():
        write(name, text)
