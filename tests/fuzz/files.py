"""Decks and scene files written by the generator, each beside the same scene in Python."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from frame import Frame
from judging import Answer
from scenes import answer, figures

import fecontact as fc

#: Abaqus's labels of the local faces -x, +x, -y, +y, -z, +z.
_LABELS = np.array([6, 4, 3, 5, 1, 2])


def _blocks(rng: np.random.Generator, frame: Frame, kinds: tuple[str, str]) -> tuple[list[Any], list[Any], float]:
    """Sizes and divisions of two blocks, the upper one on the lower, and how far it is moved down."""
    sizes = [rng.uniform(0.7, 1.4, 3) for _ in range(2)]
    meshes = [
        fc.shapes.block(tuple(map(float, size)), [int(n) for n in rng.integers(1, 4, 3)], element=kind)
        for size, kind in zip(sizes, kinds, strict=True)
    ]
    offset = (*((sizes[0] - sizes[1])[:2] / 2 + 0.05 * rng.normal(size=2)), sizes[0][2])
    meshes[1] = meshes[1].translated(offset)
    return [frame.mesh(m) for m in meshes], sizes, float(10 ** rng.uniform(-4, -2)) * frame.length * frame.deeper


def _python(meshes: list[Any], materials: list[fc.Material], mu: float, depth: float, **options: Any) -> Any:
    lower = fc.ElasticBody(meshes[0], materials[0], "top", {"bottom": "xyz"}, name="LOWER")
    upper = fc.ElasticBody(meshes[1], materials[1], "bottom", {"top": "xyz"}, name="UPPER")
    scene = fc.Scene([lower, upper], [fc.Contact(upper, lower, friction=mu)])
    return scene.solve(motions={upper: {"z": -depth}}, **options)


def _beside(result: Any, reference: Any, frame: Frame) -> Answer:
    return replace(answer(result, frame, 1e-8, "force 0"), against=figures(reference, frame))


def _drawn(rng: np.random.Generator, frame: Frame) -> tuple[list[str], list[Any], float, float]:
    """Kinds of cells, meshes, depth and friction of two blocks."""
    kinds = [str(k) for k in rng.choice(["hex8", "hex20"], 2)]
    meshes, _, depth = _blocks(rng, frame, (kinds[0], kinds[1]))
    return kinds, meshes, depth, float(rng.choice([0.0, 0.0, 0.2]))


def _text_solved(name: str, text: str, **options: Any) -> Any:
    """Result of the text of a deck."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_text(text)
        return fc.read_scene(path, **options).solve()


def deck_beside_python(number: int, frame: Frame) -> Callable[[], Answer]:
    """An Abaqus deck of two blocks, the upper one moved down."""
    rng = np.random.default_rng([11, number])
    _, meshes, depth, mu = _drawn(rng, frame)
    materials = [
        frame.material(1.0, 0.3),
        frame.material(float(10 ** rng.uniform(-0.5, 0.5)), float(rng.choice([0, 0.3]))),
    ]

    def run() -> Answer:
        result = _text_solved("blocks.inp", _deck(meshes, materials, mu, depth))
        return _beside(result, _python(meshes, materials, mu, depth, finite_motion=False), frame)

    return run


