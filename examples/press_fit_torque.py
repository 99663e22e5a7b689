"""The torque of a press fit: a steel hub on a shaft, twisted until friction no longer
holds it.

The interference presses the hub on the shaft by a negative gap. The hub is then turned
in load steps, first by as little as it sticks, at last until it slides: the torque is
that of the reaction. Under a torque instead of a turn it holds up to the same limit.

Run: python examples/press_fit_torque.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.analytic import cylinder

STEEL = fc.Material(E=210e3, nu=0.3)  # mm, N, MPa
RIGID = fc.Material(E=1e6 * STEEL.E, nu=0.3)
SEAT, RIM, WIDTH, INTERFERENCE, MU = 20.0, 35.0, 8.0, 0.02, 0.12


def main(n: int = 3, out: str | Path = "out") -> dict[str, float]:
    mesh = fc.shapes.thick_ring(SEAT, RIM, WIDTH, (n, n, 1), sector="full")
    hub = fc.ElasticBody(mesh, STEEL, "inner", {"bottom": "z", "top": "z"}, name="hub")
    shaft = fc.RigidBody(fc.surfaces.Cylinder(SEAT + INTERFERENCE), name="shaft")
    # the cylinder lies along y with its top at the origin: set it upright, round the
    # axis of the hub
    shaft = shaft.placed((0, 0, -SEAT - INTERFERENCE)).placed(
        rotation=fc.rotation_about((1, 0, 0), np.pi / 2)
    )
    scene = fc.Scene([hub, shaft], [fc.Contact(hub, shaft, friction=MU)])

    lame = cylinder.shrink_fit(
        radii=(0.0, SEAT, RIM),
        materials=(RIGID, STEEL),
        interference=INTERFERENCE,
        plane="strain",
    )
    expected = MU * lame.pressure * 2 * np.pi * SEAT**2 * WIDTH

    turns = 1e-5 * np.arange(7)  # radians
    turned = scene.solve_path([{"motions": {hub: {"rz": turn}}} for turn in turns])
    torque = np.array([result.reaction(hub)[5] for result in turned.steps])
    print(turned)
    loaded = scene.solve_path(
        [
            {"moments": {hub: (0, 0, m)}, "free": {hub: "rz"}}
            for m in (0.0, 0.98 * expected)
        ]
    )
    held = loaded[1].contacts[0].friction
    figures = {
        "torque at slip": float(torque[-1]),
        "by Lame's pressure": expected,
        "slip under 0.98 of it, a share of the last turn's": float(
            np.abs(held.slip).max() / (SEAT * turns[-1])
        ),
        "largest residual": max(
            r.friction.residuals.worst for path in (turned, loaded) for r in path.steps
        ),
    }
    for name, value in figures.items():
        print(f"{name:<52}{value:.6g}")

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.plot(1e6 * turns, torque / 1e3, "o-", label="finite elements")
    axes.axhline(expected / 1e3, color="0.5", label="friction by Lame's pressure")
    axes.set_xlabel("turn of the hub [microradians]")
    axes.set_ylabel("torque [Nm]")
    axes.grid(color="0.9")
    axes.legend()
    figure.savefig(folder / "press_fit_torque.png", dpi=150)
    return figures


if __name__ == "__main__":
    main()
