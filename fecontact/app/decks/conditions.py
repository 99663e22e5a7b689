"""Linear conditions of Abaqus and CalculiX decks: *EQUATION, *MPC, *COUPLING, *RIGID BODY, and nodes without elements.

Displacements x of all nodes are those of the mesh's points, of nodes that only conditions use (reference nodes), and
rotations of the latter, three components each. Conditions G x = 0 are linear; those of rigid parts and of *MPC are
linearised at the initial shape. Of a coupled node p at r from its reference node,

    kinematic, rigid     u_p = u_R + theta_R x r
    distributing         u_R = sum w_p u_p + theta_R x (x_R - x_C),  theta_R = T^-1 sum w_p r_p x u_p,
                         with r_p from the centre x_C = sum w_p x_p, T = sum w_p (r_p^2 - r_p r_p^T), and the
                         weights w_p by which an even pressure is spread over the nodes of the surface (as found in
                         results of CalculiX 2.20, whatever components *DISTRIBUTING names); x_C = x_R of a
                         sector (CYCLIC SYMMETRY),

and a force or moment on the reference node does the work of its motion (Abaqus Analysis User's Guide, "Coupling
constraints"; Abaqus Theory Guide, "Distributing coupling elements"; Dhondt, CalculiX CrunchiX User's Manual, *EQUATION,
*MPC, *DISTRIBUTING, *KINEMATIC, *RIGID BODY).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from fecontact.app.decks.elastic import rectangular
from fecontact.common.anisotropic import CylindricalAxes
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, not_done
from fecontact.mesh.formats.abaqus_deck import KeywordSection, values_of

#: Keywords of conditions, and those that follow one.
CONDITIONS = ("EQUATION", "MPC", "COUPLING", "RIGID BODY", "PRE-TENSION SECTION")
OF_COUPLING = ("KINEMATIC", "DISTRIBUTING")
#: Distance of a node from the plane or line of *MPC, relative to their size, that is rounding of a deck.
OFF = 1e-4
#: Share of the largest singular value up to which a motion of reference nodes is not resisted.
RANK = 1e-9


@dataclass
class Nodes:
    """Nodes by name or number, and where they are.

    Attributes
    ----------
    points : (n, 3) array
        Of the mesh, then reference nodes.
    n_mesh : int
        Points of the mesh.
    rotations : dict of int to int
        The places of the rotations of reference nodes.
    added : int
        How many of these are beyond the points.
    axes : dict of int to (3, 3) array
        Directions of the components of displacement, where *TRANSFORM gives them, as rows.
    find : callable
        Places of the nodes of a set or number.
    """

    points: Array
    n_mesh: int
    find: Callable[[str, str], IntArray]
    rotations: dict[int, int] = field(default_factory=dict)
    added: int = 0
    axes: dict[int, Array] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Places of points and rotations."""
        return len(self.points) + self.added

    @property
    def moving(self) -> Mask:
        """Mask of the places that are no rotations."""
        return ~np.isin(np.arange(self.count), list(self.rotations.values()))

    def rotation(self, node: int) -> int:
        """Place of the rotation of a node, a new one if it has none."""
        if node not in self.rotations:
            self.rotations[node] = self.count
            self.added += 1
        return self.rotations[node]

    def one(self, name: str, place: str) -> int:
        """Place of the only node of a name.

        Raises
        ------
        InputError
            If it is not one.
        """
        found = self.find(name, place)
        if len(found) != 1:
            raise InputError(f"{place}: expected one node; {name!r} has {len(found)}.", code="reference-node")
        return int(found[0])

    def component(self, node: int, c: int) -> tuple[IntArray, Array]:
        """Columns and coefficients of the component c = 1 ... 6 of a node, along its axes."""
        if c > 3:
            return np.array([3 * self.rotation(node) + c - 4]), np.ones(1)
        if node not in self.axes:
            return np.array([3 * node + c - 1]), np.ones(1)
        return 3 * node + np.arange(3), self.axes[node][c - 1]


