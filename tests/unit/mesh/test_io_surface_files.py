"""Surfaces of .ply, .off, .obj and .vtp files as programs write them, and out of meshes and decks."""

import base64
import struct
import zlib

import numpy as np
import pytest
import refusals

import fecontact as fc
from fecontact.mesh.orient import signed_volume

# coordinates 0 and 1
ROUNDING = 1e-14

POINTS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
#: A cube: four squares and, as triangles, the two others.
POLYGONS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
ROWS = [" ".join(map(str, p)) for p in POINTS.tolist()]


def off(path):
    faces = [f"{len(p)} {' '.join(map(str, p))} 255 0 0" for p in POLYGONS]
    path.write_text("COFF # a cube\n\n8 8 0\n" + "\n".join([f"{row} 0 0 0 1" for row in ROWS] + faces))


def obj(path):
    points = [f"v {row} 1.0" for row in ROWS]
    forms = ("{0}//1", "{0}/1/1", "{0}", "{0}/1")
    faces = ["f " + " ".join(forms[k % 4].format(n + 1) for n in p) for k, p in enumerate(POLYGONS)]
    path.write_text("\n".join(["mtllib a.mtl", "o cube", *points, "vn 0 0 1", "vt 0 0", "g side", "s off", *faces]))


HEADER = """ply
format {form} 1.0
comment made by hand
element camera 1
property list uchar float lens
element vertex 8
property float quality
property double x
property double y
property double z
property uchar red
element face 8
property uchar flags
property list uchar {index} vertex_indices
property list uchar float texcoord
end_header
"""


def ply_text(path):
    faces = [f"7 {len(p)} {' '.join(map(str, p))} {2 * len(p)} {'0.5 ' * 2 * len(p)}" for p in POLYGONS]
    path.write_text(
        "\n".join([HEADER.format(form="ascii", index="int") + "2 1.5 2.5", *(f"0.1 {r} 255" for r in ROWS), *faces])
    )


def ply_binary(order):
    def write(path):
        form = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
        out = HEADER.format(form=form, index="uint").encode() + struct.pack(f"{order}B2f", 2, 1.5, 2.5)
        out += b"".join(struct.pack(f"{order}f3dB", 0.1, *x, 255) for x in POINTS.tolist())
        for p in POLYGONS:
            n = len(p)
            out += struct.pack(f"{order}BB{n}IB{2 * n}f", 7, n, *p, 2 * n, *[0.5] * (2 * n))
        path.write_bytes(out)

    return write


