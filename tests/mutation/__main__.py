"""Whether the tests see it when a guard is weakened: mutants by rule, the tests that touch them, and who survives.

    make mutants                                     a sample, of each part of parts.py
    python tests/mutation --sample 9 --seed 1        another, nine of each part
    python tests/mutation --module solvers           all of the parts and modules with that in their name
    python tests/mutation --survivors                those that survived, again
    python tests/mutation --again --day              those that were judged, by the tests of every day alone

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
import hashlib  # noqa: E402
import json  # noqa: E402
import shutil  # noqa: E402
import sys  # noqa: E402
import tempfile  # noqa: E402
import tomllib  # noqa: E402
from collections import Counter  # noqa: E402
from collections.abc import Iterator  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

from judging import DAY, Work, judge, preload  # noqa: E402
from mutants import Mutant, modules, mutants  # noqa: E402
from parts import judges, part_of  # noqa: E402
from touching import Touching  # noqa: E402

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


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
    made = {name: mutants(name, path) for name, path in paths.items() if part_of(name)}
    every = [each for some in made.values() for each in some]
    before = _read(given.out, "all"), _read(given.out, "day")
    judged = before[given.day]
    chosen = _sample(every, given)
    if given.again:
        chosen = [each for each in chosen if each.key in before[not given.day]]
    elif given.survivors:
        chosen = [each for each in chosen if judged.get(each.key, {}).get("verdict") == "survived"]
    left = chosen if given.survivors else [each for each in chosen if each.key not in judged]
    if left and not given.table:
        preload(root)
        killers = {key: row["by"] for rows in before for key, row in rows.items() if "::" in row["by"]}
        _run(root, left, paths, killers, given)
    judged = _read(given.out, "day" if given.day else "all")
    return _table([each for each in every if each.key in judged], judged, len(every))


def _sample(every: list[Mutant], given: argparse.Namespace) -> list[Mutant]:
    """So many of each part, of the modules and rules that are asked for: the same as long as the functions are."""
    out: dict[str, list[Mutant]] = {}
    for each in sorted(every, key=lambda each: hashlib.sha256(f"{given.seed} {each.key}".encode()).digest()):
        part, inner = part_of(each.module), each.module.partition(".")[2]
        if given.rule in each.rule and any(word in f"{part} {inner}" for word in given.module or [""]):
            out.setdefault(part, []).append(each)
    return [each for part in out.values() for each in part[: given.sample or None]]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=0, help="so many mutants of each part; all without it")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--module", action="append", help="only parts or modules with this in their name; repeatable")
    parser.add_argument("--rule", default="", help="only rules with this in their name")
    parser.add_argument("--day", action="store_true", help="by the tests of every day, without those marked as full")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of processor time for a mutant")
    parser.add_argument("--tests", action="append", help="files or folders in tests/unit, in place of the part's")
    parser.add_argument("--survivors", action="store_true", help="judge those that survived again")
    parser.add_argument("--again", action="store_true", help="those that all tests have judged by day, or the reverse")
    parser.add_argument("--table", action="store_true", help="judge nothing, print what is known")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "mutation")
    return parser.parse_args()


def _run(
    root: Path, left: list[Mutant], paths: dict[str, Path], killers: dict[str, str], given: argparse.Namespace
) -> None:
    """Judge by the test that killed a mutant before, where it kills it still; else by all of its tests."""
    suite = "day" if given.day else "all"
    with (given.out / "mutants.jsonl").open("a") as stream:

        def judged(work: list[Work]) -> Iterator[tuple[Mutant, dict[str, Any]]]:
            yield from judge(root, work, given.jobs, given.limit, DAY if given.day else ())

        def tell(each: Mutant, verdict: dict[str, Any]) -> None:
            stream.write(json.dumps({"key": each.key, "suite": suite, **verdict}) + "\n")
            stream.flush()
            print(_line(each, verdict), flush=True)

        known = [(each, paths[each.module], [killers[each.key]]) for each in left if each.key in killers]
        done = set()
        for each, verdict in judged(known):
            if verdict["by"] == killers[each.key]:
                done.add(each.key)
                tell(each, verdict)
        rest = [each for each in left if each.key not in done]
        if given.again and given.day:  # the tests of every day are some of those that saw nothing
            for each in rest:
                if each.key not in killers:
                    tell(each, {"verdict": "survived", "by": "", "tests": 0, "seconds": 0.0})
            rest = [each for each in rest if each.key in killers]
        if not rest:
            return
        files = {part: judges(part, root, given.tests) for part in {part_of(each.module) for each in rest}}
        touching = Touching(root, given.out / "touching.json", given.day)
        touching.collect(sorted(set().union(*files.values())), given.jobs)
        work = []
        for each in rest:
            path = paths[each.module]
            work.append((each, path, touching.tests(each, path, files[part_of(each.module)], given.limit)))
        for each, verdict in judged(work):
            tell(each, verdict)


def _read(folder: Path, suite: str) -> dict[str, dict[str, str]]:
    """The last verdict on each mutant by all tests or by those of every day."""
    path = folder / "mutants.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return {row["key"]: row for row in rows if row["suite"] == suite}


def _line(mutant: Mutant, verdict: dict[str, str]) -> str:
    place = f"{mutant.module}:{mutant.line} {mutant.function}"
    by = f" by {verdict['by']}" if verdict["by"] else ""
    change = f"{mutant.before}  ->  {mutant.after}" if mutant.rule != "raise removed" else mutant.before
    return f"{verdict['verdict']}{by} | {place} | {mutant.rule} | {change}"


def _table(every: list[Mutant], judged: dict[str, dict[str, str]], made: int) -> int:
    """Print totals by part, module and rule, and the survivors; how many have no reason."""
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
        for name in (f"part {part_of(each.module)}", f"module {each.module}", f"rule {each.rule}", "all"):
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