def transformed(s: KeywordSection, nodes: IntArray, points: Array) -> dict[int, Array]:
    """Axes of nodes by *TRANSFORM: rectangular, or cylindrical (radial, tangential, axial) about a line.

    Raises
    ------
    InputError
        For other types, or a node on the axis.
    """
    kind = s.parameters.get("TYPE", "R").upper()
    given = np.array([v for line in s.lines for v in values_of(line)][:6])
    if kind not in ("R", "C") or len(given) != 6:
        raise InputError(
            f"{s.place}: expected *TRANSFORM, TYPE=R or C, and two points; found {kind}, {s.lines}.", code="transform"
        )
    a, b = given[:3], given[3:]
    if kind == "R":
        axes = rectangular(a, b)
        if axes is None:
            raise InputError(f"{s.place}: the points of *TRANSFORM are on one line with the origin.", code="transform")
        return dict.fromkeys(nodes.tolist(), axes)
    return dict(zip(nodes.tolist(), CylindricalAxes(b - a, a)(points[nodes]), strict=True))


@dataclass
class Rows:
    """Conditions as they are found."""

    columns: list[IntArray] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)

    def add(self, *terms: tuple[Sequence[int] | IntArray, Sequence[float] | Array]) -> None:
        """A condition of columns and coefficients."""
        self.columns.append(np.concatenate([np.asarray(c, dtype=np.int64) for c, _ in terms]))
        self.values.append(np.concatenate([np.asarray(v, dtype=float) for _, v in terms]))

    def matrix(self, n: int) -> sp.csr_matrix:
        """G (m, n)."""
        if not self.columns:
            return sp.csr_matrix((0, n))
        row = np.repeat(np.arange(len(self.columns)), [len(c) for c in self.columns])
        shape = (len(self.columns), n)
        out = sp.csr_matrix((np.concatenate(self.values), (row, np.concatenate(self.columns))), shape=shape)
        out.eliminate_zeros()
        return out


def reference_names(keywords: Sequence[KeywordSection]) -> list[str]:
    """Words of conditions that may name nodes: their sets and numbers."""
    out: list[str] = []
    for s in keywords:
        if s.keyword in ("COUPLING", "RIGID BODY"):
            out += [s.parameters[name] for name in ("REF NODE", "ROT NODE") if name in s.parameters]
        elif s.keyword == "PRE-TENSION SECTION":
            out += [s.parameters.get("NODE", "")]
        elif s.keyword in ("EQUATION", "MPC"):
            out += s.items
    return out


def conditions_of(
    keywords: Sequence[KeywordSection],
    nodes: Nodes,
    faces: Callable[[str, str], tuple[IntArray, Array]],
    cells: Callable[[str, str], IntArray],
) -> sp.csr_matrix:
    """Conditions (m, 3 n) of the keywords of the model part.

    `faces` gives the nodes of a surface and their weights, `cells` the nodes of an element set.

    Raises
    ------
    InputError
        For what is not done.
    """
    rows = Rows()
    for k, s in enumerate(keywords):
        if s.keyword == "EQUATION":
            _equations(s, nodes, rows)
        elif s.keyword == "MPC":
            for line in s.lines:
                _mpc(line, s.place, nodes, rows)
        elif s.keyword == "RIGID BODY":
            _rigid(s, nodes, cells, rows)
        elif s.keyword == "COUPLING":
            kind = next((t for t in keywords[k + 1 : k + 2] if t.keyword in OF_COUPLING), None)
            if kind is None:
                raise InputError(f"{s.place}: *COUPLING needs *KINEMATIC or *DISTRIBUTING after it.", code="coupling")
            _coupling(s, kind, nodes, faces, rows)
    return rows.matrix(3 * nodes.count)


def _equations(s: KeywordSection, nodes: Nodes, rows: Rows) -> None:
    """Equations: a number of terms, then node or set, component and coefficient of each."""
    if left := [name for name in s.parameters if name != "INPUT"]:
        raise not_done(f"{s.place}: *EQUATION with {', '.join(left)} is not done here.")
    words, at = s.items, 0
    while at < len(words):
        n = int(words[at])
        terms = words[at + 1 : at + 1 + 3 * n]
        if len(terms) < 3 * n or n < 1:
            raise InputError(f"{s.place}: expected {n} terms of three words; found {terms}.", code="equation")
        at += 1 + 3 * n
        members = [nodes.find(name, s.place) for name in terms[::3]]
        length = max(map(len, members))
        if any(len(m) not in (1, length) for m in members):
            raise InputError(
                f"{s.place}: sets of an equation need one node or as many as the others; found "
                f"{', '.join(map(str, map(len, members)))}.",
                code="equation",
            )
        for k in range(length):
            each = zip(members, terms[1::3], terms[2::3], strict=True)
            parts = [(nodes.component(int(m[k if len(m) > 1 else 0]), int(c)), values_of(a)[0]) for m, c, a in each]
            rows.add(*((columns, a * values) for (columns, values), a in parts))


