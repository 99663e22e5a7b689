"""A parametric knee: femoral and tibial cartilage on rigid bones, four ligaments,
flexion from 0 to 90 degrees.

Two condyles of different radii (segments of tori) stand on two plateaus with a bump
between them. The cartilage layers are extruded from the bone surfaces and tied to the
bones, which are the frames of the bodies. The tibia is held; the femur is flexed step
by step, pressed down by 1150 N, and free to slide and to tilt (varus/valgus).

Menisci can be added: two rings of wedge section, open towards the middle and held at
their horns on the tibia, shaped to the gap beside the contact. They are isotropic and
linear, so their share of the load shows the principle, no more; the pressures on their
thin inner edges depend on the mesh.

Run: python examples/knee.py            (both condyles on the plateaus)
     python examples/knee.py menisci    (each angle without and with menisci)
     python examples/knee.py finite     (cartilage of small strains and of finite ones)
     python examples/knee.py --accuracy 0.05  (divided until the pressure on the
                                               plateaus is within 5 %)
"""

import argparse
import time
from pathlib import Path

import numpy as np

import fecontact as fc
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.shapes import lattice
from fecontact.mesh.surface_mesh import SurfaceMesh

CARTILAGE = fc.Material(E=10.0, nu=0.45)  # MPa; mm and N throughout
#: The law that fitted strains of cartilage by magnetic resonance best in Butz et al.
#: (2011, J. Biomech. 44, 2667), with the moduli above, of short loads.
LAW = fc.NeoHookean(CARTILAGE.E, CARTILAGE.nu)
# isotropic; a real one is stiffer around and softer across
MENISCUS = fc.Material(E=80.0, nu=0.3)
RING = (9.5, 13.0)  # inner and outer radius of the menisci
OPENING = 50.0  # half of the angle that the C leaves open, degrees
#: How much higher than the gap in the loaded knee the wedge is between its horns, as
#: the unloaded gap that it fits is higher by the approach of the bones; and its least
#: thickness.
REACH, THINNEST = 0.4, 0.3
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
    return SurfaceMesh(
        points.reshape(-1, 3), np.stack([c.ravel() for c in corners], axis=1)
    )


def condyle(side: str, n: int) -> Mesh:
    """Cartilage of one condyle; the axis of flexion is the x axis, extension at angle
    0, the back at +110 degrees.
    """
    ring = SAGITTAL[side] - FRONTAL
    tube = FRONTAL - THICKNESS
    turn = np.radians(np.linspace(-35.0, 120.0, 3 * n + 1))
    lean = np.radians(np.linspace(-42.0, 42.0, n + 1))
    t, s = np.meshgrid(turn, lean, indexing="ij")
    radius = ring + tube * np.cos(s)
    x = (-SPACING if side == "medial" else SPACING) + tube * np.sin(s)
    bone = patch(np.stack([x, -radius * np.sin(t), -radius * np.cos(t)], axis=-1))
    down = bone.normals[bone.nodes][:, 2].sum() < 0
    return fc.extrude(bone if down else bone.flipped(), THICKNESS, layers=2)


