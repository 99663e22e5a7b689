"""Crowning of a roller for the lowest peak pressure, by gradients, and a modulus from
measured pressures.

A steel roller of 10 mm radius and 16 mm length is pressed on a steel plane by 8 kN. A
cylinder ends in an edge, where the pressure has no bound. Its profile is relieved by a
power of the distance from the middle, d (2 |y| / l)^n; drop d and exponent n are
sought. `HalfSpace.gradient` has the derivatives of a norm of the pressures, near their
largest one, by all heights, from one solution with the cells in contact; the chain rule
has those by the two unknowns.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import minimize

import fecontact as fc

STEEL = fc.Material(E=210e3, nu=0.3)
RADIUS, LENGTH, FORCE = 10.0, 16.0, 8000.0
#: Drop (micrometres) and exponent to start from.
START = (20.0, 2.0)
#: Exponent of the norm that stands for the largest pressure, which has no derivative
#: where several cells share it.
NORM = 16


def half_space(modulus=STEEL.E, cells=(32, 80)):
    """The plane below the roller, of steel as the roller is."""
    return fc.HalfSpace(
        fc.Material(modulus, 0.3), size=(1.0, 1.25 * LENGTH), cells=cells, against=STEEL
    )


def heights(half, drop, exponent):
    """Heights of the roller, and their derivatives by drop and exponent."""
    x, y = half.grid.x[:, None], half.grid.y[None, :]
    relative = 2 * np.abs(y) / LENGTH + 0 * x
    there = relative <= 1  # the roller ends within the grid
    relief = np.where(there, relative**exponent, 0.0)
    z = np.where(there, x**2 / (2 * RADIUS) + drop * relief, np.inf)
    return z, (relief, drop * relief * np.log(relative))


def norm_of_pressures(half, contact):
    """A smooth figure near the largest pressure, and its derivatives by pressures."""
    share = (contact.pressure / contact.max_pressure) ** (NORM - 1)
    total = float((contact.pressure * share).sum()) / contact.max_pressure
    value = contact.max_pressure * total ** (1 / NORM)
    return value, share * total ** (1 / NORM - 1)


def crowned():
    """Drop and exponent of the lowest peak, by L-BFGS-B, and the peaks on the way."""
    half, peaks = half_space(), []

    def figure(unknowns):
        # drop in micrometres
        z, by_unknowns = heights(half, 1e-3 * unknowns[0], unknowns[1])
        contact = half.press(z, force=FORCE)
        value, weights = norm_of_pressures(half, contact)
        slope = half.gradient(contact, weights).heights
        peaks.append(contact.max_pressure)
        return value, [
            1e-3 * (slope * by_unknowns[0]).sum(),
            (slope * by_unknowns[1]).sum(),
        ]

    found = minimize(
        figure, START, jac=True, method="L-BFGS-B", bounds=((1.0, 200.0), (1.5, 12.0))
    )
    return found, peaks


def identified(seed=1):
    """Modulus of the plane from pressures measured with a noise of 2 percent, by their
    squared differences.
    """
    rng, truth = np.random.default_rng(seed), 70e3
    z, _ = heights(half_space(), 0.02, 2.0)
    exact = half_space(truth).press(z, force=FORCE).pressure
    measured = exact * (1 + 0.02 * rng.standard_normal(exact.shape))

    def figure(logarithm):
        half = half_space(float(np.exp(logarithm[0])))
        contact = half.press(z, force=FORCE)
        off = contact.pressure - measured
        slope = half.gradient(contact, 2 * off).E
        return float((off**2).sum()) / 1e6, [slope * half.material.E / 1e6]

    found = minimize(figure, [np.log(200e3)], jac=True, method="BFGS")
    return float(np.exp(found.x[0])), truth, found


def draw(unknowns, path):
    """Profile of the relief, and pressure along the roller, before and after."""
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    relief, pressure = figure.subplots(2, 1, sharex=True)
    half = half_space()
    inside = np.abs(half.grid.y) <= LENGTH / 2
    y = half.grid.y[inside]
    for (drop, exponent), style, name in (
        (START, "0.6", "circular, 20 um"),
        (unknowns, "tab:blue", "found"),
    ):
        z, _ = heights(half, 1e-3 * drop, exponent)
        relief.plot(
            y, -drop * (2 * np.abs(y) / LENGTH) ** exponent, color=style, label=name
        )
        pressure.plot(
            y, half.press(z, force=FORCE).pressure.max(axis=0)[inside], color=style
        )
    relief.set_ylabel("relief [um]")
    relief.legend(loc="lower center")
    pressure.set_ylabel("peak across [MPa]")
    pressure.set_xlabel("y [mm]")
    for axes in (relief, pressure):
        axes.grid(color="0.9")
    figure.savefig(path, dpi=150)


def main(out="."):
    """Print both, and draw the roller."""
    found, peaks = crowned()
    print(
        f"drop {found.x[0]:.1f} um, exponent {found.x[1]:.2f}: peak {peaks[0]:.0f} -> "
        f"{peaks[-1]:.0f} MPa"
    )
    print(f"{found.nfev} presses, {found.nit} steps: {found.message}")
    draw(found.x, Path(out) / "crowned_roller.png")
    modulus, truth, told = identified()
    print(f"modulus {modulus:.0f} MPa of {truth:.0f}, {told.nfev} presses")


if __name__ == "__main__":
    main()
