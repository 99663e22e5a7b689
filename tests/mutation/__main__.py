"""Whether the tests see it when a guard is weakened: mutants by rule, the tests that touch them, and who survives.

    make mutants                                     a sample
    python tests/mutation --sample 300 --seed 1      another
    python tests/mutation --module solvers           all of the modules with that in their name
    python tests/mutation --survivors                those that survived, again

Nothing is written to the package: every mutant lives in the memory of a process of its own, and the tree is copied
first, so that it may be edited meanwhile. What is judged is kept in a file, so a run may be interrupted. Survivors that
cannot be told from the original are listed in `equivalent.toml`, each with its reason; any other is a missing test.
Needs the extra 'mutation'.
"""

from __future__ import annotations

import os

for threads in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

import argparse  # noqa: E402
import json  # noqa: E402
import random  # noqa: E402
import shutil  # noqa: E402
import sys  # noqa: E402
import tempfile  # noqa: E402
import tomllib  # noqa: E402
from collections import Counter  # noqa: E402
from pathlib import Path  # noqa: E402

from judging import judge, preload  # noqa: E402
from mutants import Mutant, modules, mutants  # noqa: E402
from touching import Touching  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TESTS = (
    *(f"tests/unit/{room}" for room in ("solvers", "surfaces", "bodies", "contact", "results", "scene")),
    "tests/verification/test_finite_motion.py",
)
"""Tests of the contact pipeline that are fast; those not in here may kill no mutant."""

SLOW = ("halfspace", "pictures", "model_size", "cost", "export", "processes")
"""Words in the names of test files that are about something else."""


def main() -> int:
    given = _arguments()
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name in ("fecontact", "tests", "examples", "docs"):
            shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__", "*.png"))
        shutil.copy(ROOT / "pyproject.toml", root)
        sys.path.insert(0, folder)
        return _judged(root, given)


def _judged(root: Path, given: argparse.Namespace) -> int:
    """Judge mutants of a copy of the tree, print the table."""
    given.out.mkdir(parents=True, exist_ok=True)
    paths = modules(root)
    every = [each for name, path in paths.items() for each in mutants(name, path)]
    judged = _read(given.out / "mutants.jsonl")
    chosen = [each for each in every if any(word in each.module for word in given.module or [""])]
    chosen = [each for each in chosen if given.rule in each.rule]
    if given.survivors:
        chosen = [each for each in chosen if judged.get(each.key, {}).get("verdict") == "survived"]
    elif given.sample:
        chosen = random.Random(given.seed).sample(chosen, min(given.sample, len(chosen)))
    left = chosen if given.survivors else [each for each in chosen if each.key not in judged]
    if left and not given.table:
        preload(root)
        touching = Touching(root, given.out / "touching.json")
        touching.collect(_test_files(root, given.tests or TESTS))
        _run(root, left, paths, touching, given)
    judged = _read(given.out / "mutants.jsonl")
    return _table([each for each in every if each.key in judged], judged, len(every))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=0, help="so many mutants drawn at random; all without it")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--module", action="append", help="only modules with this in their name; may be repeated")
    parser.add_argument("--rule", default="", help="only rules with this in their name")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of processor time for a mutant")
    parser.add_argument("--tests", action="append", help="files or folders of tests, in place of the usual ones")
    parser.add_argument("--survivors", action="store_true", help="judge those that survived again")
    parser.add_argument("--table", action="store_true", help="judge nothing, print what is known")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "mutation")
    return parser.parse_args()


def _test_files(root: Path, given: list[str] | tuple[str, ...]) -> list[Path]:
    found: set[Path] = set()
    for pattern in given:
        for path in root.glob(pattern):
            found |= set(path.rglob("test_*.py")) if path.is_dir() else {path}
    return sorted(path for path in found if path.name.startswith("test_") and not any(w in path.name for w in SLOW))


def _run(root: Path, left: list[Mutant], paths: dict[str, Path], touching: Touching, given: argparse.Namespace) -> None:
    work = [(each, paths[each.module], touching.tests(each, paths[each.module], given.limit)) for each in left]
    with (given.out / "mutants.jsonl").open("a") as stream:
        for number, (each, verdict) in enumerate(judge(root, work, given.jobs, given.limit), 1):
            stream.write(json.dumps({"key": each.key, **verdict}) + "\n")
            stream.flush()
            print(f"{number}/{len(work)} {_line(each, verdict)}", flush=True)


def _read(path: Path) -> dict[str, dict[str, str]]:
    """The last verdict on each mutant."""
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return {row["key"]: row for row in rows}


def _line(mutant: Mutant, verdict: dict[str, str]) -> str:
    place = f"{mutant.module}:{mutant.line} {mutant.function}"
    by = f" by {verdict['by']}" if verdict["by"] else ""
    change = f"{mutant.before}  ->  {mutant.after}" if mutant.rule != "raise removed" else mutant.before
    return f"{verdict['verdict']}{by} | {place} | {mutant.rule} | {change}"


def _table(every: list[Mutant], judged: dict[str, dict[str, str]], made: int) -> int:
    """Print totals by module and by rule, and the survivors; how many have no reason."""
    with (HERE / "equivalent.toml").open("rb") as stream:
        listed = tomllib.load(stream)["mutant"]
    reasons = {(row["function"], row["rule"], row["before"], row.get("after", "")): row["why"] for row in listed}
    counts: dict[str, Counter[str]] = {}
    without = 0
    for each in every:
        verdict = judged[each.key]["verdict"]
        if verdict == "survived":
            texts = (each.function, each.rule, each.before)
            why = reasons.get((*texts, each.after)) or reasons.get((*texts, ""))
            verdict = "equivalent" if why else verdict
            without += not why
            print(_line(each, judged[each.key]), f"| equivalent: {why}" if why else "")
        for name in (f"module {each.module}", f"rule {each.rule}", "all"):
            counts.setdefault(name, Counter())[verdict] += 1
    columns = ("killed", "timed out", "equivalent", "survived")
    print(f"\n{'':45}" + "".join(f"{each:>12}" for each in (*columns, "judged")))
    for name in sorted(counts):
        row = counts[name]
        print(f"{name:45}" + "".join(f"{row[each]:12d}" for each in columns) + f"{row.total():12d}")
    print(f"{made} mutants can be made; {without} survived without a reason")
    return int(without > 0)


if __name__ == "__main__":
    sys.exit(main())
