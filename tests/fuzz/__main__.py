"""Random scenes through every door of the package, each by its number.

    make fuzz                                         30 scenes a door
    make fuzz SEEDS=0:1000                            a thousand
    make fuzz SEEDS=0:20000:50                        one in fifty of twenty thousand
    python tests/fuzz --doors blocks,paths --seeds 0:200
    python tests/fuzz --one blocks 42                 one scene, with all that it says

Prints the classes of what came of them with numbers to repeat. Faults are foreign exceptions, NumPy's warnings, what is
no number, certificates above their tolerance, and answers that differ when the same scene is written otherwise.
"""

from __future__ import annotations

import os

for threads in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import argparse  # noqa: E402
import sys  # noqa: E402
import time  # noqa: E402
from collections import defaultdict  # noqa: E402
from concurrent.futures import ProcessPoolExecutor  # noqa: E402
from multiprocessing import get_context  # noqa: E402

from doors import DOORS  # noqa: E402
from frame import FRAMES, HOME  # noqa: E402
from judging import Answer, Outcome, judge, solve  # noqa: E402

#: Scenes that a process is given at once.
AT_ONCE = 10
SHOWN = 6


def _judged(task: tuple[str, range, int]) -> tuple[str, dict[int, dict[str, str]], float]:
    name, numbers, frames = task
    began = time.process_time()
    found = {number: judge(DOORS[name], number, frames).found for number in numbers}
    return name, found, time.process_time() - began


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:30", help="FIRST:LAST or FIRST:LAST:STEP, scenes of every door")
    parser.add_argument("--doors", default=",".join(DOORS), help="names, with commas between")
    parser.add_argument("--frames", type=int, default=1, help="other ways in which each scene is written")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--one", nargs=2, metavar=("DOOR", "NUMBER"), help="one scene, printed")
    given = parser.parse_args()
    if given.one:
        return _one(DOORS[given.one[0]], int(given.one[1]))
    numbers = range(*(int(n) for n in given.seeds.split(":")))
    starts = range(0, len(numbers), AT_ONCE)
    tasks = [(name, numbers[k : k + AT_ONCE], given.frames) for k in starts for name in given.doors.split(",")]
    classes: dict[str, dict[str, list[tuple[int, str]]]] = {name: defaultdict(list) for name in given.doors.split(",")}
    seconds: dict[str, float] = defaultdict(float)
    with ProcessPoolExecutor(given.jobs, mp_context=get_context("fork")) as pool:
        for name, found, took in pool.map(_judged, tasks):
            seconds[name] += took
            for number, kinds in found.items():
                for kind, detail in kinds.items():
                    classes[name][kind].append((number, detail))
    faults = 0
    for name, kinds in classes.items():
        print(f"\n{name}: {len(numbers)} scenes, {seconds[name]:.0f} s")
        for kind, which in sorted(kinds.items(), key=lambda item: -len(item[1])):
            fault = kind in Outcome(dict.fromkeys([kind], "")).faults
            faults += len(which) if fault else 0
            shown = " ".join(str(number) for number, _ in which[:SHOWN])
            print(f"  {'!' if fault else ' '}{len(which):6} {kind}   {shown}")
            if fault:
                print(f"          {which[0][1]}")
    print(f"\n{faults} faults")
    return min(faults, 1)


def _one(door: object, number: int) -> int:
    outcome = Outcome()
    home = solve(door, number, HOME, outcome)  # type: ignore[arg-type]
    print(home if isinstance(home, str) else "\n".join(str(s) for s in home.said if isinstance(s, str)))
    for name in door.frames:  # type: ignore[attr-defined]
        other = solve(door, number, FRAMES[name], outcome)  # type: ignore[arg-type]
        print(f"{name:16}", other if isinstance(other, str) else other.figures)
    if isinstance(home, Answer):
        print(f"{'at home':16}", home.figures)
    print(outcome.found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