def _deck(meshes: list[Any], materials: list[fc.Material], mu: float, depth: float) -> str:
    text = ["*HEADING", "two blocks"]
    first = [1, 1 + len(meshes[0].points)]
    for name, mesh, material, start in zip(("LOWER", "UPPER"), meshes, materials, first, strict=True):
        kind = {8: "C3D8", 20: "C3D20"}[mesh.cells.shape[1]]
        text.append(f"*NODE, NSET=N{name}")
        text += [f"{k + start}, " + ", ".join(repr(float(c)) for c in p) for k, p in enumerate(mesh.points)]
        text.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        for k, cell in enumerate(mesh.cells):
            numbers = [str(k + start), *(str(n + start) for n in cell)]
            lines = [numbers[i : i + 10] for i in range(0, len(numbers), 10)]
            text.append(",\n".join(", ".join(line) for line in lines))
        for side in ("bottom", "top"):
            text.append(f"*NSET, NSET={name}_{side}")
            text += [f"{n + start}," for n in mesh.boundary_nodes(side)]
            text.append(f"*SURFACE, NAME={name}_{side}_faces")
            text += [f"{cell + start}, S{_LABELS[face]}" for cell, face in mesh.boundaries[side]]
        text += [f"*MATERIAL, NAME=M{name}", "*ELASTIC", f"{material.E!r}, {material.nu!r}"]
        text.append(f"*SOLID SECTION, ELSET={name}, MATERIAL=M{name}")
    text += ["*SURFACE INTERACTION, NAME=DRY", *(["*FRICTION", f"{mu}, 1e5"] if mu else [])]
    text += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD"]
    text += ["*CONTACT PAIR, INTERACTION=DRY, TYPE=SURFACE TO SURFACE", "UPPER_bottom_faces, LOWER_top_faces"]
    text += ["*BOUNDARY", "LOWER_bottom, 1, 3", "UPPER_top, 1, 2"]
    text += ["*STEP", "*STATIC", "1., 1.", "*BOUNDARY", f"UPPER_top, 3, 3, {-depth!r}", "*END STEP", ""]
    return "\n".join(text)


def febio_beside_python(number: int, frame: Frame) -> Callable[[], Answer]:
    """An FEBio deck of two blocks, the upper one moved down."""
    rng = np.random.default_rng([16, number])
    kinds, meshes, depth, mu = _drawn(rng, frame)
    materials = [frame.material(float(10 ** rng.uniform(-0.5, 0.5)), float(rng.choice([0, 0.3]))) for _ in range(2)]
    order = [int(k) for k in rng.permutation(2)]

    def run() -> Answer:
        result = _text_solved("blocks.feb", _febio(meshes, kinds, materials, mu, depth, order), laws="small-strain")
        return _beside(result, _python(meshes, materials, mu, depth), frame)

    return run


def _febio(
    meshes: list[Any], kinds: list[str], materials: list[fc.Material], mu: float, depth: float, order: list[int]
) -> str:
    """The deck, its parts in that order."""
    names, starts = ("LOWER", "UPPER"), [1, 1 + len(meshes[0].points)]
    laws, parts, sets, domains = "", "", "", ""
    for k in order:
        name, mesh, first, material = names[k], meshes[k], starts[k], materials[k]
        law = f"<E>{material.E!r}</E><v>{material.nu!r}</v>"
        laws += f'<material id="{len(laws) + 1}" name="M{name}" type="isotropic elastic">{law}</material>\n'
        points = mesh.points.tolist()
        nodes = "\n".join(f'<node id="{i + first}">{x!r},{y!r},{z!r}</node>' for i, (x, y, z) in enumerate(points))
        cells = "\n".join(
            f'<elem id="{i + first}">{",".join(str(n + first) for n in cell)}</elem>'
            for i, cell in enumerate(mesh.cells.tolist())
        )
        parts += f'<Nodes>{nodes}</Nodes>\n<Elements type="{kinds[k]}" name="{name}">{cells}</Elements>\n'
        for side in ("bottom", "top"):
            facets = (mesh.face_nodes(mesh.boundaries[side]) + first).tolist()
            rows = [f'<quad{len(f)} id="{i + 1}">{",".join(map(str, f))}</quad{len(f)}>' for i, f in enumerate(facets)]
            listed = ",".join(str(n + first) for n in mesh.boundary_nodes(side))
            sets += f'<Surface name="{name}_{side}">{"".join(rows)}</Surface>\n'
            sets += f'<NodeSet name="{name}_{side}">{listed}</NodeSet>\n'
        domains += f'<SolidDomain name="{name}" mat="M{name}"/>'
    pair = '<SurfacePair name="P"><primary>UPPER_bottom</primary><secondary>LOWER_top</secondary></SurfacePair>'
    fixed = "".join(
        f'<bc type="zero displacement" node_set="{name}">{"".join(f"<{c}_dof>1</{c}_dof>" for c in axes)}</bc>\n'
        for name, axes in (("LOWER_bottom", "xyz"), ("UPPER_top", "xy"))
    )
    down = f'<dof>z</dof><value lc="1">{-depth!r}</value><relative>0</relative>'
    curve = '<load_controller id="1" type="loadcurve"><points><pt>0,0</pt><pt>1,1</pt></points></load_controller>'
    return f"""<?xml version="1.0"?>
<febio_spec version="4.0"><Control><time_steps>10</time_steps><step_size>0.1</step_size></Control>
<Material>{laws}</Material>
<Mesh>{parts}{sets}{pair}</Mesh>
<MeshDomains>{domains}</MeshDomains>
<Boundary>{fixed}<bc type="prescribed displacement" node_set="UPPER_top">{down}</bc></Boundary>
<Contact><contact type="sliding-elastic" surface_pair="P"><fric_coeff>{mu}</fric_coeff></contact></Contact>
<LoadData>{curve}</LoadData></febio_spec>
"""


