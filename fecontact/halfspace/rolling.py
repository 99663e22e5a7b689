"""Steady rolling on a half-space: Kalker's problem, its pressures and tractions solved at once, with their errors.

In axes that move with the contact, at the speed of rolling along `towards`, nothing changes with time: a point of the
surface is displaced at a rate of the displacements' slope, and the slip per length rolled is

    s(x) = (u(x) - u(x + h d)) / h - rigid slip,    |q| <= mu p,  s = 0 inside,  s opposite to q on the rim,

a problem as of one step of a load path with the compliance K differenced, D = sum_j w_j K(x + j h d) / h. In wave
numbers D is K times that sum, whose real part is not negative, as K is: for given pressures there is one answer. Along
other directions than the axes, D is the sum of both differences, each times the direction's cosine.

References
----------
J. J. Kalker, Three-dimensional elastic bodies in rolling contact, 1990, sections 1.2 and 4.2; E. A. H. Vollebregt, User
guide for CONTACT, 2023, chapter 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, ClassVar

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.halfspace.compliance import TangentialCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.fft import Convolution, Kernels
from fecontact.halfspace.friction import Friction, Tractions, certificate, staggered
from fecontact.halfspace.friction_law import FrictionLaw
from fecontact.halfspace.grid import Grid, block_means, block_sums, unfold
from fecontact.halfspace.grid_error import edge_one_way
from fecontact.halfspace.pressing import Load
from fecontact.halfspace.traction_contact import FrictionContact, TractionContact
from fecontact.halfspace.tresca import TrescaIterate, TrescaProblem, solve_nested_tresca
from fecontact.solvers.coulomb import Residuals, friction_limit, sizes

#: Weights w of a difference over cells ahead, cells from a cell's middle to where it takes the rigid slip, and whether
#: cells at the leading edge count by their share. The blended one is between first and second order by Taylor's series,
#: and its error at the leading edge, where slopes have no bound, is a hundredth of theirs. Its 1/5 was chosen, beside
#: 1/6 by Taylor; it moves answers with spin only, at first order. CONTACT's 1/6 gives the figures it prints.
RULES = {"blended": ((4 / 3, -5 / 3, 1 / 3), 1 / 5, True), "contact": ((1.0, -1.0), 1 / 6, False)}

#: End of a row as its gaps locate it, in cells from the other side of its last cell, and what is added there to the own
#: compliance of rolling, over it. Fitted to Carter's force of rollers at 50 and 100 cells across, edges anywhere in
#: their cells; at other creepages and edges it is 1e-4 of the limit at 50 and 70 cells, 4e-4 at 30. It is of straight
#: edges across the rolling and like bodies: on rounded edges, with spin and with layers it is taken over, not fitted.
ROW_END = np.array([0.41, 0.4834, 0.5588, 0.6409, 0.7309, 0.8303, 0.9414, 1.0675, 1.2151, 1.4085])
ADDED = np.array([2.28, 1.515, 1.01, 0.645, 0.372, 0.16, -0.006, -0.144, -0.259, -0.357])

#: Share of the change of a sum from cells twice as large that its error is taken to be, between first and second order,
#: and least errors of force, torque and creepage, over that of the tractions and the sum of their sizes: changes may
#: cancel by chance. With these eighty random ellipses of 32 cells have estimates above half of their errors, by a bare
#: margin for force and creepage; it is no bound.
OF_CHANGE, LEAST_FORCE, LEAST_TORQUE, LEAST_CREEPAGE = 0.6, 0.165, 0.05, 0.06

#: Smaller component of a direction along an axis of the grid: rounding of cosines.
ALONG_AXIS = 1e-12

#: Tolerance of what sticks without slip.
STICKING = 1e-8

#: Tolerance of the tractions on the coarser grid.
COARSE_TOLERANCE = 1e-4

#: Fall of a wave along the grid in the preconditioner; a third of it takes twice as many iterations.
FALL = 4 * math.pi

#: Tolerance of the tractions with the friction without slip, from which those of friction that falls are sought.
FIRST_LIMITS = 1e-3

#: Difference of tractions over the largest pressure from which two solutions are taken for two.
SEVERAL = 1e-5

#: Cells that a difference reaches ahead.
REACH = 2

Pair = tuple[float | None, float | None]
Around = list[tuple[int, int]]


@compact_repr
@dataclass(frozen=True)
class RollingStep:
    """Loads and motions of a surface that rolls, along the direction of rolling and to its left.

    Parameters
    ----------
    force, approach : float, optional
        Exactly one, as in `PressStep`.
    creepage : (float or None, float or None)
        Velocity of the surface against the half-space over that of rolling; None where the force is prescribed.
    tangential : (float or None, float or None)
        Force on the surface, for each direction without creepage; zero unless given: it rolls freely.
    spin : float
        Rotation of the surface about the normal, counter-clockwise seen from above, per length rolled.
    towards : (float, float)
        Direction of rolling: that in which the contact moves.
    rule : {'blended', 'contact'}
        Difference along the direction of rolling, see `RULES`.
    position : (float, float)
        Point about which it spins.

    Raises
    ------
    InputError
        If creepage and force are both given for one direction, or a number is not finite.

    Examples
    --------
    >>> RollingStep(force=1.0, creepage=(1e-3, None)).loads
    (None, 0.0, None)
    """

    force: float | None = None
    approach: float | None = None
    creepage: Pair = (None, None)
    tangential: Pair = (None, None)
    spin: float = 0.0
    towards: tuple[float, float] = (1.0, 0.0)
    rule: str = "blended"
    position: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        Load(self.force, self.approach, None)
        checks.among("rule", self.rule, tuple(RULES))
        checks.finite("the spin", self.spin)
        checks.vector("the direction of rolling", self.towards, 2)
        if not any(self.towards):
            raise InputError("The direction of rolling must not be (0, 0); give towards=(1, 0), say.")
        for name in ("creepage", "tangential"):
            if np.shape(pair := getattr(self, name)) != (2,):
                raise InputError(
                    f"{name} must be two numbers, along the direction of rolling and to its left, or None."
                )
            for value in pair:
                if value is not None:
                    checks.finite(f"the {name}", value)
        if any(None not in both for both in zip(self.creepage, self.tangential, strict=True)):
            raise InputError(
                "Give creepage or force for a direction, not both: one follows from the other. "
                f"Found creepage={self.creepage}, tangential={self.tangential}.",
                code="one-of",
            )

    @property
    def normal_load(self) -> Load:
        """Force or approach."""
        return Load(self.force, self.approach, None)

    @property
    def loads(self) -> tuple[float | None, float | None, None]:
        """Forces along the direction of rolling and to its left; None where the creepage is prescribed."""
        x, y = ((f or 0.0) if c is None else None for c, f in zip(self.creepage, self.tangential, strict=True))
        return x, y, None

    @property
    def motions(self) -> tuple[float | None, float | None, float]:
        """Creepages and spin; None where the force is prescribed."""
        return *self.creepage, self.spin

    @property
    def slides_by(self) -> str:
        """Name of the motion to prescribe for sliding."""
        return "creepage"

    @property
    def axes(self) -> Array:
        """The direction of rolling and the one to its left, rows (2, 2)."""
        x, y = np.asarray(self.towards, dtype=float) / math.hypot(*self.towards)
        return np.array([[x, y], [-y, x]])


@dataclass(frozen=True)
class RollingError:
    """Estimated errors of discretisation, from the grid of cells twice as large.

    Errors of sums are by chance anything up to a tenth of those of the tractions: half of the estimates are above three
    to five times the error.

    Attributes
    ----------
    traction : float
        Of the tractions, root mean square over that of the tractions.
    force, torque : float
        Of the tangential force, a length of a vector, zero where it is prescribed, and of the torque.
    creepage : float
        Of the creepage, a length of a vector; zero where it is prescribed.
    coarse_defect : float
        How far the tractions on cells twice as large are from Coulomb's law, over the largest limit.
    """

    traction: float
    force: float
    torque: float
    creepage: float
    coarse_defect: float = 0.0

    def __str__(self) -> str:
        off = f", creepage {self.creepage:.2g}" if self.creepage else ""
        return f"tractions: about {100 * self.traction:.2g} % (force {self.force:.2g}, torque {self.torque:.2g}{off})"


@compact_repr
@dataclass(frozen=True, eq=False)
class RollingContact(TractionContact):
    """Steady rolling of a surface on a half-space; made by `HalfSpace.roll`.

    Slip is per length rolled, the velocity of slip over that of rolling, and so are the works of friction: times the
    speed, `friction_work` is the power lost and `work_density` the heat per area and time. With infinite friction what
    touches sticks: the limit of small creepages, Kalker's linear theory.

    Attributes
    ----------
    creepage : (float, float)
        Velocity of the surface against the half-space along the direction of rolling and to its left, over the speed.
    spin : float
        Its rotation about the normal per length rolled.
    towards : (float, float)
        Direction of rolling, of length 1.
    law : FrictionLaw, optional
        Friction that differs along and across, or depends on the slip; `friction` is then the largest coefficient.
    also : (float, float, float), optional
        Forces along and to the left and torque of another solution, reached from sliding, where there is one.
    rolling_error : RollingError
    """

    creepage: tuple[float, float]
    spin: float
    towards: tuple[float, float]
    law: FrictionLaw | None = None
    also: tuple[float, float, float] | None = None
    rolling_error: RollingError = field(default=RollingError(np.nan, np.nan, np.nan, np.nan))

    @cached_property
    def tangential(self) -> tuple[float, float]:
        """Tangential force along the direction of rolling and to its left, on the half-space by the surface."""
        (x, y), (fx, fy) = self.towards, self.traction.sum(axis=(1, 2)) * self.grid.area
        return float(x * fx + y * fy), float(x * fy - y * fx)

    @cached_property
    def _bounded(self) -> tuple[Array, Array]:
        if (law := self.law) is None:
            return super()._bounded
        axes = np.array([self.towards, (-self.towards[1], self.towards[0])])
        limit = friction_limit(law.coefficient(sizes(self.slip)), self.pressure)
        t, s = np.tensordot(axes / law.ratio[:, None], self.traction, 1), np.tensordot(axes, self.slip, 1)
        # beyond the limit where it slips, which limits of that slip are known less exactly than
        return t - self.max_pressure / max(float(sizes(s).max()), 1e-300) * s, limit

    @property
    def sliding_integral(self) -> Array:
        """Pressure times slip."""
        return super().sliding_integral if self.law is None else self.pressure * sizes(self.slip)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Those of pressing, of an error estimated from tractions that did not converge, and of several solutions."""
        defect, found = self.rolling_error.coarse_defect, []
        if defect > COARSE_TOLERANCE:
            found.append(
                f"The tractions on cells twice as large did not converge ({defect:.1e}; tolerance "
                f"{COARSE_TOLERANCE:.0e}): the errors of rolling estimated from them may be too large or too small. "
                "Compare with other cells."
            )
        if self.also is not None:
            found.append(
                "Friction falls with slip, and there are several solutions: this one is reached from the friction "
                "without slip; reached from sliding, forces along the rolling and to its left are "
                f"({self.also[0]:.6g}, {self.also[1]:.6g}), not ({self.tangential[0]:.6g}, {self.tangential[1]:.6g})."
            )
        elif self.law and self.rolling_error.creepage and self.law.far * self.force < math.hypot(*self.tangential):
            found.append(
                "Friction falls with slip: a larger creepage may transmit the prescribed force, too, as friction of "
                f"{self.law.far:.6g} at large slips does not hold it. Prescribe creepages for the curve."
            )
        return *super().warnings, *found

    @property
    def motion(self) -> Array:
        """Creepages and spin (3,)."""
        return np.array([*self.creepage, self.spin])

    def at_rest(self) -> FrictionContact:
        """The state as the start of a load path, whose shift and twist count from it."""
        known = {name: getattr(self, name) for name in TractionContact.__dataclass_fields__}
        return FrictionContact(**known, shift=(0.0, 0.0), twist=0.0)

    @property
    def creep_work(self) -> float:
        """Work per length rolled of force and torque on creepage and spin: `friction_work`, but for its error."""
        (x, y), (fx, fy) = self.creepage, self.tangential
        return fx * x + fy * y + self.torque * self.spin

    @property
    def heat_per_area(self) -> Array:
        """Work of friction per area of the track, along the direction of rolling, across it (n,), all that passes it.

        For rolling along an axis of the grid; per cell across it.

        Raises
        ------
        InputError
            For other directions, along which the cells are not in rows.
        """
        return self._along_track(self.work_density)

    def worn_per_pass(self, coefficient: float) -> Array:
        """Depth (n,) that wears off the track in one pass, along the rolling, across it, by Archard's k: k int p |ds|.

        Of both surfaces together; the surface that rolls wears so in each of its turns. For rolling along an axis of
        the grid; per cell across it. The shape is not changed: add the depth of some passes to its heights and roll
        again, so that depths stay small beside displacements.

        Parameters
        ----------
        coefficient : float
            Volume per force and length of slip.

        Raises
        ------
        InputError
            If it is not positive, friction is infinite, or for other directions.

        References
        ----------
        J. F. Archard, J. Appl. Phys. 24 (1953) 981.

        Examples
        --------
        A wheel that slides by a tenth of its way wears a track of the section k F / 10:

        >>> import fecontact as fc
        >>> steel = fc.Material(E=210e3, nu=0.28)
        >>> half = fc.HalfSpace(steel, size=(14.0, 14.0), cells=(24, 24), against=steel)
        >>> wheel = fc.surfaces.Paraboloid(460.0)
        >>> braked = half.roll(wheel, force=80e3, friction=0.3, creepage=(0.1, 0.0))
        >>> depth = braked.worn_per_pass(1e-7)
        >>> round(float(depth.sum()) * half.grid.cell[1] / (1e-7 * 80e3 * 0.1), 2)
        1.0
        """
        return checks.positive("the coefficient of wear", coefficient) * self._along_track(self.sliding_integral)

    def _along_track(self, values: Array) -> Array:
        """Sums (n,) of values (nx, ny) over the length of the track."""
        x, y = map(abs, self.towards)
        if min(x, y) > ALONG_AXIS:
            raise InputError(
                "What passes along the track is offered for rolling along an axis of the grid. Turn the surface "
                "instead, or take `work_density` and `sliding_integral`, cell by cell."
            )
        along = int(y > x)
        return np.asarray(values.sum(axis=along) * self.grid.cell[along])

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        more = {name: getattr(self, name) for name in ("creepage", "spin", "towards", "torque")}
        more |= {"also": self.also, "law": str(self.law)} if self.law else {}
        return {**super().summary(), **more, "rolling_error": vars(self.rolling_error)}

    @property
    def _motions(self) -> dict[str, float]:
        x, y = self.creepage
        return {"torque": self.torque, "creepage along": x, "creepage across": y, "spin": self.spin}

    @property
    def _reports(self) -> tuple[object, ...]:
        return *super()._reports, f"error of {self.rolling_error}", *([self.law] if self.law else [])


