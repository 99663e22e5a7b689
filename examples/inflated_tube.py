"""A rubber tube inflated between two rolls, then let go: pressure that follows the
bore, as a function of time.

The pressure acts along the present normals and per present area. It is raised slowly
until the tube lies on the rolls, then falls to nothing in half a unit of time; the tube
springs back and swings, damped by its viscosity. A quarter is modelled, one brick long.

Run: python examples/inflated_tube.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact import ancf
from fecontact.ancf.picture import draw_side

LENGTH, PRESSURE = 0.25, 0.055


def quarter(x: np.ndarray) -> np.ndarray:
    """Points of a tube of inner radius 0.8, from depth, place along it and angle."""
    return np.stack(
        [(0.8 + x[:, 0]) * np.cos(x[:, 2]), x[:, 1], (0.8 + x[:, 0]) * np.sin(x[:, 2])],
        axis=1,
    )


def main(n: int = 8, until: float = 6.0, out: Path | None = None) -> dict[str, float]:
    """Solve with n bricks, draw and print."""
    folder, roll = (
        Path("out") if out is None else out,
        fc.RigidBody(fc.surfaces.Cylinder(0.6)),
    )
    folder.mkdir(exist_ok=True)
    mesh = fc.shapes.block((0.2, LENGTH, np.pi / 2), (1, 1, n), element="hex20").mapped(
        quarter
    )
    rubber, viscosity = (
        fc.NeoHookean(E=1.0, nu=0.49, density=0.2),
        ancf.Viscosity(retardation=0.1),
    )
    tube = ancf.AncfSolid(
        ancf.AncfSpace(mesh), rubber, points=3, volumetric="linear", viscosity=viscosity
    )
    held = {"bottom": "z", "top": "x", "y_min": "y", "y_max": "y"}
    a = ancf.Assembly.of(
        [tube], [held], [fc.Contact(tube.side("x_max"), roll.placed((0, 0, 1.05)))]
    )

    def stage(share: float) -> ancf.Stage:
        return ancf.Stage(
            a, follow=[ancf.FollowerPressure(0, "x_min", share * PRESSURE)]
        )

    path = ancf.equilibrium(stage, steps=8)
    if not path.success:
        raise SystemExit(path.message)
    scheme = ancf.EnergyMomentum()
    swing = ancf.move(
        lambda t: stage(max(0.0, 1 - 2 * t)),
        until=until,
        step=0.05,
        scheme=scheme,
        start=path.last,
        every=1,
    )
    side = tube.space.rows_at(np.array([0]), np.array([[1.0, 0.5, 0.0]]))
    radius = np.array([(side @ q.reshape(-1, 3))[0, 0] for q in swing.frames])
    push = [
        a.conditions(s.q).G.T
        @ s.forces[0]
        @ a.translation(np.array([0, 0, -2.0]))
        / LENGTH
        for s in path.steps
    ]

    figure = Figure(figsize=(13.0, 3.8), layout="constrained")
    *shapes, below, beside = figure.subplots(1, 5, width_ratios=(1, 1, 1, 1.2, 1.2))
    shown = {
        "at rest": a.q0,
        "inflated": path.last.q,
        "let go, smallest": swing.frames[radius.argmin()],
    }
    for axes, (title, q) in zip(shapes, shown.items(), strict=True):
        drawn = draw_side(axes, tube, q, "y_min", limits=(0.0, 0.5))
        t = np.linspace(np.pi, 2 * np.pi, 61)
        axes.fill(
            0.6 * np.cos(t), 1.65 + 0.6 * np.sin(t), facecolor="0.9", edgecolor="0.4"
        )
        axes.set(xlim=(0, 1.5), ylim=(0, 1.7), title=title)
    figure.colorbar(
        drawn, ax=shapes, label="equivalent stress", location="bottom", shrink=0.5
    )
    below.plot([PRESSURE * s.level for s in path.steps], push, "o-")
    below.set(xlabel="pressure", title="force of a roll / length")
    beside.plot(swing.frame_times, radius)
    beside.set(xlabel="time", title="radius at the side")
    figure.savefig(folder / "inflated_tube.png", dpi=150)
    figures = {
        "force": push[-1],
        "largest radius": radius.max(),
        "last radius": radius[-1],
        "energy drift": swing.drift,
    }
    print(
        "\n".join(f"{name:18} {value:.5g}" for name, value in figures.items()),
        swing.message,
        sep="\n",
    )
    return figures


if __name__ == "__main__":
    main()
