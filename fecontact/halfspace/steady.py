"""Steady motion of a contact over a visco-elastic half-space: hysteretic friction, of rolling or sliding.

In axes that move with the contact at the velocity v nothing changes with time. What is at x now was at x + v t before,
ahead of it, so a term of creep (see `viscoelastic`) remembers, exactly,

    m(x) = (1/l) int_0^inf exp(-r/l) f(x + r d) dr,    l = theta |v|,  d = v/|v|,

and the compliance is K + sum s K', K' = K convolved with this exponential: K / (1 - i l k.d) in wave numbers k. Among
cells K' at an offset is exp(-h/l) times that one cell on, and the integral over the cell between.

The compliance is not symmetric, but its symmetric part is positive: there is one answer. It is found by the primal-dual
active set method, whose equations GMRES solves. What is lost per length moved is the work of the forces f - m on the
creep they drive, sum s/l (f, (K - K') f): the drag, times the length.

References
----------
S. C. Hunter, J. Appl. Mech. 28 (1961) 611; L. W. Morland, J. Appl. Mech. 29 (1962) 345; I. G. Goryacheva, J. Appl.
Math. Mech. 37 (1973) 877; G. Wang, K. Knothe, J. Appl. Mech. 60 (1993) 310; G. Carbone, C. Putignano, J. Mech. Phys.
Solids 61 (2013) 1822.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft
import scipy.special

from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.units import Units
from fecontact.halfspace.cg import MAX_ROUNDS, GridIterate
from fecontact.halfspace.compliance import SurfaceCompliance, TangentialCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.fft import Convolution, Tally, padded
from fecontact.halfspace.kernels import love, symbol
from fecontact.halfspace.nested import GridLevel
from fecontact.halfspace.pictures import plot_moving
from fecontact.halfspace.pressing import Load, press
from fecontact.halfspace.rolling import ALONG_AXIS
from fecontact.halfspace.tresca import LinearStep, TrescaIterate, TrescaProblem, solve_by_gmres

#: Error of the drag, relative, over the square of that of the pressure, at least: drags on cells twice as large may be
#: alike by chance. Chosen on 40 paraboloids, of which the largest had 4.8; of 30 others it was 4.4.
OF_DRAG = 3

#: Places in a cell where the kernel is taken, which is smooth there, from its middle and over its side: those of
#: Chebyshev's polynomials, with the ends.
PLACES = np.cos(np.pi * np.arange(8, -1, -1) / 8) / 2 * (np.arange(9) != 4)
#: Nodes t of the rule of what lies beyond the grid, r = l exp(t - exp(-t)) (Takahasi & Mori 1974), and their distance.
BEYOND, SPACING = np.arange(-4, 4.5, 1 / 16), 1 / 16
#: Wave number times cell above which a wave is of two cells.
TWO_CELLS = 0.999999 * math.pi


@compact_repr
@dataclass(frozen=True, eq=False)
class MovingContact(HalfSpaceContact):
    """Contact that moves steadily over a visco-elastic half-space; made by `HalfSpace.press` with `velocity`.

    Drawn are the pressure with its centre, and a section along the motion.

    Attributes
    ----------
    velocity : (float, float)
        Of the contact over the half-space, along x and y.
    drag : float
        Force that opposes the motion, by what is lost: of a surface that slides without friction the horizontal force,
        of one that rolls the moment over its radius. Over `force` it is the coefficient of hysteretic friction.
    drag_error : float
        Its estimated error: by cells twice as large, at least `OF_DRAG` times the square of the pressure's error.
    """

    velocity: tuple[float, float]
    drag: float
    drag_error: float

    @property
    def has_stiffness(self) -> bool:
        """No: what is lost depends on the way."""
        return False

    @property
    def power(self) -> float:
        """What is lost per time."""
        return self.drag * math.hypot(*self.velocity)

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures by name."""
        return {**super().figures, "drag": self.drag, "drag_error": self.drag_error}

    @property
    def _printed(self) -> dict[str, float]:
        return {**super()._printed, "drag": self.drag, "error of the drag": self.drag_error}

    def picture(self, units: Units, name: str = "", path: str | Path | None = None) -> Any:
        """What `plot` draws."""
        return plot_moving(self, path, units)


