"""Decks of Abaqus and CalculiX of two blocks, one on the other, and the same scene in Python."""

import fecontact as fc

#: Faces S6, S4, S3, S5, S1, S2 of C3D8 are the local faces -x, +x, -y, +y, -z, +z.
LABELS = (6, 4, 3, 5, 1, 2)
TYPES = {"hex8": "C3D8", "hex20": "C3D20"}
SIDES = ("bottom", "top", "x_min", "y_min")
MATERIAL = fc.Material(100.0, 0.3)


def blocks(lower="hex8", upper="hex8", divisions=((2, 2, 2), (3, 3, 2))):
    """Two unit cubes."""
    one, other = (
        fc.shapes.block((1.0, 1.0, 1.0), n, element=e) for n, e in zip(divisions, (lower, upper), strict=True)
    )
    return one, other.translated((0.0, 0.0, 1.0))


def listed(name, mesh, first):
    """Nodes, elements, sets `name`_top, ... and surfaces `name`_face_top, ... of a mesh, numbered from `first`."""

    def line(number, values):
        return ", ".join(map(str, (number, *values[:9]))) + "".join(f",\n{v}" for v in values[9:]) + "\n"

    kind = TYPES[mesh.cell_type]
    out = "*NODE\n" + "".join(line(first + k, x) for k, x in enumerate(mesh.points.tolist()))
    out += f"*ELEMENT, TYPE={kind}, ELSET={name}\n"
    out += "".join(line(first + k, c) for k, c in enumerate((mesh.cells + first).tolist()))
    for side in SIDES:
        out += f"*NSET, NSET={name}_{side}\n" + "".join(f"{n},\n" for n in (mesh.boundary_nodes(side) + first).tolist())
        faces = "".join(f"{first + cell}, S{LABELS[face]}\n" for cell, face in mesh.faces(side).tolist())
        out += f"*SURFACE, NAME={name}_face_{side}\n{faces}"
    return out


def deck_of(meshes, steps, model="", friction="", interaction=""):
    """Text of a deck of a lower block LOW and an upper one UP, of `MATERIAL`, with their contact."""
    E, nu = MATERIAL.E, MATERIAL.nu
    parts = "".join(
        listed(name, mesh, first) for name, mesh, first in zip(("LOW", "UP"), meshes, (1, 5001), strict=True)
    )
    return (
        f"{parts}*MATERIAL, NAME=M\n*ELASTIC\n{E}, {nu}\n*SOLID SECTION, ELSET=LOW, MATERIAL=M\n"
        f"*SOLID SECTION, ELSET=UP, MATERIAL=M\n*SURFACE INTERACTION, NAME=I\n{interaction}{friction}"
        f"*CONTACT PAIR, INTERACTION=I\nUP_face_bottom, LOW_face_top\n{model}{steps}"
    )


def step(loads, head="*STEP\n", static="*STATIC\n1., 1.\n"):
    return f"{head}{static}{loads}*END STEP\n"


def scene_of(meshes, friction=0.0, low="xyz", up="xyz"):
    """The same scene in Python, with its bottom and top held in these components."""
    lower, upper = meshes
    one = fc.ElasticBody(lower, MATERIAL, "top", {"bottom": low} if low else {}, name="LOW")
    other = fc.ElasticBody(upper, MATERIAL, "bottom", {"top": up} if up else {}, name="UP")
    return fc.Scene([one, other], [fc.Contact(other, one, friction=friction)])