def vtp(form, compressed=False, order="<", header="UInt32"):
    """A writer of .vtp: 'ascii', 'binary' (base64), 'base64' and 'raw' (appended)."""

    def write(path):
        head = {"UInt32": "I", "UInt64": "Q"}[header]
        appended = b""

        def array(values, kind, name):
            nonlocal appended
            data = np.asarray(values).astype(order + {"Float64": "f8", "Int32": "i4"}[kind]).tobytes()
            pieces = [data[: len(data) // 2], data[len(data) // 2 :]]
            packed = [zlib.compress(p) for p in pieces]
            if compressed:
                start = struct.pack(f"{order}5{head}", 2, len(pieces[0]), len(pieces[1]), *map(len, packed))
                parts = [start, b"".join(packed)]
            else:
                parts = [struct.pack(f"{order}{head}", len(data)) + data]
            text = " ".join(map(repr, np.ravel(values).tolist())).encode()
            if form in ("binary", "base64"):
                text = b"".join(map(base64.b64encode, parts))
            offset = f'offset="{len(appended)}" ' if form in ("base64", "raw") else ""
            if form in ("base64", "raw"):
                appended += text if form == "base64" else b"".join(parts)
                text = b""
            shown = "appended" if offset else form
            head_of = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="3" {offset}format="{shown}">'
            return head_of.encode() + text + b"</DataArray>"

        ends = np.cumsum([len(p) for p in POLYGONS])
        body = b"<Points>" + array(POINTS, "Float64", "Points") + b"</Points><Polys>"
        body += array(np.concatenate(POLYGONS), "Int32", "connectivity") + array(ends, "Int32", "offsets") + b"</Polys>"
        byte_order = {"<": "LittleEndian", ">": "BigEndian"}[order]
        zipped = ' compressor="vtkZLibDataCompressor"' if compressed else ""
        out = f'<VTKFile type="PolyData" byte_order="{byte_order}" header_type="{header}"{zipped}><PolyData>'.encode()
        out += b'<Piece NumberOfPoints="8" NumberOfPolys="8">' + body + b"</Piece></PolyData>"
        if appended:
            encoding = "raw" if form == "raw" else "base64"
            out += f'<AppendedData encoding="{encoding}">_'.encode() + appended + b"</AppendedData>"
        path.write_bytes(out + b"</VTKFile>")

    return write


WRITERS = {
    "cube.off": off,
    "cube.obj": obj,
    "text.ply": ply_text,
    "little.ply": ply_binary("<"),
    "big.ply": ply_binary(">"),
    "ascii.vtp": vtp("ascii"),
    "binary.vtp": vtp("binary"),
    "zipped.vtp": vtp("binary", compressed=True, header="UInt64"),
    "base64.vtp": vtp("base64", compressed=True),
    "appended.vtp": vtp("base64"),
    "raw.vtp": vtp("raw", order=">", header="UInt64"),
    "zippedraw.vtp": vtp("raw", compressed=True),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_cube_of_squares_and_triangles(name, tmp_path):
    WRITERS[name](tmp_path / name)
    surface = fc.read_surface(tmp_path / name, scale=2.0)
    assert len(surface.facets) == 8
    assert surface.is_closed
    assert abs(signed_volume(surface.points, surface.facets) - 8) < ROUNDING
    with refusals.refused(fc.InputError, "one-surface", "'top'"):
        fc.read_surface(tmp_path / name, "top")


@pytest.mark.parametrize("name", WRITERS)
def test_files_that_are_cut_short(name, tmp_path):
    path = tmp_path / name
    WRITERS[name](path)
    whole = path.read_bytes()
    refused = 0
    for share in (0.1, 0.4, 0.7, 0.9):
        path.write_bytes(whole[: int(share * len(whole))])
        try:
            fc.read_surface(path)
        except fc.MeshError:
            refused += 1
    # faces that are missing at the end of an .obj file cannot be seen
    assert refused >= (1 if name == "cube.obj" else 4)


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("ascii.vtp", "4 8 12 16 19 22 25 28", "4 8 12 16 19 22 25 999", ("mesh", "offsets")),
        ("ascii.vtp", "4 8 12 16 19 22 25 28", "4 2 12 16 19 22 25 28", ("mesh", "offsets")),
        ("ascii.vtp", 'type="PolyData"', 'type="ImageData"', ("no-poly",)),
        ("cube.off", "1.0 1.0 1.0", "1.0 1e308 1.0", ("out-of-scale", "The size of the mesh")),
        ("cube.off", "1.0 1.0 1.0", "1.0 nan 1.0", ("mesh", "not finite")),
        ("cube.off", "COFF", "MESH", ("mesh", "does not begin with OFF")),
        ("text.ply", "ascii 1.0", "morse 1.0", ("ply-format",)),
        ("text.ply", "element vertex 8", "element vertex 80", ("mesh", "incomplete")),
        ("text.ply", "ply\n", "plop\n", ("no-ply-header",)),
    ],
)
def test_damaged_files(name, old, new, words, tmp_path):
    path = tmp_path / name
    WRITERS[name](path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with refusals.refused((fc.MeshError, fc.InputError), *words):
        fc.read_surface(path)


DECK = """*NODE
1,0,0,0
2,1,0,0
3,0,1,0
4,0,0,1
5,5,0,0
6,6,0,0
7,6,1,0
8,5,1,0
*ELEMENT, TYPE=C3D4, ELSET=Solid
1,1,2,3,4
*ELEMENT, TYPE=R3D4, ELSET=Plate
2,5,6,7,8
*SURFACE, NAME=Bottom
1,S1
"""
FEB = """<febio_spec version="4.0"><Mesh><Nodes><node id="1">0,0,0</node>
<node id="5">5,0,0</node><node id="6">6,0,0</node><node id="7">6,1,0</node><node id="8">5,1,0</node></Nodes>
<Elements type="quad4" name="Plate"><elem id="2">5,6,7,8</elem></Elements></Mesh></febio_spec>"""


def test_shells_and_surfaces_by_name(tmp_path):
    deck, shell = tmp_path / "deck.inp", tmp_path / "deck.feb"
    deck.write_text(DECK)
    shell.write_text(FEB)
    for plate in (fc.read_surface(deck, "plate"), fc.read_surface(shell)):
        assert np.ptp(plate.points, axis=0).tolist() == [1, 1, 0]
        assert abs(plate.areas.sum() - 1) < ROUNDING
    bottom = fc.read_surface(deck, "Bottom", scale=3.0)
    assert abs(bottom.areas.sum() - 4.5) < 9 * ROUNDING
    assert abs(bottom.normals[bottom.nodes] - [0, 0, -1]).max() < ROUNDING
    with refusals.refused(fc.InputError, "several-surfaces", "has 2", "'Plate', 'Bottom'"):
        fc.read_surface(deck)
    with refusals.refused(fc.InputError, "unknown", "'Lid'", "'Plate', 'Bottom'"):
        fc.read_surface(deck, "Lid")
    with refusals.refused(fc.InputError, "input", "scale is given as scale="):
        fc.read_surface(deck, 2.0)
    assert fc.RigidBody.from_surface(deck, part="Plate").size > 1
