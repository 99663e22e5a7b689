"""Geometry of a body's contact faces: placed on the surface that they stand for when the body is made.

Flat pieces of a round surface, straight sides and the 20-node map, which has no s^2 t^2, make contacts that no division
of cells mends. The nodes of contact faces are therefore placed on a given surface, or on one fitted to the mesh. Cells
keep their kind: those of 8 nodes stay flat, but the nodes of their divisions are placed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fecontact.bodies.pose import Pose
from fecontact.bodies.rigid import RigidBody, RigidShape
from fecontact.common.arrays import ROUNDING, Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.placement import Placement, curved_facets, nodes_off_centre, placed
from fecontact.surfaces.facet_surface import FacetSurface, Projection
from fecontact.surfaces.smooth import SmoothSurface, bordering, fitted

#: What a contact surface is made of: fitted where it is curved, a shape in the body's axes, what an earlier body of the
#: same geometry was given, or as the mesh has it.
Geometry = str | RigidShape | RigidBody | Placement | None
CHOICES = ("auto", "plain")
#: Part of the height of curved faces by which nodes move without being worth a note.
UNTOLD = 0.01
#: Distance from a given surface, in sizes of the face, above which it is another surface.
FARTHEST = 0.5
#: Share of a boundary's nodes that a smooth surface must represent for its faces to be placed on it.
MIN_FITTED = 0.75
#: End of the note on moved nodes.
TURNED_OFF = "(geometry='plain' leaves them as they were)."


@dataclass(frozen=True, eq=False)
class PosedShape:
    """A shape that stands turned and shifted in the body's axes."""

    shape: RigidShape
    pose: Pose

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3)."""
        foot = self.shape.project(self.pose.to_body(points))
        return replace(foot, points=self.pose.to_world(foot.points), normals=foot.normals @ self.pose.rotation.T)


def recovered(
    mesh: Mesh, names: tuple[str, ...], geometry: Geometry | Mapping[str, Geometry], midface: bool
) -> tuple[Mesh, dict[str, Geometry]]:
    """A mesh with the nodes of contact faces where they belong, and what they were placed on.

    Parameters
    ----------
    mesh : Mesh
    names : tuple of str
        Contact boundaries.
    geometry
        As `ElasticBody` takes it.
    midface : bool
        Whether faces of 20-node cells get a node in their middle.

    Returns
    -------
    Mesh
    dict of str to Placement or 'plain'
    """
    choice = {name: _choice(geometry, name) for name in names}
    unknown = set(geometry) - set(names) if isinstance(geometry, Mapping) else set()
    if unknown:
        raise InputError(
            f"geometry names {', '.join(map(repr, sorted(unknown)))}, which are no contact surfaces; these are "
            f"{', '.join(map(repr, names)) or 'none'}.",
            code="no-contact-surface",
        )
    fresh = fitted(mesh, [name for name, what in choice.items() if isinstance(what, str) and what == "auto"])
    given = {name: _given(mesh, name, what) for name, what in choice.items() if not isinstance(what, str)}
    out = mesh.with_midface_nodes(names) if midface and names and mesh.cell_type == "hex20" else mesh
    # a fitted surface passes through the corners: as long as these are all there is, nothing moves
    due = given if mesh.cell_type == "hex8" else {**fresh, **given}
    rough = {name for name, what in due.items() if _share(what) < MIN_FITTED}
    # a node that an earlier body placed was not given to fits of its 8 neighbours, which have moved since
    before = [nodes_off_centre(mesh, name, _rounding(mesh)) for name in fresh if mesh.cell_type == "hex20"]
    settled = np.concatenate([np.zeros(0, np.int64), *before])
    where, drawn = placed(out, {name: what for name, what in due.items() if name not in rough}, settled)
    notes = [note for name in sorted(rough) if (note := _left_alone(name, due[name])) not in mesh.notes]
    if not any(note.endswith(TURNED_OFF) for note in mesh.notes):
        notes += _notes(out, where, due, drawn)
    kept: dict[str, Geometry] = {
        name: "plain" if name in rough else {**fresh, **given}.get(name, "plain") for name in names
    }
    return replace(where, notes=(*where.notes, *notes)), kept


def _share(placement: Placement) -> float:
    """Share of a boundary's nodes that its surface represents: all, where it is given."""
    surface = placement.surface
    return float(surface.fits.is_fitted.mean()) if isinstance(surface, SmoothSurface) else 1.0


def _left_alone(name: str, placement: Placement) -> str:
    """Note on a boundary whose nodes no smooth surface represents."""
    return (
        f"faces of {name!r} are left as they were: no smooth surface represents {1 - _share(placement):.0%} of their "
        "nodes, too few or too rough (geometry='plain' says that this is meant)."
    )


def _choice(geometry: Geometry | Mapping[str, Geometry], name: str) -> str | RigidShape | RigidBody | Placement:
    """What is asked for one surface."""
    what = geometry.get(name, "auto") if isinstance(geometry, Mapping) else geometry
    if what is None:
        return "plain"
    if isinstance(what, str):
        among("geometry", what, CHOICES)
    elif not isinstance(what, (RigidBody, Placement)) and not hasattr(what, "project"):
        raise InputError(
            f"geometry of {name!r} is 'auto', 'plain' or a shape, such as fc.Sphere(10.0) or "
            f"fc.RigidBody(fc.Sphere(10.0)).placed(...); found {type(what).__name__}.",
            code="geometry",
        )
    return what


def _given(mesh: Mesh, name: str, what: RigidShape | RigidBody | Placement) -> Placement:
    """Where the nodes of a boundary belong by a given shape.

    Raises
    ------
    InputError
        If nodes lie farther from it than faces are wide.
    """
    if isinstance(what, Placement):
        out = what
    else:
        shape = PosedShape(what.shape, what.pose) if isinstance(what, RigidBody) else what
        out = Placement(shape, bordering(mesh, name))
    surface = FacetSurface(mesh.points, curved_facets(mesh, name, out), name)
    if len(surface.facets) == 0:
        return out
    gap = np.abs(out.surface.project(mesh.points[surface.nodes]).gap)
    far = gap > FARTHEST * surface.mean_facet_size.max()
    if far.any():
        raise InputError(
            f"geometry of {name!r}: {far.sum()} of its {len(far)} nodes lie up to {gap.max():.3g} from the given "
            f"surface, more than half a face ({surface.mean_facet_size.max():.3g}). Shapes stand as rigid bodies do, "
            "their lowest point at the origin of the mesh; pose them by fc.RigidBody(shape).placed(...).",
            code="geometry-too-far",
        )
    return out


def _rounding(mesh: Mesh) -> float:
    """Shift of its nodes that is rounding."""
    return ROUNDING * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))


def _notes(before: Mesh, after: Mesh, placements: Mapping[str, Placement], drawn: int) -> list[str]:
    """What was done, for the notes of results."""
    out = []
    least = _rounding(before)
    for name, placement in placements.items():
        facets = after.face_nodes(after.faces(name))
        shift = np.linalg.norm(after.points[facets] - before.points[facets], axis=2).max()
        corners = after.points[facets[:, :4]].mean(axis=1)
        height = np.linalg.norm(after.points[facets].mean(axis=1) - corners, axis=1).max()
        if shift > max(UNTOLD * height, least):
            kind = (
                "a smooth surface through them" if isinstance(placement.surface, SmoothSurface) else "the given surface"
            )
            out.append(f"nodes of {name!r} moved by up to {shift:.2g} onto {kind}")
    if drawn:
        out.append(f"{drawn} nodes less far, lest cells fold")
    return [f"{'; '.join(out)} {TURNED_OFF}"] if out else []
