"""Supports and joints of bricks and slender structures: linear conditions on coordinates, eliminated beforehand.

A joint ties positions or gradients of two places; a support fixes them. The
directions that are left free, an orthonormal basis, are all that statics and dynamics move, so that joints are exact
and cost nothing. A place is a node of a slender structure, or any point of a solid of bricks.

A reference node (hub) is a solid of bricks that moves affinely, r = A X + b, by its twelve coordinates: `affine`. Named
in `Assembly(.., rigid=[..])` it is exactly rigid, see `hubs`, else as far as its material is stiff; boundaries of other
solids follow it by `follows`, a moment or a prescribed motion acts on it as on any solid. Source: A. A. Shabana, ANCF
reference node for multibody system analysis, Proc. IMechE K 229 (2015).

Supports: positions and in-face gradients held on named boundaries.

To hold a component on a whole face, hold its nodal values *and* its in-face derivatives; otherwise the face bends
between its nodes. The derivative across the face stays free, as it is a strain (a clamp that holds it too is stiffer
than a built-in end, by 4.6 % for a beam of slenderness ten and nu = 0).

On a face along the axes the held coordinates are entries of q. Elsewhere they are combinations of a node's gradients,
so the basis is rotated: q = q0 + Z y with y free and Z of orthonormal columns.

Rigid hubs: solids that move affinely, r = A X + b, by six conditions rigidly.

The Green-Lagrange strains of a hub vanish,

    c_ij(q) = (F_i . F_j - delta_ij) / 2 = 0,    F_i = dr/dX_i at its first node,

so that A is a rotation. They are quadratic in q, with the constant second derivative B_ij, and their multipliers l_ij
are the stresses of the hub times its volume (ANCF reference node: A. A. Shabana, Proc. IMechE K 229, 2015; constraints
of a rigid body in natural coordinates: J. Garcia de Jalon & E. Bayo, Kinematic and Dynamic Simulation of Multibody
Systems, 1994, chapter 2). Forces C(q)^T l are internal: without resultant, and without moment as l_ij is symmetric.
Between two states c(q1) - c(q0) = C((q0 + q1)/2) (q1 - q0), so that by the derivative in the middle they do no work.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from fecontact.ancf.bricks.space import AncfSpace
from fecontact.ancf.system.member import Member
from fecontact.ancf.system.newton import Ties
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError
from fecontact.fem.support import SAME_DIRECTION, Support, support_directions
from fecontact.mesh.element import FACES
from fecontact.mesh.facets import places_among

#: Share of a direction in the tangents of the faces round a node above which it counts as in the face; facets of a
#: curved boundary may be inclined by about 13 degrees to their mean.
ALONG = 0.05


@dataclass(frozen=True, eq=False)
class Supports:
    """Held coordinates.

    Attributes
    ----------
    basis : (n_dofs, n_dofs) csr_matrix
        Orthonormal columns; the identity except at nodes with oblique supports.
    held : (n_held,) int array
        Columns that are held.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSpace, hold
    >>> space = AncfSpace(fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8"))
    >>> hold(space, {"x_min": "xyz"}).held.size  # four nodes, position and two gradients
    36
    """

    basis: sp.csr_matrix
    held: IntArray

    @cached_property
    def free(self) -> sp.csr_matrix:
        """Matrix Z (n_dofs, n_free): q = q0 + Z y."""
        kept = np.setdiff1d(np.arange(self.basis.shape[1]), self.held, assume_unique=True)
        return self.basis[:, kept].tocsr()

    @cached_property
    def rows(self) -> sp.csr_matrix:
        """Matrix (n_held, n_dofs) of the held components of a change of q."""
        return self.basis[:, self.held].T.tocsr()


def hold(space: AncfSpace, supports: Mapping[str, Support]) -> Supports:
    """Hold named boundaries, such as ``{"base": "xyz", "sym_x": "x", "flank": "n", "seat": (1, 1, 0)}``.

    A node set holds positions only, a boundary holds positions and in-face derivatives.

    Raises
    ------
    InputError
        For unknown names or components, or ``"n"`` on a boundary that is not plane.
    """
    width = int(np.diff(np.append(space.start, space.n_functions)).max()) - 1
    position = np.zeros((len(space.nodes), 3, 3))
    ties = np.zeros((len(space.nodes), width, 3, width, 3))
    for name, support in supports.items():
        point, d = support_directions(space.mesh, name, support)
        here = np.isin(point, space.nodes)
        node, d = np.searchsorted(space.nodes, point[here]), d[here]
        if len(node) == 0:
            raise InputError(f"No point of {name!r} is a corner of a cell, where the nodes of this element are.")
        across = np.einsum("nki,nkj->nij", d, d)
        position[node] += across
        if name in space.mesh.boundaries:
            _refuse_curved(space, name, support)
            owner, rows = _tangent_rows(space, space.mesh.boundaries[name])
            along = _projectors(_outer_sums(space, owner, rows, width)[node])
            ties[node] += np.einsum("nab,nij->naibj", along, across)
    return _separated(space, position, ties)


def _refuse_curved(space: AncfSpace, name: str, support: Support) -> None:
    """Refuse 'n' on a curved boundary: n . u = 0 couples derivatives to positions, which is not supported."""
    if not (isinstance(support, str) and "n" in support):
        return
    faces = space.mesh.boundaries[name]
    x = space.mesh.points[space.mesh.face_nodes(faces)].reshape(-1, 3)
    thickness = np.linalg.svd(x - x.mean(axis=0), compute_uv=False)
    if thickness[2] > 1e-9 * thickness[0]:
        raise InputError(
            f"The boundary {name!r} is not plane, so the brick with gradient coordinates cannot be supported along its "
            "normal 'n'; support it in components or a direction, or use ElasticBody.",
            code="boundary-not-plane",
        )


def _tangent_rows(space: AncfSpace, faces: IntArray) -> tuple[IntArray, sp.csr_matrix]:
    """Nodes (n,) and unit in-face derivatives (n, n_functions), two orthonormal ones at each corner of each face."""
    cell, face = faces.T
    local = FACES[face, :4]
    J = space.nodal_jacobians[cell[:, None], local]
    axes = np.stack([(face // 2 + 1) % 3, (face // 2 + 2) % 3], axis=1)
    tangents = np.take_along_axis(J, axes[:, None, None, :], axis=3)
    t = np.linalg.qr(tangents)[0].swapaxes(2, 3).reshape(-1, 3)
    gradient = space.functions[cell[:, None], 4 * local + 1].ravel().repeat(2)[:, None] + np.arange(3)
    n = int(space.functions.max()) + 1
    rows = sp.csr_matrix((t.ravel(), gradient.ravel(), np.arange(0, t.size + 1, 3)), shape=(len(t), n))
    node = space.corners[cell[:, None], local].ravel().repeat(2)
    return node, rows if space.joining is None else (rows @ space.joining).tocsr()


def _outer_sums(space: AncfSpace, node: IntArray, rows: sp.csr_matrix, width: int) -> Array:
    """Sums (n_nodes, width, width) of the outer products of the rows over each node's gradient functions."""
    coo = rows.tocoo()
    dense = np.zeros((rows.shape[0], width))
    dense[coo.row, coo.col - space.start[node[coo.row]] - 1] = coo.data
    out = np.zeros((len(space.nodes), width, width))
    np.add.at(out, node, dense[:, :, None] * dense[:, None, :])
    return out


def _projectors(normal: Array) -> Array:
    """Projectors (n, k, k) on the eigenvectors above the share `ALONG` of the largest eigenvalue."""
    values, vectors = np.linalg.eigh(normal)
    kept = vectors * (values > ALONG * values[:, -1:])[:, None, :]
    return kept @ kept.swapaxes(1, 2)


def _separated(space: AncfSpace, position: Array, ties: Array) -> Supports:
    """Rotated positions and gradients of every node, such that each coordinate is held or free."""
    n_free = np.diff(np.append(space.start, space.n_functions)) - 1
    turns = [_turned(position, 3 * space.start[:, None] + np.arange(3))]
    for d in np.unique(n_free):
        node = np.flatnonzero(n_free == d)
        dofs = 3 * (space.start[node] + 1)[:, None] + np.arange(3 * d)
        turns.append(_turned(ties[node, :d, :, :d].reshape(-1, 3 * d, 3 * d), dofs))
    turned = np.concatenate([rows for _, rows, _, _ in turns])
    rest = np.setdiff1d(np.arange(space.n_dofs), turned)
    columns = np.concatenate([rest, *(c for _, _, c, _ in turns)])
    values = np.concatenate([np.ones(len(rest)), *(v for _, _, _, v in turns)])
    basis = sp.csr_matrix((values, (np.concatenate([rest, turned]), columns)), shape=(space.n_dofs,) * 2)
    return Supports(basis, np.unique(np.concatenate([held for held, _, _, _ in turns])))


def _turned(sums: Array, dofs: IntArray) -> tuple[IntArray, IntArray, IntArray, Array]:
    """Held coordinates, and rows, columns and values of the rotated axes, of blocks with coordinates `dofs` (n, k).

    The range of every sum (k, k) is to be held. Where it lies along the axes these are kept.
    """
    share = np.einsum("nii->ni", sums).copy()
    oblique = np.abs(sums - share[:, :, None] * np.eye(sums.shape[1])).max(axis=(1, 2)) > 1e-12
    share[oblique], vectors = np.linalg.eigh(sums[oblique])
    rows = np.broadcast_to(dofs[oblique][:, :, None], vectors.shape)
    return dofs[share > SAME_DIRECTION], rows.ravel(), rows.swapaxes(1, 2).ravel(), vectors.ravel()


#: A member's number and a node of it, or a point or points (n, 3) of the initial shape of bricks.
Place = tuple[int, Any]
#: Relative difference of two gradients that is rounding.
EQUAL = 1e-9


@dataclass(frozen=True, eq=False)
class Joints:
    """Conditions on the coordinates of several structures, one after the other.

    Parameters
    ----------
    structures : sequence of AncfSolid, Structure or CorotationalBeam

    Examples
    --------
    >>> from fecontact.ancf.slender import line, straight
    >>> cable = line(straight((0, 0, 0), (1, 0, 0), 2), EA=1.0, EI=1.0)
    >>> joints = Joints([cable])
    >>> joints.free([joints.flat(), joints.clamped((0, 0))]).shape
    (18, 9)

    A hinge of a brick about the middle of an edge of its end, and a hub:

    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSolid, AncfSpace
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    >>> cube = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.0))
    >>> joints = Joints([cube])
    >>> joints.free([joints.pinned((0, (0.0, 0.5, 0.5)))]).shape
    (96, 93)
    >>> joints.free([joints.affine(0)]).shape
    (96, 12)
    """

    structures: Sequence[Member]

    def _rows(self, place: Place, given: Sequence[int] | None, directions: ArrayLike | None = None) -> sp.csr_matrix:
        """Components along directions (k, 3) of some vectors of a node, or of all."""
        k, where = place
        self._check(k)
        member = self.structures[k]
        every = member.place_rows(where)
        vectors = range(len(every)) if given is None else given
        if max(vectors) >= len(every):
            raise InputError(
                f"A node of a {getattr(member, 'name', 'solid')} has a position and {len(every) - 1} gradients; this "
                f"joint needs {max(vectors)}.",
                code="too-few-gradients",
            )
        along = np.eye(3) if directions is None else np.atleast_2d(np.asarray(directions, dtype=float))
        return self._placed(k, sp.kron(sp.vstack([every[v] for v in vectors]), along, format="csr"))

    def _check(self, k: int) -> None:
        if not 0 <= k < len(self.structures):
            raise InputError(f"There are {len(self.structures)} structures, counted from 0; found {k}.", code="unknown")

    def _space(self, k: int) -> AncfSpace:
        self._check(k)
        space: AncfSpace | None = getattr(self.structures[k], "space", None)
        if space is None:
            raise InputError(f"Member {k} has no bricks, which this condition needs.", code="no-bricks")
        return space

    def _placed(self, k: int, rows: sp.csr_matrix) -> sp.csr_matrix:
        """Rows on the coordinates of member k as rows on all."""
        sizes = [s.n_dofs for s in self.structures]
        before = sp.csr_matrix((rows.shape[0], sum(sizes[:k])))
        return sp.hstack([before, rows, sp.csr_matrix((rows.shape[0], sum(sizes[k + 1 :])))], format="csr")

    def clamped(self, place: Place) -> sp.csr_matrix:
        """Position and rotation fixed, and stretches free; of bricks position and all gradients.

        The section of a line or a beam keeps its rotation, six conditions or five (a line does not twist): its axis may
        stretch and shear, and the section strain. All gradients of a plate keep their directions, as the bending of its
        surface is theirs; on an edge that is held, `guided` stops the stretch along it between nodes, too.
        """
        k, where = place
        self._check(k)
        member = self.structures[k]
        along = getattr(member, "n_along", 0)
        if not along:
            return self._rows(place, None)
        axes = (sp.vstack(member.place_rows(where)[1:]) @ member.q0.reshape(-1, 3)).reshape(-1, 3)
        bare = scipy.linalg.null_space(axes).T  # directions without a gradient of their own
        rows = [self.pinned(place), *(self.guided(place, g + 1, bare) for g in range(len(axes)) if len(bare))]
        if along == 1:
            rows += [self.guided(place, g + 1, axes[0]) for g in range(1, len(axes))]
            rows += [self.guided(place, 2, axes[2]) - self.guided(place, 3, axes[1])] if len(axes) == 3 else []
        else:
            rows += [self.guided(place, g + 1, axes[d]) for g, d in permutations(range(len(axes)), 2)]
        return sp.vstack(rows, format="csr")

    def pinned(self, place: Place, directions: ArrayLike | None = None) -> sp.csr_matrix:
        """Position fixed, or along some directions (k, 3) only: a slot or roller."""
        return self._rows(place, [0], directions)

    def guided(self, place: Place, gradient: int, directions: ArrayLike | None = None) -> sp.csr_matrix:
        """A gradient (1, 2 or 3) fixed, or along some directions only, as by symmetry."""
        return self._rows(place, [gradient], directions)

    def flat(self) -> sp.csr_matrix:
        """All vectors of all nodes kept in the plane x, y."""
        n_dofs = sum(s.n_dofs for s in self.structures)
        columns = np.arange(2, n_dofs, 3)
        return sp.csr_matrix((np.ones(len(columns)), (np.arange(len(columns)), columns)), shape=(len(columns), n_dofs))

    def held(self, k: int, supports: Mapping[str, Support]) -> sp.csr_matrix:
        """Boundaries of a solid of bricks held as by `hold`, such as {"base": "xyz"}."""
        return self._placed(k, hold(self._space(k), supports).rows)

    def affine(self, k: int) -> sp.csr_matrix:
        """A solid of bricks that moves by r = A X + b only: a hub of twelve coordinates."""
        return self._placed(k, sp.csr_matrix(scipy.linalg.null_space(affine_modes(self._space(k)).T).T))

    def follows(self, k: int, boundary: str, hub: int) -> sp.csr_matrix:
        """A boundary of a solid of bricks that moves with a hub: its positions and in-face gradients, as in a clamp.

        The hub needs the condition `affine`, and may lie anywhere.
        """
        space, centre = self._space(k), self._space(hub)
        if k == hub:
            raise InputError(f"Solid {k} cannot follow itself; give the number of the hub.", code="follows-itself")
        # A and b from the hub's first node: r = r_0 + F_0 (X - X_0)
        first = int(centre.start[0])
        at = centre.q0.reshape(-1, 3)[first]
        pick = sp.csr_matrix((np.ones(12), (np.arange(12), 3 * first + np.arange(12))), shape=(12, centre.n_dofs))
        rows = hold(space, {boundary: "xyz"}).rows
        moved = sp.csr_matrix(rows @ _affine(space, at))
        return sp.csr_matrix(self._placed(k, rows) - self._placed(hub, sp.csr_matrix(moved @ pick)))

    def spherical(self, one: Place, other: Place) -> sp.csr_matrix:
        """Positions tied, which coincide or are joined by an arm of the first; in a plane a pin joint."""
        return self._tied(one, other, np.zeros((0, 3)))

    def slot(self, one: Place, other: Place, along: ArrayLike) -> sp.csr_matrix:
        """Positions tied across a fixed direction (3,)."""
        across = scipy.linalg.null_space(np.atleast_2d(np.asarray(along, dtype=float))).T
        return sp.csr_matrix(self._rows(one, [0], across) - self._rows(other, [0], across))

    def revolute(self, one: Place, other: Place, gradient: int) -> sp.csr_matrix:
        """Positions tied, and the material line along the axis of the hinge: a gradient (1, 2 or 3) at the first place.

        Raises
        ------
        InputError
            If the gradients at the other place do not span it, or the places lie apart.
        """
        axes = self._initial(one)
        if not 1 <= gradient <= len(axes):
            self._rows(one, [gradient])
        return self._tied(one, other, axes[[gradient - 1]])

    def rigid(self, one: Place, other: Place) -> sp.csr_matrix:
        """Positions and deformation gradients tied, so that members that meet at any angle turn and strain together.

        F d is a constant combination of a node's gradients, found in the initial shape, for each direction d that both
        have: a slope discontinuity. A strip or a beam on bricks, as on a hub, is tied by its section alone: its axis
        may stretch and shear. Two lines at an angle in the plane x, y are held in this plane, and stretch alike at the
        joint. Places of members with three gradients may lie apart.
        Source: A. A. Shabana & A. M. Mikkola, J. Mech. Des. 125 (2003), 342-350; Shabana, Computational Continuum
        Mechanics, 5.2.

        Raises
        ------
        InputError
            If their gradients share too few directions, as of plates that are folded or cables in space: a rigid
            motion of both would violate the tie.

        Examples
        --------
        A frame of two beams that meet at a right angle:

        >>> import fecontact as fc
        >>> from fecontact.ancf.slender import beam, straight
        >>> steel = fc.Material(E=210e3, nu=0.3)
        >>> legs = straight((0, 0, 0), (0, 0, 9), 2), straight((0, 0, 9), (9, 0, 9), 2)
        >>> joints = Joints([beam(p, steel, width=1.0, height=1.0, up=(0, 1, 0)) for p in legs])
        >>> joints.rigid((0, -1), (1, 0)).shape
        (12, 72)
        """
        bricks = [not self.structures[k].is_slender for k, _ in (one, other)]
        thin, wide = sorted((one, other), key=lambda place: len(self._initial(place)))
        if bricks[0] != bricks[1]:
            thin, wide = (one, other) if bricks[1] else (other, one)
        axes, others = self._initial(thin), self._initial(wide)
        along = [getattr(self.structures[k], "n_along", 0) for k, _ in (thin, wide)]
        if any(bricks) and along[0] == 1 and len(axes) > 1:
            axes = axes[1:]
        elif along == [1, 1] and not (
            axes[:, 2].any()
            or others[:, 2].any()
            or (len(axes) == len(others) and np.allclose(axes, others, rtol=0, atol=EQUAL))
        ):
            return self._corner(thin, wide)
        return self._tied(wide, thin, axes)

    def _initial(self, place: Place) -> Array:
        """Initial gradients (n, 3) at a place, at the first of several points."""
        k, where = place
        self._check(k)
        q0 = self.structures[k].q0.reshape(-1, 3)
        return np.array([(rows[[0]] @ q0)[0] for rows in self.structures[k].place_rows(where)[1:]])

    def _carried(self, place: Place, directions: Array) -> sp.csr_matrix:
        """F d of material directions d (n, 3) at a place, F the deformation gradient there.

        Raises
        ------
        InputError
            If its gradients do not span them.
        """
        every = self.structures[place[0]].place_rows(place[1])
        axes = self._initial(place)
        if not len(directions):
            return sp.csr_matrix((0, sum(s.n_dofs for s in self.structures)))
        share = np.linalg.lstsq(axes.T, directions.T, rcond=EQUAL)[0]
        if np.abs(axes.T @ share - directions.T).max() > EQUAL * np.abs(directions).max():
            raise InputError(
                f"The gradients at {place} do not carry all directions of the other member there, or its distance: a "
                "tie would stop both from turning together. Tie positions that coincide (`spherical`), take members "
                "with three gradients (`beam`, `thick_plate`), or tie both to a hub of bricks.",
                code="members-at-an-angle",
            )
        rows = [
            sum((c * rows for c, rows in zip(column, every[1:], strict=True) if c), 0 * every[0]) for column in share.T
        ]
        return self._placed(place[0], sp.kron(sp.vstack(rows), np.eye(3), format="csr"))

    def _tied(self, one: Place, other: Place, directions: Array) -> sp.csr_matrix:
        """Positions of two places, and what both carry along material directions (n, 3); the first carries the arm."""
        q0 = np.concatenate([s.q0 for s in self.structures])
        positions = sp.csr_matrix(self._rows(one, [0]) - self._rows(other, [0]))
        apart = (positions @ q0).reshape(-1, 3)
        if np.abs(apart).max() > EQUAL * np.abs(q0).max():
            positions = sp.csr_matrix(positions - self._carried(one, apart[:1]))
        return sp.vstack([positions, self._carried(one, directions) - self._carried(other, directions)], format="csr")

    def _corner(self, one: Place, other: Place) -> sp.csr_matrix:
        """Lines and strips in the plane x, y: tangent or section of the second is that of the first, turned."""
        (k, a), (m, b) = ((len(axes), axes[-1]) for axes in map(self._initial, (one, other)))
        turn = np.array([[a @ b, a[1] * b[0] - a[0] * b[1]], [a[0] * b[1] - a[1] * b[0], a @ b]]) / (a @ a)
        flat, up = np.eye(3)[:2], np.eye(3)[2]
        tied = [
            self._rows(one, [0]) - self._rows(other, [0]),
            self._rows(other, [m], flat) - self._rows(one, [k], turn @ flat),
            self._rows(one, [k], up),
            self._rows(other, [m], up),
        ]
        return sp.vstack(tied, format="csr")

    def motion(self, conditions: Sequence[sp.csr_matrix], changes: Sequence[ArrayLike | None]) -> Array:
        """Smallest change (n_dofs,) of the coordinates that changes every condition as given; None keeps one.

        For `Stage(.., motion=..)`: the present value of a condition C is C (q - q0), in the order in which it was made.

        Raises
        ------
        InputError
            If the changes do not fit the conditions, or contradict each other.

        Examples
        --------
        >>> from fecontact.ancf.slender import line, straight
        >>> joints = Joints([line(straight((0, 0, 0), (1, 0, 0), 1), EA=1.0, EI=1.0)])
        >>> joints.motion([joints.clamped((0, 0)), joints.pinned((0, 1))], [None, (0.1, 0.0, 0.0)])[6:9].tolist()
        [0.1, 0.0, 0.0]
        """
        given = [np.zeros(C.shape[0]) if d is None else np.ravel(d) for C, d in zip(conditions, changes, strict=True)]
        if any(len(d) != C.shape[0] for C, d in zip(conditions, given, strict=True)):
            raise InputError(
                f"The conditions have {[C.shape[0] for C in conditions]} components and the changes "
                f"{[len(d) for d in given]}; give as many to each, or None.",
                code="change-shape",
            )
        rows, values = sp.vstack(conditions, format="csr"), np.concatenate(given).astype(float)
        touched = np.unique(rows.indices)
        C, out = rows[:, touched].toarray(), np.zeros(rows.shape[1])
        out[touched] = np.linalg.lstsq(C, values, rcond=1e-10)[0]
        if np.abs(rows @ out - values).max(initial=0.0) > 1e-9 * np.abs(values).max(initial=0.0):
            raise InputError("The changes contradict each other: two conditions hold the same coordinates.")
        return out

    def free(self, conditions: Sequence[sp.csr_matrix]) -> sp.csr_matrix:
        """Orthonormal directions (n_dofs, n_free) that fulfil all conditions."""
        return free_directions(conditions, sum(s.n_dofs for s in self.structures))


def free_directions(conditions: Sequence[sp.csr_matrix], n: int) -> sp.csr_matrix:
    """Orthonormal directions (n, n_free) that fulfil all conditions, rows (k, n).

    Single coordinates are eliminated as they are, others by the null spaces of rows that have some in common, of all
    parts of one shape at once.
    """
    rows = sp.vstack([sp.csr_matrix((0, n)), *conditions], format="csr")
    rows.eliminate_zeros()
    single = np.diff(rows.indptr) == 1
    loose = np.setdiff1d(np.arange(n), rows[np.flatnonzero(single)].indices)
    rest = rows[np.flatnonzero(~single)][:, loose]
    touched = np.unique(rest.indices)
    rest = rest[np.flatnonzero(np.diff(rest.indptr))][:, touched]
    count, label = connected_components(abs(rest.T) @ abs(rest), directed=False) if len(touched) else (0, touched)
    of_row = label[rest.indices[rest.indptr[:-1]]]
    (heights, _, line), (widths, members, column) = (_sorted_by(x, count) for x in (of_row, label))
    entries, starts = rest.tocoo(), np.cumsum(widths) - widths
    owner, at, values = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0)]
    for h, w in np.unique(np.stack([heights, widths], axis=1), axis=0):
        parts = np.flatnonzero((heights == h) & (widths == w))
        place = places_among(parts, count)[label[entries.col]]
        mine = place >= 0
        blocks = np.zeros((len(parts), h, w))
        blocks[place[mine], line[entries.row[mine]], column[entries.col[mine]]] = entries.data[mine]
        _, singular, V = np.linalg.svd(blocks)
        # rows may depend on each other
        part, k = np.nonzero(np.arange(w) >= (singular > 1e-10 * singular[:, :1]).sum(axis=1)[:, None])
        owner.append(parts[part])
        at.append(loose[touched[members[starts[parts[part], None] + np.arange(w)]]].ravel())
        values.append(V[part, k].ravel())
    alone, owners = np.setdiff1d(loose, loose[touched]), np.concatenate(owner)
    # directions of one part beside each other
    number = np.empty(len(owners), dtype=np.int64)
    number[np.argsort(owners, kind="stable")] = len(alone) + np.arange(len(owners))
    columns = np.concatenate([np.arange(len(alone)), np.repeat(number, widths[owners])])
    found = np.concatenate([np.ones(len(alone)), *values]), (np.concatenate([alone, *at]), columns)
    Z = sp.csr_matrix(found, shape=(n, len(alone) + len(owners)))
    Z.eliminate_zeros()
    return Z


