"""The decks of CalculiX's test suite with contact or ties and a static step, solved here and by ccx beside.

Run: python tests/benchmarks/ccx_decks.py FOLDER [NAME ...] [--csv docs/how-to/decks.csv] [--seconds 300]

One line per deck: by how much displacements and forces of the second run of ccx, which answers the question that is
answered here (`fecontact/app/decks/ccx.py`), are off at most, over the largest, in percent; of the first run where the
second changes nothing. Names restrict the run; the lines of others in the CSV stay.
"""

from __future__ import annotations

import argparse
import csv
import json
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

#: Bounds of displacements and forces, in percent.
WITHIN = (1.0, 2.0)
#: Decks whose cells are one to a block, or a few, divided in both programs so many times.
ONE_CELL = "contact10 contact13 contact14 contact4 contact4_mortar contact5 cubes cubesmortar cubesmortar2 cubespring"
DIVIDED = dict.fromkeys(ONE_CELL.split(), 1)
#: Why decks that are solved are not within.
WHY = {
    "beamcontact": "two edges hold the beam: neither program has converged when its cells are divided twice",
    "changefric": "slides by half of its cell; linearised here, as the result warns",
    "contact10": "slides by a tenth of its cell; by a 20th of that .47 %",
    "contact13": "overlaps at first; ccx is 1.9 % off its own contact14, the same question; a 20th of it: .29 %",
    "contact2": "large deflection, force at an edge; at a tenth of gap and load 2.6, and divided once 1.0, twice .29 %",
    "punch1": "a ridge narrower than a face; moves by .733, divided .749, .741e-3 here, by .653, .684, .710e-3 there",
    "punch2": "as punch1",
    "segmentlintemp": "ccx 2.20 does not read *TEMPERATURE with LINTEMP",
    "segmenttemp": "ccx fits trilinear temperatures to cells; 6e-4 % where they are so",
    "thread": "a few faces at an edge",
}
#: Forces of these decks that are zero but for the accuracy of ccx, in their units (N); others are larger.
NOTHING = 1e-3
COLUMNS = ("deck", "divided", "displacement_percent", "force_percent", "within", "why_not", "seconds", "ccx_seconds")


def decks(folder: Path) -> list[Path]:
    """Decks with contact pairs or ties, and a static step."""
    wanted = [re.compile(p, re.I | re.M) for p in (r"^\*\s*(CONTACT\s*PAIR|TIE)\b", r"^\*\s*STATIC\b")]
    texts = {path: path.read_text(errors="replace") for path in sorted(folder.glob("*.inp"))}
    return [path for path, text in texts.items() if all(p.search(text) for p in wanted)]


def figures(beside: dict[str, Any]) -> tuple[float, float]:
    """Largest differences of displacements and of forces, over the largest, in percent."""
    moved = beside.get("displacements_apart_alike", beside["displacements_apart"])
    pairs = [(row["fecontact"], row.get("ccx_alike", row["ccx"])) for name, row in beside.items() if "force" in name]
    pairs = [pair for pair in pairs if max(map(abs, pair)) > NOTHING]
    largest = max((abs(theirs) for _, theirs in pairs), default=1.0)
    off = max((abs(ours - theirs) for ours, theirs in pairs), default=0.0)
    return 100 * max(moved.values()), 100 * off / largest


def compare(deck: Path, seconds: float) -> dict[str, Any]:
    """The line of a deck."""
    times = DIVIDED.get(deck.stem, 0)
    row: dict[str, Any] = {"deck": deck.stem, "divided": times, "within": "no"}
    command = [sys.executable, "-m", "fecontact", "solve", str(deck), "--beside", "ccx", "--json", "-"]
    command += ["--divide", str(times)] if times else []
    start = time.perf_counter()
    try:
        ran = subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return {**row, "why_not": f"not done in {seconds:g} s"}
    row["seconds"] = round(time.perf_counter() - start, 1)
    if ran.returncode:
        said = " ".join(ran.stderr.split()) or f"status {ran.returncode}"
        return {**row, "why_not": WHY.get(deck.stem, said[:160])}
    beside = json.loads(ran.stdout)["beside_ccx"]
    ours, theirs = beside["seconds"]["fecontact"], beside["seconds"]["ccx"]
    moved, force = figures(beside)
    good = moved <= WITHIN[0] and force <= WITHIN[1]
    row |= {"displacement_percent": f"{moved:.2g}", "force_percent": f"{force:.2g}", "seconds": f"{ours:.2g}"}
    why = {} if good else {"why_not": WHY.get(deck.stem, "")}
    return {**row, **why, "ccx_seconds": f"{theirs:.2g}", "within": "yes" if good else "no"}


def main() -> None:
    """Compare and write the CSV."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--csv", type=Path, default=Path("docs/how-to/decks.csv"))
    parser.add_argument("--seconds", type=float, default=300.0)
    options = parser.parse_args()
    known: dict[str, dict[str, Any]] = {}
    if options.csv.is_file():
        with options.csv.open(newline="") as file:
            known = {row["deck"]: row for row in csv.DictReader(file)}
    for deck in decks(options.folder):
        if options.names and deck.stem not in options.names:
            continue
        known[deck.stem] = compare(deck, options.seconds)
        print(known[deck.stem], flush=True)
        with options.csv.open("w", newline="") as file:
            out = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            out.writeheader()
            out.writerows(known[name] for name in sorted(known))


if __name__ == "__main__":
    main()