@dataclass(frozen=True, eq=False)
class RollingFriction(Friction):
    """Friction of a surface that rolls: its compliances give the slip per length rolled.

    With two coefficients these are in the variables in which friction is isotropic, q = `stretch` q' and s' = stretch^T
    s, along the direction of rolling and to its left, see `contact.contact`.
    """

    axes: Array = field(default_factory=lambda: np.eye(2), kw_only=True)
    rule: str = field(default="blended", kw_only=True)
    law: FrictionLaw | None = field(default=None, kw_only=True)
    _others: dict[Grid, RollingFriction] = field(default_factory=dict, repr=False, kw_only=True)
    on_coarser: ClassVar = 0  # cells twice as large err more, and fewer iterations follow

    def on(self, grid: Grid) -> RollingFriction:
        """The same on another grid, made once."""
        if grid not in self._others:
            self._others[grid] = replace(self, body=replace(self.body, grid=grid), _made={}, _others={})
        return self._others[grid]

    @property
    def ratio(self) -> Array:
        """Coefficients (2,) along the rolling and to its left, over the larger."""
        return np.ones(2) if self.law is None else self.law.ratio

    @cached_property
    def stretch(self) -> Array | None:
        """Tractions (2, 2) by those of the isotropic problem; None: the same."""
        return None if self.law is None or not self.law.unlike else self.axes.T * self.ratio

    @cached_property
    def shrink(self) -> Array | None:
        """Inverse of `stretch`."""
        return None if self.stretch is None else np.asarray(np.linalg.inv(self.stretch), dtype=float)

    def may_slide(self, step: RollingStep, force: float) -> bool:
        """Whether friction falls with slip, and holds the loads as a whole when it slides, too."""
        far = 0.0 if self.law is None or self.law.of_slip is None else self.law.far
        return far < self.mu and math.hypot(*(f or 0.0 for f in step.loads)) < far * force

    def compliance(self, level: int, shape: tuple[int, int]) -> TangentialCompliance:
        """Compliance among as many cells of the grid coarsened `level` times by two, differenced."""
        if (level, shape) not in self._made:
            plain = Friction(self.body, 0.0, 0.0, self.workers).compliance(level, (shape[0] + REACH, shape[1] + REACH))
            self._made[level, shape] = self._differenced(plain, shape, level)
        return self._made[level, shape]

    def _differenced(self, plain: TangentialCompliance, shape: tuple[int, int], level: int) -> TangentialCompliance:
        def product(convolution: Convolution, by: NDArray, left: Array | None, right: Array | None) -> Convolution:
            by = by.astype(np.complex64) if convolution._is_single else by
            kernels = stretched(convolution.kernels, left, right)
            made = tuple(tuple(None if k is None else k * by for k in row) for row in kernels)
            return replace(convolution, kernels=made, shape=shape)

        L, ahead = self.stretch, self._symbol(plain.tractions.lengths, level)
        tractions = product(plain.tractions, ahead, L, L)
        back = None if self.shrink is None else self.shrink.T
        own = [scipy.fft.irfft2(tractions.kernels[j][j], s=tractions.lengths)[0, 0] for j in (0, 1)]
        return TangentialCompliance(
            tractions,
            None,
            None if plain.drag is None else product(plain.drag, ahead, L, None),
            product(plain.inverse, 1 / self._symbol(plain.inverse.lengths, level, damped=True), back, back),
            float(np.mean(own)),
            False,
            symmetric=False,
        )

    def _symbol(self, lengths: tuple[int, int], level: int, damped: bool = False) -> NDArray:
        """Sum of w_j exp(i j k) over the cells' sides; damped as by a wave that falls along the grid."""
        waves = (scipy.fft.fftfreq(lengths[0])[:, None], scipy.fft.rfftfreq(lengths[1])[None, :])
        total = np.zeros((1, 1), complex)
        for wave, length, side, cosine in zip(waves, lengths, self.body.grid.cell, self.axes[0], strict=True):
            step = np.exp(2j * math.pi * math.copysign(1, cosine) * wave) * (1 - damped * FALL / length)
            weights = RULES[self.rule][0]
            total = total + abs(cosine) / (side * 2**level) * sum(w * step**j for j, w in enumerate(weights))
        return np.asarray(total)


