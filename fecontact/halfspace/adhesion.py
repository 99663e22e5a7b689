"""Adhesion on a half-space: surfaces attract each other by a constant traction up to a range (Dugdale's law).

The energy is that of the elastic displacements and of the attraction, an exact integral over gaps that are linear
between the cells' centres: a cell carries the share of the traction that its part within the range gives it. It is
convex but for the attraction, which is concave: contact under the tractions of the last gap lowers it (the
concave-convex procedure, Yuille & Rangarajan, Neural Comput. 15 (2003) 915). Newton's method on the shares goes on from
there, where it lowers the energy too. Its matrix is 1 - C with the softening C by attraction, found by Lanczos' method,
each product of which is a contact of a given outline; a state is a local minimum if all eigenvalues of C are below 1.

References
----------
D. S. Dugdale, J. Mech. Phys. Solids 8 (1960) 100; D. Maugis, J. Colloid Interface Sci. 150 (1992) 243.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, cg

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import ErrorEstimate, ResponseError
from fecontact.common.errors import InputError, SolverError
from fecontact.common.path import Path
from fecontact.common.progress import progress_line
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.fft import DampedInverse, Product, Tally
from fecontact.halfspace.grid import Even, part_of, unfold
from fecontact.halfspace.grid_error import EdgeCells, edge_cells
from fecontact.halfspace.nested import GridLevel, compliance, preconditioner
from fecontact.halfspace.pictures import Drawn, plot_adhesion
from fecontact.halfspace.pressing import Load, checked_heights, grid_level, press

#: Steps towards one state.
MAX_STEPS = 300
#: Largest residual of the law, a share of the traction, over the tolerance of the contact.
OF_LAW = 100
#: Steps of Lanczos' method, and the residual at which they end; for the eigenvalue, its change.
MAX_LANCZOS, ENOUGH, SETTLED = 40, 1e-2, 1e-3
#: Tolerance of the contact of a given outline in them.
HELD_TOLERANCE = 1e-4
#: Energy lost in a step of a curve, over force times approach, from which it is halved, how often, and the difference
#: of forces to which the pull-off is located.
LOST, HALVINGS, PULLED = 0.05, 7, 2e-3
#: Columns of a curve.
FIGURES = ("approach", "force", "area", "adhesive_area", "max_pressure", "energy", "stability", "worst_residual")


@dataclass(frozen=True)
class Dugdale:
    """Adhesion by a constant traction up to a range of the gap, none beyond.

    Parameters
    ----------
    work : float
        Work of adhesion, per area of both surfaces.
    range : float
        Gap up to which they attract each other.

    Examples
    --------
    >>> Dugdale(work=0.05, range=1e-3).traction
    50.0
    """

    work: float
    range: float

    def __post_init__(self) -> None:
        positive("the work of adhesion", self.work)
        positive("the range of adhesion", self.range)

    @property
    def traction(self) -> float:
        """Work over range."""
        return self.work / self.range

    def zone_width(self, modulus: float) -> float:
        """Width of the zone at the edge of a contact that is large beside it, pi E* w/(4 s0^2).

        Dugdale's pi K^2/(8 s0^2) with K^2 = 2 E* w.
        """
        return math.pi * modulus * self.work / (4 * self.traction**2)


@compact_repr
@dataclass(frozen=True, eq=False)
class AdhesiveContact(HalfSpaceContact):
    """Contact of a half-space with a rigid surface that adheres; made by `HalfSpace.press` with `adhesion`.

    Pressures, and the force, are net ones: tension is negative. What touches is what is pressed against attraction.

    Attributes
    ----------
    adhesion : Dugdale
    attraction : (nx, ny) array
        Tension by adhesion: the traction times the share of a cell within the range.
    law_residual : float
        Largest difference of a share to that of the gap, recomputed.
    stability : float
        Smallest eigenvalue of the energy's second derivative, over that without attraction: above 0 the state is a
        local minimum, among states of the symmetry that is modelled.
    energy : float
        Elastic energy less that of adhesion.
    zone_width : float
        Width of the zone at the edge of a large contact.
    """

    adhesion: Dugdale
    attraction: Array
    law_residual: float
    stability: float
    energy: float
    zone_width: float

    @property
    def active(self) -> Mask:
        """Cells (nx, ny) that touch."""
        return self.pressure + self.attraction > 0

    @property
    def is_minimum(self) -> bool:
        """Whether the state is a local minimum of the energy."""
        return self.stability > 0

    @property
    def adhesive_area(self) -> float:
        """Area within the range of adhesion, of the contact too."""
        return float(self.attraction.sum()) * self.grid.area / self.adhesion.traction

    @cached_property
    def _edge(self) -> EdgeCells:
        return edge_cells(self.pressure + self.attraction, self.gap, self.periodic)

    @property
    def error_estimate(self) -> ErrorEstimate:
        """None with adhesion."""
        return ErrorEstimate.none("not estimated with adhesion")

    @property
    def response_error(self) -> ResponseError:
        """None with adhesion."""
        return ResponseError()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of a state that is no local minimum, too, and of a zone of adhesion that cells do not resolve."""
        found = super().warnings
        if not self.is_minimum:
            found += (
                f"The state is not a local minimum of the energy: an eigenvalue is {self.stability:.2g} of that "
                "without adhesion. Give the approach in smaller steps, by `HalfSpace.curve`.",
            )
        width = self.zone_width
        if self.active.any() and max(self.grid.cell) > width / 2:
            found += (
                f"Cells of {max(self.grid.cell):.3g} are wider than half the zone of adhesion, about {width:.3g} at "
                f"the edge of a large contact: it may come off in jumps from cell to cell. Take cells of "
                f"{width / 2:.2g}, or a larger range with the same work.",
            )
        return found

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        names = ("adhesive_area", "energy", "law_residual", "stability")
        law = {"work": self.adhesion.work, "range": self.adhesion.range}
        return super().summary() | {"adhesion": law} | {name: getattr(self, name) for name in names}

    def columns(self) -> dict[str, Array]:
        """Fields (nx, ny) on the cells by name."""
        return {**super().columns(), "attraction": self.attraction}

    @property
    def _printed(self) -> dict[str, float]:
        return {**super()._printed, "adhesive area": self.adhesive_area, "energy": self.energy}

    @property
    def _reports(self) -> tuple[object, ...]:
        kind = "a local minimum" if self.is_minimum else "not a local minimum"
        law = f"law of adhesion kept to {self.law_residual:.1e}; {kind} of the energy (eigenvalue {self.stability:.2g})"
        return self.solver, law


