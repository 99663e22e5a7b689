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
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, cg

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import ErrorEstimate, ResponseError, percent
from fecontact.common.errors import InputError, SolverError
from fecontact.common.path import Steps
from fecontact.common.units import Units
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.fft import DampedInverse, Product, Tally
from fecontact.halfspace.grid import Even, block_sums, part_of, unfold
from fecontact.halfspace.grid_error import EdgeCells, edge_cells
from fecontact.halfspace.nested import GridLevel, coarser, compliance, preconditioner
from fecontact.halfspace.path import Curve, prints_of
from fecontact.halfspace.pictures import draw_adhesion
from fecontact.halfspace.pressing import Load, check_box, checked_heights, grid_level, press

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
#: Change to cells twice as large over the error, of forces, areas and pressures.
CHANGE = 0.7
#: Estimate without a coarser grid.
UNKNOWN = ErrorEstimate.none("not estimated, the grid has no coarser one")
#: Columns of a curve.
FIGURES = (
    "approach", "force", "area", "adhesive_area", "max_pressure", "energy", "stability", "force_error", "area_error",
    "worst_residual",
)  # fmt: skip


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
    estimate : ErrorEstimate
    response : ResponseError
    """

    adhesion: Dugdale
    attraction: Array
    law_residual: float
    stability: float
    energy: float
    zone_width: float
    estimate: ErrorEstimate = field(default=UNKNOWN, kw_only=True, repr=False)
    response: ResponseError = field(default=ResponseError(), kw_only=True, repr=False)

    @property
    def active(self) -> Mask:
        """Cells (nx, ny) that touch."""
        return self.pressure + self.attraction > 0

    @property
    def has_stiffness(self) -> bool:
        """No: the force depends on the path."""
        return False

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
        """From the change by a grid of cells twice as large."""
        return self.estimate

    @property
    def response_error(self) -> ResponseError:
        """Of the force over what presses or, if more, pulls; or of the approach over the larger of it and the range."""
        return self.response

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

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures by name."""
        names = ("adhesive_area", "energy", "stability", "law_residual")
        return {**super().figures, **{name: getattr(self, name) for name in names}}

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        return super().summary() | {"adhesion": {"work": self.adhesion.work, "range": self.adhesion.range}}

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


class Given(NamedTuple):
    """What is prescribed: an approach or a force."""

    approach: float | None
    force: float | None = None


