"""A leaf spring: three leaves clamped at the middle of the car's axle, one on the
other, with friction between them.

Half of it is modelled. The end of the main leaf is loaded and let go: leaves press on
each other near their ends and slide, so that the spring is stiffer on the way down than
on the way back, and takes up work.

Run: python examples/leaf_spring.py
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact import ancf
from fecontact.ancf.slender import Joints, line, straight

SPRING_STEEL, WIDTH, THICKNESS, FORCE = 210e3, 60.0, 8.0, 1500.0
LEAVES = {600.0: 12, 450.0: 10, 300.0: 8}  # lengths, and numbers of elements


def spring(friction: float) -> ancf.Assembly:
    """Leaves from the main one downwards, in N and mm."""
    area, bending = WIDTH * THICKNESS, WIDTH * THICKNESS**3 / 12
    leaves = [
        line(
            straight((0, -k * THICKNESS, 0), (size, -k * THICKNESS, 0), n),
            EA=SPRING_STEEL * area,
            EI=SPRING_STEEL * bending,
        )
        for k, (size, n) in enumerate(LEAVES.items())
    ]
    joints = Joints(leaves)
    sides = [leaf.side(THICKNESS / 2) for leaf in leaves]
    contacts = [
        fc.Contact(upper, lower, friction=friction) for upper, lower in pairwise(sides)
    ]
    return ancf.Assembly(
        leaves,
        [joints.flat(), *(joints.clamped((k, 0)) for k in range(len(leaves)))],
        contacts,
    )


def cycle(a: ancf.Assembly, steps: int) -> tuple[ancf.Path, ancf.Path]:
    """States as the force grows and as it falls."""
    load = ancf.force_at(a.solids[0], (max(LEAVES), 0, 0), (0, -FORCE, 0))
    load = np.concatenate([load, np.zeros(a.n_dofs - len(load))])
    down = ancf.equilibrium(lambda s: ancf.Stage(a, s * load), steps=steps)
    back = ancf.equilibrium(
        lambda s: ancf.Stage(a, (1 - s) * load), steps=steps, start=down.last
    )
    if not (down.success and back.success):
        raise SystemExit(f"{down.message} {back.message}")
    return down, back


def main(
    friction: float = 0.3, steps: int = 6, out: Path | None = None
) -> dict[str, float]:
    """Load and let go, without friction too, draw and print."""
    folder = Path("out") if out is None else out
    folder.mkdir(exist_ok=True)
    figure = Figure(figsize=(12.5, 3.2), layout="constrained")
    shapes, curves, loops = figure.subplots(1, 3, width_ratios=(1.5, 1, 1))
    found, smooth = {}, np.zeros((2, 0))
    for mu in (0.0, friction):
        a = spring(mu)
        down, back = cycle(a, steps)
        states = [*down, *back[1:]]
        force = FORCE * np.array(
            [0.0, *(s.level for s in down), *(1 - s.level for s in back[1:])]
        )
        sunk = np.array(
            [0.0, *(-a.solids[0].positions(a.part(s.q, 0))[-1, 1] for s in states)]
        )
        smooth = smooth if smooth.size else np.sort([sunk, force])
        loops.plot(sunk, force - np.interp(sunk, *smooth), "o-", markersize=3)
        curves.plot(sunk, force, "o-", markersize=3, label=f"friction {mu:g}")
        found |= {
            f"sunk by, friction {mu:g}": sunk.max(),
            f"work taken up, friction {mu:g}": np.trapezoid(force, sunk),
        }
    for k, leaf in enumerate(a.solids):
        for q, colour in ((a.q0, "0.7"), (down.last.q, f"C{k}")):
            x = leaf.points(a.part(q, k)).reshape(-1, 3)
            shapes.plot(x[:, 0], x[:, 1], color=colour, linewidth=2.5)
    shapes.set(title="at rest and loaded", xlabel="x in mm", aspect="equal")
    curves.set(xlabel="end sinks by, in mm", title="force in N")
    curves.legend()
    loops.set(
        xlabel="end sinks by, in mm", title="force less that without friction, in N"
    )
    figure.savefig(folder / "leaf_spring.png", dpi=150)
    print(
        "\n".join(f"{name:30} {value:.5g}" for name, value in found.items()),
        down,
        sep="\n",
    )
    return found


if __name__ == "__main__":
    main()
