"""A kneecap from an STL file, pressed into its groove: a surface of 17,000 triangles
becomes a solid in one call.

The script writes the surface, as a scan would give it: a rounded triangle, flat in
front, with a ridge between two hollows behind. It is meshed with quadratic tetrahedra
that are small behind and lie on the smooth surface, held at the front and pressed by a
rigid groove of the shape of a femur's.

Run: python examples/patella.py
"""

import time
from pathlib import Path

import meshio
import numpy as np

import fecontact as fc

BONE = fc.Material(E=100.0, nu=0.3)  # mm, N, MPa: bone and its cartilage in one
FORCE = 200.0
BEHIND = [(-10.0, -0.7, 8.0), (10.0, -0.7, 8.0)]  # where the contacts are expected


def scan(divisions: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles, 12 divisions^2, of a patella: a cube's faces, divided and
    rounded, then shaped.
    """
    cube = fc.shapes.block(
        (2.0, 2.0, 2.0), (divisions, divisions, divisions), element="hex8"
    )
    used, quads = np.unique(cube.skin, return_inverse=True)
    # nearly equal angles
    x = np.tan(np.pi / 4 * (cube.points[used] - cube.points.mean(axis=0)))
    x, y, z = (x / np.linalg.norm(x, axis=1, keepdims=True)).T
    ridge = 1.0 * np.exp(-((x / 0.25) ** 2)) - 1.5 * np.exp(
        -(((np.abs(x) - 0.5) / 0.3) ** 2) - (y / 0.6) ** 2
    )
    depth = np.where(z < 0, 8.0 * z, 11.0 * z + ridge * np.maximum(z, 0.0) ** 2)
    points = np.stack([22.5 * x * (1 - 0.18 * y), 21.0 * y, depth], axis=1)
    corners = quads.reshape(-1, 4)
    return points, np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


def groove(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Heights of the femur's groove over the patella: 4 mm deep between condyles 24 mm
    apart, round along y.
    """
    across = np.abs(x)
    between = 2.0 * (np.cos(np.pi * across / 12.0) - 1.0)
    return np.where(across < 12.0, between, (across - 12.0) ** 2 / 8.0 - 4.0) + y**2 / (
        2 * 25.0
    )


def pressed(path: Path, size: float) -> fc.ContactResult:
    """The patella of an STL file, held at its front, under the groove."""
    mesh = fc.mesh_solid(
        path, size=size, near=BEHIND, near_size=0.25 * size, growth=0.3
    )
    mesh = mesh.with_boundary("back", fc.pick.facing((0, 0, 1), angle=50))
    mesh = mesh.with_boundary("front", fc.pick.facing((0, 0, -1), angle=30))
    patella = fc.ElasticBody(
        mesh, BONE, contact="back", supports={"front": "xyz"}, name="patella"
    )
    femur = fc.RigidBody(
        fc.surfaces.FunctionSurface(groove, size=20.0), name="femur"
    ).placed((0.0, 0.0, 16.0))
    scene = fc.Scene(
        [patella, femur], [fc.Contact(patella, femur)], units=("mm", "N", "MPa")
    )
    return scene.solve(forces={femur: (0.0, 0.0, -FORCE)})


def main(
    size: float = 3.5, divisions: int = 38, out: str | Path = "out"
) -> dict[str, float]:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    points, triangles = scan(divisions)
    meshio.Mesh(points, [("triangle", triangles)]).write(
        folder / "patella.stl", binary=True
    )
    start = time.perf_counter()
    result = pressed(folder / "patella.stl", size)
    seconds = time.perf_counter() - start
    contact = result.contacts[0]
    print(
        f"{len(triangles)} triangles -> {result.n_dofs} unknowns -> pressed in "
        f"{seconds:.1f} s"
    )
    print(result)
    result.plot("pressure", folder / "patella.png")
    result.plot("von_mises", folder / "patella_stress.png")
    regions = len(contact.regions)
    return {
        "regions": regions,
        "force": contact.total_force,
        "area": contact.area,
        "peak": float(contact.pressure.max()),
        "seconds": seconds,
    }


if __name__ == "__main__":
    main()
