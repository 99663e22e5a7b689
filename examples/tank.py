"""A liquid in a tank that is shaken: bricks that follow the liquid, against walls that
touch and let go.

The tank moves to and fro at the frequency of the first wave, omega^2 = g k tanh(k h)
with k = pi / length, and the liquid answers by larger waves each time. Walls and bottom
are rigid planes in contact without friction.

Run: python examples/tank.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact import ancf
from fecontact.ancf.picture import draw_side

LENGTH, DEPTH, WIDTH, G, DENSITY = 1.0, 0.5, 0.1, 9.81, 1000.0
STROKE = 0.015
#: Time in which the weight grows, so that the liquid does not bounce.
SETTLED = 0.3


def main(n: int = 6, periods: float = 2.0, out: Path | None = None) -> dict[str, float]:
    """Move the tank for some periods, with n x n/2 bricks, draw and print."""
    folder = Path("out") if out is None else out
    folder.mkdir(exist_ok=True)
    k = np.pi / LENGTH
    omega = np.sqrt(G * k * np.tanh(k * DEPTH))
    mesh = fc.shapes.block((LENGTH, WIDTH, DEPTH), (n, 1, n // 2), element="hex8")
    water = ancf.Liquid(bulk=4e3 * DENSITY * G * DEPTH, density=DENSITY)
    liquid = ancf.AncfSolid(
        ancf.AncfSpace(mesh), water, points=3, viscosity=ancf.Viscosity(newtonian=2.0)
    )
    bottom = fc.RigidBody(fc.Plane())
    left, right = (
        bottom.placed(rotation=fc.rotation_about((0, 1, 0), s * np.pi / 2))
        for s in (1, -1)
    )
    sides = {"bottom": bottom, "x_min": left, "x_max": right.placed((LENGTH, 0, 0))}
    contacts = [fc.Contact(liquid.side(side), wall) for side, wall in sides.items()]
    a = ancf.Assembly.of([liquid], [{"y_min": "y", "y_max": "y"}], contacts)

    weight = a.gravity(np.array([0.0, 0.0, -G]))

    def tank(t: float) -> float:
        return STROKE * (1 - np.cos(omega * max(0.0, t - SETTLED)))

    def stage(t: float) -> ancf.Stage:
        walls = (wall.placed((tank(t), 0, 0)) for wall in sides.values())
        return ancf.Stage(a.with_rigid(*walls), forces=min(1.0, t / SETTLED) * weight)

    motion = ancf.move(
        stage,
        until=SETTLED + periods * 2 * np.pi / omega,
        step=0.02,
        scheme=ancf.GeneralisedAlpha(0.5),
        every=1,
    )
    space = liquid.space
    cells, X = space.located([(0.0, WIDTH / 2, DEPTH), (LENGTH, WIDTH / 2, DEPTH)])
    rows = space.rows_at(cells, X)
    level = np.array([(rows @ q.reshape(-1, 3))[:, 2] for q in motion.frames]) - DEPTH
    middles = np.full((len(space.corners), 3), 0.5)
    J = [
        np.linalg.det(space.gradient_at(q, np.arange(len(middles)), middles))
        for q in motion.frames
    ]

    figure = Figure(figsize=(13.0, 3.2), layout="constrained")
    *shapes, beside = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.3))
    for axes, at in zip(shapes, (0.5, 1.25, 1.75), strict=True):
        i = np.abs((motion.frame_times - SETTLED) * omega / (2 * np.pi) - at).argmin()
        draw_side(axes, liquid, motion.frames[i], "y_min", shaded=False)
        x, t = tank(motion.frame_times[i]), motion.frame_times[i]
        axes.plot(
            [x, x, x + LENGTH, x + LENGTH], [0.75, 0, 0, 0.75], color="0.3", linewidth=3
        )
        axes.set(xlim=(-0.05, 1.1), ylim=(-0.03, 0.8), title=f"t = {t:.2f} s")
    beside.plot(motion.frame_times, 100 * level, label=["left wall", "right wall"])
    beside.set(xlabel="time in s", title="level at the walls in cm")
    beside.legend()
    figure.savefig(folder / "tank.png", dpi=150)
    found = {
        "period of the first wave": 2 * np.pi / omega,
        "highest level": level.max(),
        "change of volume": float(np.abs(np.array(J) - 1).max()),
        "success": float(motion.success),
    }
    print(
        "\n".join(f"{name:25} {value:.4g}" for name, value in found.items()),
        motion,
        sep="\n",
    )
    return found


if __name__ == "__main__":
    main()
