"""One run in a process of its own: ``python -m compare.worker JOB``, the job as JSON, see `measured`.

So every run has its own peak of memory, its number of threads, and cannot spoil the others. The row is printed as one
line of JSON. Times are medians of repeats and leave out the loading of packages.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from dataclasses import asdict
from typing import Any

from compare.methods import variant
from compare.problems import problem
from fecontact.common.stopwatch import peak_memory


def measured(job: dict[str, Any]) -> dict[str, Any]:
    """Run a job and time it.

    Parameters
    ----------
    job : dict
        'problem', 'spec' (see `methods.variant`), 'setting', 'repeats', and 'enough': CPU seconds after which it is not
        repeated any more.

    Returns
    -------
    dict
        `methods.Measured`, 'seconds' (processor), 'wall' and their number 'repeats', 'peak_mb'.

    Examples
    --------
    >>> job = {"problem": "hertz", "spec": "half-space", "setting": 32, "repeats": 1, "enough": 10.0}
    >>> row = measured(job)
    >>> row["dofs"], row["repeats"], row["errors"]["pressure_l2"] < 0.05
    (1024, 1, True)
    """
    which = problem(job["problem"])
    chosen = variant(job["spec"], job["problem"])
    chosen.method.run(which, chosen.method.settings[0], chosen.options)  # loads what is imported on first use
    seconds: list[float] = []
    wall: list[float] = []
    for _ in range(job["repeats"]):
        began, cpu = time.perf_counter(), time.process_time()
        found = chosen.method.run(which, job["setting"], chosen.options)
        seconds.append(time.process_time() - cpu)
        wall.append(time.perf_counter() - began)
        if sum(seconds) > job["enough"]:
            break
    return {
        **asdict(found),
        "seconds": statistics.median(seconds),
        "wall": statistics.median(wall),
        "repeats": len(seconds),
        "peak_mb": peak_memory(),
    }


if __name__ == "__main__":
    print(json.dumps(measured(json.loads(sys.argv[1]))))
