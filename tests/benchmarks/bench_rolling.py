"""Steady rolling beside FASTSIM, Kalker's simplified theory: errors of force and torque, and seconds.

FASTSIM has a flexibility in place of the half-space, from Kalker's coefficients, and marches along strips against the
direction of rolling; its bound of the tractions is the pressure of an ellipsoid or of a paraboloid. The truth is the
half-space on 176 x 176 cells. `python tests/benchmarks/bench_rolling.py`

Source: Kalker, Vehicle System Dynamics 11 (1982) 1; the bounds and the example are those of CONTACT (fastsim.ref_out).
"""

import math
import time

import numpy as np

import fecontact as fc

G, NU, MU, FORCE, A, B = 82000.0, 0.28, 0.3, 82000.0, 8.0, 4.0
STEEL = fc.Material(E=2 * G * (1 + NU), nu=NU)
WHEEL = fc.surfaces.Paraboloid(1 / (2 * 0.8464e-3), 1 / (2 * 0.2406e-2))
CASES = {
    "lateral and spin": ((0.0, -6.25e-4), 6.25e-4),
    "along": ((5e-4, 0.0), 0.0),
    "all": ((-8e-4, 4e-4), 3e-4),
}


def fastsim(creepage, spin, coefficients, n=44, parabolic=True):
    """Force along the rolling and to its left, and torque, on an ellipse with semi-axes A and B of n x n cells.

    In the signs of `HalfSpace.roll`: tractions on the lower body.
    """
    c11, c22, c23 = coefficients
    L = [8 * A / (3 * G * c11), 8 * A / (3 * G * c22), math.pi * A * math.sqrt(A / B) / (4 * G * c23)]
    y = B * (2 * np.arange(n) + 1 - n) / n
    step = 2 * A * np.sqrt(1 - (y / B) ** 2) / n
    q, sums = np.zeros((2, n)), np.zeros(3)
    for k in range(n):
        x, long = step * (n / 2 - k - 0.5), step * (1 if k else 0.5)
        before = x + long / 2
        rigid = np.stack([creepage[0] / L[0] - spin * y / L[2], creepage[1] / L[1] + spin * before / L[2]])
        q = q + rigid * long
        inside = np.maximum(0, 1 - (x / A) ** 2 - (y / B) ** 2)
        peak = FORCE / (math.pi * A * B)
        limit = MU * (2 * peak * inside if parabolic else 1.5 * peak * np.sqrt(inside))
        q *= np.minimum(1, limit / np.maximum(np.hypot(*q), 1e-300))
        area = step * 2 * B / n
        sums += np.array([q[0] @ area, q[1] @ area, (x * q[1] - y * q[0]) @ area])
    return sums


def timed(solve):
    begin = time.process_time()
    found = solve()
    return found, time.process_time() - begin


def rolled(n, creepage, spin, **options):
    half = fc.HalfSpace(STEEL, (17.6, 8.8), (n, n), against=STEEL)
    found = half.roll(WHEEL, force=FORCE, friction=MU, creepage=creepage, spin=spin, **options)
    return np.array([*found.tangential, found.torque])


def main():
    half = fc.HalfSpace(STEEL, (17.6, 8.8), (96, 96), against=STEEL)
    kalker = half.creep_coefficients(WHEEL, force=FORCE)
    coefficients = (kalker.c11, kalker.c22, kalker.c23)
    print(kalker)
    scale = MU * FORCE * np.array([1, 1, math.sqrt(A * B)])
    print(f"{'':18}{'':26}{'force':>8}{'torque':>9}{'seconds':>9}")
    for name, (creepage, spin) in CASES.items():
        truth = rolled(176, creepage, spin) / scale
        ways = {
            "FASTSIM, parabolic": lambda c=creepage, s=spin: fastsim(c, s, coefficients),
            "FASTSIM, elliptic": lambda c=creepage, s=spin: fastsim(c, s, coefficients, parabolic=False),
            "CONTACT's rule, 44 x 44": lambda c=creepage, s=spin: rolled(44, c, s, rule="contact"),
            "half-space, 44 x 44": lambda c=creepage, s=spin: rolled(44, c, s),
        }
        for way, solve in ways.items():
            found, seconds = timed(solve)
            off = found / scale - truth
            print(f"{name:18}{way:26}{np.hypot(*off[:2]):8.4f}{abs(off[2]):9.4f}{seconds:9.3f}")


if __name__ == "__main__":
    main()
