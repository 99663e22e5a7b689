"""A cemented hip prosthesis: steel stem with neck and ball, cement and bone as one
body, loaded through a cup.

This is the idealised total hip of Elangovan (1978, appendix B, fig. B-9): three
materials in one body, and wedges (20-node hexahedra with coalesced edges) along its
axis. The drawing is lost, so the dimensions below are chosen here. A cup of
polyethylene presses on the ball with the load of walking; the bone is held at its lower
end. The stresses along the bone are set beside those of composite beam theory, which
holds away from the ends.

Load: 238 % of body weight (Bergmann et al. 2001, J. Biomech. 34, 859), with the parts
of Heller et al. (2005, J. Biomech. 38, 1155). Axes: x to the middle of the body, y
forwards, z upwards; mm, N, MPa.

Run: python examples/hip_stem.py                  (one mesh)
     python examples/hip_stem.py --accuracy 0.05  (divided to a pressure within 5 %)
"""

import argparse
from pathlib import Path

import numpy as np

import fecontact as fc
from fecontact.common.material import von_mises
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.shapes import Level, lattice

MATERIALS = {
    "stem": fc.Material(E=200e3, nu=0.3),
    "cement": fc.Material(E=2.3e3, nu=0.3),
    "bone": fc.Material(E=17e3, nu=0.3),
}
POLYETHYLENE = fc.Material(E=800.0, nu=0.45)
# on the ball, for a body weight of 800 N
LOAD = 800.0 * np.array([-0.54, -0.328, -2.292])

# heights of the stem's tip, the cement's and the bone's lower ends; cut at 0
TIP, PLUG, END = -120.0, -130.0, -180.0
STEM_RADIUS = {"tip": 4.5, "cut": 8.0}
MANTLE = 2.5  # thickness of the cement
BONE_RADIUS = {"end": 14.0, "cut": 16.0}
# radius of the neck's bend and its angle to the stem
BEND, INCLINATION = 20.0, np.radians(50.0)
NECK_LENGTH, NECK_RADIUS, BALL = 14.0, 6.0, 14.0
CLEARANCE, CUP = 0.1, 8.0  # between ball and cup, thickness of the cup
RINGS = (0.0, 0.12, 0.3, 0.53, 0.76, 1.0)  # of the stem; the first are wedges
STEM = len(RINGS) - 1  # rings of the stem; outside are one of cement and two of bone
HEIGHTS = (END, -170, -160, -145, PLUG, TIP, -105, -90, -75, -60, -45, -30, -15, -6, 0)


def radii(z: np.ndarray) -> np.ndarray:
    """Radii (n, STEM + 4) of the rings at heights: those of the stem, the cement and
    twice the bone.
    """
    stem = np.interp(z, (TIP, 0.0), (STEM_RADIUS["tip"], STEM_RADIUS["cut"]))
    cement = stem + MANTLE
    bone = np.interp(z, (END, 0.0), (BONE_RADIUS["end"], BONE_RADIUS["cut"]))
    return np.stack(
        [*(f * stem for f in RINGS), cement, (cement + bone) / 2, bone], axis=1
    )


