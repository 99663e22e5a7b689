"""The chapters of the verification manual from the record of a run: `pytest tests/verification --figures FILE`."""

from __future__ import annotations

import os
import platform
import re
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "generated" / "images"
#: Files of tests in the order of the chapters, from closed forms to the hardest; others follow.
ORDER = (
    *(
        "hertz",
        "sections",
        "halfspace",
        "halfspace_friction",
        "rolling",
        "adhesion_limits",
        "halfspace_couplings",
        "couplings",
        "patch",
        "patch_interfaces",
        "patch_kites",
    ),
    *("mesh_io", "elements", "ancf", "ancf_motion", "supports", "scenes", "finite_bodies", "hard_cases", "step_bodies"),
    *("stability", "solver_robustness", "scale"),
)
#: Picture shown at the head of a chapter, drawn anew each time.
PICTURES = {
    "sections": ("hertz_line", "Pressure of a line contact on the coarsest mesh and on a finer one."),
    "hard_cases": ("pin_and_layer", "A pin in a hole against Michell's series; a receding layer against transforms."),
    "finite_bodies": ("shear_below", "Shear stress below a sphere on a plane, on the axis."),
}
HEAD = "| case | quantity | target | obtained | error | allowed | dofs | CPU s |\n|---|---|---|---|---|---|---|---|"


def pages(record: dict[str, Any]) -> dict[str, str]:
    """Text of all pages by their place in docs/generated."""
    return {"verification": head(record)} | {f"verification/{k}": text for k, text in chapters(record).items()}


def draw(since: float) -> None:
    """Draw the pictures that are older than the record, which was written at the time `since`."""
    import manual_pictures  # brings the tests that it draws

    IMAGES.mkdir(parents=True, exist_ok=True)
    for name, _ in PICTURES.values():
        path = IMAGES / f"{name}.png"
        if not path.exists() or path.stat().st_mtime < since:
            getattr(manual_pictures, name)(path)


def head(record: dict[str, Any]) -> str:
    """The manual's first page: what was run, and a table of the chapters."""
    figures, ends = record["figures"], record["tests"]
    outcomes = {kind: sum(e["outcome"] == kind for e in ends) for kind in ("passed", "failed", "skipped")}
    held = [f for f in figures if f["within"] is not None]
    inside = sum(f["error"] < f["within"] for f in held)
    lines = [
        "# Chapters",
        "",
        "Generated from a run of `tests/verification`; nothing here is typed.",
        "",
        f"{len(ends)} tests: {outcomes['passed']} passed, {outcomes['failed']} failed, {outcomes['skipped']} skipped. "
        f"{len(figures)} figures, of which {len(held)} are held to a tolerance and {inside} lie within it.",
    ]
    amiss = [f"- {e['outcome']}: `{e['test'].split('/')[-1]}` {e['reason']}" for e in ends if e["outcome"] != "passed"]
    lines += ["", machine(), *(["", "Not passed:", "", *amiss] if amiss else [])]
    lines += ["", "| chapter | figures |", "|---|---|"]
    stems = []
    for file, tests in _chapters(ends):
        names = {e["test"] for e in tests}
        stems.append(_stem(file))
        count = sum(f["test"] in names for f in figures)
        lines.append(f"| [{_title(ROOT / file)}](verification/{stems[-1]}.md) | {count} |")
    contents = [f"verification/{stem}" for stem in stems]
    return "\n".join([*lines, "", "```{toctree}", ":hidden:", *contents, "```"]) + "\n"


def chapters(record: dict[str, Any]) -> dict[str, str]:
    """Text of each chapter by its name: a section for each test, a row for each figure."""
    pages = {}
    for file, tests in _chapters(record["tests"]):
        stem = _stem(file)
        body = [f"# {_title(ROOT / file)}", "", f"Generated from a run of [`{file}`](../../../{file})."]
        if stem in PICTURES:
            name, caption = PICTURES[stem]
            body += ["", f"![{caption}](../images/{name}.png)", "", caption]
        for name, same in groupby(tests, key=lambda e: e["test"].split("[")[0]):
            body += _section(name, list(same), record["figures"])
        pages[stem] = "\n".join(body) + "\n"
    return pages


def machine() -> str:
    """What the run was made with."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "scikit-fem"))
    return f"Python {platform.python_version()}, {packages}; {platform.machine()}, {os.cpu_count()} cores."


def _chapters(ends: list[dict[str, Any]]) -> list[tuple[str, list[dict[str, Any]]]]:
    """Files of tests with what became of theirs, in the order of the manual."""
    files: dict[str, list[dict[str, Any]]] = {}
    for end in ends:
        files.setdefault(end["test"].split("::")[0], []).append(end)
    place = {stem: n for n, stem in enumerate(ORDER)}
    ordered = sorted(files, key=lambda file: (place.get(_stem(file), len(ORDER)), file))
    return [(file, _in_order(file, files[file])) for file in ordered]


def _in_order(file: str, ends: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Put tests that several processes have run into the order of their file."""
    text = (ROOT / file).read_text(encoding="utf-8")
    return sorted(ends, key=lambda e: text.find(f"def {e['test'].split('::')[-1].split('[')[0]}("))


def _stem(file: str) -> str:
    return Path(file).stem.removeprefix("test_")


def _title(path: Path) -> str:
    first = re.match(r'"""(.*?)(?:"""|\n\n)', path.read_text(encoding="utf-8"), flags=re.DOTALL)
    return " ".join(first[1].split()).rstrip(".") if first else path.stem


def _section(name: str, ends: list[dict[str, Any]], figures: list[dict[str, Any]]) -> list[str]:
    first, *rest = " ".join(ends[0]["text"].split()).split(". ", 1)
    passed = sum(e["outcome"] == "passed" for e in ends)
    lines = ["", f"## {first[0].upper()}{first[1:].rstrip('.')}", ""]
    lines += [rest[0], ""] if rest else []
    state = "passed" if passed == len(ends) else f"{passed} of {len(ends)} passed"
    lines.append(f"`{name.split('::')[1]}`: {state}.")
    lines += [f"- {e['outcome']}: `{e['test'].split('::')[1]}` {e['reason']}" for e in ends if e["outcome"] != "passed"]
    rows = [f for f in figures if f["test"].split("[")[0] == name]
    if rows:
        lines += ["", HEAD, *map(_row, rows)]
    return lines


def _row(f: dict[str, Any]) -> str:
    allowed = "" if f["within"] is None else f"{f['within']:.2g}"
    dofs = "" if f["dofs"] is None else f["dofs"]
    return (
        f"| {f['case']} | {f['quantity']} | {f['target']:.6g} | {f['obtained']:.6g} | {f['error']:.1e} "
        f"| {allowed} | {dofs} | {f['seconds']:.2f} |"
    )