def _mpc(line: str, place: str, nodes: Nodes, rows: Rows) -> None:
    """A line of *MPC: its type, then nodes."""
    kind, *names = [word.strip() for word in line.split(",") if word.strip()]
    members = np.concatenate([nodes.find(name, place) for name in names]) if names else np.zeros(0, np.int64)
    least = {"PLANE": 4, "STRAIGHT": 3, "BEAM": 2, "LINK": 2, "TIE": 2, "PIN": 2}.get(kind.upper())
    if least is None:
        raise not_done(f"{place}: *MPC of the type {kind} is not done here.")
    if len(members) < least:
        raise InputError(f"{place}: *MPC {kind} needs {least} nodes; found {len(members)}.", code="mpc")
    x, kind = nodes.points[members], kind.upper()
    if kind in ("TIE", "PIN"):
        for p in members[1:].tolist():
            for c in range(3):
                rows.add(([3 * p + c, 3 * members[0] + c], [1.0, -1.0]))
    elif kind in ("BEAM", "LINK"):
        along = (x[0] - x[1]) / np.linalg.norm(x[0] - x[1])
        rows.add((3 * members[0] + np.arange(3), along), (3 * members[1] + np.arange(3), -along))
    else:
        _aligned(members, x, 3 if kind == "PLANE" else 2, place, rows)


def _aligned(members: IntArray, x: Array, n: int, place: str, rows: Rows) -> None:
    """Nodes that stay in the plane of the first three, or on the line of the first two."""
    span = x[1:n] - x[0]
    _, singular, axes = np.linalg.svd(span)
    if singular.min() <= OFF * singular.max():
        raise InputError(f"{place}: the first {n} nodes of *MPC make no plane or line.", code="mpc")
    shares = np.linalg.lstsq(span.T, (x[n:] - x[0]).T, rcond=None)[0].T
    off = np.abs(shares @ span - (x[n:] - x[0])).max()
    if off > OFF * singular.max():
        raise InputError(f"{place}: nodes of *MPC lie up to {off:.3g} off their plane or line at first.", code="mpc")
    for p, share in zip(members[n:].tolist(), shares, strict=True):
        weights = [1.0, -(1 - share.sum()), *(-share)]
        for normal in axes[n - 1 :]:
            every = zip([p, *members[:n].tolist()], weights, strict=True)
            rows.add(*((3 * node + np.arange(3), w * normal) for node, w in every))


def _follow(node: int, members: IntArray, components: Sequence[int], nodes: Nodes, turn: int, rows: Rows) -> None:
    """Nodes that move with a rigid part: u_p - u_R - theta x r = 0, of some components."""
    for p in members[members != node].tolist():
        r = nodes.points[p] - nodes.points[node]
        # (theta x r)_c
        cross = np.array([[0.0, r[2], -r[1]], [-r[2], 0.0, r[0]], [r[1], -r[0], 0.0]])
        for c in components:
            rows.add(([3 * p + c, 3 * node + c], [1.0, -1.0]), (3 * turn + np.arange(3), -cross[c]))


def _rigid(s: KeywordSection, nodes: Nodes, cells: Callable[[str, str], IntArray], rows: Rows) -> None:
    """*RIGID BODY of a node set or an element set."""
    known = {"NSET", "ELSET", "REF NODE", "ROT NODE"}
    if (left := [name for name in s.parameters if name not in known]) or "REF NODE" not in s.parameters:
        what = f"with {', '.join(left)}" if left else "without REF NODE"
        raise not_done(f"{s.place}: *RIGID BODY {what} is not done here.")
    node = nodes.one(s.parameters["REF NODE"], s.place)
    if "ROT NODE" in s.parameters:
        nodes.rotations[node] = nodes.one(s.parameters["ROT NODE"], s.place)
    turn = nodes.rotation(node)
    sets = [nodes.find(s.parameters["NSET"], s.place)] if "NSET" in s.parameters else []
    sets += [cells(s.parameters["ELSET"], s.place)] if "ELSET" in s.parameters else []
    if not sets:
        raise InputError(f"{s.place}: *RIGID BODY needs NSET or ELSET.", code="rigid-body")
    _follow(node, np.unique(np.concatenate(sets)), range(3), nodes, turn, rows)