def between(table: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Values (n,) of the rows of a table (n, m) at places between its columns."""
    low = np.minimum(index.astype(int), table.shape[1] - 2)
    rows = np.arange(len(index))
    return table[rows, low] + (index - low) * (table[rows, low + 1] - table[rows, low])


def around(radius: np.ndarray, angle_index: np.ndarray, sectors: int) -> np.ndarray:
    """Plane coordinates (n, 2) of points at radii in sectors; the last sector ends
    where the first begins.
    """
    angle = 2 * np.pi * np.mod(angle_index, sectors) / sectors
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def shaft(sectors: int) -> Mesh:
    """Stem, cement and bone below the cut; the canal below the cement is empty."""
    mesh = lattice(
        (STEM + 3, sectors, len(HEIGHTS) - 1), (None, None, None, None, "end", None)
    )
    tip, plug = HEIGHTS.index(TIP), HEIGHTS.index(PLUG)

    def in_stem(c: np.ndarray) -> np.ndarray:
        return (c[:, 0] < STEM) & (c[:, 2] > tip)

    def in_bone(c: np.ndarray) -> np.ndarray:
        return c[:, 0] > STEM + 1

    mesh = mesh.with_group("stem", in_stem).with_group("bone", in_bone)
    mesh = mesh.with_group(
        "cement", lambda c: (c[:, 2] > plug) & ~in_stem(c) & ~in_bone(c)
    )
    mesh = mesh.with_group("solid", lambda c: in_bone(c) | (c[:, 2] > plug)).part(
        "solid"
    )

    def shape(index: np.ndarray) -> np.ndarray:
        z = between(np.tile(HEIGHTS, (len(index), 1)), index[:, 2])
        return np.column_stack(
            [around(between(radii(z), index[:, 0]), index[:, 1], sectors), z]
        )

    return mesh.mapped(shape)


def bent(plane: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Points (n, 3) from coordinates in the neck's sections and the length along its
    axis, a bend and a straight.
    """
    angle = np.clip(along / BEND, 0.0, INCLINATION)
    beyond = along - BEND * angle
    x = (
        BEND * (1 - np.cos(angle))
        + plane[:, 0] * np.cos(angle)
        + beyond * np.sin(angle)
    )
    z = BEND * np.sin(angle) - plane[:, 0] * np.sin(angle) + beyond * np.cos(angle)
    return np.stack([x, plane[:, 1], z], axis=1)


NECK = BEND * INCLINATION + NECK_LENGTH  # from the cut to the ball, along the axis
SUNK = float(np.sqrt(BALL**2 - NECK_RADIUS**2))  # from there to the ball's middle
CENTRE = bent(np.zeros((1, 2)), np.array([NECK + SUNK]))[0]


def neck(sectors: int, n: int = 6) -> Mesh:
    """Stem from the cut to the ball."""
    mesh = lattice((STEM, sectors, n), (None,) * 6).with_group(
        "stem", lambda c: np.ones(len(c), bool)
    )

    def shape(index: np.ndarray) -> np.ndarray:
        share = index[:, 2] / n
        size = STEM_RADIUS["cut"] + share * (NECK_RADIUS - STEM_RADIUS["cut"])
        plane = around(
            size * np.interp(index[:, 0], range(STEM + 1), RINGS), index[:, 1], sectors
        )
        return bent(plane, share * NECK)

    return mesh.mapped(shape)


def ball(sectors: int, n: int = 5) -> Mesh:
    """Ball on the neck: sections that go over from the neck's flat end to a cap of 70
    degrees round the pole.
    """
    mesh = lattice((STEM, sectors, n), (None, "ball", None, None, None, "ball"))
    mesh = mesh.with_group("stem", lambda c: np.ones(len(c), bool))
    low, high = np.pi - np.arcsin(NECK_RADIUS / BALL), np.radians(70.0)

    def arc(polar: np.ndarray) -> np.ndarray:
        return BALL * np.stack([np.sin(polar), np.cos(polar)], axis=1)

    def shape(index: np.ndarray) -> np.ndarray:
        s, t = np.interp(index[:, 0], range(STEM + 1), RINGS)[:, None], index[:, 2:] / n
        foot = np.concatenate([s * NECK_RADIUS, np.full_like(s, -SUNK)], axis=1)
        corner = (1 - t) * arc(np.array([low])) + t * arc(np.array([high]))
        # blended from the sides of the meridian plane (Coons), of which the axis is
        # straight
        meridian = (
            (1 - t) * foot
            + t * arc(high * s[:, 0])
            + s * (arc(low + (high - low) * t[:, 0]) - corner)
        )
        return bent(
            around(meridian[:, 0], index[:, 1], sectors), NECK + SUNK + meridian[:, 1]
        )

    return mesh.mapped(shape)


def prosthesis(sectors: int) -> fc.ElasticBody:
    """Stem, cement and bone, held at the bone's lower end."""
    mesh = fc.merge([shaft(sectors), neck(sectors), ball(sectors)], 1e-6)
    return fc.ElasticBody(
        mesh, MATERIALS, contact="ball", supports={"end": "xyz"}, name="hip"
    )


def cup(n: int) -> fc.ElasticBody:
    """Cup of polyethylene in a shell of metal, which is its frame; its pole where the
    load presses.
    """
    # faces whose middles were off the sphere by a thousandth of a millimetre would show
    # in the pressure: 27 nodes
    level = Level(core=n, rings=2 * n, edge=0.999 / (3 * n), layer=0.9, growth=1.6)
    plan = fc.shapes.cylinder(
        1.0, 1.0, contact_radius=0.55, level=level, element="hex27"
    )

    def bowl(x: np.ndarray) -> np.ndarray:
        r, radius = np.hypot(x[:, 0], x[:, 1]), BALL + CLEARANCE + CUP * x[:, 2]
        polar = r * np.radians(80.0)
        across = radius * np.divide(
            np.sin(polar), r, out=np.full_like(r, np.radians(80.0)), where=r > 0
        )
        return np.stack(
            [across * x[:, 0], across * x[:, 1], radius * np.cos(polar)], axis=1
        )

    up, pole = np.array([0.0, 0.0, 1.0]), -LOAD / np.linalg.norm(LOAD)
    turn = fc.rotation_about(np.cross(up, pole), float(np.arccos(up @ pole)))
    body = fc.ElasticBody(
        plan.mapped(bowl),
        POLYETHYLENE,
        contact="cap",
        supports={"base": "xyz"},
        name="cup",
    )
    return body.placed(CENTRE + turn @ (0.0, 0.0, -CLEARANCE), turn)


def beam_stress(z: float, angle: np.ndarray) -> np.ndarray:
    """Stress along the outside of the bone (n,) at a height after the theory of
    composite beams.
    """
    radius = radii(np.array([z]))[0]
    shells = [("bone", radius[-3], radius[-1])]
    if z > PLUG:
        shells += [("cement", radius[STEM] if z > TIP else 0.0, radius[-3])]
    if z > TIP:
        shells += [("stem", 0.0, radius[STEM])]
    stretching = sum(MATERIALS[m].E * np.pi * (b**2 - a**2) for m, a, b in shells)
    bending = sum(MATERIALS[m].E * np.pi / 4 * (b**4 - a**4) for m, a, b in shells)
    moment = np.cross(CENTRE - (0.0, 0.0, z), LOAD)
    x, y = radius[-1] * np.cos(angle), radius[-1] * np.sin(angle)
    return MATERIALS["bone"].E * (
        LOAD[2] / stretching + (moment[0] * y - moment[1] * x) / bending
    )


def beam_error(
    body: fc.ElasticBody, result: fc.ContactResult, z: float
) -> tuple[float, float]:
    """Largest stress of beam theory on the outside of the bone at a height, and how far
    the solution is from it.
    """
    # its mesh may have been divided
    (solved,) = (other for other in result.scene.bodies if other.name == body.name)
    points = solved.mesh.points
    radius = np.hypot(points[:, 0], points[:, 1])
    # nodes of divided arcs are off the circle by a few millionths of its radius
    outside = np.isclose(points[:, 2], z) & np.isclose(
        radius, radii(np.array([z]))[0, -1], rtol=1e-4
    )
    beam = beam_stress(z, np.arctan2(points[outside, 1], points[outside, 0]))
    found = result.stress(body, "bone")[outside, 2]
    largest = float(np.abs(beam).max())
    return largest, float(np.abs(found - beam).max()) / largest


def main(
    sectors: int = 20,
    n: int = 3,
    out: str | Path = "out",
    accuracy: float | None = None,
) -> dict[str, dict]:
    body, socket = prosthesis(sectors), cup(n)
    print(f"{body.describe()}, of which {body.mesh.kinds}", socket.describe(), sep="\n")
    scene = fc.Scene(
        [body, socket], [fc.Contact(socket, body)], units=("mm", "N", "MPa")
    )
    result = scene.solve(
        forces={socket: LOAD}, free={socket: "x y z"}, accuracy=accuracy
    )
    contact, held = result.contacts[0], result.reaction(body, "end")
    print(
        f"contact force {np.linalg.norm(contact.force):.1f} N, peak "
        f"{contact.max_pressure:.2f} MPa",
        end=", ",
    )
    print(
        f"area {contact.area:.1f} mm2; the bone's end holds "
        f"{np.array2string(held[:3], precision=1)} N"
    )
    figures: dict[str, dict] = {
        "contact": {
            "held": held[:3],
            "peak": contact.max_pressure,
            "area": contact.area,
        }
    }
    figures["contact"]["equilibrium"] = result.residuals().equilibrium

    print(f"{'material':>10}{'von Mises':>11}{'along z from':>14}{'to MPa':>8}")
    for material in MATERIALS:
        stress = result.stress(body, material)
        figures[material] = {
            "von_mises": float(np.nanmax(von_mises(stress))),
            "lowest": float(np.nanmin(stress[:, 2])),
            "highest": float(np.nanmax(stress[:, 2])),
        }
        row = figures[material]
        print(
            f"{material:>10}{row['von_mises']:>11.1f}{row['lowest']:>14.1f}"
            f"{row['highest']:>8.1f}"
        )
    for name, z in (("beside the stem", -60.0), ("below the stem", -160.0)):
        largest, error = beam_error(body, result, z)
        figures[name] = {"beam": largest, "error": error}
        print(
            f"bone {name} (z = {z:g}): beam theory up to {largest:.1f} MPa, off by "
            f"{100 * error:.1f} % of that at most"
        )

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    result.save(folder / "hip_stem.vtu")
    result.plot("pressure", folder / "hip_stem_pressure.png")
    result.plot(
        "von_mises", folder / "hip_stem_stress.png", cut="y>0", view="-y",
        limits=(0.0, 120.0), scale=10.0, title="cut open, displacements × 10",
    )  # fmt: skip
    return figures


def arguments() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument(
        "--accuracy",
        type=float,
        help="of the pressure, such as 0.05: divides the meshes",
    )
    return parser.parse_args()


if __name__ == "__main__":
    main(accuracy=arguments().accuracy)
