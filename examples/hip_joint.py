"""A hip: a ball in a socket with cartilage on both, a head of metal in the same socket,
and the load of walking.

Both cartilages are layers extruded from spherical bone surfaces and tied to the bones,
which are the frames of the bodies. The pelvis is held; the femur is pushed into the
socket and free to find its place there. The load is oblique to the axis of the socket,
so the pressure leans towards its upper rim.

Load: 238 % of body weight, the average peak of walking at 4 km/h (Bergmann et al. 2001,
J. Biomech. 34, 859), with the parts of Heller et al. (2005, J. Biomech. 38, 1155): 54 %
from medial, 33 % from the front and 229 % from above. Axes: x to the middle of the
body, y forwards, z upwards; mm, N, MPa.

Run: python examples/hip_joint.py                  (two meshes of each head)
     python examples/hip_joint.py --finite         (cartilage of finite strains too)
     python examples/hip_joint.py --accuracy 0.05  (both divided to within 5 %)
"""

import argparse
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy.optimize

import fecontact as fc
from fecontact.bodies.layer import foundation_modulus
from fecontact.mesh.shapes import Level
from fecontact.mesh.surface_mesh import SurfaceMesh

CARTILAGE = fc.Material(E=12.0, nu=0.45)
#: The kind of law of Anderson et al. (2008, J. Biomech. Eng. 130, 051008) for short
#: loads, with the moduli above.
LAW = fc.NeoHookean(CARTILAGE.E, CARTILAGE.nu)
BODY_WEIGHT = 800.0
# by which the femur presses on the pelvis
LOAD = BODY_WEIGHT * np.array([0.54, 0.328, 2.292])
HEAD, SOCKET = 24.0, 24.5  # radii of the sliding surfaces
THICKNESS = 2.0  # of either cartilage
HEAD_EDGE, SOCKET_EDGE = 80.0, 85.0  # degrees from the pole to the rim
INCLINATION, ANTEVERSION = 45.0, 15.0  # of the socket's axis, degrees


def dome(radius: float, edge: float, n: int) -> SurfaceMesh:
    """Part of a sphere round its lowest point out to an angle, normals outwards; n:
    elements along half the core.
    """
    cut = Level(core=n, rings=2 * n, edge=0.999 / (3 * n), layer=1.0, growth=1.2)
    disc = SurfaceMesh.of(
        fc.shapes.cylinder(1.0, 1.0, contact_radius=0.8, level=cut), "cap"
    )

    def onto_sphere(x: np.ndarray) -> np.ndarray:
        r = np.hypot(x[:, 0], x[:, 1])
        polar = r * np.radians(edge)
        across = radius * np.divide(
            np.sin(polar), r, out=np.full_like(r, np.radians(edge)), where=r > 0
        )
        return np.stack(
            [across * x[:, 0], across * x[:, 1], -radius * np.cos(polar)], axis=1
        )

    return disc.mapped(onto_sphere)


