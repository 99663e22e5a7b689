"""Rough periodic surfaces up to full contact and with a hardness, beside tamaas and ContactMechanics.

`python tests/benchmarks/bench_rough.py [--peer-python peers/bin/python] [--cells 256 512] [--limit 60]` prints the
tables of `docs/rough-contact.md`: processor seconds of one thread, share of cells that touch, and the worst residual of
the pressures, recomputed by this package for all. Another program that has taken longer than the limit on a grid is not
run on larger ones.
"""

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import fecontact as fc
from fecontact.halfspace.pressing import Load, normal_residuals

PROGRAMS = ("tamaas", "contactmechanics")
PRESSURES = (0.01, 0.04, 0.1, 0.2, 0.4)
SLOPE, HARDNESS = 0.2, (0.25, (0.04, 0.1, 0.2))
FOLDER = Path(__file__).parent


def surface(n):
    """Heights of the same surface on n x n cells: wavelengths from a quarter to 1/64 of the period."""
    return fc.surfaces.self_affine(
        (n, n), size=(1.0, 1.0), hurst=0.8, rms_slope=SLOPE, longest=0.25, shortest=1 / 64, seed=1
    ).z


def half_space(n):
    return fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(1.0, 1.0), cells=(n, n), periodic=True)


def residual(half, z, mean, own, pressure):
    """Worst residual of pressures under the approach that fits them best."""
    if (pressure == own.pressure).all():
        return own.residuals.worst
    p = np.maximum(pressure, 0.0)
    u = half.compliance.product().apply(p)
    free = p > 0 if own.hardness is None else (p > 0) & (p < (1 - 1e-9) * own.hardness)
    approach = float((u + z)[free].mean())
    dent = (
        None if own.hardness is None else np.where(p >= (1 - 1e-9) * own.hardness, np.maximum(approach - u - z, 0), 0)
    )
    found = replace(own, pressure=p, approach=approach, dent=dent)
    return normal_residuals(half.compliance, z, Load(mean, None, None), found).worst


def ours(half, z, mean, hardness):
    began = time.process_time()
    found = half.press(z, force=mean, hardness=None if math.isinf(hardness) else hardness)
    return found, time.process_time() - began


def theirs(python, program, z, mean, hardness, limit):
    """Seconds and pressures; None beyond the limit."""
    with tempfile.TemporaryDirectory() as folder:
        heights, out = Path(folder) / "z.npy", Path(folder) / "p.npy"
        np.save(heights, z)
        call = [python, str(FOLDER / "peers" / "_rough.py"), program, str(heights), str(mean), str(hardness), str(out)]
        env = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": ""}
        try:
            ran = subprocess.run(call, capture_output=True, text=True, timeout=limit, check=True, env=env)
        except subprocess.TimeoutExpired:
            return None
        except subprocess.CalledProcessError as error:
            print(f"{program} failed: {error.stderr.strip().splitlines()[-1]}", file=sys.stderr)
            return None
        return float(ran.stdout.split()[-1]), np.load(out)


def table(python, cells, pressures, hardness, limit):
    print(f"\n| cells | p/E* | {' | '.join(f'{name}: s, area, residual' for name in ('here', *PROGRAMS))} |")
    print("|---" * (3 + len(PROGRAMS)) + "|", flush=True)
    late = set()
    for n in cells:
        half, z = half_space(n), surface(n)
        for mean in pressures:
            own, seconds = ours(half, z, mean, hardness)
            row = [f"{seconds:.2f}, {own.active.mean():.5f}, {own.residuals.worst:.0e}"]
            for program in PROGRAMS:
                done = None
                if python and (program, mean) not in late:
                    done = theirs(python, program, z, mean, hardness, limit)
                    if done is None:
                        late.add((program, mean))
                share = (
                    "" if done is None else f"{(done[1] > 0).mean():.5f}, {residual(half, z, mean, own, done[1]):.0e}"
                )
                row.append("" if not python else f"over {limit:g}" if done is None else f"{done[0]:.2f}, {share}")
            print(f"| {n} | {mean:g} | {' | '.join(row)} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peer-python", help="interpreter that has the other programs")
    parser.add_argument("--cells", nargs="+", type=int, default=[256, 512, 1024, 2048])
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of a solve of another program")
    given = parser.parse_args()
    table(given.peer_python, given.cells, PRESSURES, math.inf, given.limit)
    hardness, pressures = HARDNESS
    print(f"\nHardness {hardness:g} E*:")
    table(given.peer_python, given.cells, pressures, hardness, given.limit)


if __name__ == "__main__":
    main()
