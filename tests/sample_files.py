"""Small valid files of every format that is read, and damaged copies of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import meshio
import numpy as np

import fecontact as fc

INP = """*HEADING
cube
*NODE, NSET=ALL
{nodes}
*ELEMENT, TYPE=C3D8, ELSET=CUBE
1, {cell}
*NSET, NSET=LOW, GENERATE
1, 4, 1
*ELSET, ELSET=EL
1
*SURFACE, NAME=TOP
CUBE, S2
*MATERIAL, NAME=SOFT
*ELASTIC
1.0, 0.3
*SOLID SECTION, ELSET=CUBE, MATERIAL=SOFT
*STEP
*STATIC
*BOUNDARY
LOW, 1, 3
*CLOAD
5, 3, -1.0
*END STEP
"""
FEB = """<?xml version="1.0" encoding="ISO-8859-1"?>
<febio_spec version="2.5">
<Material><material id="1" name="soft" type="isotropic elastic"><E>1</E><v>0.3</v></material></Material>
<Geometry>
<Nodes name="all">
{nodes}
</Nodes>
<Elements type="hex8" mat="1" name="cube">
<elem id="1">{cell}</elem>
</Elements>
<Surface name="top"><quad4 id="1">5,6,7,8</quad4></Surface>
</Geometry>
</febio_spec>
"""
TOML = """title = "block on a floor"
[units]
length = "mm"
[materials.soft]
E = 1.0
nu = 0.0
[bodies.block]
material = "soft"
shape = { kind = "block", size = [1, 1, 1], divisions = [1, 1, 1], element = "hex8" }
contact = "bottom"
supports = { top = "xyz" }
[bodies.floor]
type = "rigid"
shape = { kind = "plane" }
pose = { translation = [0, 0, 0] }
[[contacts]]
slave = "block"
master = "floor"
[loads.motions]
block = { z = -0.01 }
[solve]
tolerance = 1e-9
[outputs]
json = "block.json"
"""
ASC = "ncols 2\nnrows 2\ncellsize 1.0\nnodata_value -9999\n0 1\n2 3\n"
XYZ = "0 0 0\n0 1 1\n1 0 1\n1 1 2\n"
OFF = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
OBJ = "# tetrahedron\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1//1 2//1 4//1\nf 2/1/1 3/1/1 4/1/1\nf -4 -1 -2\n"


def sample_files(folder: Path) -> dict[str, tuple[Path, Callable[[Path], Any]]]:
    """File and reader by format."""
    cube = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    solid = meshio.Mesh(cube.points, [("hexahedron", cube.cells)])
    surface = meshio.Mesh(corners, [("triangle", triangles)])
    number = {"nodes": "", "cell": ", ".join(str(k + 1) for k in cube.cells[0])}
    lines = [f"{k + 1}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(cube.points)]
    tags = [f'<node id="{k + 1}">{x},{y},{z}</node>' for k, (x, y, z) in enumerate(cube.points)]
    texts = {
        "cube.inp": INP.format(**{**number, "nodes": "\n".join(lines)}),
        "cube.feb": FEB.format(**{**number, "nodes": "\n".join(tags)}),
        "scene.toml": TOML,
        "map.asc": ASC,
        "map.xyz": XYZ,
        "map.txt": "0 1 2\n3 4 5\n",
        "map.csv": "0,1,2\n3,4,5\n",
        "one.off": OFF,
        "one.obj": OBJ,
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    np.save(folder / "map.npy", np.arange(6.0).reshape(2, 3))
    for name, options in (
        ("cube.msh", {"file_format": "gmsh22", "binary": False}),
        ("cube4.msh", {"file_format": "gmsh22", "binary": True}),
    ):
        meshio.write(folder / name, solid, **options)
    meshio.write(folder / "cube.vtu", solid, binary=False)
    meshio.write(folder / "cube.vtk", solid)
    meshio.write(folder / "text.stl", surface, binary=False)
    meshio.write(folder / "bits.stl", surface, binary=True)
    meshio.write(folder / "text.ply", surface, binary=False)
    meshio.write(folder / "bits.ply", surface, binary=True)
    readers = {".toml": fc.read_scene, **dict.fromkeys((".stl", ".ply", ".obj", ".off", ".vtp"), fc.read_surface)}
    readers |= dict.fromkeys((".asc", ".xyz", ".txt", ".csv", ".npy"), fc.surfaces.read_topography)
    return {path.name: (path, readers.get(path.suffix, fc.read_mesh)) for path in sorted(folder.iterdir())}


WORDS = [b"NaN", b"1e999", b"-1", b"99999999999999999999", b"0", b"", b"\xff\x00", b"x", b"1e11", b"[[[[[[[["]


def damaged(data: bytes, rng: np.random.Generator, count: int) -> Iterator[bytes]:
    """Copies cut off, with flipped bits, with a word or a line replaced, repeated, swapped or left out."""
    for k in range(count):
        at = int(rng.integers(0, max(len(data), 1)))
        if k % 4 == 0:
            yield data[:at]
        elif k % 4 == 1:
            out = bytearray(data)
            for place in rng.integers(0, len(data), 1 + k % 3):
                out[place] ^= 1 << int(rng.integers(0, 8))
            yield bytes(out)
        elif k % 4 == 2:
            words = data.split(b" ") if k % 8 == 2 else data.split(b"\n")
            words[int(rng.integers(0, len(words)))] = WORDS[int(rng.integers(0, len(WORDS)))]
            yield (b" " if k % 8 == 2 else b"\n").join(words)
        else:
            lines = data.split(b"\n")
            one, other = rng.integers(0, len(lines), 2)
            lines[one], lines[other] = (lines[other], lines[one]) if k % 8 == 3 else (lines[one], lines[one])
            yield b"\n".join(lines)