@dataclass(frozen=True, eq=False)
class Motion:
    """Velocity of a contact over a visco-elastic half-space, and compliances in axes that move with it."""

    body: SurfaceCompliance
    velocity: tuple[float, float]
    _made: dict[int, TangentialCompliance] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        x, y = vector("the velocity", self.velocity, 2)
        if not (x or y):
            raise InputError(
                "The velocity of the contact must not be (0, 0): at rest the half-space relaxes. Press on an elastic "
                "one of its material after a long time (`.relaxed`).",
                code="at-rest",
            )
        if not self.body.periodic and min(abs(x), abs(y)) > ALONG_AXIS * math.hypot(x, y):
            raise InputError(
                "On a free half-space a contact moves along an axis of the grid. Turn the surface instead, or make "
                f"the half-space periodic; found the velocity ({x:g}, {y:g}).",
                code="off-axis",
            )
        if self.body.pressure != "uniform":
            raise InputError(
                f"Steady motion needs pressure='uniform'; found {self.body.pressure!r}.", code="pressure-not-available"
            )

    @property
    def creep(self) -> tuple[Array, Array]:
        """Shares and lengths (n,) of creep."""
        assert self.body.memory is not None
        return np.array(self.body.memory.shares), np.array(self.body.memory.times) * math.hypot(*self.velocity)

    def compliance(self, level: GridLevel, tally: Tally) -> TangentialCompliance:
        """Displacements of the cells of a grid by pressures on them; in place of `lift` what they lose."""
        if level.depth not in self._made:
            cell = (self.body.grid.cell[0] * 2**level.depth, self.body.grid.cell[1] * 2**level.depth)
            self._made[level.depth] = self._compliance(level.g.shape, cell, tally)
        return self._made[level.depth]

    def drag(self, p: Array, depth: int) -> float:
        """What pressures on the cells of a grid that was solved lose per length."""
        loss = self._made[depth].lift
        assert loss is not None
        return float(np.vdot(p, loss.apply(p))) * self.body.grid.area * 4**depth

    def _compliance(self, shape: tuple[int, int], cell: tuple[float, float], tally: Tally) -> TangentialCompliance:
        lengths = shape if self.body.periodic else (2 * padded(shape[0]), 2 * padded(shape[1]))
        unpadded = shape if self.body.periodic else (padded(shape[0]), padded(shape[1]))
        inverse = self._symbol(unpadded, cell)[0]
        inverse[0, 0] = 2 * np.abs(inverse).max()
        exact, loss = self._symbol(shape, cell) if self.body.periodic else self._spectra(shape, cell, lengths)
        both = [Convolution(((kernel,),), shape, lengths, tally=tally) for kernel in (exact, loss)]
        without = Convolution(((1 / inverse,),), shape, unpadded, tally=tally, product=False).rough
        own = float(love((1, 1), cell)[0, 0]) / self.body.modulus
        return TangentialCompliance(both[0], both[1], None, without, own, self.body.periodic, symmetric=False)

    def _symbol(self, shape: tuple[int, int], cell: tuple[float, float]) -> tuple[Array, Array]:
        """Compliance and loss by waves of pressure; a mean, which moves nothing, has the loss 0."""
        k = [2 * math.pi * scipy.fft.fftfreq(shape[0], cell[0]), 2 * math.pi * scipy.fft.rfftfreq(shape[1], cell[1])]
        phase = (self.velocity[0] * k[0][:, None] + self.velocity[1] * k[1]) / math.hypot(*self.velocity)
        odd = phase.copy()  # waves of two cells have no sign
        odd[np.abs(k[0]) * cell[0] > TWO_CELLS] = odd[:, k[1] * cell[1] > TWO_CELLS] = 0.0
        K = symbol(k[0][:, None], k[1]) / self.body.modulus
        total, loss = np.ones(K.shape, complex), np.zeros(K.shape)
        for share, length in zip(*self.creep, strict=True):
            total += share * (1 + 1j * length * odd) / (1 + (length * phase) ** 2)
            loss += share * length * phase**2 / (1 + (length * phase) ** 2)
        exact = K * total
        return exact, K * loss

    def _spectra(
        self, shape: tuple[int, int], cell: tuple[float, float], lengths: tuple[int, int]
    ) -> tuple[Array, Array]:
        """Spectra of compliance and loss among the cells of a free grid."""
        axis = int(abs(self.velocity[1]) > abs(self.velocity[0]))
        sign = int(np.sign(self.velocity[axis]))
        (nx, ny), lengths = (shape, lengths) if axis == 0 else (shape[::-1], lengths[::-1])
        own, memories = _tables((nx, ny), (cell[axis], cell[1 - axis]), self.creep[1])
        total, loss = own.copy(), np.zeros(own.shape)
        for share, length, memory in zip(*self.creep, memories, strict=True):
            total += share * memory
            loss += share / length * (own - memory)
        made = []
        for table in (total, loss):
            full = np.zeros(lengths)
            at = sign * np.arange(1 - nx, nx)[:, None]
            full[at, np.arange(ny)] = table
            full[at, -np.arange(1, ny)] = table[:, 1:]
            made.append(scipy.fft.rfft2(full if axis == 0 else full.T) / self.body.modulus)
        return made[0], made[1]

    def solve(
        self, level: GridLevel, start: Array, active: Mask, tolerance: float, tally: Tally, workers: int | None
    ) -> GridIterate:
        """Solution on a grid, see `nested.solve_level`."""
        body = self.compliance(level, tally)
        limit = np.where(level.allowed, np.inf, 0.0)
        problem = TrescaProblem(body, limit, level.g[None], level.B[:, None], level.F)
        p, m, nit, history, rounds = start[None], np.zeros(len(level.F)), 0, [], 0
        while True:
            p, rounds = np.where(active, p, 0.0), rounds + 1
            gap = problem.slip(p, m)
            u = gap[0] - level.g + np.tensordot(m, level.B, 1)
            scale = float(np.abs(u).max(where=level.allowed, initial=1e-300))
            lack = np.abs(level.F - np.tensordot(level.B, p[0], 2)).max(initial=0.0) / (float(p.sum()) or 1.0)
            off = np.abs(np.where(active, gap[0], np.minimum(gap[0], 0.0)))
            left = off.max(where=level.allowed, initial=0.0) / scale
            history.append(float(left))
            pulls, enters = active & (p[0] < 0), level.allowed & ~active & (gap[0] < -tolerance * scale)
            done = not (pulls.any() or enters.any()) and max(left, lack) <= tolerance
            if done or rounds == MAX_ROUNDS:
                return GridIterate(p[0], u, -m, active, nit, rounds, done, tuple(history), recomputed=True)
            active = (active & ~pulls) | enters
            p = np.where(active, p, 0.0)
            linear = LinearStep(problem, active, np.zeros(p.shape), np.zeros(p.shape[1:]), np.ones(p.shape[1:]))
            before = TrescaIterate(p, problem.slip(p, m), m, nit=nit)
            after = solve_by_gmres(linear, before, np.zeros(p.shape), np.zeros(p.shape), 0.0)
            p, m, nit = after.q, after.m, after.nit