def _coupling(
    s: KeywordSection,
    kind: KeywordSection,
    nodes: Nodes,
    faces: Callable[[str, str], tuple[IntArray, Array]],
    rows: Rows,
) -> None:
    """*COUPLING of a surface to a reference node, kinematic or distributing."""
    left = [name for name in s.parameters if name not in ("REF NODE", "SURFACE", "CONSTRAINT NAME")]
    cyclic = kind.keyword == "DISTRIBUTING" and "CYCLIC SYMMETRY" in kind.parameters
    known = {"COUPLING": "CONTINUUM"} | ({"CYCLIC SYMMETRY": kind.parameters["CYCLIC SYMMETRY"]} if cyclic else {})
    left += [name for name, value in kind.parameters.items() if known.get(name) != value]
    if left or not {"REF NODE", "SURFACE"} <= set(s.parameters):
        what = f"with {', '.join(left)}" if left else "without REF NODE and SURFACE"
        raise not_done(f"{s.place}: *COUPLING {what} is not done here.")
    node = nodes.one(s.parameters["REF NODE"], s.place)
    turn = nodes.rotation(node)
    members, weights = faces(s.parameters["SURFACE"], s.place)
    components: set[int] = set()
    for line in kind.lines:
        given = [int(v) for v in values_of(line)]
        components |= set(range(given[0] - 1, given[-1] if len(given) > 1 and given[-1] else given[0]))
    components = components or set(range(6))
    if kind.keyword == "KINEMATIC":
        _follow(node, members, sorted(components & {0, 1, 2}), nodes, turn, rows)
        return
    w = weights / weights.sum()
    centre = nodes.points[node] if cyclic else w @ nodes.points[members]
    _distribute(node, turn, members, w, centre, nodes, rows, s.place)


