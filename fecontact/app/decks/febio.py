"""Scenes from FEBio decks: laws, rigid parts, supports, loads, sliding and tied contacts, load curves.

Sections as in the FEBio User Manual (specification 2.5 to 4.0). What is not used is listed with its line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from fecontact.app.decks.content import DeckContent, DeckPair, DeckRigid, Remarks
from fecontact.app.decks.febio_steps import Curves, deck_steps, nodes_of, rigid_name, segments_of, wall_name, wall_of
from fecontact.app.decks.materials import AT_REST, LAWS, REMEDY, law_of_febio, of_febio
from fecontact.app.options import FINITE
from fecontact.common.arrays import IntArray
from fecontact.common.errors import InputError, not_done
from fecontact.common.material import Material
from fecontact.fem.laws import Law
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.build import build
from fecontact.mesh.facets import places_among
from fecontact.mesh.formats.febio import MESH_SECTIONS, read_febio, read_tree
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.surface_mesh import SurfaceMesh

Element = ElementTree.Element

#: Contacts that slide and that are tied, by their types.
SLIDING = {
    "sliding-elastic",
    "sliding-facet-on-facet",
    "sliding-node-on-facet",
    "facet-to-facet sliding",
    "sliding_with_gaps",
    "sliding2",
    "sliding3",
    "sliding-biphasic",
}
TIED = {"tied-elastic", "tied-facet-on-facet", "tied-node-on-facet", "tied", "tied-biphasic"}
#: Materials whose solid is their child of this tag.
OUTER = {
    "biphasic": "solid",
    "biphasic-solute": "solid",
    "triphasic": "solid",
    "multiphasic": "solid",
    "viscoelastic": "elastic",
    "uncoupled viscoelastic": "elastic",
    "prestrain elastic": "elastic",
}
#: What such a material has beside its solid, by the tag of that.
OUTER_IS = {"solid": "the flow of its fluid", "elastic": "relaxation or prestrain"}
RIGID = "rigid body"
WALL = "rigid_wall"
#: Sections that are read, or that set how to solve and what to print.
USED = {"Module", "Control", "Globals", "Material", "MeshDomains", "Boundary", "Rigid", "Loads", "Contact", "Step"}
USED |= {"Constraints", "LoadData", "Output", *MESH_SECTIONS}


@dataclass(frozen=True, eq=False)
class Parts:
    """Cells of materials, and cells and nodes of shells of rigid parts, of a mesh with all its cells."""

    sections: list[tuple[IntArray, str]]
    materials: dict[str, Material | Law]
    rigid: dict[str, IntArray]
    rigid_shells: dict[str, IntArray]


def read_feb(path: Path, laws: str = FINITE) -> DeckContent:
    """Contents of a deck, with its laws of finite strain or with their moduli at rest.

    Raises
    ------
    InputError, MeshError
        For names that are missing, values that cannot be read, and laws that are not known.
    """
    root, missing = read_tree(path, numbered=True)
    raw = read_febio(path)
    mesh = build(raw, path.name)
    if missing:
        raise InputError(f"Files that {path.name} includes are missing: {', '.join(missing)}.", code="missing-files")
    remarks = Remarks(list(mesh.notes))
    try:
        parts = _parts(root, raw, mesh, laws, remarks)
        names = _rigid_names(root)
        contacts, ties = _pairs(root, remarks)
        wanted = {n for p in contacts for n in (p.slave, p.master)}
        stiff = [m for m in root.iterfind("Material/material") if m.get("type") == RIGID]
        walls = [wall_of(c, mesh) for c in root.iter("constraint") if c.get("type") == WALL]
        if len({w.name for w in walls}) < len(walls):
            raise not_done(
                f"{path.name}: a surface has several <constraint type={WALL!r}>; give each one a <Surface> of its own."
            )
        rigid = [_rigid(m, parts, raw, mesh, wanted, _glued(_name(m), root, names, mesh, remarks)) for m in stiff]
        rigid += walls
        curves, segments = Curves.of(root), segments_of(root)
        for a in (a for a in root.iter("analysis") if (a.text or a.get("type") or "").strip().lower() == "dynamic"):
            raise InputError(f"{a.get('line')}: the analysis is dynamic; inertia is not computed here.", code="dynamic")
        steps = deck_steps(segments, curves, mesh, {r.name: r for r in rigid}, names, path.name, remarks)
    except (ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path.name} holds a value that cannot be read: {error}.", code="bad-value") from error
    for s in (s for s in root if s.tag not in USED):
        remarks.warn(f"{s.get('line')}: <{s.tag}> is not used: what it changes is left out.")
    cells = np.setdiff1d(np.arange(len(mesh.cells)), np.concatenate([np.zeros(0, np.int64), *parts.rigid.values()]))
    if not len(cells):
        raise InputError(f"{path.name} has rigid parts only; a scene needs an elastic body.")
    kept = np.unique(mesh.cells[cells])
    point = places_among(kept, len(mesh.points))
    number = places_among(cells, len(mesh.cells))
    elastic = replace(mesh, groups={**mesh.groups, "elastic cells": cells}).part("elastic cells")
    elastic = replace(elastic, groups={k: g for k, g in elastic.groups.items() if k != "elastic cells"})
    return DeckContent(
        path.name,
        "",
        elastic,
        [(number[own], material) for own, material in parts.sections],
        parts.materials,
        [replace(s, held=s.held[kept], forces=s.forces[kept]) for s in steps],
        contacts,
        ties,
        remarks.all_notes,
        [replace(r, attached=point[r.attached][point[r.attached] >= 0]) for r in rigid],
        tuple(dict.fromkeys(remarks.warnings)),
    )


def _parts(root: Element, raw: RawMesh, mesh: Mesh, laws: str, remarks: Remarks) -> Parts:
    """Materials of the domains; those of FEBio 2.5 stand at <Elements>."""
    found = {_name(m): m for m in root.iterfind("Material/material")}
    by_id = {m.get("id", ""): name for name, m in found.items()}
    none = np.zeros(0, np.int64)
    stiff = [name for name, m in found.items() if m.get("type") == RIGID]
    out = Parts([], {}, dict.fromkeys(stiff, none), dict.fromkeys(stiff, none))
    domains = [d for section in root.findall("MeshDomains") for d in section]
    blocks = [e for tag in MESH_SECTIONS for section in root.findall(tag) for e in section.findall("Elements")]
    for d in [*domains, *(e for e in blocks if e.get("mat"))]:
        domain, given = d.get("name") or d.get("elset") or "", d.get("mat", "")
        name = given if given in found else by_id.get(given, "")
        if name not in found:
            raise InputError(
                f"{d.get('line')}: there is no material {given!r}; there are: {', '.join(found) or 'none'}."
            )
        material = found[name]
        if material.get("type") == RIGID:
            out.rigid[name] = np.union1d(out.rigid[name], mesh.groups.get(domain, none))
            shells = [f.ravel() for f in raw.shells.get(domain, [])]
            out.rigid_shells[name] = np.unique(np.concatenate([out.rigid_shells[name], *shells]))
        elif domain in mesh.groups:
            out.materials.setdefault(name, _material(material, laws, remarks))
            out.sections.append((mesh.groups[domain], name))
        else:
            raise not_done(
                f"{d.get('line')}: the elements of {domain!r} of the elastic material {name!r} are no solids, and "
                "their stiffness would be lost."
            )
    return out


def _name(material: Element) -> str:
    """Name of a material, else its number."""
    return material.get("name") or material.get("id") or ""


def _rigid_names(root: Element) -> dict[str, str]:
    """Names of rigid materials by name and by number."""
    found = [m for m in root.iterfind("Material/material") if m.get("type") == RIGID]
    names = {m.get("id", ""): _name(m) for m in found}
    return names | {name: name for name in names.values()}


def _material(material: Element, laws: str, remarks: Remarks) -> Material | Law:
    """The law of a material, or its linear material at rest."""
    kind, where, line = material.get("type", ""), material, material.get("line")
    outer = ""
    while kind in OUTER and (inner := where.find(OUTER[kind])) is not None:
        outer = outer or f"the {OUTER[kind]} of the {kind} material, "
        density = where.findtext("density")
        where, kind = inner, inner.get("type", "")
        if density is not None and where.find("density") is None:
            ElementTree.SubElement(where, "density").text = density
    values = {}
    for child in where:
        if child.get("lc"):
            raise not_done(
                f"{child.get('line')}: <{child.tag}> of a material changes by a load curve, which is not done here; "
                "write its value."
            )
        try:
            values[child.tag] = float(child.text or "")
        except ValueError:
            continue
    if laws == FINITE:
        model = (where.findtext("pressure_model") or "default").strip()
        known = "" if outer or model not in ("0", "default") else kind
        if (law := law_of_febio(known, values)) is not None:
            return law
        what = f"{outer or 'the law '}{kind!r}" + ", with its <pressure_model>" * (model not in ("0", "default"))
        rest = f" {REMEDY}" if kind in AT_REST else ""
        if outer:
            raise InputError(
                f"{line}: the {kind} in a {material.get('type')} material: {OUTER_IS[OUTER[material.get('type', '')]]} "
                f"changes its answer with time, which is not computed here.{rest}",
                code="unknown-law",
            )
        raise InputError(
            f"{line}: {what}, is not offered at finite strain; there are: {', '.join(LAWS)}.{rest}", code="unknown-law"
        )
    made = of_febio(kind, values)
    if made is None:
        raise InputError(
            f"{line}: {outer}the law {kind!r} has no linear isotropic material at rest that is known here.",
            code="unknown-law",
        )
    remarks.warn(f"{line}: {outer}{kind} is linear, with the moduli at rest: E = {made.E:.6g}, nu = {made.nu:.6g}.")
    return made


def _glued(name: str, root: Element, names: dict[str, str], mesh: Mesh, remarks: Remarks) -> list[IntArray]:
    """Nodes that <bc type="rigid"> or <rigid> attaches to a rigid part."""
    entries = [b for section in root.iter("Boundary") for b in section if (b.get("type") or b.tag) == "rigid"]
    sets = [nodes_of(b, mesh, remarks) for b in entries if rigid_name(b, names) == name]
    return [nodes for nodes in sets if nodes is not None]


def _rigid(
    material: Element, parts: Parts, raw: RawMesh, mesh: Mesh, wanted: set[str], glued: Sequence[IntArray]
) -> DeckRigid:
    """A rigid part with its contact surfaces, and the elastic points that are its own or glued to it.

    It turns about the centre of mass that its material gives, else about that of its cells, or the mean of the corners
    of its shells.
    """
    name = _name(material)
    cells, shells = parts.rigid[name], parts.rigid_shells[name]
    facets, names = [np.zeros((0, 4), np.int64)], set()
    points = mesh.points
    for surface in sorted(wanted & set(mesh.boundaries)):
        faces = mesh.faces(surface)
        own = faces[np.isin(faces[:, 0], cells)]
        if len(own):
            facets.append(mesh.face_nodes(own)[:, :4])
            names.add(surface)
    for surface in sorted(wanted & set(raw.facets) - set(mesh.boundaries)):
        given = [f[:, [0, 1, 2, -1]] for f in raw.facets[surface]]
        if given and all(np.isin(f, shells).all() for f in given):
            facets += [f + len(points) for f in given]
            names.add(surface)
    elastic = np.setdiff1d(np.arange(len(mesh.cells)), np.concatenate(list(parts.rigid.values())))
    number = {int(n): k for k, n in enumerate(mesh.file_nodes if mesh.file_nodes is not None else [])}
    ids = raw.node_ids[shells] if raw.node_ids is not None else shells
    of_shells = np.array([number[n] for n in ids.tolist() if n in number], dtype=np.int64)
    own_points = np.unique(np.concatenate([mesh.cells[cells].ravel(), of_shells, *glued]))
    attached = np.intersect1d(own_points, np.unique(mesh.cells[elastic]))
    surface_mesh = None
    if names:
        used, own_facets = np.unique(np.concatenate(facets), return_inverse=True)
        surface_mesh = SurfaceMesh(np.concatenate([points, raw.points])[used], own_facets.reshape(-1, 4))
    text = material.findtext("center_of_mass")
    solid = replace(mesh, groups={"solid": cells})
    volume, middle = moments_of_volume(solid.part("solid")) if len(cells) else (0.0, np.zeros(3))
    mass = None if len(shells) else float(material.findtext("density") or 1.0) * volume
    corners = raw.points[shells] if len(shells) else mesh.points[attached]
    if not len(cells) and len(corners):
        middle = corners.mean(axis=0)
    centre = middle if text is None else np.array(text.split(","), dtype=float)
    return DeckRigid(name, centre, surface_mesh, frozenset(names), attached, mass=mass)


def _pairs(root: Element, remarks: Remarks) -> tuple[list[DeckPair], list[DeckPair]]:
    """Sliding and tied contacts of all steps; others are refused."""
    pairs = {}
    for pair in (p for tag in MESH_SECTIONS for p in root.iterfind(f"{tag}/SurfacePair")):
        ends = [_end(pair, tags) for tags in (("primary", "slave"), ("secondary", "master"))]
        pairs[pair.get("name", "")] = ends
    contacts: list[DeckPair] = []
    ties: list[DeckPair] = []
    inner = [c for step in root.iter("Step") for c in (*step.iter("contact"), *step.iter("constraint"))]
    steps = [s for step in root.findall("Step") for s in (step.findall("step") or [step])]
    several, late = len(steps) > 1, [c for step in steps[1:] for c in step.iter("contact")]
    for c in root.iter("contact"):
        place, kind, name = c.get("line", ""), c.get("type", ""), c.get("surface_pair", "")
        if kind not in SLIDING | TIED:
            raise not_done(
                f"{place}: the contact {c.get('name') or name!r} of type {kind!r} is not done here, and would be lost; "
                f"there are: {', '.join(sorted(SLIDING | TIED))}."
            )
        if name not in pairs:
            raise InputError(f"{place}: there is no surface pair {name!r}; there are: {', '.join(pairs) or 'none'}.")
        if (wrong := c.find("fric_coeff")) is not None and wrong.get("lc"):
            raise not_done(f"{wrong.get('line')}: friction by a load curve changes with time, which is not done here.")
        if (c.findtext("tension") or "0").strip() != "0" and kind in SLIDING:
            raise InputError(f"{place}: surfaces that pull on each other (tension) are not done here.", code="tension")
        if kind in TIED and c in late:
            raise not_done(
                f"{place}: the tie {c.get('name') or name!r} begins in a later step, at the shape of that time; here "
                "ties hold from the start. Give its step as a deck of its own."
            )
        if several and c in inner:
            remarks.warn(f"{place}: the contact {c.get('name') or name!r} acts in all steps, not in its own alone.")
        friction = float(c.findtext("fric_coeff") or 0.0)
        slave, master = pairs[name]
        (ties if kind in TIED else contacts).append(DeckPair(slave, master, friction, place))
    for c in (c for c in root.iter("constraint") if c.get("type") == WALL):
        if several and c in inner:
            remarks.warn(f"{c.get('line')}: the {wall_name(c)!r} acts in all steps, not in its own alone.")
        contacts.append(DeckPair(c.get("surface", ""), wall_name(c), 0.0, c.get("line", "")))
    return contacts, ties


def _end(pair: Element, tags: Sequence[str]) -> str:
    """Name of a surface of a pair: the text of the first of these tags, or its attribute."""
    for tag in tags:
        if (found := pair.find(tag)) is not None:
            return (found.get("surface") or found.text or "").strip()
    raise InputError(f"{pair.get('line')}: the surface pair {pair.get('name')!r} has no <{tags[0]}>.", code="no-pair")
