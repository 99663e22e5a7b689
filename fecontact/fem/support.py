"""Supports: held coordinates, and artificial supports against the remaining null space.

The coordinates are those of `fem.coordinates`: of nodes that do not hang, in rotated axes where a support is oblique.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import array_of
from fecontact.common.errors import InputError, shown
from fecontact.fem.coordinates import Coordinates
from fecontact.fem.links import Links
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.mesh.surface_mesh import averaged_normals

#: Components such as ``"xyz"`` or ``"n"`` (the face's normal), a direction, or several directions.
Support = str | Sequence[float] | Sequence[Sequence[float]]

#: Two directions count as one if they differ by less than 2 milliradians: ratio of the eigenvalues of the sum of d d^T.
SAME_DIRECTION = 1e-6
#: Thickness of a boundary, relative to the mesh's size, up to which it counts as plane.
PLANE = 1e-6
#: Largest angle (degrees) between the normals of the faces round a node up to which they share one normal.
MAX_ANGLE = 45.0


def checked_support(name: str, support: Support) -> str | Array:
    """Component strings unchanged, directions as unit vectors (k, 3).

    Raises
    ------
    InputError
        If it is neither.
    """
    if isinstance(support, str):
        if support and not set(support) - set("xyzn"):
            return support
    else:
        found = array_of(support)
        directions = np.zeros((0, 3)) if found is None else np.atleast_2d(found)
        if directions.ndim == 2 and directions.shape[1] == 3 and len(directions) and np.isfinite(directions).all():
            length = np.linalg.norm(directions, axis=1, keepdims=True)
            if (length > 0).all():
                return np.asarray(directions / length, dtype=np.float64)
    raise InputError(
        f"The support of {name!r} must name components out of 'x', 'y', 'z' and 'n' (the face's normal), such as 'xyz' "
        f"or 'n', or give a direction (1, 1, 0) or several; found {shown(support)}.",
        code="support-components",
    )


def is_plane(support: Support) -> bool:
    """Whether a support holds one component only, as on a plane of symmetry."""
    return len(support) == 1 or (not isinstance(support, str) and np.ndim(support) == 1)


def support_directions(mesh: Mesh | SectionMesh, name: str, support: Support) -> tuple[IntArray, Array]:
    """Nodes (n,) of a support and the unit directions (n, k, 3) held there.

    Raises
    ------
    InputError
        If the boundary or a component is unknown, or there is no normal where one is asked for.
    """
    given, nodes = checked_support(name, support), mesh.boundary_nodes(name)
    if not isinstance(given, str):
        return nodes, np.broadcast_to(given, (len(nodes), *given.shape))
    parts = [np.broadcast_to(np.eye(3)["xyz".index(c)], (len(nodes), 3)) for c in given if c != "n"]
    if "n" in given:
        assert isinstance(mesh, Mesh)
        parts.append(_normals(mesh, name)[nodes])
    return nodes, np.stack(parts, axis=1)


def _normals(mesh: Mesh, name: str) -> Array:
    """Unit normals (n_points, 3) of a smooth boundary."""
    if name in mesh.node_sets and name not in mesh.boundaries:
        raise InputError(
            f"{name!r} is a set of nodes and has no normal; support it with 'n' as a boundary, or give the direction.",
            code="no-normal",
        )
    normals, cosine = averaged_normals(mesh.points, mesh.face_nodes(mesh.faces(name)))
    worst = int(np.argmin(cosine))
    if cosine[worst] < np.cos(np.radians(MAX_ANGLE / 2)):
        raise InputError(
            f"The boundary {name!r} has an edge at {np.array2string(mesh.points[worst], precision=4)}, so it has no "
            "normal there to support it along; name the faces on either side separately.",
            code="no-normal",
        )
    return normals


def symmetry_planes(mesh: Mesh | SectionMesh, supports: Mapping[str, Support]) -> tuple[IntArray, Array]:
    """Nodes (n,) on planes of symmetry and the planes' unit normals (n, 3): boundaries held along it.

    Only plane boundaries count. A node on two such planes is listed twice.
    """
    found = [(np.zeros(0, np.int64), np.zeros((0, 3))), *_plane_boundaries(mesh, supports)]
    nodes, across = zip(*found, strict=True)
    return np.concatenate(nodes), np.concatenate(across)


def mirrors(mesh: Mesh, supports: Mapping[str, Support]) -> Array:
    """Planes of symmetry (k, 4) as unit normals n and heights n . x, each of them once.

    Examples
    --------
    >>> from fecontact.mesh.shapes import block
    >>> mirrors(block((1.0, 1.0, 1.0), (1, 1, 1)), {"x_min": "x", "y_max": "y", "bottom": "xyz"}).tolist()
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 1.0]]
    """
    out = np.zeros((0, 4))
    for on, across in _plane_boundaries(mesh, supports):
        n, middle = across[0], mesh.points[on].mean(axis=0)
        off = np.abs(out[:, :3] @ middle - out[:, 3]) > PLANE * np.ptp(mesh.points, axis=0).max()
        if (off | (np.abs(out[:, :3] @ n) < 1 - PLANE)).all():
            out = np.concatenate([out, [[*n, n @ middle]]])
    return out


def _plane_boundaries(mesh: Mesh | SectionMesh, supports: Mapping[str, Support]) -> Iterator[tuple[IntArray, Array]]:
    """Nodes (n,) and unit normals (n, 3) of each plane boundary that is held along its normal."""
    for name, support in supports.items():
        if is_plane(support):
            on, directions = support_directions(mesh, name, support)
            height = np.einsum("ni,ni->n", mesh.points[on], directions[:, 0])
            if np.ptp(height) <= PLANE * np.ptp(mesh.points, axis=0).max():
                yield on, directions[:, 0]


def held_directions(mesh: Mesh, supports: Mapping[str, Support]) -> Array:
    """Sums (n_points, 3, 3) of d d^T over the unit directions d that supports hold; their range is the held space."""
    total = np.zeros((len(mesh.points), 3, 3))
    for name, support in supports.items():
        nodes, d = support_directions(mesh, name, support)
        total[nodes] += np.einsum("nki,nkj->nij", d, d)
    return total


def nodal_coordinates(mesh: Mesh, supports: Mapping[str, Support]) -> tuple[Coordinates, IntArray]:
    """Coordinates of a mesh, and those that its supports hold: ``{"base": "xyz", "flank": "n", ...}``.

    Nodes that are held along the mesh's axes only keep those. At the others the axes are the eigenvectors of the sum of
    d d^T, the held ones first.

    Raises
    ------
    InputError
        As in `support_directions`; if a support holds a hanging node but not all those that it follows.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    >>> nodal_coordinates(mesh, {"bottom": "z"})[1].tolist()
    [2, 8, 14, 20]
    >>> coordinates, held = nodal_coordinates(mesh, {"bottom": (1, 0, 1)})
    >>> len(held), coordinates.axes.shape
    (4, (24, 24))
    """
    check_followed(mesh, supports)
    total = held_directions(mesh, supports)
    ties = mesh.hanging
    if ties is not None:
        total = total[ties.free]
    diagonal = np.einsum("nii->ni", total)
    held = diagonal > 0
    oblique = np.flatnonzero((np.abs(total).sum(axis=2) > diagonal).any(axis=1))
    if len(oblique) == 0:
        return Coordinates(ties=ties), np.flatnonzero(held)
    values, vectors = np.linalg.eigh(total[oblique])
    held[oblique] = (values > SAME_DIRECTION * values[:, 2:])[:, ::-1]
    axes = np.tile(np.eye(3), (len(total), 1, 1))
    axes[oblique] = vectors[:, :, ::-1]
    number = np.arange(len(total))
    shape = (3 * len(number), 3 * len(number))
    turned = sp.bsr_matrix((axes, number, np.arange(len(number) + 1)), shape=shape).tocsr()
    return Coordinates(turned, ties), np.flatnonzero(held)


def linked(
    coordinates: Coordinates, held: IntArray, conditions: sp.csr_matrix | None, n_dofs: int
) -> tuple[Coordinates, IntArray]:
    """The coordinates and the held ones, with linear conditions (m, n_dofs) between displacements."""
    if conditions is None:
        return coordinates, held
    n = coordinates.count(n_dofs)
    mask = np.zeros(n, bool)
    mask[held] = True
    links = Links.of(sp.csr_matrix(coordinates.rows(conditions)), mask)
    return replace(coordinates, links=links), np.union1d(held, links.dependents)


#: Difference of prescribed displacements, relative to the largest, that is rounding.
AGREE = 1e-9


def prescribed_displacements(
    mesh: Mesh | SectionMesh, supports: Mapping[str, Support], given: Mapping[str, Array]
) -> Array:
    """Displacements (n_points, 3) at supports by those of each, (n_nodes, 3): of the least size along what is held.

    Raises
    ------
    InputError
        If one has a component that its support does not hold, or two supports of a node do not agree.
    """
    total, along = np.zeros((len(mesh.points), 3, 3)), np.zeros((len(mesh.points), 3))
    each = [(name, *support_directions(mesh, name, support)) for name, support in supports.items()]
    most = max((float(np.abs(values).max(initial=0.0)) for values in given.values()), default=0.0)
    for name, nodes, d in each:
        values = given.get(name, np.zeros((len(nodes), 3)))
        own = np.einsum("nki,nkj->nij", d, d)
        inside = np.einsum("nij,njk,nk->ni", own, np.linalg.pinv(own, rcond=SAME_DIRECTION, hermitian=True), values)
        if (np.abs(values - inside) > AGREE * most).any():
            k = int(np.argmax(np.abs(values - inside).max(axis=1)))
            raise InputError(
                f"The displacement {values[k]} of the support of {name!r} has a component that it does not hold; it "
                f"holds {shown(supports[name])}.",
                code="not-held",
            )
        total[nodes] += own
        along[nodes] += np.einsum("nij,nj->ni", own, values)
    out = np.einsum("nij,nj->ni", np.linalg.pinv(total, rcond=SAME_DIRECTION, hermitian=True), along)
    for name, nodes, d in each:
        values = given.get(name, np.zeros((len(nodes), 3)))
        off = np.abs(np.einsum("nki,ni->nk", d, out[nodes] - values)).max(axis=1, initial=0.0)
        if (off > AGREE * most).any():
            k = int(off.argmax())
            raise InputError(
                f"Two supports of the node at {np.array2string(mesh.points[nodes[k]], precision=4)} prescribe "
                f"different displacements; one of them is {name!r}.",
                code="supports-disagree",
            )
    return out


def check_followed(mesh: Mesh | SectionMesh, supports: Mapping[str, Support]) -> None:
    """Refuse supports that hold a hanging node but not all those that it follows.

    Raises
    ------
    InputError
    """
    if mesh.hanging is None:
        return
    for name in supports:
        outside = np.ones(len(mesh.points))
        outside[mesh.boundary_nodes(name)] = 0.0
        loose = (outside[mesh.hanging.nodes] == 0) & (abs(mesh.hanging.weights) @ outside > 0)
        if loose.any():
            where = np.array2string(mesh.points[mesh.hanging.nodes[np.argmax(loose)]], precision=4)
            raise InputError(
                f"The support of {name!r} holds {loose.sum()} hanging nodes that follow from nodes it does not hold, "
                f"the first at {where}. Name whole faces of the undivided cells there too, or divide these cells.",
                code="hanging-support",
            )


def share_of_support(mesh: Mesh, supports: Mapping[str, Support], name: str, rest: Array) -> Array:
    """Contribution (n_dofs,) of one support to the total nodal support forces `rest` (n_dofs,).

    Where several hold one direction, each takes an equal share; generally c_d = d^T (sum of d d^T)^+ rest is the
    least-norm set of forces along the directions d with that sum.
    """
    nodes, d = support_directions(mesh, name, supports[name])
    inverse = np.linalg.pinv(held_directions(mesh, supports)[nodes], rcond=SAME_DIRECTION, hermitian=True)
    along = np.einsum("nki,nij,nj->nk", d, inverse, rest.reshape(-1, 3)[nodes])
    out = np.zeros((len(mesh.points), 3))
    out[nodes] = np.einsum("nk,nki->ni", along, d)
    return out.ravel()


def fix_null_space(modes: Array, held: IntArray, length: float) -> IntArray:
    """Degrees of freedom, one for each free motion, to hold a body artificially.

    Loads in equilibrium cause no reactions there (Elangovan 1978, section IV.3), so the choice affects conditioning
    only: pivoted QR picks the rows of the modes that span the largest volume.

    Parameters
    ----------
    modes : (3 n, k) array
        Displacement fields of the free motions.
    held : int array
        Degrees of freedom that supports hold already.
    length : float
        Size of the body, to scale rotations.
    """
    if modes.shape[1] == 0:
        return np.zeros(0, dtype=np.int64)
    candidates = np.setdiff1d(np.arange(len(modes)), held)
    scaled = modes[candidates] / np.linalg.norm(modes, axis=0)
    _, _, pivots = scipy.linalg.qr(scaled.T, mode="economic", pivoting=True)
    return np.sort(candidates[pivots[: modes.shape[1]]])