class Zone(NamedTuple):
    """What is within the range.

    Attributes
    ----------
    share : (nx, ny) array
        Of each cell.
    depth : float
        Sum over the cells of the range less the gap.
    points : (n, nx ny) csr_matrix
        Interpolation at points of the outline.
    weights : (n,) array
        Cells that come within the range there by a unit of the gap.
    """

    share: Array
    depth: float
    points: sp.csr_matrix
    weights: Array


@dataclass(frozen=True, eq=False)
class Centres:
    """Quadrilaterals between the centres of modelled cells; those at planes of symmetry and borders are halves.

    Attributes
    ----------
    shape : (int, int)
    closed : (bool, bool)
        Axes along which the last cell is beside the first.
    """

    shape: tuple[int, int]
    closed: Even

    @cached_property
    def corners(self) -> tuple[IntArray, Array]:
        """Cells (4, n) round the quadrilaterals, and their areas (n,) over that of a cell."""
        ends, weights = [], []
        for n, closed in zip(self.shape, self.closed, strict=True):
            first = np.arange(0 if closed else -1, n)
            pair = np.stack([first, first + 1])
            ends.append(pair % n if closed else np.clip(pair, 0, n - 1))
            weights.append(np.where(closed | (first >= 0) & (first < n - 1), 1.0, 0.5))
        (x, y), around = ends, ((0, 0), (1, 0), (1, 1), (0, 1))
        cells = np.stack([x[i][:, None] * self.shape[1] + y[j] for i, j in around])
        return cells.reshape(4, -1), np.outer(*weights).ravel()

    def zone(self, gap: Array, reach: float) -> Zone:
        """What is within a range of gaps (nx, ny); infinite ones are taken as those beside them, and carry nothing."""
        cells, weight = self.corners
        f = (reach - gap.ravel())[cells]
        known = np.isfinite(f)
        if not known.all():
            mean = np.where(known, f, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
            f = np.where(known, f, np.where(known.any(axis=0), mean, -reach))
        inside = (f > 0).sum(axis=0)
        whole, cut = inside == 4, np.flatnonzero((inside > 0) & (inside < 4))
        # both diagonals divide a quadrilateral, by halves, so that mirror images are the same
        three = np.array([(0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)])
        corners, values = (v[:, cut][three].transpose(0, 2, 1).reshape(-1, 3) for v in (cells, f))
        areas = np.tile(weight[cut] / 4, 4)
        moments, depth, lone, rows, lengths = cut_triangles(values)
        share = np.asarray(np.bincount(cells[:, whole].ravel(), np.tile(weight[whole] / 4, 4), gap.size), dtype=float)
        share += np.bincount(corners.ravel(), (areas[:, None] * moments).ravel(), gap.size)
        there = np.isfinite(gap).ravel()
        share[~there] = 0.0
        at, place = np.repeat(corners[lone], 2, axis=0), np.repeat(np.arange(2 * len(lone)), 3)
        points = sp.csr_matrix((rows.ravel() * there[at.ravel()], (place, at.ravel())), (len(at), gap.size))
        total = float(weight[whole] @ f[:, whole].mean(axis=0) + areas @ depth)
        return Zone(share.reshape(gap.shape), total, points, np.repeat(areas[lone] * lengths, 2))


def cut_triangles(values: Array) -> tuple[Array, Array, IntArray, Array, Array]:
    """Where functions that are linear over triangles are positive, from values (n, 3) at their corners.

    Returns
    -------
    moments : (n, 3) array
        Mean of each corner's shape function there, zero elsewhere.
    mean : (n,) array
        Mean of the positive part.
    crossed : (m,) int array
        Triangles that a line of zeros crosses.
    rows : (2 m, 3) array
        Interpolation at two Gauss points of each line.
    lengths : (m,) array
        Growth of the positive share of the area with the function, of each point.

    Examples
    --------
    A line through the middles of two sides:

    >>> moments, mean, *_ = cut_triangles(np.array([[1.0, -1.0, -1.0]]))
    >>> float(moments.sum()), bool(np.isclose(mean[0], 0.25 / 3))
    (0.25, True)
    """
    count = (values > 0).sum(axis=1)
    moments = np.tile(np.where(count == 3, 1 / 3, 0.0)[:, None], 3)
    mean = np.where(count == 3, values.mean(axis=1), 0.0)
    crossed = np.flatnonzero((count == 1) | (count == 2))
    one = count[crossed] == 1
    lone = np.argmax((values[crossed] > 0) == one[:, None], axis=1)  # the corner that is alone on its side
    order = (lone[:, None] + np.arange(3)) % 3
    f = np.take_along_axis(values[crossed], order, axis=1)
    size = np.abs(f)
    a, b = (size[:, 0] / (size[:, 0] + size[:, k]) for k in (1, 2))  # where the line cuts the sides, from that corner
    corner = np.stack([1 - (a + b) / 3, a / 3, b / 3], axis=1) * (a * b)[:, None]
    kept = np.empty_like(corner)
    np.put_along_axis(kept, order, np.where(one[:, None], corner, 1 / 3 - corner), axis=1)
    moments[crossed] = kept
    mean[crossed] = size[:, 0] * a * b / 3 + np.where(one, 0.0, f.mean(axis=1))
    none = np.zeros(len(a))
    start, end = np.stack([1 - a, a, none], axis=1), np.stack([1 - b, none, b], axis=1)
    places = np.stack([(1 - s) * start + s * end for s in 0.5 + np.array([-0.5, 0.5]) / math.sqrt(3)], axis=1)
    rows = np.empty_like(places)
    np.put_along_axis(rows, np.repeat(order[:, None], 2, axis=1), places, axis=2)
    lengths = size[:, 0] / ((size[:, 0] + size[:, 1]) * (size[:, 0] + size[:, 2]))
    return moments, mean, crossed, rows.reshape(-1, 3), lengths


class State(NamedTuple):
    """A contact under given shares of attraction, of the modelled cells; energies are over the area of a cell."""

    contact: HalfSpaceContact
    share: Array
    zone: Zone
    energy: float
    scale: float

    @property
    def residual(self) -> float:
        """Largest difference of a share to that of the gap."""
        return float(np.abs(self.zone.share - self.share).max())


@dataclass(frozen=True, eq=False)
class Adhesive:
    """A surface with heights (nx, ny) that adheres to a half-space."""

    body: SurfaceCompliance
    heights: Array
    law: Dugdale
    tolerance: float
    symmetry: bool
    workers: int | None

    @cached_property
    def level(self) -> GridLevel:
        """The modelled cells."""
        z, allowed = checked_heights(self.heights, self.body.grid)
        return grid_level(self.body, z, allowed, Load(None, 0.0, None), self.symmetry)

    @cached_property
    def _products(self) -> tuple[Product, Product | DampedInverse]:
        make = self.level, self.level.whole, Tally(self.body.grid.n_cells), self.workers
        return compliance(*make), preconditioner(*make)

    @cached_property
    def _centres(self) -> Centres:
        x, y = (self.body.periodic and not even for even in self.level.symmetric)
        return Centres(self.level.g.shape, (x, y))

    def _of(self, values: Any) -> Any:
        """Values of the modelled cells."""
        return values[part_of(self.body.grid.shape, self.level.symmetric)]

    def contact(self, approach: float, last: State | None = None) -> tuple[AdhesiveContact, State]:
        """The state that follows the last one; from separated surfaces without it."""
        at = self._state(approach, np.zeros(self.level.g.shape) if last is None else last.share, last)
        for _ in range(MAX_STEPS):
            if at.residual <= OF_LAW * self.tolerance:
                self._check_box(at.share)
                return self._certified(at), at
            at = self._next(approach, at)
        raise SolverError(
            f"No certified answer after {MAX_STEPS} steps of the adhesive zone: shares differ by {at.residual:.1e} "
            f"from those of the gap. Take smaller cells or a larger range.",
            code="adhesion-not-settled",
        )

    def _next(self, approach: float, at: State) -> State:
        """Newton's step where it lowers the energy, else the contact under the tractions of the last gap."""
        found = at.zone.share - at.share
        B, lowered = self._outline(at), self._lowered(at.contact)
        change, softening = lanczos(lambda y: B @ lowered(B.T @ y), B @ lowered(self.law.traction * found.ravel()))
        if softening < 1:
            step = found + (B.T @ change).reshape(found.shape) / self.law.traction
            new = self._state(approach, np.clip(at.share + step, 0.0, 1.0), at)
            if new.energy <= at.energy + 10 * self.tolerance * at.scale:
                return new
        return self._state(approach, at.zone.share, at)

    def _state(self, approach: float, share: Array, last: State | None) -> State:
        """The contact under given shares."""
        lifted = self._products[0].apply(self.law.traction * share)
        z = unfold(np.where(self.level.allowed, self.level.g - lifted, np.inf), self.level.symmetric)
        load, start = Load(None, approach, None), None if last is None else last.contact
        contact = press(self.body, z, load, self.tolerance, self.symmetry, self.workers, boxed=False, start=start)
        zone = self._centres.zone(self._of(contact.gap), self.law.range)
        net = self._of(contact.pressure) - self.law.traction * share
        elastic = float(np.vdot(net, self._of(contact.displacement) - lifted)) / 2
        adhesive = self.law.traction * zone.depth
        return State(contact, share, zone, elastic - adhesive, abs(elastic) + adhesive)

    def _outline(self, at: State) -> sp.csr_matrix:
        """Rows of gaps at points of the zone's outline, times roots of what comes within the range there."""
        return sp.csr_matrix(sp.diags(np.sqrt(self.law.traction * at.zone.weights)) @ at.zone.points)

    def _lowered(self, contact: HalfSpaceContact) -> Callable[[Array], Array]:
        """Function of tractions: by how much they close the gap while what touches stays so, all (n,)."""
        (A, P), held = self._products, self._of(contact.active)

        def among(product: Product | DampedInverse) -> LinearOperator:
            apply = lambda x: (product.apply(x.reshape(held.shape) * held) * held).ravel()  # noqa: E731
            return LinearOperator((held.size, held.size), matvec=apply, dtype=float)

        own, inverse = among(A), among(P)

        def lowered(tension: Array) -> Array:
            u = A.apply(tension.reshape(held.shape))
            if held.any():
                p = cg(own, (u * held).ravel(), rtol=HELD_TOLERANCE, maxiter=100, M=inverse)[0]
                u -= A.apply(p.reshape(held.shape))
            return np.asarray(u.ravel())

        return lowered

    def _certified(self, at: State) -> AdhesiveContact:
        """The contact with its residuals and its stability."""
        B, lowered = self._outline(at), self._lowered(at.contact)
        start = np.random.default_rng(1).normal(size=B.shape[0])
        softening = lanczos(lambda y: B @ lowered(B.T @ y), start, settled=True)[1]
        attraction = self.law.traction * unfold(at.share, self.level.symmetric)
        lifted = unfold(self._products[0].apply(self.law.traction * at.share), self.level.symmetric)
        of_all = self.body.grid.area * 2 ** sum(self.level.symmetric)
        fields = vars(at.contact) | {
            "pressure": at.contact.pressure - attraction,
            "displacement": at.contact.displacement - lifted,
            "coarse": None,
            "status": "solved" if attraction.any() else at.contact.status,
        }
        kept = {name: fields[name] for name in HalfSpaceContact.__dataclass_fields__}
        return AdhesiveContact(
            **kept,
            adhesion=self.law,
            attraction=attraction,
            law_residual=at.residual,
            stability=1 - softening,
            energy=at.energy * of_all,
            zone_width=self.law.zone_width(self.body.modulus),
        )

    def _check_box(self, share: Array) -> None:
        """Refuse a zone that reaches the border of a free grid."""
        if self.body.periodic:
            return
        for axis in (0, 1):
            lines = np.moveaxis(share, axis, 0)
            borders = [-1] if self.level.symmetric[axis] else [0, -1]
            if any(bool(lines[b].any()) for b in borders):
                raise InputError(
                    f"The surfaces adhere up to the border of the grid along {'xy'[axis]}, size "
                    f"{self.body.grid.size[axis]:g}. Take a larger grid; if the counter-surface ends there, add a rim "
                    "of cells with infinite height; if it repeats, use periodic=True.",
                    code="grid-too-small",
                )


def lanczos(apply: Callable[[Array], Array], b: Array, settled: bool = False) -> tuple[Array, float]:
    """Solve (1 - C) y = b by Lanczos' method: y (n,), and the largest eigenvalue found of the symmetric C, or 0.

    With `settled` it goes on until the eigenvalue is.

    Examples
    --------
    >>> C = np.diag([0.5, 0.25, 0.0])
    >>> y, largest = lanczos(lambda x: C @ x, np.ones(3), settled=True)
    >>> bool(np.allclose(y, [2.0, 4 / 3, 1.0])), round(largest, 12)
    (True, 0.5)
    """
    size = float(np.linalg.norm(b))
    if size == 0:
        return np.zeros(len(b)), 0.0
    basis, T, largest = (b / size)[None], np.zeros((MAX_LANCZOS + 1, MAX_LANCZOS + 1)), -np.inf
    for k in range(MAX_LANCZOS):
        rest = apply(basis[k])
        for _ in range(2):  # twice is enough
            parts = basis @ rest
            T[k, k] += parts[k]
            rest = rest - parts @ basis
        beta, n, before = float(np.linalg.norm(rest)), k + 1, largest
        shares = np.linalg.lstsq(np.eye(n) - T[:n, :n], size * np.eye(n)[0])[0]
        largest = float(np.linalg.eigvalsh(T[:n, :n])[-1])
        done = largest - before <= SETTLED * abs(largest) if settled else beta * abs(shares[-1]) <= ENOUGH * size
        if done or n == len(b) or beta <= 1e-12:
            break
        T[k, n] = T[n, k] = beta
        basis = np.vstack([basis, rest / beta])
    return np.asarray(shares @ basis[:n]), largest


class Jump(NamedTuple):
    """A jump of a curve: approach just after it, forces before and after, energy lost, and whether surfaces come on."""

    approach: float
    before: float
    after: float
    lost: float
    on: bool

    def __str__(self) -> str:
        way = "on" if self.on else "off"
        return f"Jumps {way} at the approach {self.approach:.6g}: force {self.before:.6g} to {self.after:.6g}"


@compact_repr
@dataclass(frozen=True, eq=False)
class AdhesionCurve(Path[dict[str, Any]], Drawn):
    """States of a surface that adheres, one after the other; made by `HalfSpace.curve` with `adhesion`.

    Drawn is the force over the approach, coming on and off, with the pull-off.

    Attributes
    ----------
    steps : tuple of dict
        Of each approach in the order given, and of others between them where the curve jumps or the pull-off is
        located: approach, force, area, adhesive_area, max_pressure, energy, stability, worst_residual and warnings.
    jumps : tuple of Jump
    """

    jumps: tuple[Jump, ...] = ()

    @property
    def force(self) -> Array:
        """Forces (n,); tension is negative."""
        return self.figures["force"]

    @property
    def approach(self) -> Array:
        """Approaches (n,)."""
        return self.figures["approach"]

    @cached_property
    def _least(self) -> int:
        """State of the smallest force while coming off; of all, if the path only comes on."""
        off = coming_off(self.steps)
        return int(np.where(off | (not off.any()), self.force, np.inf).argmin())

    @property
    def pull_off(self) -> float:
        """Largest tensile force while coming off; 0 without any."""
        return max(0.0, -float(self.force[self._least]))

    @property
    def pull_off_approach(self) -> float:
        """Approach at the pull-off."""
        return float(self.approach[self._least])

    @property
    def hysteresis(self) -> float:
        """Energy lost: work of the force, by the rule of trapezoids, less the energy gained; in a loop its area."""
        return float(np.trapezoid(self.force, self.approach) - np.diff(self.figures["energy"][[0, -1]])[0])

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings, each with the first approach that it concerns."""
        first: dict[str, float] = {}
        for row in self.steps:
            for text in row["warnings"]:
                first.setdefault(text, row["approach"])
        return tuple(f"At the approach {at:g}: {text}" for text, at in first.items())

    def rows(self) -> list[dict[str, float]]:
        """Figures of each state by name."""
        return [{name: row[name] for name in FIGURES} for row in self.steps]

    def _drawn(self, path: str | FilePath | None, units: Units) -> Any:
        return plot_adhesion(self, path, units)

    def __str__(self) -> str:
        notes = [f"Pull-off {self.pull_off:.6g} at the approach {self.pull_off_approach:.6g}"] if self.pull_off else []
        notes += [*map(str, self.jumps), f"Energy lost {self.hysteresis:.6g}"]
        notes += [f"Warning: {text}" for text in self.warnings]
        return str(Table(FIGURES, [list(row.values()) for row in self.rows()], notes))


def coming_off(rows: Sequence[dict[str, Any]]) -> Mask:
    """Whether the approach falls to states (n,)."""
    return np.diff([row["approach"] for row in rows], prepend=-np.inf) < 0


class Point(NamedTuple):
    """A point of a curve."""

    row: dict[str, Any]
    state: State

    def lost_to(self, other: Point) -> float:
        """Energy lost up to another point, but for the rule of trapezoids."""
        step = other.row["approach"] - self.row["approach"]
        return (self.row["force"] + other.row["force"]) / 2 * step - (other.row["energy"] - self.row["energy"])


def adhesion_curve(adhesive: Adhesive, approaches: Array, progress: bool | None) -> AdhesionCurve:
    """Follow a surface through approaches (n,), see `HalfSpace.curve`."""

    def point(approach: float, last: Point | None) -> Point:
        contact, state = adhesive.contact(approach, last.state if last else None)
        found = {"adhesive_area": contact.adhesive_area, "energy": contact.energy, "stability": contact.stability}
        found |= {**contact.figures, "worst_residual": max(contact.residuals.worst, contact.law_residual)}
        return Point({name: found[name] for name in FIGURES} | {"warnings": contact.warnings}, state)

    def middle(a: Point, b: Point) -> Point:
        return point((a.row["approach"] + b.row["approach"]) / 2, a)

    def between(a: Point, b: Point, allowed: float, depth: int) -> list[Point]:
        """Points after one up to another: halved where energy is lost, and where the surfaces meet or part."""
        lost, parted = a.lost_to(b), (a.row["adhesive_area"] > 0) != (b.row["adhesive_area"] > 0)
        if lost <= allowed and not parted:
            return [b]
        if depth == 0:
            on = b.row["adhesive_area"] > a.row["adhesive_area"]
            jumps.append(Jump(b.row["approach"], a.row["force"], b.row["force"], lost, on))
            return [b]
        half = middle(a, b)
        first = between(a, half, allowed, depth - 1)
        if half.lost_to(b) > allowed:
            b = point(b.row["approach"], half)
        return [*first, *between(half, b, allowed, depth - 1)]

    jumps: list[Jump] = []
    points: list[Point] = []
    lowest, least = 0.0, 0.0
    with progress_line("curve", progress, total=len(approaches), unit="approach") as line:
        for approach in approaches.tolist():
            last = points[-1] if points else None
            new = point(approach, last)
            if last and approach == last.row["approach"]:
                continue
            if last:
                step = abs(approach - last.row["approach"])
                allowed = LOST * step * max(abs(last.row["force"]), abs(new.row["force"]))
                points += between(last, new, allowed, HALVINGS)
                least = step / 2**HALVINGS
            else:
                points.append(new)
            lowest = _pulled(points, middle, lowest, least)
            line.update()
    rows = tuple(p.row for p in points)
    return AdhesionCurve(rows, (1,) * len(rows), tuple(jumps))


def _pulled(points: list[Point], middle: Callable[[Point, Point], Point], lowest: float, least: float) -> float:
    """Locate a smallest force of coming off, by points put between others; returns the smallest force so far."""
    while True:
        rows = [p.row for p in points]
        force = np.array([row["force"] for row in rows])
        k = int(np.where(coming_off(rows), force, np.inf).argmin())
        if not (0 < k < len(points) - 1 and force[k] < lowest):
            return lowest
        a, b, c = points[k - 1 : k + 2]
        wide = abs(c.row["approach"] - a.row["approach"]) > 2.5 * least
        if not wide or max(force[k - 1], force[k + 1]) - force[k] <= PULLED * abs(force[k]):
            return float(force[k])
        points[k - 1 : k + 2] = [a, middle(a, b), b, middle(b, c), c]
