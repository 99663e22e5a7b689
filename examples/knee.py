"""A parametric knee: femoral and tibial cartilage on rigid bones, four ligaments, flexion from 0 to 90 degrees.

Two condyles of different radii (segments of tori) stand on two plateaus with a bump between them. The cartilage layers
are extruded from the bone surfaces and tied to the bones, which are the frames of the bodies. The tibia is held; the
femur is flexed step by step, pressed down by 1150 N, and free to slide and to tilt (varus/valgus).

Run: python examples/knee.py
"""

from pathlib import Path

import numpy as np

import fecontact as fc
from fecontact.mesh.extrude import extrude
from fecontact.mesh.mesh import Mesh, merge
from fecontact.mesh.surfaces import SurfaceMesh

CARTILAGE = fc.Material(E=10.0, nu=0.45)  # MPa; mm and N throughout
LOAD = 1150.0
SPACING = 23.0  # half the distance of the condyles
SAGITTAL = {"medial": 32.0, "lateral": 29.0}  # radii of the femoral cartilage's surface
FRONTAL = 20.0
THICKNESS = 2.0


def patch(points: np.ndarray) -> SurfaceMesh:
    """Quadrilaterals on a grid of points (n, m, 3)."""
    n, m, _ = points.shape
    index = np.arange(n * m).reshape(n, m)
    corners = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    return SurfaceMesh(points.reshape(-1, 3), np.stack([c.ravel() for c in corners], axis=1))


def condyle(side: str, n: int) -> Mesh:
    """Cartilage of one condyle; the axis of flexion is the x axis, extension at angle 0, the back at +110 degrees."""
    ring = SAGITTAL[side] - FRONTAL
    tube = FRONTAL - THICKNESS
    turn = np.radians(np.linspace(-35.0, 120.0, 3 * n + 1))
    lean = np.radians(np.linspace(-42.0, 42.0, n + 1))
    t, s = np.meshgrid(turn, lean, indexing="ij")
    radius = ring + tube * np.cos(s)
    x = (-SPACING if side == "medial" else SPACING) + tube * np.sin(s)
    bone = patch(np.stack([x, -radius * np.sin(t), -radius * np.cos(t)], axis=-1))
    down = bone.normals[bone.nodes][:, 2].sum() < 0
    return extrude(bone if down else bone.flipped(), THICKNESS, layers=2)


def plateau(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the tibial bone: a dish under the medial condyle, nearly flat under the lateral one, a bump between."""
    dish = ((x + SPACING) ** 2 / 60.0 + y**2 / 120.0) / 2
    flat = ((x - SPACING) ** 2 / 90.0 - y**2 / 400.0) / 2
    blend = 1 / (1 + np.exp(x / 4.0))
    return np.minimum(blend * dish + (1 - blend) * flat, 6.0) + 5.0 * np.exp(-((x / 7.0) ** 2))


def tibia(n: int) -> fc.ElasticBody:
    """Cartilage of the tibia on its bone, which is held."""
    x, y = np.meshgrid(np.linspace(-38.0, 38.0, 3 * n + 1), np.linspace(-24.0, 24.0, 2 * n + 1), indexing="ij")
    bone = patch(np.stack([x, y, plateau(x, y)], axis=-1))
    mesh = extrude(bone if bone.normals[bone.nodes][:, 2].sum() > 0 else bone.flipped(), THICKNESS, layers=2)
    return fc.ElasticBody(mesh, CARTILAGE, contact="top", supports={"base": "xyz"}, name="tibia")


def femur(n: int) -> fc.ElasticBody:
    """Both condyles on one bone, with the axis of flexion along x through the origin."""
    mesh = merge([condyle("medial", n), condyle("lateral", n)], tolerance=1e-6)
    return fc.ElasticBody(mesh, CARTILAGE, contact="top", supports={"base": "xyz"}, name="femur")


#: Height of the femur's axis at which both condyles about touch the plateaus in extension.
HEIGHT = 31.6


def ligaments(bone: fc.ElasticBody) -> list[fc.Spring]:
    """Four ligaments from points of the femur to the ground, which holds the tibia; just taut in extension."""
    places = {
        "MCL": ((-40.0, 2.0, 2.0), (-40.0, -2.0, -40.0), 60.0),
        "LCL": ((40.0, 2.0, 2.0), (40.0, 8.0, -30.0), 50.0),
        "ACL": ((8.0, 8.0, -4.0), (-2.0, -12.0, 2.0), 90.0),
        "PCL": ((-8.0, -4.0, -6.0), (2.0, 20.0, -8.0), 110.0),
    }
    springs = []
    for name, (femoral, tibial, stiffness) in places.items():
        slack = float(np.linalg.norm(np.add(femoral, (0, 0, HEIGHT)) - np.array(tibial)))
        springs.append(fc.Spring(stiffness, (bone, femoral), (None, tibial), slack_length=slack, name=name))
    return springs


def flexed(below: fc.ElasticBody, above: fc.ElasticBody, degrees: float) -> fc.ContactResult:
    """Knee at an angle of flexion; the condensed cartilage is reused from one angle to the next."""
    bone = above.placed((0.0, 0.0, HEIGHT), rotation=fc.rotation_about((1, 0, 0), np.radians(degrees)))
    scene = fc.Scene([below, bone], [fc.Contact(bone, below)], springs=ligaments(bone))
    return scene.solve(forces={bone: (0, 0, -LOAD)}, free={bone: "x y ry"}, finite_motion=True)


def main(n: int = 5, angles: tuple[float, ...] = (0.0, 30.0, 60.0, 90.0), out: str | Path = "out") -> list[dict]:
    below, above = tibia(n), femur(n)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    print(below.describe(), above.describe(), sep="\n")
    print(f"{'flexion':>8}{'medial N':>10}{'lateral N':>11}{'area mm2':>10}{'peak MPa':>10}  ligament tensions N")
    rows = []
    for angle in angles:
        result = flexed(below, above, angle)
        contact = result.contacts[0]
        inner, outer = contact.split_by_plane((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
        tensions = {s.spring.name: s.tension for s in result.springs}
        rows.append(
            {
                "flexion": angle,
                "medial": abs(float(inner.force[2])),
                "lateral": abs(float(outer.force[2])),
                "area": contact.area,
                "peak": contact.max_pressure,
                "tensions": tensions,
                "equilibrium": result.residuals().equilibrium,
            }
        )
        row = rows[-1]
        pulls = "  ".join(f"{name} {pull:.0f}" for name, pull in tensions.items())
        carried = f"{row['medial']:>10.1f}{row['lateral']:>11.1f}{row['area']:>10.1f}{row['peak']:>10.2f}"
        print(f"{angle:>8.0f}{carried}  {pulls}")
        result.plot("pressure", folder / f"knee_{angle:.0f}.png", units="MPa")
    return rows


if __name__ == "__main__":
    main()
