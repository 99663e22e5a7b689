"""A machine designer's first picture: a bracket from a STEP file on a rigid table, pressed by its bolt.

Run: python examples/step_on_plane.py
"""

from pathlib import Path

import fecontact as fc

STEP = Path(__file__).with_name("bracket.step")


def main(size: float = 4.0, out: str | Path = "out") -> fc.ContactResult:
    mesh = fc.mesh_solid(STEP, size=size)  # mm; N, MPa
    mesh = mesh.with_boundary("under", fc.pick.plane((0, 0, 0), (0, 0, 1)))
    mesh = mesh.with_boundary("washer", fc.pick.near([(24.0, 15.0, 5.0)], 10.0) & fc.pick.plane((0, 0, 5), (0, 0, 1)))
    bracket = fc.ElasticBody(mesh, fc.Material(E=70e3, nu=0.33), contact="under", name="bracket")
    table = fc.RigidBody(fc.Plane(), name="table")
    scene = fc.Scene([bracket, table], [fc.Contact(bracket, table)])
    result = scene.solve(forces={(bracket, "washer"): (0, 0, -8000.0)}, free={bracket: "z rx ry"})
    print(result)
    Path(out).mkdir(parents=True, exist_ok=True)
    result.plot("pressure", Path(out) / "step_on_plane.png", units="MPa")
    return result


if __name__ == "__main__":
    main()
