"""Woven yarns pulled in one direction: they straighten, and the others take over their
waves.

Yarns are beams of absolute nodal coordinates, bent to waves without stress, that cross
over and under each other with friction. Pulled, those along x straighten at first with
little force and push the others to larger waves, which makes these shorter; then they
stretch.

Run: python examples/woven_yarns.py
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.ancf import Assembly, Stage, equilibrium
from fecontact.ancf.slender import Joints, Structure, beam

RADIUS, PITCH, MU, STRAIN = 0.06, 1.0, 0.2, 0.02
X, Y, Z = np.eye(3)


def yarn(n: int, number: int, along: int, elements: int) -> Structure:
    """Yarn of a plain weave of n by n, along x (0) or y (1), with a number of elements
    between crossings.
    """
    s = np.linspace(-0.5, n - 0.5, elements * n + 1)
    high = RADIUS * (-1) ** (number + along)
    points = np.zeros((len(s), 3))
    points[:, along], points[:, 1 - along] = PITCH * s, PITCH * number
    points[:, 2] = high * np.cos(math.pi * s)
    tangents = np.zeros_like(points)
    tangents[:, along], tangents[:, 2] = PITCH, -high * math.pi * np.sin(math.pi * s)
    side = math.sqrt(math.pi) * RADIUS  # of a square as large as the circle
    size = np.linalg.norm(tangents, axis=1, keepdims=True)
    return beam(
        points,
        fc.Material(E=1000.0, nu=0.0),
        width=side,
        height=side,
        tangents=tangents / size,
    )


def main(
    n: int = 3, elements: int = 4, steps: int = 8, out: Path | None = None
) -> dict[str, float]:
    """Solve, draw and print."""
    folder = Path("out") if out is None else out
    folder.mkdir(exist_ok=True)
    yarns = [yarn(n, k, along, elements) for along in (0, 1) for k in range(n)]
    joints, held, ends = Joints(yarns), [], []
    for k in range(2 * n):
        own = X if k < n else Y
        # ends stay in the middle plane and do not twist; yarns across are drawn in at
        # their far ends
        held += [
            joints.pinned((k, 0)),
            joints.guided((k, 0), 2, Z),
            joints.pinned((k, -1), [Z, Y if k < n else X]),
        ]
        ends += [joints.pinned((k, -1), own)] if k < n else []
    touches = [
        fc.Contact(yarns[k].side(RADIUS), yarns[n + j].side(RADIUS), friction=MU)
        for k in range(n)
        for j in range(n)
    ]
    a = Assembly(yarns, [*held, *ends], touches)
    motion = joints.motion(
        [*held, *ends], [None] * len(held) + [[STRAIN * n * PITCH]] * n
    )
    path = equilibrium(lambda level: Stage(a, motion=level * motion), steps=steps)
    if not path.success:
        raise SystemExit(path.message)
    strain = STRAIN * np.array([0.0, *(s.level for s in path.steps)])
    states = [a.q0, *(s.q for s in path.steps)]
    # the middle yarns: where an end is, what pulls it, how high the wave is, and what
    # presses at their crossing
    middle = n // 2
    pulled = np.array([0.0, *(a.part(s.reactions, middle)[-12] for s in path.steps)])
    shorter = -np.array(
        [
            yarns[n].positions(a.part(q, n + middle))[-1, 1] - (n - 0.5) * PITCH
            for q in states
        ]
    )
    pressed = np.array(
        [0.0, *(s.forces[middle * n + middle].sum() for s in path.steps)]
    )
    waves = [
        [np.abs(yarns[k].points(a.part(q, k))[..., 2]).max() for q in states]
        for k in (middle, n + middle)
    ]
    draw(
        yarns, (a.q0, path.last.q), n, strain, [pulled, pressed, shorter / (n * PITCH)]
    ).savefig(folder / "woven_yarns.png", dpi=150)
    figures = {
        "strain": strain[-1],
        "pull of a yarn": pulled[-1],
        "stiffness at first": pulled[1] / strain[1],
        "stiffness at last": (pulled[-1] - pulled[-2]) / (strain[-1] - strain[-2]),
        "of a straight yarn": 1000.0 * math.pi * RADIUS**2,
        "force at a crossing": pressed[-1],
        "wave, pulled yarn": waves[0][-1] / RADIUS,
        "wave, yarn across": waves[1][-1] / RADIUS,
        "contraction across": shorter[-1] / (n * PITCH),
        "defect of Coulomb's law": max(s.residuals.slip for s in path.steps),
    }
    print("\n".join(f"{name:26} {value:.5g}" for name, value in figures.items()))
    return figures


def draw(
    yarns: list[Structure],
    states: tuple[np.ndarray, np.ndarray],
    n: int,
    strain: np.ndarray,
    curves: list[np.ndarray],
) -> Figure:
    """Cuts along a pulled yarn and along one across, at rest and pulled, and forces
    over the strain.
    """
    figure = Figure(figsize=(10.0, 3.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.6, 1.0))
    starts, t = (
        np.cumsum([0] + [y.n_dofs for y in yarns]),
        np.linspace(0, 2 * math.pi, 60),
    )
    for row, (shown, across, axis) in enumerate(
        ((n // 2, range(n, 2 * n), 0), (n + n // 2, range(n), 1))
    ):
        plot = figure.add_subplot(grid[row, 0])
        for q, colour, size in zip(states, ("0.75", "C0"), (1.0, 1.5), strict=True):
            line = (
                yarns[shown]
                .points(q[starts[shown] : starts[shown + 1]])[:, :-1]
                .reshape(-1, 3)
            )
            slope = np.gradient(line, axis=0)
            up = (
                RADIUS
                * np.stack([-slope[:, 2], slope[:, axis]])
                / np.linalg.norm(slope, axis=1)
            )
            for side in (-1, 1):
                plot.plot(
                    line[:, axis] + side * up[0],
                    line[:, 2] + side * up[1],
                    color=colour,
                    linewidth=size,
                )
            for k in across:
                # where the yarn across passes through the plane of the cut
                other = yarns[k].points(q[starts[k] : starts[k + 1]]).reshape(-1, 3)
                at = other[
                    np.abs(other[:, 1 - axis] - line[:, 1 - axis].mean()).argmin()
                ]
                round_ = at[axis] + RADIUS * np.cos(t), at[2] + RADIUS * np.sin(t)
                plot.plot(*round_, color=colour, linewidth=size)
        name = ("along a pulled yarn", "along a yarn across")[row]
        plot.set(
            aspect="equal",
            title=f"{name}: at rest (grey), pulled (blue)",
            xlabel="xy"[axis],
        )
    plot = figure.add_subplot(grid[:, 1])
    plot.plot(100 * strain, curves[0], "o-", label="pull of a yarn")
    plot.plot(100 * strain, curves[1], "s-", label="force at a crossing")
    plot.plot([], [], "k--", label="contraction across")
    plot.set(xlabel="strain [%]", ylabel="force", ylim=(0, None))
    plot.legend(fontsize="small", loc="upper left")
    other = plot.twinx()
    other.plot(100 * strain, 100 * curves[2], "k--")
    other.set(ylabel="contraction across [%]", ylim=(0, None))
    return figure


if __name__ == "__main__":
    main()
