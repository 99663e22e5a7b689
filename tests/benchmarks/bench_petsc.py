"""The engine 'petsc' against the number of processes: steps, processor seconds and memory of each, and the forces.

    python tests/benchmarks/bench_petsc.py 31 1 2 4    divisions of the block, numbers of processes

The block of `bench_scale.py`. Needs mpiexec and petsc4py, see docs/scale.md. Seconds and memory are those of the
process that takes most; the forces are compared with those of `backend="amg"`.
"""

import sys

import numpy as np
from bench_scale import scene

HEAD = "| dofs | processes | steps | seconds of each | all | peak of each, MB | largest difference of forces |"


def row(n, ranks, expected):
    """One row of the table."""
    ball, model = scene(n, "auto")
    result = model.solve(forces={ball: (0.0, 0.0, -0.03)}, engine="petsc", ranks=ranks)
    steps, seconds, peaks = zip(*result.problem.S.factor.job.usage(), strict=True)
    difference = np.abs(result.contacts[0].forces - expected).max() / expected.max()
    return (
        f"| {result.n_dofs} | {ranks} | {steps[0]} | {max(seconds):.1f} | {sum(seconds):.1f} | {max(peaks):.0f} | "
        f"{difference:.1e} |"
    )


def main():
    n, *processes = map(int, sys.argv[1:])
    ball, model = scene(n, "amg")
    expected = model.solve(forces={ball: (0.0, 0.0, -0.03)}).contacts[0].forces
    print(HEAD)
    print("|" + "---|" * (HEAD.count("|") - 1))
    for ranks in processes:
        print(row(n, ranks, expected), flush=True)


if __name__ == "__main__":
    main()