def plateau(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the tibial bone: a dish under the medial condyle, nearly flat under the
    lateral one, a bump between.
    """
    dish = ((x + SPACING) ** 2 / 60.0 + y**2 / 120.0) / 2
    flat = ((x - SPACING) ** 2 / 90.0 - y**2 / 400.0) / 2
    blend = 1 / (1 + np.exp(x / 4.0))
    return np.minimum(blend * dish + (1 - blend) * flat, 6.0) + 5.0 * np.exp(
        -((x / 7.0) ** 2)
    )


def tibia(n: int, material: fc.Material | fc.NeoHookean = CARTILAGE) -> fc.ElasticBody:
    """Cartilage of the tibia on its bone, which is held."""
    x, y = np.meshgrid(
        np.linspace(-38.0, 38.0, 3 * n + 1),
        np.linspace(-24.0, 24.0, 2 * n + 1),
        indexing="ij",
    )
    bone = patch(np.stack([x, y, plateau(x, y)], axis=-1))
    mesh = fc.extrude(
        bone if bone.normals[bone.nodes][:, 2].sum() > 0 else bone.flipped(),
        THICKNESS,
        layers=2,
    )
    return fc.ElasticBody(
        mesh, material, contact="top", supports={"base": "xyz"}, name="tibia"
    )


def femur(n: int, material: fc.Material | fc.NeoHookean = CARTILAGE) -> fc.ElasticBody:
    """Both condyles on one bone; the axis of flexion is x, through the origin."""
    mesh = fc.merge([condyle("medial", n), condyle("lateral", n)], tolerance=1e-6)
    return fc.ElasticBody(
        mesh, material, contact="top", supports={"base": "xyz"}, name="femur"
    )


#: Height of the femur's axis at which both condyles about touch the plateaus in
#: extension.
HEIGHT = 31.6


def ligaments(bone: fc.ElasticBody) -> list[fc.Spring]:
    """Four ligaments from points of the femur to the ground, which holds the tibia;
    just taut in extension.
    """
    places = {
        "MCL": ((-40.0, 2.0, 2.0), (-40.0, -2.0, -40.0), 60.0),
        "LCL": ((40.0, 2.0, 2.0), (40.0, 8.0, -30.0), 50.0),
        "ACL": ((8.0, 8.0, -4.0), (-2.0, -12.0, 2.0), 90.0),
        "PCL": ((-8.0, -4.0, -6.0), (2.0, 20.0, -8.0), 110.0),
    }
    springs = []
    for name, (femoral, tibial, stiffness) in places.items():
        slack = float(
            np.linalg.norm(np.add(femoral, (0, 0, HEIGHT)) - np.array(tibial))
        )
        springs.append(
            fc.Spring(
                stiffness,
                (bone, femoral),
                (None, tibial),
                slack_length=slack,
                name=name,
            )
        )
    return springs


def flexed(
    below: fc.ElasticBody,
    above: fc.ElasticBody,
    degrees: float,
    accuracy: float | None = None,
) -> fc.ContactResult:
    """Knee at an angle of flexion; the condensed cartilage is reused from one angle to
    the next.
    """
    bone = above.placed(
        (0.0, 0.0, HEIGHT), rotation=fc.rotation_about((1, 0, 0), np.radians(degrees))
    )
    scene = fc.Scene(
        [below, bone],
        [fc.Contact(bone, below)],
        springs=ligaments(bone),
        units=("mm", "N", "MPa"),
    )
    return scene.solve(
        forces={bone: (0, 0, -LOAD)},
        free={bone: "x y ry"},
        finite_motion=True,
        accuracy=accuracy,
    )


def meniscus(side: str, result: fc.ContactResult, n: int) -> fc.ElasticBody:
    """A C-shaped ring of wedge section in the gap that a knee without menisci leaves;
    its horns are on the tibia.
    """
    femoral, tibial = result.scene.bodies[1], result.scene.bodies[0]
    middle = np.array([-SPACING if side == "medial" else SPACING, 0.0])
    radii = np.linspace(RING[0], RING[1], 3)
    # the opening of the C faces the middle of the knee
    towards = 0.0 if side == "medial" else np.pi
    angles = towards + np.radians(np.linspace(OPENING, 360.0 - OPENING, 4 * n + 1))

    def plan(index: np.ndarray) -> np.ndarray:
        r = np.interp(index[:, 0], range(3), radii)
        angle = np.interp(index[:, 1], range(4 * n + 1), angles)
        return middle + r[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def shape(index: np.ndarray) -> np.ndarray:
        xy = plan(index)
        low = height_of(tibial, xy, 1.0)
        reach = REACH * np.sin(np.pi * index[:, 1] / (4 * n))
        high = np.maximum(height_of(femoral, xy, -1.0) + reach, low + THINNEST)
        return np.column_stack([xy, low + index[:, 2] / 2 * (high - low)])

    mesh = lattice(
        (2, 4 * n, 2), (None, None, "front", "back", "lower", "upper")
    ).mapped(shape)
    horns = {"front": "xyz", "back": "xyz"}
    return fc.ElasticBody(
        mesh,
        MENISCUS,
        contact=("lower", "upper"),
        supports=horns,
        name=f"{side} meniscus",
    )


def height_of(body: fc.ElasticBody, xy: np.ndarray, sign: float) -> np.ndarray:
    """Height (n,) of a body's cartilage over points of the plane: of what looks up
    (sign 1) or down (-1).
    """
    surface, pose = body.surface("top"), body.pose
    z = np.full(len(xy), -1.0 * sign)
    # a few steps down the gap, which is a distance along the surface's own normal
    for _ in range(30):
        feet = surface.project(
            (np.column_stack([xy, z]) - pose.translation) @ pose.rotation
        )
        z -= sign * feet.gap * np.abs((feet.normals @ pose.rotation.T)[:, 2])
    return z


def with_menisci(bare: fc.ContactResult, n: int) -> fc.ContactResult:
    """The same knee with menisci, from where it stands without."""
    below, bone = bare.scene.bodies
    rings = [meniscus(side, bare, n) for side in SAGITTAL]
    contacts = [fc.Contact(bone, below)]
    for ring in rings:
        # the ring is covered as a whole, so it stays the slave
        contacts += [fc.Contact(ring, below, ("lower", "top"), swap="never")]
        contacts += [fc.Contact(ring, bone, ("upper", "top"), swap="never")]
    # ligaments as long as they were: the springs of the bare knee, now from the pose it
    # has found
    springs = [
        fc.Spring(
            s.spring.stiffness,
            (bone, s.spring.start[1]),
            s.spring.end,
            s.spring.slack_length,
            name=s.spring.name,
        )
        for s in bare.springs
    ]
    scene = fc.Scene(
        [below, bone, *rings], contacts, springs=springs, units=("mm", "N", "MPa")
    )
    return scene.solve(
        forces={bone: (0, 0, -LOAD)}, free={bone: "x y ry"}, finite_motion=True
    )


def figures(result: fc.ContactResult, angle: float) -> dict:
    """What the table shows: forces of the femur on the plateaus and on the menisci,
    pressures, pulls.
    """
    contact = result.contacts[0]
    inner, outer = contact.split_by_plane((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    return {
        "flexion": angle,
        "medial": abs(float(inner.force[2])),
        "lateral": abs(float(outer.force[2])),
        "menisci": sum(
            abs(float(c.force[2])) for c in result.contacts[1:] if "upper" in c.surfaces
        ),
        "area": contact.area,
        "peak": contact.max_pressure,
        "tensions": {s.spring.name: s.tension for s in result.springs},
        "equilibrium": result.residuals().equilibrium,
    }


def side_by_side(
    n: int = 5, angles: tuple[float, ...] = (0.0, 60.0), out: str | Path = "out"
) -> list[dict]:
    """Each angle with linear cartilage and with cartilage at finite strain."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    bodies = [(tibia(n, material), femur(n, material)) for material in (CARTILAGE, LAW)]
    print(
        f"{'flexion':>8}{'law':>14}{'strain':>8}{'area mm2':>10}{'peak MPa':>10}"
        f"{'mean MPa':>10}{'s':>6}  iterations"
    )
    rows = []
    for angle in angles:
        for below, above in bodies:
            began = time.process_time()
            result = flexed(below, above, angle)
            seconds = time.process_time() - began
            contact, name = result.contacts[0], type(below.material).__name__
            strain = max(
                float(np.abs(result.strain(body)).max())
                for body in (below, result.scene.bodies[1])
            )
            mean = float(np.linalg.norm(contact.force)) / contact.area
            row = {
                "flexion": angle,
                "law": name,
                "strain": strain,
                "area": contact.area,
                "mean": mean,
            }
            rows.append({**row, "peak": contact.max_pressure, "seconds": seconds})
            steps = [step.iterations for step in result.finite_strain]
            print(
                f"{angle:>8.0f}{name:>14}{strain:>8.1%}{contact.area:>10.1f}"
                f"{contact.max_pressure:>10.2f}{mean:>10.2f}"
                f"{seconds:>6.1f}  {steps or ''}"
            )
            file = f"knee_{angle:.0f}_{name}"
            result.plot("pressure", folder / f"{file}.png")
            result.plot(
                "contact_pressure",
                folder / f"{file}_femur.png",
                bodies=["femur"],
                view="below",
                scale=1.0,
            )
    return rows


def main(
    n: int = 5,
    angles: tuple[float, ...] = (0.0, 30.0, 60.0, 90.0),
    menisci: bool = False,
    out: str | Path = "out",
    accuracy: float | None = None,
) -> list[dict]:
    below, above = tibia(n), femur(n)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    print(below.describe(), above.describe(), sep="\n")
    head = f"{'flexion':>8}{'medial N':>10}{'lateral N':>11}{'menisci N':>11}"
    head += f"{'area mm2':>10}{'peak MPa':>10}"
    print(f"{head}  ligament tensions N")
    rows = []
    for angle in angles:
        results = [flexed(below, above, angle, accuracy)]
        if menisci:
            results.append(with_menisci(results[0], n))
        for kind, result in zip(("", "_menisci"), results, strict=False):
            row = figures(result, angle)
            rows.append(row)
            pulls = "  ".join(
                f"{name} {pull:.0f}" for name, pull in row["tensions"].items()
            )
            carried = (
                f"{row['medial']:>10.1f}{row['lateral']:>11.1f}{row['menisci']:>11.1f}"
            )
            print(
                f"{angle:>8.0f}{carried}{row['area']:>10.1f}{row['peak']:>10.2f}  "
                f"{pulls}"
            )
            result.plot("pressure", folder / f"knee_{angle:.0f}{kind}.png")
    return rows


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument(
        "menisci",
        nargs="?",
        choices=["menisci", "finite"],
        help="with menisci too, or finite strain beside",
    )
    parser.add_argument(
        "--accuracy",
        type=float,
        help="of the pressure, such as 0.05: divides the meshes",
    )
    given = parser.parse_args()
    if given.menisci == "finite":
        side_by_side()
    else:
        main(menisci=bool(given.menisci), accuracy=given.accuracy)