class State(NamedTuple):
    """A contact under given shares of attraction, of the modelled cells; energies are over the area of a cell."""

    given: Given
    contact: HalfSpaceContact
    share: Array
    zone: Zone
    energy: float
    potential: float
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

    @cached_property
    def _coarse(self) -> Adhesive | None:
        """The same on cells twice as large; None if they do not fit."""
        if any(n % 4 for n in self.body.grid.shape):
            return None
        level = coarser(self.level, self.body.kernel(1))
        heights = unfold(np.where(level.allowed, level.g, np.inf), level.symmetric)
        return replace(self, body=replace(self.body, grid=self.body.grid.coarser), heights=heights)

    def _of(self, values: Any) -> Any:
        """Values of the modelled cells."""
        return values[part_of(self.body.grid.shape, self.level.symmetric)]

    def contact(
        self, given: Given, share: Array | None = None, last: State | None = None
    ) -> tuple[AdhesiveContact, State]:
        """The state that follows one with shares (nx, ny) of modelled cells; without them from separated surfaces.

        Under a force without shares they follow the first touch.
        """
        if share is None and given.approach is None:
            last = self._settled(Given(float(self.heights.min())), np.zeros(self.level.g.shape), None)
            share = last.share
        at = self._settled(given, np.zeros(self.level.g.shape) if share is None else share, last)
        if not self.body.periodic:
            check_box(self.body.grid, at.share > 0, None, self.level.symmetric, "zone of adhesion")
        return self._certified(at), at

    def _settled(self, given: Given, share: Array, last: State | None) -> State:
        """The state by steps from given shares."""
        at = self._state(given, share, last)
        for _ in range(MAX_STEPS):
            if at.residual <= OF_LAW * self.tolerance:
                return at
            at = self._next(at)
        raise SolverError(
            f"No certified answer after {MAX_STEPS} steps of the adhesive zone: shares differ by {at.residual:.1e} "
            f"from those of the gap. Take smaller cells or a larger range.",
            code="adhesion-not-settled",
        )

    def _next(self, at: State) -> State:
        """Newton's step where it lowers the energy, else the contact under the tractions of the last gap."""
        found = at.zone.share - at.share
        B, lowered = self._outline(at), self._lowered(at)
        change, softening = lanczos(lambda y: B @ lowered(B.T @ y), B @ lowered(self.law.traction * found.ravel()))
        if softening < 1:
            step = found + (B.T @ change).reshape(found.shape) / self.law.traction
            new = self._state(at.given, np.clip(at.share + step, 0.0, 1.0), at)
            if new.energy <= at.energy + 10 * self.tolerance * at.scale:
                return new
        return self._state(at.given, at.zone.share, at)

    def _state(self, given: Given, share: Array, last: State | None) -> State:
        """The contact under given shares."""
        lifted = self._products[0].apply(self.law.traction * share)
        z = unfold(np.where(self.level.allowed, self.level.g - lifted, np.inf), self.level.symmetric)
        load, start = self._load(given, share), None if last is None else last.contact
        contact = press(self.body, z, load, self.tolerance, self.symmetry, self.workers, boxed=False, start=start)
        zone = self._centres.zone(self._of(contact.gap), self.law.range)
        net = self._of(contact.pressure) - self.law.traction * share
        elastic = float(np.vdot(net, self._of(contact.displacement) - lifted)) / 2
        adhesive = self.law.traction * zone.depth
        work = 0.0 if given.force is None else contact.approach * float(net.sum())
        return State(
            given, contact, share, zone, elastic - adhesive - work, elastic - adhesive, abs(elastic) + adhesive
        )

    def _load(self, given: Given, share: Array) -> Load:
        """The load of the contact under given shares: a force with what they pull."""
        if given.force is None:
            return Load(None, given.approach, None)
        pull = self.law.traction * float(share.sum()) * self.body.grid.area * 2 ** sum(self.level.symmetric)
        if given.force + pull <= 0:
            raise InputError(
                f"Under a tension of {-given.force:g} the surfaces come off. Take a smaller one: the largest is the "
                "pull_off of HalfSpace.curve with adhesion, which comes off by approaches.",
                code="beyond-pull-off",
            )
        return Load(given.force + pull, None, None)

    def _outline(self, at: State) -> sp.csr_matrix:
        """Rows of gaps at points of the zone's outline, times roots of what comes within the range there."""
        return sp.csr_matrix(sp.diags(np.sqrt(self.law.traction * at.zone.weights)) @ at.zone.points)

    def _lowered(self, at: State) -> Callable[[Array], Array]:
        """Function of tractions: by how much they close the gap while what touches stays so, all (n,)."""
        (A, P), held = self._products, self._of(at.contact.active)

        def among(product: Product | DampedInverse) -> LinearOperator:
            apply = lambda x: (product.apply(x.reshape(held.shape) * held) * held).ravel()  # noqa: E731
            return LinearOperator((held.size, held.size), matvec=apply, dtype=float)

        own, inverse = among(A), among(P)

        def carried(u: Array) -> Array:
            """Pressures of what touches by displacements there."""
            p = cg(own, (u * held).ravel(), rtol=HELD_TOLERANCE, maxiter=100, M=inverse)[0]
            return np.asarray(p.reshape(held.shape))

        # under a force the surface moves too: pressures by a unit of its approach
        unit = carried(np.ones(held.shape)) if at.given.force is not None and held.any() and not held.all() else None

        def lowered(tension: Array) -> Array:
            t = tension.reshape(held.shape)
            u = A.apply(t)
            if held.any():
                p = carried(u)
                moved = 0.0 if unit is None else float((t - p).sum() / unit.sum())
                u += moved - A.apply(p if unit is None else p + moved * unit)
            return np.asarray(u.ravel())

        return lowered

    def _certified(self, at: State) -> AdhesiveContact:
        """The contact with its residuals, stability and estimated errors."""
        B, lowered = self._outline(at), self._lowered(at)
        start = np.random.default_rng(1).normal(size=B.shape[0])
        softening = lanczos(lambda y: B @ lowered(B.T @ y), start, settled=True)[1]
        attraction = self.law.traction * unfold(at.share, self.level.symmetric)
        lifted = unfold(self._products[0].apply(self.law.traction * at.share), self.level.symmetric)
        fields = {name: getattr(at.contact, name) for name in HalfSpaceContact.__dataclass_fields__} | {
            "pressure": at.contact.pressure - attraction,
            "displacement": at.contact.displacement - lifted,
            "coarse": None,
            "status": "solved" if attraction.any() else at.contact.status,
            "given": "approach" if at.given.force is None else "force",
        }
        return AdhesiveContact(
            **fields,
            adhesion=self.law,
            attraction=attraction,
            law_residual=at.residual,
            stability=1 - softening,
            energy=at.potential * self.body.grid.area * 2 ** sum(self.level.symmetric),
            zone_width=self.law.zone_width(self.body.modulus),
        )

    def judged(self, contact: AdhesiveContact, at: State) -> AdhesiveContact:
        """The contact with errors by the change to cells twice as large, whose steps begin with the same shares."""
        if self._coarse is None or not at.share.any():
            return contact
        try:
            near = self._coarse._settled(at.given, block_sums(at.share) / 4, None)
        except (InputError, SolverError):
            return replace(contact, estimate=ErrorEstimate.none("not estimated, cells twice as large have no answer"))
        coarse = self._coarse._certified(near)
        means, loaded = block_sums(contact.pressure) / 4, contact.pressure + contact.attraction
        largest = max(float(loaded.sum()), float(contact.attraction.sum())) * self.body.grid.area

        def change(name: str, scale: float) -> float:
            return abs(coarse.figures[name] - contact.figures[name]) / (CHANGE * scale) if scale else 0.0

        estimate = ErrorEstimate(
            pressure=float(np.linalg.norm(means - coarse.pressure) / np.linalg.norm(means)) / CHANGE,
            geometry=0.0,
            interior=0.0,
            peak=change("max_pressure", contact.max_pressure),
            area=change("area", contact.figures["area"]),
            faces_across=float(2 * np.sqrt((contact.attraction > 0).sum() / np.pi)),
        )
        by = {"force": change("force", largest)}
        if at.given.force is not None:
            by = {"approach": change("approach", max(abs(contact.approach), self.law.range))}
        return replace(contact, estimate=estimate, response=ResponseError(**by))


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
class AdhesionCurve(Curve):
    """States of a surface that adheres, one after the other; made by `HalfSpace.curve` with `adhesion`.

    Drawn is the force over the approach, coming on and off, with the pull-off.

    Attributes
    ----------
    steps : tuple of dict
        Of each approach in the order given, and of others between them where the curve jumps or the pull-off is
        located: approach, force, area, adhesive_area, max_pressure, energy, stability, force_error and area_error
        (estimated, relative), worst_residual, warnings, and the jump to it or None.
    """

    by: ClassVar = "approach"

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Jumps in their order."""
        return tuple(Jump(*row["jump"]) for row in self.steps if row["jump"])

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

    def _draw_in(self, ax: Axes, units: Units) -> None:
        draw_adhesion(ax, self, units)

    @property
    def _notes(self) -> list[str]:
        error = percent(self.figures["force_error"][self._least])
        pulled = f"Pull-off {self.pull_off:.6g} at the approach {self.pull_off_approach:.6g}, error about {error}"
        return [*([pulled] if self.pull_off else []), *map(str, self.jumps), f"Energy lost {self.hysteresis:.6g}"]


def coming_off(rows: Sequence[Mapping[str, Any]]) -> Mask:
    """Whether the approach falls to states (n,)."""
    return np.diff([row["approach"] for row in rows], prepend=-np.inf) < 0


class Point(NamedTuple):
    """A point of a curve; those from files have no state."""

    row: Mapping[str, Any]
    share: Array
    state: State | None = None

    def lost_to(self, other: Point) -> float:
        """Energy lost up to another point, but for the rule of trapezoids."""
        step = other.row["approach"] - self.row["approach"]
        return (self.row["force"] + other.row["force"]) / 2 * step - (other.row["energy"] - self.row["energy"])


@dataclass(frozen=True, eq=False)
class ApproachSteps(Steps[tuple[Point, ...]]):
    """Approaches of a surface that adheres, see `HalfSpace.curve`; of each the points after the one before."""

    adhesive: Adhesive
    approaches: Sequence[float]

    def halvings(self, k: int, before: tuple[Point, ...] | None) -> int:
        """None: steps are halved by the energy that they lose."""
        return 0

    def part(
        self, k: int, before: tuple[Point, ...] | None, start: float, end: float, last: tuple[Point, ...] | None,
        known: Any = None,
    ) -> tuple[Point, ...]:  # fmt: skip
        """Points up to approach k."""
        if known is not None:
            return tuple(Point(**point) for point in known)
        if before is None:
            return (self.point(self.approaches[k]),)
        a = before[-1]
        if self.approaches[k] == a.row["approach"]:
            return (a,)
        b = self.point(self.approaches[k], a)
        step = abs(b.row["approach"] - a.row["approach"])
        allowed = LOST * step * max(abs(a.row["force"]), abs(b.row["force"]))
        return tuple(self.between(a, b, allowed, HALVINGS))

    def point(self, approach: float, last: Point | None = None, judged: bool = True) -> Point:
        """The point after another one, with estimates of its errors or without."""
        contact, state = self.adhesive.contact(Given(approach), *(last[1:] if last else ()))
        contact = self.adhesive.judged(contact, state) if judged else contact
        found = {"force_error": contact.response_error.force or math.nan, "area_error": contact.error_estimate.area}
        found |= {**contact.figures, "worst_residual": max(contact.residuals.worst, contact.law_residual)}
        row = {name: found[name] for name in FIGURES} | {"warnings": contact.warnings, "jump": None}
        return Point(row, state.share, state)

    def middle(self, a: Point, b: Point) -> Point:
        """The point half way to another one."""
        return self.point((a.row["approach"] + b.row["approach"]) / 2, a, judged=False)

    def between(self, a: Point, b: Point, allowed: float, depth: int) -> Iterator[Point]:
        """Points after one up to another: halved where energy is lost, and where the surfaces meet or part."""
        lost, grows = a.lost_to(b), b.row["adhesive_area"] - a.row["adhesive_area"]
        if lost <= allowed and (a.row["adhesive_area"] > 0) == (b.row["adhesive_area"] > 0):
            yield b
        elif depth == 0:
            jump = Jump(b.row["approach"], a.row["force"], b.row["force"], lost, grows > 0)
            yield b._replace(row={**b.row, "jump": tuple(jump)})
        else:
            half = self.middle(a, b)
            yield from self.between(a, half, allowed, depth - 1)
            if half.lost_to(b) > allowed:
                b = self.point(b.row["approach"], half)
            yield from self.between(half, b, allowed, depth - 1)

    def end(self, part: tuple[Point, ...]) -> Any:
        """Rows and shares."""
        return [{"row": point.row, "share": point.share} for point in part]

    def prints(self) -> Mapping[str, Mapping[str, str]]:
        """Fingerprints by part of each approach by its number."""
        settings = {"heights": self.adhesive.heights, "adhesion": self.adhesive.law}
        steps = [{"approach": approach} for approach in self.approaches]
        return prints_of(self.adhesive.body, steps, **settings, tolerance=self.adhesive.tolerance)

    def curve(self, parts: Sequence[tuple[Point, ...]]) -> AdhesionCurve:
        """The curve, with points put round the smallest force of coming off until it is located."""
        every = [point for part in parts for point in part]
        at = [point.row["approach"] for point in every]
        points = [point for k, point in enumerate(every) if k == 0 or at[k] != at[k - 1]]
        steps = np.abs(np.diff(self.approaches))
        least = steps[steps > 0].min(initial=np.inf) / 2**HALVINGS
        while True:
            force = np.array([point.row["force"] for point in points])
            k = int(np.where(coming_off([point.row for point in points]), force, np.inf).argmin())
            around = force[max(k - 1, 0) : k + 2]
            a, b, c = points[max(k - 1, 0)], points[k], points[min(k + 1, len(points) - 1)]
            wide = abs(c.row["approach"] - a.row["approach"]) > 2.5 * least
            if len(around) < 3 or force[k] >= 0 or not wide or around.max() - force[k] <= PULLED * abs(force[k]):
                if math.isnan(b.row["force_error"]) and force[k] < 0:  # estimates for what lies between those given
                    row = self.point(b.row["approach"], b).row
                    points[k] = b._replace(row={**row, "jump": b.row["jump"]})
                return AdhesionCurve(tuple(point.row for point in points), (1,) * len(points))
            points[k - 1 : k + 2] = [a, self.middle(a, b), b, self.middle(b, c), c]