def turned(matrix: Array | None, v: Array) -> Array:
    """Vectors (2, bx, by) times a matrix; None is the identity."""
    return v if matrix is None else np.tensordot(matrix, v, 1)


def stretched(kernels: Kernels, left: Array | None, right: Array | None) -> Kernels:
    """Kernels left^T K right, without those that are zero; None is the identity."""
    if left is None:
        return kernels
    right = np.eye(len(kernels[0])) if right is None else right

    def entry(a: int, b: int) -> NDArray | None:
        parts = [
            left[i, a] * right[j, b] * k
            for i, row in enumerate(kernels)
            for j, k in enumerate(row)
            if k is not None and abs(left[i, a] * right[j, b]) > ALONG_AXIS
        ]
        return np.asarray(sum(parts), dtype=parts[0].dtype) if parts else None

    return tuple(tuple(entry(a, b) for b in range(right.shape[1])) for a in range(left.shape[1]))


@dataclass(frozen=True, eq=False)
class RollingTractions(Tractions[RollingStep, RollingContact]):
    """Tractions of steady rolling, with what is added to the compliance of cells (nx, ny); None: by their pressures.

    Where friction depends on the slip, from the limits without slip or from those of sliding.
    """

    friction: RollingFriction
    added: Array | None = None
    from_sliding: bool = False

    def __post_init__(self) -> None:
        if not self.normal.active.any():
            raise InputError(
                "Nothing is pressed: no middle of a cell touches at this approach. Increase it, or take smaller cells.",
                code="nothing-touches",
            )

    @cached_property
    def rows(self) -> Array:
        """Rigid slips (3, 2, bx, by) by unit creepages along the direction of rolling and to its left, and by spin."""
        ahead = RULES[self.step.rule][1] * self.step.axes[0] * self.normal.grid.cell
        x = (self.normal.grid.x - self.step.position[0] + ahead[0])[self.box[0], None]
        y = (self.normal.grid.y - self.step.position[1] + ahead[1])[None, self.box[1]]
        rows = np.zeros((3, 2, *self.compliance.shape))
        rows[:2] = self.step.axes[:, :, None, None]
        rows[2, 0], rows[2, 1] = -y, x
        L = self.friction.stretch
        return rows if L is None else np.einsum("ia,kixy->kaxy", L, rows)

    @property
    def _alone(self) -> Array | float:
        added = self.at_leading_edge() if self.added is None else self.added
        alone, squares = np.asarray(added[self.box] * self.compliance.own), self.friction.ratio**2
        return alone if self.friction.stretch is None else np.multiply.outer(squares / squares.mean(), alone)

    def reached(self, q: Array, m: Array, tolerance: float, near: bool = False, finest: int = 0) -> TrescaIterate:
        """Tractions on the box and motions; where friction depends on the slip, from those of the first limits."""
        setting, problem, nit = self.friction, self.problem, 0
        q, newton = turned(setting.shrink, q), 0
        if problem.law is not None and not near:
            first = replace(problem, law=None)
            at = solve_nested_tresca(first, setting.compliance, q, m, max(tolerance, FIRST_LIMITS))
            q, m, newton, nit, near = at.q, at.m, at.newton, at.nit, True
        at = super().reached(q, m, tolerance, near, finest)
        return replace(at, q=turned(setting.stretch, at.q), newton=newton + at.newton, nit=nit + at.nit)

    def slip(self, q: Array, m: Array) -> Array:
        """Slip (2, bx, by) on the box; zero where nothing touches."""
        shrink = self.friction.shrink
        return turned(None if shrink is None else shrink.T, super().slip(turned(shrink, q), m))

    def residuals(self, normal: HalfSpaceContact, q: Array, slip: Array) -> Residuals:
        """Certificate of pressures, and of tractions and slip on the box, with the limits of that slip."""
        L, shrink = self.friction.stretch, self.friction.shrink
        slip = turned(None if L is None else L.T, slip)
        return certificate(normal, self.problem, turned(shrink, q), slip, self._length)

    @cached_property
    def problem(self) -> TrescaProblem:
        """The problem of the tractions; where friction depends on the slip with the first limits, and their law."""
        found, law, p = super().problem, self.friction.law, self.normal.pressure[self.box]
        if law is None or law.of_slip is None:
            return found
        squares = (self.friction.ratio**-2)[:, None, None]

        def limits(s: Array) -> tuple[Array, Array]:
            size = np.sqrt((squares * s**2).sum(axis=0))  # s is multiplied by the ratio
            limit, more = (friction_limit(mu, p) for mu in law.around(size))
            return limit, more * squares * s / np.maximum(size, 1e-300)

        return replace(found, limit=friction_limit(law.far, p) if self.from_sliding else found.limit, law=limits)

    def at_leading_edge(self) -> Array:
        """What is added to the own compliance of cells (nx, ny), over it: of those that the contact covers by a share.

        By gaps, or where they are not known, on coarser grids, by pressures.
        """
        normal, added = self.normal, np.zeros(self.normal.grid.shape)
        known = normal.gap.shape == normal.grid.shape
        gap = normal.gap if known else np.zeros(normal.grid.shape)
        steps = np.abs(self.step.axes[0]) / normal.grid.cell * RULES[self.step.rule][2]
        for axis in np.flatnonzero(steps):
            edge = edge_one_way(normal.pressure, gap, int(axis), -int(np.sign(self.step.axes[0, axis])), False)
            share = np.interp(1 + edge.ends[0 if known else 1], ROW_END, ADDED)
            added[tuple(edge.place)] += share * steps[axis] / steps.sum()
        return added

    @property
    def _length(self) -> float:
        """Length of the contact's box along the direction of rolling."""
        sides = [n * side for n, side in zip(self.compliance.shape, self.normal.grid.cell, strict=True)]
        return float(np.abs(self.step.axes[0]) @ sides)

    def _made(self, motion: Array, **fields: Any) -> RollingContact:
        x, y, spin = motion.tolist()
        along = self.step.axes[0].tolist()
        law = self.friction.law
        return RollingContact(**fields, creepage=(x, y), spin=spin, towards=(along[0], along[1]), law=law)


