"""A belt on two pulleys: tension, stick and slip while one of them is turned.

The belt is a cable of absolute nodal coordinates that nothing holds but the friction of
the pulleys. One pulley is pulled away until the belt is tight; then the other is
turned. Points slip where the belt leaves it first, then on the whole arc: the tensions
have reached Euler and Eytelwein's exp(mu pi), and the torque grows no more.

Run: python examples/belt_drive.py
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.analytic import friction
from fecontact.ancf import Assembly, Stage, State, equilibrium
from fecontact.ancf.slender import Joints, Structure, line

MU, RADIUS, DISTANCE, EA, EI = 0.3, 1.0, 3.0, 100.0, 2e-2


def pulley(x: float, turn: float = 0.0) -> fc.RigidBody:
    """A cylinder along z at (x, 0), turned about its axis."""
    along = fc.rotation_about((0, 0, 1), turn) @ fc.rotation_about(
        (1, 0, 0), math.pi / 2
    )
    body = fc.RigidBody(fc.surfaces.Cylinder(RADIUS), name="pulley").placed(
        (0, 0, -RADIUS)
    )
    return body.placed(rotation=along).placed((x, 0, 0))


def belt(n: int, m: int) -> Structure:
    """A closed belt without stress: n elements on each half pulley, m on each span."""
    points, tangents = [], []
    for x, first in ((0.0, math.pi / 2), (DISTANCE, -math.pi / 2)):
        angle = first + np.linspace(0, math.pi, n + 1)
        radial = np.stack([np.cos(angle), np.sin(angle), np.zeros(n + 1)], axis=1)
        along = np.stack([-np.sin(angle), np.cos(angle), np.zeros(n + 1)], axis=1)
        span = np.arange(1, m)[:, None] / m * DISTANCE * along[-1]
        points += [[x, 0, 0] + RADIUS * radial, [x, 0, 0] + RADIUS * radial[-1] + span]
        tangents += [along, np.tile(along[-1], (m - 1, 1))]
    closed = [np.concatenate([*parts, parts[0][:1]]) for parts in (points, tangents)]
    return line(closed[0], EA=EA, EI=EI, tangents=closed[1])


def main(n: int = 24, turns: int = 12, out: Path | None = None) -> dict[str, float]:
    """Solve, draw and print."""
    folder = Path("out") if out is None else out
    folder.mkdir(exist_ok=True)
    m = n // 3
    band = belt(n, m)
    joints = Joints([band])
    closed = [joints.flat(), joints.rigid((0, 0), (0, -1))]
    driver, driven = (
        [len(band.cells) - 1, *range(n + 1)],
        range(n + m - 1, 2 * n + m + 1),
    )
    a = Assembly(
        [band],
        closed,
        [
            fc.Contact(band.side(elements=driver), pulley(0.0), friction=MU),
            fc.Contact(band.side(elements=driven), pulley(DISTANCE), friction=MU),
        ],
    )
    states = [
        equilibrium(
            lambda s: Stage(a.with_rigid(pulley(0.0), pulley(DISTANCE + 0.02 * s))),
            steps=1,
        ).last
    ]
    angles = np.linspace(0, 0.012, turns + 1)
    for turn in angles[1:]:
        stage = Stage(a.with_rigid(pulley(0.0, turn), pulley(DISTANCE + 0.02)))
        path = equilibrium(lambda _, at=stage: at, steps=1, start=states[-1])
        if not path.success:
            raise SystemExit(path.message)
        states.append(path.last)
    tension = np.array([EA * band.strains(s.q, 0)[..., 0].mean(axis=1) for s in states])
    slack, tight = tension[:, n + m // 2], tension[:, -1 - m // 2]
    draw(band, states[-1], tension[-1], angles, (slack, tight)).savefig(
        folder / "belt_drive.png", dpi=150
    )
    figures = {
        "tension at rest": slack[0],
        "slack": slack[-1],
        "tight": tight[-1],
        "tight / slack": tight[-1] / slack[-1],
        "of Euler and Eytelwein": friction.belt_tension(1.0, MU, math.pi),
        "torque": RADIUS * (tight[-1] - slack[-1]),
        "work of friction": sum(s.friction.friction_work for s in states[1:]),
        "defect of Coulomb's law": max(s.residuals.slip for s in states),
    }
    print("\n".join(f"{name:26} {value:.5g}" for name, value in figures.items()))
    return figures


def draw(
    band: Structure,
    state: State,
    tension: np.ndarray,
    angles: np.ndarray,
    spans: tuple[np.ndarray, np.ndarray],
) -> Figure:
    """The belt coloured by its tension, and both tensions while the pulley turns."""
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
    for x in (0.0, DISTANCE + 0.02):
        t = np.linspace(0, 2 * math.pi, 100)
        left.fill(x + RADIUS * np.cos(t), RADIUS * np.sin(t), color="0.9")
    pieces = LineCollection(
        list(band.points(state.q)[..., :2]), cmap="viridis", linewidths=4
    )
    pieces.set_array(tension)
    left.add_collection(pieces)
    figure.colorbar(pieces, ax=left, label="tension", location="bottom")
    left.set(
        aspect="equal",
        xlim=(-1.3, DISTANCE + 1.3),
        ylim=(-1.3, 1.3),
        title="belt, left pulley turned",
        xlabel="x",
        ylabel="y",
    )
    for values, name in zip(spans, ("slack span", "tight span"), strict=True):
        right.plot(1e3 * angles, values, "o-", label=name)
    limit = spans[0][-1] * friction.belt_tension(1.0, MU, math.pi)
    right.axhline(limit, color="0.5", linestyle="--", label="slack exp(mu pi)")
    right.set(xlabel="turn of the pulley [mrad]", ylabel="tension", ylim=(0, None))
    right.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    main()