def _distribute(
    node: int, turn: int, members: IntArray, w: Array, centre: Array, nodes: Nodes, rows: Rows, place: str
) -> None:
    """A reference node that moves as nodes do on average, about a centre (3,)."""
    x = nodes.points[members]
    r = x - centre
    T = np.einsum("n,nij->ij", w, (r * r).sum(axis=1)[:, None, None] * np.eye(3) - r[:, :, None] * r[:, None, :])
    # nodes of a section turn in its plane alone
    if np.linalg.cond(T) > 1 / RANK and np.ptp(nodes.points[:, 2]):
        raise InputError(f"{place}: the nodes of a distributing coupling lie on a line.", code="coupling")
    cross = np.zeros((len(x), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -r[:, 2], r[:, 1], -r[:, 0]
    cross -= cross.transpose(0, 2, 1)
    spin = np.einsum("ij,n,njk->ink", np.linalg.pinv(T, rcond=RANK), w, cross)
    arm = nodes.points[node] - centre
    lever = np.array([[0.0, arm[2], -arm[1]], [-arm[2], 0.0, arm[0]], [arm[1], -arm[0], 0.0]])
    every = (3 * members[:, None] + np.arange(3)).ravel()
    for c in range(3):
        rows.add(([3 * node + c], [1.0]), (3 * members + c, -w), (3 * turn + np.arange(3), -lever[c]))
        rows.add(([3 * turn + c], [1.0]), (every, -spin[c].ravel()))


@dataclass(frozen=True, eq=False)
class BodyConditions:
    """Conditions of a body, without reference nodes: C u = V h, of which h are prescribed displacements of all nodes.

    Attributes
    ----------
    rows : (m, 3 n) csr_matrix
        C, over the points of the body.
    given : (m, 3 n_all) csr_matrix
        V.
    forces : (3 n, 3 n_all) csr_matrix
        Forces on points of the body by those on all nodes that it has conditions with.
    loose : (k, 3 n_all) array
        Directions in which reference nodes are free: forces on them along these have nothing to resist them.
    """

    rows: sp.csr_matrix
    given: sp.csr_matrix
    forces: sp.csr_matrix
    loose: Array


def of_body(G: sp.csr_matrix, held: Mask, points: IntArray, n_mesh: int) -> BodyConditions | None:
    """The conditions of a body, by all (m, 3 n_all); None where it has none.

    Parameters
    ----------
    G : (m, 3 n_all) csr_matrix
    held : (3 n_all,) mask
        Of prescribed displacements.
    points : (n,) int array
        Places of its points.
    n_mesh : int
        Places of points of the mesh; others are those of reference nodes.
    """
    own = np.zeros(G.shape[1], bool)
    own[(3 * points[:, None] + np.arange(3)).ravel()] = True
    virtual = np.arange(G.shape[1]) >= 3 * n_mesh
    # of all conditions those that are connected to it, also through free reference nodes
    mine = np.zeros(G.shape[0], bool)
    reached = own.copy()
    pattern = abs(G)
    while True:
        found = pattern @ reached.astype(float) > 0
        if (found == mine).all():
            break
        mine = found
        reached |= (pattern[mine].sum(axis=0).A1 > 0) & virtual & ~held
    if not mine.any():
        return None
    A = G[np.flatnonzero(mine)]
    A = sp.csr_matrix(sp.diags(1 / abs(A).max(axis=1).toarray().ravel()) @ A)
    free = np.flatnonzero((pattern[np.flatnonzero(mine)].sum(axis=0).A1 > 0) & virtual & ~held)
    mesh_own = np.flatnonzero(own)
    known = np.flatnonzero(~own & ~(virtual & ~held))
    unit = sp.eye_array(G.shape[1], format="csr")
    F = A[:, free].toarray()
    U, K = A[:, mesh_own], A[:, known] @ unit[known]
    if not len(free):
        return BodyConditions(
            U, sp.csr_matrix(-K), sp.csr_matrix((len(mesh_own), G.shape[1])), np.zeros((0, G.shape[1]))
        )
    size = np.abs(F).max(axis=0)
    size[size == 0] = 1.0
    _, R, order = scipy.linalg.qr((F / size).T, mode="economic", pivoting=True)
    diagonal = np.abs(np.diagonal(R))
    rank = int((diagonal > RANK * diagonal.max()).sum())
    chosen, others = np.sort(order[:rank]), np.setdiff1d(np.arange(len(F)), order[:rank])
    inverse = np.linalg.pinv(F[chosen] / size) / size[:, None]
    # f = -inverse (U u + K h) of the chosen rows
    through = sp.csr_matrix(F[others] @ inverse)
    rows, given = sp.csr_matrix(U[others] - through @ U[chosen]), sp.csr_matrix(K[others] - through @ K[chosen])
    rows.data[np.abs(rows.data) < RANK] = 0.0
    rows.eliminate_zeros()
    kept = np.flatnonzero(np.diff(rows.indptr))
    forces = sp.csr_matrix(-(sp.csr_matrix(inverse) @ U[chosen]).T @ unit[free])
    loose = scipy.linalg.null_space(F / size).T / size
    return BodyConditions(sp.csr_matrix(rows[kept]), sp.csr_matrix(-given[kept]), forces, loose @ unit[free].toarray())


def with_supports_along(
    found: BodyConditions | None, axes: Mapping[int, Array], along: Array | None, points: IntArray, n_all: int
) -> BodyConditions | None:
    """The conditions of a body with its supports along axes of their own: `along` (n_all / 3, 3) is NaN where free."""
    if along is None or not np.isfinite(along[points]).any():
        return found
    place, rows, taken = {int(p): k for k, p in enumerate(points)}, Rows(), []
    for node in np.flatnonzero(np.isfinite(along).any(axis=1)).tolist():
        if node in place:
            held = np.flatnonzero(np.isfinite(along[node]))
            for c in held.tolist():
                rows.add((3 * place[node] + np.arange(3), axes[node][c]))
            taken += (3 * node + held).tolist()
    C = rows.matrix(3 * len(points))
    V = sp.csr_matrix((np.ones(len(taken)), (np.arange(len(taken)), taken)), shape=(len(taken), n_all))
    if found is None:
        return BodyConditions(C, V, sp.csr_matrix((C.shape[1], n_all)), np.zeros((0, n_all)))
    return replace(
        found, rows=sp.vstack([found.rows, C], format="csr"), given=sp.vstack([found.given, V], format="csr")
    )