def _tables(shape: tuple[int, int], cell: tuple[float, float], lengths: Array) -> tuple[Array, list[Array]]:
    """Displacements (2 nx - 1, ny) at offsets 1 - nx ... along the motion, for E* = 1: at once and remembered."""
    nx, powers = shape[0], np.arange(len(PLACES))[:, None]
    fields = []  # at the places of all cells
    for place in PLACES[len(PLACES) // 2 :]:
        after, before = love(shape, cell, place), love(shape, cell, 1 - place)
        fields.append(np.concatenate([before[: nx - 1][::-1], after]))
    fields = [field[::-1] for field in fields[:0:-1]] + fields
    own = fields[len(PLACES) // 2]
    memories = []
    for length in lengths:
        x = cell[0] / length
        gamma = scipy.special.gammainc(powers + 1, x / 2) * scipy.special.factorial(powers)
        moments = (gamma / (x / 2) ** powers)[:, 0]
        on, back = (np.linalg.solve((2 * PLACES + by) ** powers, moments) for by in (0, 1))
        between = sum(w * f[:-1] for w, f in zip(on, fields, strict=True))
        between += sum(math.exp(-x / 2) * w * f[1:] for w, f in zip(back, fields, strict=True))
        r = length * np.exp(BEYOND - np.exp(-BEYOND))
        share = SPACING * np.exp(-r / length) * r / length * (1 + np.exp(-BEYOND))
        last = sum(w * love((1, shape[1]), cell, nx - 1 + by / cell[0]) for w, by in zip(share, r, strict=True))
        keep = math.exp(-x)
        found = scipy.signal.lfilter([1.0], [1.0, -keep], between[::-1], axis=0, zi=keep * last)[0]
        memories.append(np.concatenate([last, found])[::-1])
    return own, memories


def press_moving(
    body: SurfaceCompliance,
    heights: Array,
    load: Load,
    velocity: tuple[float, float],
    tolerance: float,
    workers: int | None,
) -> MovingContact:
    """A contact that moves steadily, see `HalfSpace.press`."""
    motion = Motion(body, velocity)
    found = press(body, heights, load, tolerance, False, workers, motion=motion)
    own = motion.drag(found.pressure, 0)
    error = OF_DRAG * np.nan_to_num(found.error_estimate.pressure, nan=1.0) ** 2 * abs(own)
    if found.coarse is not None:
        error = max(error, abs(motion.drag(found.coarse, 1) - own))
    known: dict[str, Any] = {name: getattr(found, name) for name in HalfSpaceContact.__dataclass_fields__}
    return MovingContact(**known, velocity=(float(velocity[0]), float(velocity[1])), drag=own, drag_error=float(error))
