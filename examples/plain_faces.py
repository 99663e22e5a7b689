"""Why contact faces carry a ninth node: the plain 20-node element beside it, on Hertz
and on a uniform patch.

Run: python examples/plain_faces.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.app.studies.spheres import CASES, solve_spheres
from fecontact.common.files import save_figure
from fecontact.results.field_map import field_map
from fecontact.results.pictures.draw import draw_field


def patch(pressure: str, n: int = 3) -> fc.ContactResult:
    """A block under uniform compression; every contact force should be a share of one
    and the same pressure.
    """
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (n, n, n))
    supports = {"top": "z", "x_min": "x", "y_min": "y"}
    block = fc.ElasticBody(
        mesh, fc.Material(1.0, 0.3), "bottom", supports, pressure=pressure, name="block"
    )
    floor = fc.RigidBody(fc.Plane())
    return fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(
        forces={block: (0, 0, -0.01)}
    )


def main(level: int = 2, out: str | Path = "out") -> dict[str, float]:
    errors = {}
    figure = Figure(figsize=(11.0, 9.0), layout="constrained")
    for row, pressure in zip(figure.subplots(2, 2), ("midface", "nodal"), strict=True):
        hertz = solve_spheres(
            "equal", model="symmetric", level=level, pressure=pressure
        )
        errors[pressure] = hertz.figures["pressure, L2"].found
        exact, (contact,) = CASES["equal"].hertz, hertz.solved.contacts
        radius = np.hypot(contact.points[:, 0], contact.points[:, 1])
        near = radius < 1.3 * exact.a
        r = np.linspace(0, 1.3 * exact.a, 500)
        row[0].plot(radius[near], contact.pressure[near], "o", markersize=4)
        row[0].plot(r, exact.pressure(r), "k")
        row[0].set_title(f"{pressure}: Hertz, L2 error {100 * errors[pressure]:.1f} %")
        row[0].set_xlabel("radius [cm]")
        row[0].set_ylabel("pressure [kgf/cm²]")
        uniform = patch(pressure).contacts[0]
        draw_field(row[1], field_map(uniform, "pressure"), top=0.0125)
        idle = f"{(~uniform.active).sum()} of {len(uniform.points)} points idle"
        row[1].set_title(f"{pressure}: uniform pressure of 0.01, {idle}", fontsize=10)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder / "plain_faces.png")
    for name, error in errors.items():
        print(f"{name:8} pressure L2 error {100 * error:6.2f} %")
    return errors


if __name__ == "__main__":
    main()