def scene_file_beside_python(number: int, frame: Frame) -> Callable[[], Answer]:
    """The same two blocks in a scene file, the upper one moved down or loaded."""
    rng = np.random.default_rng([12, number])
    sizes = [rng.uniform(0.7, 1.4, 3) * frame.length for _ in range(2)]
    cells = [[int(n) for n in rng.integers(1, 4, 3)] for _ in range(2)]
    kinds = [str(k) for k in rng.choice(["hex8", "hex20", "hex27"], 2)]
    stiff = [1.0 * frame.modulus, float(10 ** rng.uniform(-0.5, 0.5)) * frame.modulus]
    at = [*((sizes[0] - sizes[1])[:2] / 2 + 0.05 * rng.normal(size=2) * frame.length).tolist(), float(sizes[0][2])]
    depth, mu = float(10 ** rng.uniform(-4, -2)) * frame.length * frame.deeper, float(rng.choice([0.0, 0.3]))
    loaded = bool(rng.random() < 0.4)
    load = depth / frame.length * frame.force

    def body(k: int) -> list[str]:
        name, side, held = (("lower", "top", "bottom"), ("upper", "bottom", "top"))[k]
        shape = f'kind = "block", size = {sizes[k].tolist()}, divisions = {cells[k]}, element = "{kinds[k]}"'
        out = [f"[materials.m{k}]", f"E = {stiff[k]!r}", "nu = 0.3", f"[bodies.{name}]", f'material = "m{k}"']
        out += [f'contact = "{side}"', f'supports = {{ {held} = "xyz" }}', f"shape = {{ {shape} }}"]
        return [*out, f"pose = {{ translation = {at} }}"] if k else out

    given = f"forces.upper = [0.0, 0.0, {-load!r}]" if loaded else f"motions.upper = {{ z = {-depth!r} }}"
    text = [
        *body(0),
        *body(1),
        "[[contacts]]",
        'slave = "upper"',
        'master = "lower"',
        f"friction = {mu}",
        "[loads]",
        given,
    ]

    def run() -> Answer:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "blocks.toml"
            path.write_text("\n".join([*text, ""]))
            result = fc.read_scene(path).solve()
        meshes = [
            fc.shapes.block(tuple(map(float, size)), n, element=kind)
            for size, n, kind in zip(sizes, cells, kinds, strict=True)
        ]
        lower = fc.ElasticBody(meshes[0], fc.Material(stiff[0], 0.3), "top", {"bottom": "xyz"}, name="lower")
        upper = fc.ElasticBody(meshes[1], fc.Material(stiff[1], 0.3), "bottom", {"top": "xyz"}, name="upper")
        upper = upper.placed(tuple(at))
        scene = fc.Scene([lower, upper], [fc.Contact(upper, lower, friction=mu)])
        loads: dict[str, Any] = {"forces": {upper: (0, 0, -load)}} if loaded else {"motions": {upper: {"z": -depth}}}
        # the file's meshes are not the frame's
        return replace(_beside(result, scene.solve(**loads), frame), errors={})

    return run
