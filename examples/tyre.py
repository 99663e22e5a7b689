"""A tyre on its hub: a shell of bricks, inflated, then pressed on the ground until its
patch is flat.

A quarter is modelled: half of the circumference and half of the section. Its rim
follows a rigid hub, which moves down; the pressure inside follows the present surface.
The ground bears what the hub presses.

Run: python examples/tyre.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact import ancf
from fecontact.ancf.picture import draw_side

RADIUS, SECTION, THICKNESS, TO_RIM = 250.0, 80.0, 12.0, 2.2
RUBBER, PRESSURE, DOWN = fc.NeoHookean(E=30.0, nu=0.45), 0.2, 25.0
OUTSIDE = RADIUS + SECTION + THICKNESS / 2


def torus(x: np.ndarray) -> np.ndarray:
    """Points in mm from the angle from the top, that from the middle of the tread to
    the rim, and the depth.
    """
    a = SECTION + x[:, 2] - THICKNESS / 2
    r = RADIUS + a * np.cos(x[:, 1])
    return np.stack(
        [r * np.sin(x[:, 0]), a * np.sin(x[:, 1]), r * np.cos(x[:, 0])], axis=1
    )


def main(n: int = 12, steps: int = 4, out: Path | None = None) -> dict[str, float]:
    """Inflate and press a shell of n bricks round half of the circumference, draw and
    print.
    """
    folder = Path("out") if out is None else out
    folder.mkdir(exist_ok=True)
    shell_mesh = fc.shapes.block(
        (np.pi, TO_RIM, THICKNESS), (n, 4, 1), element="hex20"
    ).mapped(torus)
    shell = ancf.AncfSolid(ancf.AncfSpace(shell_mesh), RUBBER, points=3)
    hub_mesh = fc.shapes.block(
        (100.0, 60.0, 100.0), (1, 1, 1), element="hex8"
    ).translated((-50.0, 0.0, -50.0))
    hub = ancf.AncfSolid(ancf.AncfSpace(hub_mesh), RUBBER)
    ground = fc.RigidBody(fc.Plane()).placed((0, 0, -OUTSIDE))
    joints = ancf.Joints([shell, hub])
    ties = [
        joints.held(0, {"x_min": "x", "x_max": "x", "y_min": "y"}),
        joints.affine(1),
        joints.follows(0, "y_max", 1),
        joints.held(1, {"bottom": "xyz", "x_min": "xyz", "y_min": "xyz"}),
    ]
    a = ancf.Assembly([shell, hub], ties, [fc.Contact(shell.side("top"), ground)])
    lower = a.held(a.translation(np.array([0.0, 0.0, -DOWN])))

    def stage(pressed: float, pressure: float) -> ancf.Stage:
        inside = ancf.FollowerPressure(0, "bottom", pressure * PRESSURE)
        return ancf.Stage(a, motion=pressed * lower, follow=[inside])

    blown = ancf.equilibrium(lambda s: stage(0.0, s), steps=steps)
    path = ancf.equilibrium(lambda s: stage(s, 1.0), steps=2 * steps, start=blown.last)
    if not path.success:
        raise SystemExit(path.message)
    loads = [4 * s.contacts[0].force[2] for s in path]
    found = {
        "load": abs(loads[-1]),
        "patch": 4 * path.last.contacts[0].point_area,
        "grown by": float(
            np.abs(
                shell.space.points_at(blown.last.q[: shell.n_dofs], *top(shell))[0, 2]
            )
            - OUTSIDE
        ),
    }
    found["load / patch"] = found["load"] / found["patch"]
    figure = Figure(figsize=(12.0, 4.2), layout="constrained")
    side, section, curve = figure.subplots(1, 3)
    for axes, boundary, plane in ((side, "top", (0, 2)), (section, "x_max", (1, 2))):
        draw_side(
            axes,
            shell,
            a.q0[: shell.n_dofs],
            boundary,
            plane=plane,
            shaded=False,
            colors="0.75",
        )
        q = path.last.q[: shell.n_dofs]
        drawn = draw_side(axes, shell, q, boundary, plane=plane, limits=(0.0, 3.0))
        axes.axhline(-OUTSIDE, color="0.3")
    side.set(title="half of the tyre, from the side")
    section.set(title="half of its section, below")
    figure.colorbar(
        drawn,
        ax=[side, section],
        label="equivalent stress in MPa",
        location="bottom",
        shrink=0.5,
    )
    curve.plot([DOWN * s.level for s in path], np.abs(loads) / 1e3, "o-")
    curve.set(xlabel="hub sinks by, in mm", title="load in kN")
    figure.savefig(folder / "tyre.png", dpi=150)
    print(
        "\n".join(f"{name:13} {value:.5g}" for name, value in found.items()),
        path,
        sep="\n",
    )
    return found


def top(shell: ancf.AncfSolid) -> tuple[np.ndarray, np.ndarray]:
    """The outermost point of the shell, at the top."""
    return shell.space.located([(0.0, 0.0, OUTSIDE)])


if __name__ == "__main__":
    main()