def roll(
    friction: RollingFriction,
    heights: Array,
    step: RollingStep,
    start: RollingContact | None = None,
    symmetry: bool = True,
    first: HalfSpaceContact | None = None,
) -> RollingContact:
    """Steady rolling of a surface of heights (nx, ny), with its errors, from a solution nearby if there is one.

    The first pressures, without tractions, may be known.

    Raises
    ------
    InputError
        If the forces make the contact slide as a whole, or the start is of another grid.
    SolverError
        If no certified solution was found.
    """
    load = step.normal_load
    if start is not None and start.grid != friction.body.grid:
        raise InputError(
            "The start of rolling is of another grid. Leave it out, or roll on the half-space that it was found on.",
            code="other-grid",
        )
    begin = None if start is None else (start.traction, None)

    edges: list[Array] = []  # of the first pressures: edges that move with the tractions may go to and fro

    def tractions_of(normal: HalfSpaceContact, from_sliding: bool = False) -> RollingTractions:
        if not edges:
            edges.append(RollingTractions(friction, normal, step).at_leading_edge())
        return RollingTractions(friction, normal, step, edges[0], from_sliding)

    found = staggered(friction, heights, load, tractions_of, begin, symmetry, first)
    if friction.may_slide(step, found.force):
        other = staggered(friction, heights, load, partial(tractions_of, from_sliding=True), begin, symmetry, first)
        if np.abs(other.traction - found.traction).max() > SEVERAL * found.max_pressure:
            found = replace(found, also=(*other.tangential, other.torque))
    return replace(found, rolling_error=rolling_error(friction, found, step))


