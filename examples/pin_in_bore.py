"""A machine designer's first picture: a pin pressed into the bolt hole of a bracket
from a STEP file.

The hole is named by a point on its wall, and the mesh is divided until the pressure is
known to 10 %.

Run: python examples/pin_in_bore.py
"""

from pathlib import Path

import numpy as np

import fecontact as fc

HERE = Path(__file__).parent
# copied, they lie beside this script
MESHES = HERE.parent / "meshes" if (HERE.parent / "meshes").is_dir() else HERE
STEP = MESHES / "bracket.step"
BORE, PIN, THICK, FORCE = 5.0, 4.95, 5.0, 2000.0  # radii and thickness in mm, N
ALUMINIUM = fc.Material(E=70e3, nu=0.33)  # MPa


def main(
    size: float = 4.0, accuracy: float = 0.1, out: str | Path = "out"
) -> fc.ContactResult:
    low = (24.0, 10.0, 2.5)  # where the pin will press
    mesh = fc.mesh_solid(STEP, size=size, near=[low], near_size=1.5)
    mesh = mesh.with_boundary("bore", fc.pick.flood(low)).with_boundary(
        "wall", fc.pick.plane((0, 0, 0), (-1, 0, 0))
    )
    bracket = fc.ElasticBody(
        mesh, ALUMINIUM, contact="bore", supports={"wall": "xyz"}, name="bracket"
    )
    # the cylinder's axis from y to z
    upright = fc.rotation_about((1, 0, 0), -np.pi / 2)
    pin = fc.RigidBody(fc.surfaces.Cylinder(PIN), name="pin").placed(low, upright)
    scene = fc.Scene(
        [bracket, pin], [fc.Contact(bracket, pin)], units=("mm", "N", "MPa")
    )
    result = scene.solve(
        forces={pin: (0, -FORCE, 0)}, free={pin: "x"}, accuracy=accuracy
    )
    print(result)
    exact = fc.analytic.hertz.line((-BORE, PIN), (ALUMINIUM, None), force=FORCE / THICK)
    print(
        f"peak {result.contacts[0].max_pressure:.1f} MPa; of a pin in a half-space's "
        f"groove {exact.p0:.1f} MPa"
    )
    Path(out).mkdir(parents=True, exist_ok=True)
    result.plot("pressure", Path(out) / "pin_in_bore.png")
    return result


if __name__ == "__main__":
    main()