def _sorted_by(label: IntArray, count: int) -> tuple[IntArray, IntArray, IntArray]:
    """Sizes (count,) of labels, members (n,) label by label, and the place (n,) of each in its label."""
    sizes, order = np.bincount(label, minlength=count), np.argsort(label, kind="stable")
    place = np.empty(len(label), dtype=np.int64)
    place[order] = np.arange(len(label)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return sizes, order, place


def affine_modes(space: AncfSpace) -> Array:
    """Orthonormal changes (n_dofs, 12) of the coordinates by r = A X + b."""
    return np.asarray(scipy.linalg.orth(_affine(space)))


def _affine(space: AncfSpace, about: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Changes (n_dofs, 12) of the coordinates by unit b, and by unit columns of A about a point (3,)."""
    origin, out = np.asarray(about, dtype=float), [space.affine(np.zeros((3, 3)), e) for e in np.eye(3)]
    for column in range(3):
        for e in np.eye(3):
            A = np.outer(e, np.eye(3)[column])
            out.append(space.affine(A, -A @ origin))
    return np.stack(out, axis=1)


#: The strains i <= j, and the factor of their work.
_I, _J = np.array([0, 1, 2, 0, 1, 0]), np.array([0, 1, 2, 1, 2, 2])


@dataclass(frozen=True, eq=False)
class Hubs:
    """Conditions of several rigid hubs.

    Parameters
    ----------
    gradients : (n_hubs, 3, 3) int array
        Coordinates of the three gradients at the first node of each: gradient, component.
    n_dofs : int
        Coordinates of all solids.

    Examples
    --------
    >>> hub = Hubs(np.arange(9).reshape(1, 3, 3), 9)
    >>> hub.strains(np.diag([1.1, 1.0, 1.0]).ravel()).round(12).tolist()
    [0.105, 0.0, 0.0, 0.0, 0.0, 0.0]
    """

    gradients: IntArray
    n_dofs: int

    def strains(self, q: Array) -> Array:
        """The conditions c (6 n_hubs,) at coordinates q (n_dofs,)."""
        F = q[self.gradients]
        return np.asarray((((F[:, _I] * F[:, _J]).sum(axis=2) - (_I == _J)) / 2).ravel())

    def derivative(self, q: Array) -> sp.csr_matrix:
        """C (6 n_hubs, n_dofs)."""
        places, F = self.gradients, q[self.gradients]
        data = np.concatenate([F[:, _J], F[:, _I]], axis=2) / 2
        columns = np.concatenate([places[:, _I], places[:, _J]], axis=2)
        rows = np.broadcast_to(np.arange(6 * len(F)).reshape(-1, 6, 1), data.shape)
        return sp.csr_matrix((data.ravel(), (rows.ravel(), columns.ravel())), shape=(6 * len(F), self.n_dofs))

    def curvature(self, multipliers: Array) -> sp.csr_matrix:
        """Second derivative (n_dofs, n_dofs) of multipliers . c."""
        one, other = self.gradients[:, _I], self.gradients[:, _J]
        data = np.repeat(multipliers / 2, 3)
        rows, columns = one.ravel(), other.ravel()
        both = np.concatenate([rows, columns]), np.concatenate([columns, rows])
        return sp.csr_matrix((np.tile(data, 2), both), shape=(self.n_dofs, self.n_dofs))

    def quadratic_velocity(self, v: Array) -> Array:
        """C'' of velocities v (n_dofs,): what C a lacks of the second derivative of c by time."""
        V = v[self.gradients]
        return np.asarray((V[:, _I] * V[:, _J]).sum(axis=2).ravel())

    def subtracted(
        self, K: sp.csr_matrix, q: Array, multipliers: Array, share: float = 1.0
    ) -> tuple[sp.csr_matrix, float]:
        """What is subtracted from a tangent K, and the weight w of the equations in it.

        A share of the second derivative of multipliers . c, and -w C^T C, which makes the tangent positive definite
        where its rigid motions are resisted (augmented Lagrangian): under equations it shifts the multipliers only,
        those of K are w c more.
        """
        C = self.derivative(q)
        weight = float(K.diagonal()[self.gradients].max() + 10 * np.abs(multipliers).max())
        return sp.csr_matrix(share * self.curvature(multipliers) - weight * (C.T @ C)), weight

    def ties(self, q: Array, middle: Array | None = None) -> Ties:
        """What a Newton step needs at coordinates q; forces act along the derivative in the middle of a step."""
        C = self.derivative(q)
        return Ties(C, C if middle is None else self.derivative(middle), self.strains(q))