def on_coarser(contact: HalfSpaceContact) -> tuple[Grid, Array, tuple[float, float], Around]:
    """The grid of cells twice as large, pressures on it, its middle, and cells of the fine one missing at its sides.

    Without such pressures, on grids of a few cells, those are the means of the pressures found.
    """
    grid, even = contact.grid, contact.solver.symmetric
    pressure = block_means(contact.pressure) if contact.coarse is None else unfold(contact.coarse, even)
    # an odd number of cells has one more at its end, of symmetric ones at both
    missing = [2 * m - n for m, n in zip(pressure.shape, grid.shape, strict=True)]
    before = [k // 2 if mirrored else 0 for k, mirrored in zip(missing, even, strict=True)]
    x, y = ((n / 2 - k) * side for k, n, side in zip(before, missing, grid.cell, strict=True))
    shape = (pressure.shape[0], pressure.shape[1])
    larger = Grid((2 * grid.cell[0] * shape[0], 2 * grid.cell[1] * shape[1]), shape)
    return larger, pressure, (x, y), [(k, n - k) for k, n in zip(before, missing, strict=True)]


def rolling_error(friction: RollingFriction, found: RollingContact, step: RollingStep) -> RollingError:
    """Errors by the tractions under the pressures of cells twice as large."""
    if not found.traction.any():
        return RollingError(0.0, 0.0, 0.0, 0.0)
    larger, pressure, shift, around = on_coarser(found)
    own = block_sums(np.pad(found.traction, [(0, 0), *around])) / 4
    setting = friction.on(larger)
    coarse = replace(found, grid=larger, pressure=pressure)
    position = (step.position[0] - shift[0], step.position[1] - shift[1])
    tractions = RollingTractions(setting, coarse, replace(step, position=position))
    creepage = np.array([found.creepage[j] for j in tractions.free])
    start = own[:, *tractions.box]
    at = tractions.reached(start, creepage, COARSE_TOLERANCE)
    change = tractions.spread(at.q) - own
    x, y = larger.x[:, None] - position[0], larger.y - position[1]
    error = float(np.linalg.norm(change) / np.linalg.norm(own))
    # changes of sums may cancel by chance
    force = step.axes @ change.sum(axis=(1, 2)) * larger.area
    force[tractions.free] = 0.0
    torque = float((x * change[1] - y * change[0]).sum()) * larger.area
    size, reach = error * float(sizes(own).sum()) * larger.area, math.sqrt(found.figures["area"] / math.pi)
    motion = LEAST_CREEPAGE * error * math.hypot(*found.creepage, reach * found.spin)
    return RollingError(
        error,
        max(OF_CHANGE * float(np.hypot(*force)), LEAST_FORCE * size if len(tractions.free) < 2 else 0.0),
        max(OF_CHANGE * abs(torque), LEAST_TORQUE * size * reach),
        max(OF_CHANGE * float(np.linalg.norm(at.m - creepage)), motion if tractions.free else 0.0),
        at.defect,
    )
