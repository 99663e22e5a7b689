"""A ball pressed into a bonded metal layer and taken away: what it leaves, beside the
elastic answer.

A quarter of the layer is modelled. The ball moves down by a fiftieth of the thickness
and up again. Up to the first yield both layers carry the same; then the plastic one
carries less, and keeps a dent with stresses round it.

Run: python examples/dent.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact import ancf
from fecontact.ancf.picture import draw_side

STEEL = fc.Material(E=210e3, nu=0.3)
RADIUS, DEPTH, SIZE = 5.0, 0.02, (2.0, 2.0, 1.0)


def main(n: int = 6, steps: int = 8, out: Path | None = None) -> dict[str, float]:
    """Solve with n x n x n/2 bricks, finer towards the contact, draw and print."""
    folder = Path("out") if out is None else out
    folder.mkdir(exist_ok=True)
    block = fc.shapes.block(SIZE, (n, n, n // 2), element="hex8")
    mesh = block.mapped(
        lambda x: (
            x
            * np.column_stack(
                [0.4 + 0.3 * x[:, 0], 0.4 + 0.3 * x[:, 1], 1.4 - 0.4 * x[:, 2]]
            )
        )
    )
    start = np.array([0.0, 0.0, SIZE[2]])
    figure = Figure(figsize=(13.0, 3.4), layout="constrained")
    elastic, plastic, curves, left = figure.subplots(
        1, 4, width_ratios=(1.3, 1.3, 1, 1)
    )
    found = {}
    for axes, (name, material) in zip(
        (elastic, plastic),
        {
            "elastic": STEEL,
            "plastic": ancf.Plastic(STEEL, 400.0, hardening=2000.0),
        }.items(),
        strict=True,
    ):
        layer = ancf.AncfSolid(
            ancf.AncfSpace(mesh), material, points=3, volumetric="linear"
        )
        ball = fc.RigidBody(fc.Sphere(RADIUS))
        held = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
        a = ancf.Assembly.of(
            [layer], [held], [fc.Contact(layer.side("top"), ball.placed(start))]
        )

        def stage(
            depth: float, a: ancf.Assembly = a, ball: fc.RigidBody = ball
        ) -> ancf.Stage:
            return ancf.Stage(a.with_rigid(ball.placed(start - [0.0, 0.0, depth])))

        press = ancf.equilibrium(lambda s: stage(s * DEPTH), steps=steps)
        path = ancf.equilibrium(
            lambda s: stage((1 - 1.2 * s) * DEPTH), steps=steps, start=press.last
        )
        if not path.success:
            raise SystemExit(path.message)
        depth = DEPTH * np.array(
            [s.level for s in press] + [1 - 1.2 * s.level for s in path[1:]]
        )
        force = -4 * np.array(
            [state.contacts[0].force[2] for state in [*press, *path[1:]]]
        )
        end = path.last.assembly.solids[0]
        x = np.column_stack(
            [np.linspace(0, SIZE[0], 61), np.zeros(61), np.full(61, SIZE[2])]
        )
        cells, X = layer.space.located(x)
        dent = end.space.points_at(path.last.q, cells, X)[:, 2] - SIZE[2]
        drawn = draw_side(
            axes,
            press.last.assembly.solids[0],
            press.last.q,
            "y_min",
            limits=(0.0, 800.0),
        )
        axes.set(
            xlim=(0, 1.5), ylim=(0, 1.05), title=f"{name}, pressed", xlabel="x in mm"
        )
        curves.plot([0, *depth], [0, *force / 1e3], "o-", markersize=3, label=name)
        found |= {f"{name} force": force.max(), f"{name} dent": -dent.min()}
        left.plot(x[:, 0], 1e3 * dent)
        found["plastic strain"] = float(end.plastic_strain.max())
    figure.colorbar(
        drawn,
        ax=[elastic, plastic],
        label="equivalent stress in MPa",
        location="bottom",
        shrink=0.5,
    )
    curves.set(xlabel="depth of the ball in mm", title="force in kN")
    curves.legend(loc="upper left")
    left.set(xlabel="x in mm", title="what is left, in µm")
    figure.savefig(folder / "dent.png", dpi=150)
    print(
        "\n".join(f"{key:15} {value:.4g}" for key, value in found.items()),
        path,
        sep="\n",
    )
    return found


if __name__ == "__main__":
    main()
