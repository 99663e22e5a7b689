"""Friction: two steel balls pressed together and dragged to and fro, beside Mindlin and
Deresiewicz.

Run: python examples/partial_slip.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.analytic import friction, hertz
from fecontact.scene.load_path import LoadPath

RADIUS, LOAD, MU = 10.0, 100.0, 0.3  # mm, N
#: Tangential forces of the steps, over mu times the load: one way, back, and one way
#: again.
CYCLE = (0.0, 0.3, 0.6, 0.8, 0.4, 0.0, -0.4, -0.8, -0.4, 0.0, 0.4, 0.8)


def main(level: int = 1, out: str | Path = "out") -> dict[str, float]:
    steel = fc.Material(E=210e3, nu=0.3)
    ball = hertz.spheres((RADIUS, RADIUS), (steel, steel), force=LOAD)
    exact = friction.mindlin(ball, MU, tangential=0.8 * MU * LOAD)

    # half of each ball; the lower one is the upper one turned over
    mesh = fc.shapes.half_sphere(
        RADIUS, contact_radius=ball.a, level=level, sector="half"
    )
    upper = fc.ElasticBody(
        mesh, steel, "cap", {"base": "xyz", "sym_y": "y"}, name="upper"
    )
    lower = upper.placed(rotation=fc.rotation_about((0, 1, 0), np.pi), name="lower")
    scene = fc.Scene(
        [upper, lower],
        [fc.Contact(upper, lower, friction=MU)],
        units=("mm", "N", "MPa"),
    )
    steps = [
        {
            "forces": {upper: (share * MU * LOAD / 2, 0, -LOAD / 2)},
            "free": {upper: "x z"},
        }
        for share in CYCLE
    ]
    path = scene.solve_path(steps)
    print(path)

    # from one reversal over the other and back
    worked = 2 * float(path.friction_work[4:].sum())
    last = path[3].contacts[0]
    figures = {
        "energy of a cycle": worked,
        "of Mindlin and Deresiewicz": exact.cycle_energy,
        "stick radius": float(np.sqrt(2 * last.stick_area / np.pi)),
        "of Cattaneo and Mindlin": exact.c,
        "largest residual": max(
            result.friction.residuals.worst for result in path.steps
        ),
    }
    for name, value in figures.items():
        print(f"{name:<28}{value:.4g}")

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    path[3].plot("friction", folder / "partial_slip.png")
    first = friction.mindlin(ball, MU, tangential=CYCLE[1] * MU * LOAD)
    draw_loop(path, upper, first.shift, exact, folder / "partial_slip_loop.png")
    return figures


def draw_loop(
    path: LoadPath,
    ball: fc.ElasticBody,
    first: float,
    exact: friction.RoundSlip,
    file: Path,
) -> None:
    """Friction against the shift of the contact, without the bulk of the half balls,
    beside the closed form.
    """
    force = MU * LOAD * np.array(CYCLE)
    shift = path.motions(ball)[:, 0]
    # the bulk shears in proportion to the force: the first step tells by how much, its
    # slip is little
    bulk = (shift[1] - shift[0] - first) / force[1]
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    axes = figure.subplots()
    axes.plot(
        1e3 * (shift - shift[0] - bulk * force), force, "o-", label="finite elements"
    )
    fine = np.linspace(-0.8, 0.8, 200) * MU * LOAD
    loop = exact.shift_in_cycle(fine)
    axes.plot(1e3 * loop, fine, color="0.5", label="Mindlin and Deresiewicz")
    axes.plot(-1e3 * loop[::-1], fine, color="0.5")
    axes.set_xlabel("shift [micrometres]")
    axes.set_ylabel("tangential force [N]")
    axes.grid(color="0.9")
    axes.legend()
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    main()
