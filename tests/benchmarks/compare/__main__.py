"""Run a problem with a known answer by many methods, and other programs beside them; error against time and size.

    make compare
    python tests/benchmarks/compare hertz --out out/compare
    python tests/benchmarks/compare ellipse --methods hex20 hex20:solver=nnls half-space
    python tests/benchmarks/compare hertz --peers tests/benchmarks/peers --peer-python peers/bin/python

Finished runs are kept: an interrupted command goes on where it stopped.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from compare import page
from compare.files import places, write
from compare.peers import find_peers, published, styled
from compare.precision import against_peers, sentence
from compare.problems import problem
from compare.run import Plan, compare
from compare.table import conditions, table
from fecontact import FecontactError


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status (0 success, 2 an error that was explained)."""
    given = _arguments(arguments)
    try:
        print(_compared(given))
    except FecontactError as error:
        print(f"compare: {error}", file=sys.stderr)
        return 2
    return 0


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="compare", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("problem", help="hertz, unequal, ellipse, line, layer or punch")
    parser.add_argument("--methods", nargs="+", default=(), metavar="NAME[:KEY=VALUE]", help="all of the problem's")
    parser.add_argument("--refinements", type=int, metavar="N", help="of each method, the coarsest first; all if left")
    parser.add_argument("--repeats", type=int, default=3, help="of each run; the median counts")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--enough", type=float, default=20.0, help="CPU seconds after which a method is not refined")
    parser.add_argument("--peers", metavar="FOLDER", help="adapters of other programs")
    parser.add_argument("--peer-python", default=sys.executable, metavar="PYTHON", help="that has these programs")
    parser.add_argument("--out", metavar="FOLDER", help="write compare_PROBLEM.jsonl, .json, .csv, .png and .md there")
    parser.add_argument("--page", metavar="FILE.md", help="write the page there instead")
    parser.add_argument("--plot", metavar="FILE", help="write the picture there instead")
    return parser.parse_args(arguments)


def _compared(given: argparse.Namespace) -> str:
    """Compare, write what is wanted, and give back the text for the screen."""
    plan = Plan(given.problem, tuple(given.methods), given.refinements, given.repeats, given.threads, given.enough)
    files = places(given.problem, given.out, picture=given.plot, page=given.page)
    peers, absent = ([], []) if given.peers is None else find_peers(given.peers, given.peer_python)
    rows = compare(plan, files.get("rows"), peers)
    elsewhere = [] if given.peers is None else published(Path(given.peers), given.problem, rows)
    title = problem(given.problem).title
    text = page.page(rows, title, files=files, absent=absent, published=elsewhere)
    parts = [
        title[0].upper() + title[1:],
        table(rows),
        *(f"not run: {line}" for line in absent),
        conditions(rows),
        sentence(rows),
        against_peers(rows),
        *write(files, rows, title, text, [*styled(rows), *elsewhere]),
    ]
    return "\n".join(part for part in parts if part)


if __name__ == "__main__":
    sys.exit(main())
