"""Sectors of cyclic symmetry: one side moves as the other side does, turned by the angle of a sector.

Of N sectors about an axis a node p of the dependent side lies where a point of the other side comes by the turn R of
2 pi / N. With that side's functions w at the point, R^-1 u_p = sum w_j u_j for a state that all sectors share (nodal
diameter zero): conditions u_p - sum w_j R u_j = 0. On the axis both sides are one, u_p = R u_p.

Source: Dhondt, CalculiX CrunchiX User's Manual, *CYCLIC SYMMETRY MODEL; D. L. Thomas, Dynamics of rotationally periodic
structures, Int. J. Numer. Meth. Eng. 14 (1979) 81.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, not_done
from fecontact.mesh.formats.abaqus_deck import KeywordSection, values_of
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface

#: Distance from the axis, relative to the size of the mesh, that is on it.
ON_AXIS = 1e-9
#: Distance from the turned side, relative to the size of its facets, up to which nodes follow by default.
NEAR = 0.05


@dataclass(frozen=True, eq=False)
class Sector:
    """Two sides of a sector, the dependent one first, the number of sectors, and two points of the axis."""

    slave: str
    master: str
    count: int
    axis: Array
    place: str
    reach: float | None = None


def sectors_of(model: Sequence[KeywordSection]) -> list[tuple[KeywordSection, str, KeywordSection]]:
    """Cyclic ties with a data line of each, and the *CYCLIC SYMMETRY MODEL that they belong to.

    Raises
    ------
    InputError
        If a tie has none, or is of another kind.
    """
    models = [s for s in model if s.keyword == "CYCLIC SYMMETRY MODEL"]
    ties = [s for s in model if s.keyword == "TIE" and "CYCLIC SYMMETRY" in s.parameters]
    out = []
    for tie in ties:
        name = tie.parameters.get("NAME", "").upper()
        own = [s for s in models if s.parameters.get("TIE", name).upper() == name]
        if len(own) != 1:
            raise InputError(
                f"{tie.place}: *TIE, CYCLIC SYMMETRY needs one *CYCLIC SYMMETRY MODEL of its name {name!r}; found "
                f"{len(own)}.",
                code="cyclic-symmetry",
            )
        if "CONTACT" in own[0].parameters:
            raise not_done(
                f"{own[0].place}: contact between the sides of a sector (*CYCLIC SYMMETRY MODEL, CONTACT) is not done "
                "here."
            )
        out += [(tie, line, own[0]) for line in tie.lines]
    return out


def sector(tie: KeywordSection, names: tuple[str, str], model: KeywordSection) -> Sector:
    """A sector of its keywords.

    Raises
    ------
    InputError
        Without a number of sectors or an axis.
    """
    count, axis = model.parameters.get("N", ""), np.array(values_of(model.lines[0] if model.lines else ""))
    if not count.isdigit() or int(count) < 2 or len(axis) < 6 or np.array_equal(axis[:3], axis[3:6]):
        raise InputError(
            f"{model.place}: *CYCLIC SYMMETRY MODEL needs N of 2 or more and two points of its axis; found {count!r}, "
            f"{model.lines[:1]}.",
            code="cyclic-symmetry",
        )
    reach = tie.parameters.get("POSITION TOLERANCE")
    return Sector(*names, int(count), axis[:6].reshape(2, 3), tie.place, None if reach is None else values_of(reach)[0])


def sector_conditions(mesh: Mesh, given: Sector, n: int) -> sp.csr_matrix:
    """Conditions (m, n) between the displacements of the points of a mesh, the first 3 n_points of n.

    Raises
    ------
    InputError
        If a node has nothing to follow.
    """
    slave = mesh.boundary_nodes(given.slave)
    surface = FacetSurface(mesh.points, mesh.face_nodes(mesh.faces(given.master)))
    start, along = given.axis[0], given.axis[1] - given.axis[0]
    along /= np.linalg.norm(along)
    x = mesh.points[slave] - start
    size = float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    central = np.linalg.norm(np.cross(x, along), axis=1) <= ON_AXIS * size
    slave, centre, x = slave[~central], slave[central], x[~central]
    turns = [Rotation.from_rotvec(sign * 2 * np.pi / given.count * along).as_matrix() for sign in (1, -1)]
    found = [surface.project(x @ R + start) for R in turns]
    away = [np.linalg.norm(f.points - (x @ R + start), axis=1) for f, R in zip(found, turns, strict=True)]
    k = int(np.argmin([d.max(initial=0.0) for d in away]))
    R, weights = turns[k], found[k].weights
    assert weights is not None
    corners = mesh.points[surface.facets[:, :4]]
    reach = given.reach or NEAR * float(np.linalg.norm(np.ptp(corners, axis=1), axis=1).mean())
    if (loose := away[k] > reach).any():
        raise InputError(
            f"{given.place}: {loose.sum()} of {len(slave)} nodes of {given.slave!r} lie up to {away[k].max():.3g} from "
            f"{given.master!r} turned by 360/{given.count} degrees, beyond the tie's reach of {reach:.3g}.",
            code="tie-apart",
        )
    own = sp.csr_matrix((np.ones(len(slave)), (np.arange(len(slave)), slave)), shape=weights.shape)
    shape = (len(centre), len(mesh.points))
    still = sp.csr_matrix((np.ones(len(centre)), (np.arange(len(centre)), centre)), shape=shape)
    even = sp.diags(1 / np.asarray(weights.sum(axis=1)).ravel()) @ weights
    rows = sp.vstack([sp.kron(own, np.eye(3)) - sp.kron(even, R), sp.kron(still, np.eye(3) - R)], format="csr")
    rows.resize(rows.shape[0], n)
    return rows[np.flatnonzero(abs(rows).max(axis=1).toarray().ravel() > 0)]