def towards(direction: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) that takes the pole, -z, to a direction."""
    d = direction / np.linalg.norm(direction)
    axis = np.cross((0.0, 0.0, -1.0), d)
    return fc.rotation_about(axis, float(np.arctan2(np.linalg.norm(axis), -d[2])))


def socket_axis() -> np.ndarray:
    """Direction from the socket's middle to its bottom; the socket opens sideways,
    downwards and forwards.
    """
    tilt, turn = np.radians([INCLINATION, ANTEVERSION])
    return np.array(
        [np.sin(tilt) * np.cos(turn), -np.sin(turn), np.cos(tilt) * np.cos(turn)]
    )


def socket(n: int, material: fc.Material | fc.NeoHookean = CARTILAGE) -> fc.ElasticBody:
    """Cartilage of the socket on the pelvis, which is held."""
    layer = fc.extrude(
        dome(SOCKET + THICKNESS, SOCKET_EDGE, n).flipped(), THICKNESS, layers=2
    )
    body = fc.ElasticBody(
        layer, material, contact="top", supports={"base": "xyz"}, name="socket"
    )
    return body.placed(rotation=towards(socket_axis()))


def cartilage_head(
    n: int, material: fc.Material | fc.NeoHookean = CARTILAGE
) -> fc.ElasticBody:
    """Cartilage of the head on the femur, its pole where the load presses."""
    layer = fc.extrude(dome(HEAD - THICKNESS, HEAD_EDGE, n), THICKNESS, layers=2)
    body = fc.ElasticBody(
        layer, material, contact="top", supports={"base": "xyz"}, name="head"
    )
    return body.placed(rotation=towards(LOAD))


def metal_head() -> fc.RigidBody:
    """The same ball of metal, which does not give beside cartilage."""
    return fc.RigidBody(fc.Sphere(HEAD), name="metal head").placed((0.0, 0.0, -HEAD))


def loaded(
    cup: fc.ElasticBody,
    ball: fc.ElasticBody | fc.RigidBody,
    accuracy: float | None = None,
) -> fc.ContactResult:
    """The ball pushed into the socket; pressure cannot turn a ball, so only its place
    is free.
    """
    scene = fc.Scene([cup, ball], [fc.Contact(cup, ball)], units=("mm", "N", "MPa"))
    return scene.solve(forces={ball: LOAD}, free={ball: "x y z"}, accuracy=accuracy)


def thin_layers(height: float) -> float:
    """Peak pressure if every column of cartilage of that height gave by itself, without
    regard to the rim.

    p = M/h (e cos - c) up to cos = c/e, with M the modulus without strain along the
    layer, c the difference of the radii and e - c the approach, which follows from the
    load: F = 2 pi R^2 times the integral of p cos d(cos).
    """
    modulus, gap = foundation_modulus(CARTILAGE), SOCKET - HEAD
    size = 2 * np.pi * HEAD**2 * modulus / height

    def missing(e: float) -> float:
        t = gap / e
        return float(
            size * (e * (1 - t**3) / 3 - gap * (1 - t**2) / 2) - np.linalg.norm(LOAD)
        )

    return modulus / height * (scipy.optimize.brentq(missing, gap, 10 * gap) - gap)


def side_by_side(n: int = 2, out: str | Path = "out") -> list[dict]:
    """Linear cartilage and cartilage at finite strain, under a head of cartilage and
    one of metal.
    """
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    print(
        f"{'head':>10}{'law':>14}{'strain':>8}{'area mm2':>10}{'peak MPa':>10}"
        f"{'iterations':>12}{'s':>6}"
    )
    rows = []
    for kind in ("cartilage", "metal"):
        for material in (CARTILAGE, LAW):
            cup = socket(n, material)
            began = time.process_time()
            result = loaded(
                cup,
                cartilage_head(n, material) if kind == "cartilage" else metal_head(),
            )
            seconds = time.process_time() - began
            contact, strain = (
                result.contacts[0],
                float(np.abs(result.strain(cup)).max()),
            )
            name, steps = (
                type(material).__name__,
                [step.iterations for step in result.finite_strain],
            )
            rows.append(
                {
                    "head": kind,
                    "law": name,
                    "area": contact.area,
                    "peak": contact.max_pressure,
                }
            )
            rows[-1] |= {
                "held": result.reaction(cup)[:3],
                "strain": strain,
                "seconds": seconds,
            }
            print(
                f"{kind:>10}{name:>14}{strain:>8.1%}{contact.area:>10.1f}"
                f"{contact.max_pressure:>10.3f}"
                f"{steps or '-'!s:>12}{seconds:>6.1f}"
            )
        x, y, z = -socket_axis()  # into the opening
        view = {
            "view": (np.degrees(np.arctan2(y, x)), np.degrees(np.arcsin(z))),
            "bodies": ["socket"],
            "scale": 1.0,
        }
        result.plot("contact_pressure", folder / f"hip_joint_{kind}_finite.png", **view)
    return rows


def main(
    sizes: tuple[int, ...] = (2, 3),
    out: str | Path = "out",
    accuracy: float | None = None,
) -> list[dict]:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    print(f"load {np.linalg.norm(LOAD):.0f} N, {len(sizes)} meshes of each head")
    print(
        f"{'head':>10}{'n':>3}{'dofs':>8}{'force N':>9}{'area mm2':>10}"
        f"{'peak MPa':>10}{'mean MPa':>10}{'s':>6}"
    )
    rows = []
    for kind in ("cartilage", "metal"):
        for n in sizes:
            cup = socket(n)
            result = loaded(
                cup,
                cartilage_head(n) if kind == "cartilage" else metal_head(),
                accuracy,
            )
            contact = result.contacts[0]
            rows.append(
                {
                    "head": kind,
                    "n": n,
                    "held": result.reaction(cup)[:3],
                    "area": contact.area,
                    "peak": contact.max_pressure,
                    "thin": thin_layers(
                        2 * THICKNESS if kind == "cartilage" else THICKNESS
                    ),
                    "equilibrium": result.residuals().equilibrium,
                }
            )
            size = float(np.linalg.norm(contact.force))
            print(
                f"{kind:>10}{n:>3}{result.n_dofs:>8}{size:>9.1f}{contact.area:>10.1f}"
                f"{contact.max_pressure:>10.3f}"
                f"{size / contact.area:>10.3f}{result.seconds['total']:>6.1f}"
            )
        result.plot("pressure", folder / f"hip_joint_{kind}.png")
        peaks = [row["peak"] for row in rows if row["head"] == kind]
        steps = ", ".join(f"{100 * (b / a - 1):+.1f} %" for a, b in pairwise(peaks))
        if steps:
            print(f"peak pressure from mesh to mesh: {steps}")
        print(
            "thin-layer theory, which lets nothing bulge: peak "
            f"{rows[-1]['thin']:.3f} MPa"
        )
    return rows


def arguments() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument(
        "--accuracy",
        type=float,
        help="of the pressure, such as 0.05: divides the meshes",
    )
    parser.add_argument(
        "--finite",
        action="store_true",
        help="linear cartilage and finite strain side by side",
    )
    return parser.parse_args()


if __name__ == "__main__":
    given = arguments()
    if given.finite:
        side_by_side()
    else:
        main(accuracy=given.accuracy)
