"""Figures 2 and 3 of Elangovan's report: spheres on half-spaces by point forces, dense,
by Wolfe's simplex method.

Two spheres of 25 cm, 454 kgf, forces on cells of 0.0875 and 0.075 mm; the pressure
along a diagonal and the contact area, beside Hertz. The report's rule gives a force
twice the displacement under itself that it has on its nearest neighbour; Love's exact
mean over a cell is 3.5255 times.

Run: python examples/report_half_space.py
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.common.files import save_figure
from fecontact.halfspace.operator import CellModel
from fecontact.solvers import ContactProblem, solve

STEEL = fc.Material(E=2.0e6, nu=0.3)  # kgf/cm2
RADIUS, FORCE = 25.0, 454.0  # cm, kgf
CELLS = (0.00875, 0.0075)  # cm
RULES = {
    "twice the nearest (report)": ("point", 2.0),
    "3.5255 times": ("point", 3.5255),
    "Love": ("uniform", 2.0),
}


@dataclass(frozen=True)
class Answer:
    """Pressures on a grid of cells and what Hertz says."""

    pressure: np.ndarray
    x: np.ndarray
    errors: dict[str, float]


def press(
    cell: float, kind: str, ratio: float, hertz: fc.hertz.CircularContact
) -> Answer:
    """All cells near the contact with their dense compliance; a force on a cell of a
    quarter stands for four.
    """
    n = 2 * int(np.ceil(1.15 * hertz.a / cell))
    half = fc.HalfSpace(
        STEEL,
        size=(n * cell, n * cell),
        cells=(n, n),
        against=STEEL,
        pressure=kind,
        self_ratio=ratio,
    )
    r = np.hypot(half.grid.x[:, None], half.grid.y[None, :])
    number = np.arange(n * n).reshape(n, n)
    quarter = number[n // 2 :, n // 2 :][r[n // 2 :, n // 2 :] < 1.15 * hertz.a]
    images = [
        m.ravel()[quarter]
        for m in (number, number[::-1], number[:, ::-1], number[::-1, ::-1])
    ]
    rows = sp.csr_matrix(
        (
            np.full(4 * len(quarter), 0.5),
            (np.tile(np.arange(len(quarter)), 4), np.concatenate(images)),
        ),
        (len(quarter), n * n),
    )
    gap = r.ravel()[quarter] ** 2 / RADIUS  # of both spheres
    S = CellModel(half.compliance).dense(rows)
    problem = ContactProblem(
        S, 2 * gap, np.full((1, len(quarter)), 2.0), np.array([FORCE])
    )
    solution = solve(problem, "wolfe")
    pressure = np.zeros(n * n)
    for image in images:
        pressure[image] = solution.forces / 2 / cell**2
    exact = hertz.pressure(r.ravel())
    errors = {
        "pressure, L2": float(np.linalg.norm(pressure - exact) / np.linalg.norm(exact)),
        "centre": float(
            pressure[number[n // 2, n // 2]] / exact[number[n // 2, n // 2]] - 1
        ),
        "area": float((pressure > 0).sum() * cell**2 / (np.pi * hertz.a**2) - 1),
        "approach": float(-solution.q[0] / hertz.approach - 1),
    }
    return Answer(pressure.reshape(n, n), half.grid.x, errors)


def main(
    cells: tuple[float, ...] = CELLS, out: str | Path = "out"
) -> dict[tuple[float, str], dict[str, float]]:
    hertz = fc.hertz.spheres((RADIUS, RADIUS), (STEEL, STEEL), force=FORCE)
    found = {
        (cell, rule): press(cell, *RULES[rule], hertz)
        for cell in cells
        for rule in RULES
    }
    figure = Figure(figsize=(4.9 * (len(cells) + 1), 5.2), layout="constrained")
    *maps, lines = figure.subplots(1, len(cells) + 1)
    report = next(iter(RULES))
    for axes, cell in zip(maps, cells, strict=True):
        answer, edge = found[cell, report], np.linspace(0, 2 * np.pi, 200)
        side = -10 * answer.x[0] + 5 * cell  # mm
        forces = np.where(answer.pressure > 0, answer.pressure * cell**2, np.nan)
        drawn = axes.imshow(
            forces.T, origin="lower", extent=(-side, side, -side, side), cmap="YlOrRd"
        )
        axes.plot(
            10 * hertz.a * np.cos(edge), 10 * hertz.a * np.sin(edge), "k--", linewidth=1
        )
        axes.set_title(
            f"forces [kgf], cells of {10 * cell:g} mm\ndashed: Hertz", fontsize="medium"
        )
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
        figure.colorbar(drawn, ax=axes, shrink=0.8)
    r = np.linspace(0, 1.15 * hertz.a, 200)
    lines.plot(10 * r, hertz.pressure(r), "k-", linewidth=1, label="Hertz")
    for marker, ((cell, rule), answer) in zip("ox+s^*", found.items(), strict=False):
        middle = len(answer.x) // 2
        diagonal = answer.pressure[middle:, middle:].diagonal()
        lines.plot(
            10 * np.sqrt(2) * answer.x[middle:],
            diagonal,
            marker,
            markersize=4,
            label=f"{10 * cell:g} mm, {rule}",
        )
    lines.set_xlabel("distance from the middle along a diagonal [mm]")
    lines.set_ylabel("pressure [kgf/cm²]")
    lines.set_xlim(0, 11.5 * hertz.a)
    lines.legend(fontsize="x-small")
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder / "report_half_space.png")
    errors = {key: answer.errors for key, answer in found.items()}
    for (cell, rule), e in errors.items():
        print(
            f"{10 * cell:g} mm, {rule:28}"
            + "".join(f"{name} {100 * v:+6.2f} %   " for name, v in e.items())
        )
    return errors


if __name__ == "__main__":
    main()
