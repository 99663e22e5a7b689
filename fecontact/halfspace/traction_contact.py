"""Contact of a half-space with friction, dragged or rolling: tractions, slip and work; the end of a step of a path."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.error_estimate import percent
from fecontact.common.errors import InputError
from fecontact.common.renamed import RenamedKeys, renamed
from fecontact.common.units import Units
from fecontact.common.wear import wear_warnings
from fecontact.halfspace import inside
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.grid_error import edge_area, edge_cells
from fecontact.halfspace.pictures import plot_dragged
from fecontact.solvers.coulomb import friction_limit, sticks

#: Error by the steps in time from which a result warns.
MAX_TIME_ERROR = 0.05


@dataclass(frozen=True)
class TangentialReport:
    """Statistics of the tractions.

    Attributes
    ----------
    staggered : int
        Staggered iterations: pressures, then tractions.
    newton : int
        Newton steps on the finest grid.
    nit : int
        Steps of conjugate gradients on the finest grid.
    seconds : float
        For the step, pressures included.
    """

    staggered: int
    newton: int
    nit: int
    seconds: float

    turns = renamed("turns", "staggered")

    def __str__(self) -> str:
        return (
            f"{self.staggered} staggered iterations, {self.newton} Newton steps, {self.nit} iterations, "
            f"{self.seconds:.3f} s"
        )


@compact_repr
@dataclass(frozen=True, eq=False)
class TractionContact(HalfSpaceContact):
    """Contact of a half-space with a rigid surface, with friction, dragged or rolling.

    Drawn are what sticks and slips, with arrows along the tractions, and their size. Tractions act on the half-space,
    slip is its motion against the counter-surface; so slip opposes the traction.

    Attributes
    ----------
    friction : float
        Coulomb's mu.
    traction : (2, nx, ny) array
        Tangential tractions along x and y.
    slip : (2, nx, ny) array
        Slip along x and y; zero where nothing touches.
    position : (float, float)
        Where the counter-surface's own origin is.
    residuals : Residuals
        Recomputed from the problem, relative; in those of friction forces are over the largest pressure, displacements
        over the largest normal one, loads over the normal force.
    tangential_solver : TangentialReport
    """

    friction: float
    traction: Array
    slip: Array
    position: tuple[float, float]
    tangential_solver: TangentialReport

    @property
    @abstractmethod
    def motion(self) -> Array:
        """Motions (3,) along, across and about the normal."""

    @property
    def _parts(self) -> tuple[TractionContact, ...]:
        """Contacts whose work and sliding come before its own."""
        return ()

    @cached_property
    def tangential(self) -> tuple[float, float]:
        """Tangential force along x and y, on the half-space by the counter-surface."""
        x, y = self.traction.sum(axis=(1, 2)) * self.grid.area
        return float(x), float(y)

    @property
    def _cell_forces(self) -> Array:
        return np.stack([*self.traction, -self.pressure]) * self.grid.area

    @cached_property
    def torque(self) -> float:
        """Torque of the tractions about the normal through `position`."""
        x, y = self.grid.x[:, None] - self.position[0], self.grid.y[None, :] - self.position[1]
        return float((x * self.traction[1] - y * self.traction[0]).sum()) * self.grid.area

    @cached_property
    def _bounded(self) -> tuple[Array, Array]:
        """Tractions (2, nx, ny) and their limits (nx, ny), at which cells slip."""
        return self.traction, friction_limit(self.friction, self.pressure)

    @cached_property
    def slipping(self) -> Mask:
        """Cells (nx, ny) in contact whose traction is at its limit mu p."""
        return self.active & ~sticks(*self._bounded)

    @property
    def sticking(self) -> Mask:
        """Cells (nx, ny) in contact that do not slip."""
        return np.asarray(self.active & ~self.slipping)

    @cached_property
    def stick_area(self) -> float:
        """Area that sticks, its edge located within the cells as that of the contact is.

        There the reserve of friction mu p - |t| falls to zero as the pressure does at the edge of the contact, and slip
        grows as the gap does (Ciavarella 1998, *The generalized Cattaneo partial slip plane contact problem*).
        """
        count, area = int(self.sticking.sum()), self.figures["area"]
        if count == 0 or not self.slipping.any():
            return area if count else 0.0
        traction, limit = self._bounded
        left = limit - np.hypot(traction[0], traction[1])
        slid = np.where(self.slipping, np.hypot(self.slip[0], self.slip[1]), 0.0)
        slid[~np.isfinite(self.gap)] = np.inf
        edge = edge_cells(np.where(self.sticking, left, 0.0), slid, self.periodic)
        return min(edge_area(edge, count)[0] * self.grid.area, area)

    @property
    def slip_area(self) -> float:
        """The rest of `area`."""
        return self.figures["area"] - self.stick_area

    @property
    def point_stick_area(self) -> float:
        """Area of the cells that stick."""
        return int(self.sticking.sum()) * self.grid.area

    @cached_property
    def work_density(self) -> Array:
        """Work of friction in the step, per area (nx, ny), not negative: what sticks slips by rounding either way."""
        own = np.maximum(-(self.traction * self.slip).sum(axis=0), 0.0)
        return sum((part.work_density for part in self._parts), start=own)

    @property
    def friction_work(self) -> float:
        """Work of friction in the step."""
        return float(self.work_density.sum()) * self.grid.area

    @property
    def sliding_integral(self) -> Array:
        """Integral (nx, ny) of the pressure over the length of slip; times Archard's coefficient the wear depth.

        Raises
        ------
        InputError
            If friction is infinite, where what touches does not slide.
        """
        if np.isinf(self.friction):
            raise InputError("Infinite friction has no sliding: Archard's law needs a finite coefficient.")
        if self.friction == 0:
            own = self.pressure * np.hypot(self.slip[0], self.slip[1])
            return sum((part.sliding_integral for part in self._parts), start=own)
        return self.work_density / self.friction

    def stress(self, points: ArrayLike, chunk: int = 20_000) -> Array:
        """Stress (n, 6) inside the half-space by pressures and tractions, see `HalfSpaceContact.stress`.

        Raises
        ------
        InputError
            If a point lies outside, or the half-space is periodic or layered.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3), size=(3.0, 3.0), cells=(32, 32))
        >>> dragged = half.press(fc.Sphere(10.0), force=0.1, friction=0.3, tangential=(0.02, 0.0))
        >>> bool(dragged.stress([[0.0, 0.0, -0.1]])[0, 5] > 0)
        True
        """
        if self.periodic or self.layers:
            raise InputError(
                "Stress inside a periodic or layered half-space is offered for contacts without friction only. Press a "
                "free, homogeneous one, or without friction.",
                code="stress-with-friction",
            )
        by_pressure = super().stress(points, chunk)
        downwards = np.asarray(points, dtype=float) * np.array([1.0, 1.0, -1.0])
        loaded = inside.Loaded(self.grid, self.pressure, self.material, ())
        return np.asarray(by_pressure + loaded.sheared(downwards, self.traction, chunk) * inside.OUTWARDS)

    def picture(self, units: Units, name: str = "", path: str | Path | None = None) -> Any:
        """What `plot` draws."""
        return plot_dragged(self, path, units)

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        return RenamedKeys(
            super().summary(),
            friction=self.friction,
            tangential=list(self.tangential),
            stick_area=self.stick_area,
            slip_area=self.slip_area,
            friction_work=self.friction_work,
        )

    def columns(self) -> dict[str, Array]:
        """Fields (nx, ny) on the cells by name."""
        (tx, ty), (sx, sy) = self.traction, self.slip
        return {**super().columns(), "traction_x": tx, "traction_y": ty, "slip_x": sx, "slip_y": sy}

    @property
    def _printed(self) -> dict[str, float]:
        return {
            **super()._printed,
            "friction": self.friction,
            "tangential force x": self.tangential[0],
            "tangential force y": self.tangential[1],
            **self._motions,
            "stick area": self.stick_area,
            "slip area": self.slip_area,
            "work of friction": self.friction_work,
        }

    @property
    def _motions(self) -> dict[str, float]:
        """Printed motions by their words."""
        return {}

    @property
    def _reports(self) -> tuple[object, ...]:
        return self.solver, self.tangential_solver


class TimeError(NamedTuple):
    """Relative errors by the steps in time.

    Attributes
    ----------
    pressure : float
        Of the pressure over the contact (L2 norm).
    force : float
        Of the force at a given approach; zero where it is given.
    """

    pressure: float
    force: float

    def __str__(self) -> str:
        return f"error by the steps in time: pressure about {percent(self.pressure)}, force {percent(self.force)}"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warning of a large error, with the number of steps that reduces it."""
        if not max(self) > MAX_TIME_ERROR:
            return ()
        times = math.ceil(math.sqrt(max(self) / MAX_TIME_ERROR))
        return (
            f"The pressure may be off by about {percent(self.pressure)} and the force by {percent(self.force)}, by the "
            f"steps in time. Take about {times} times as many, most where loads have changed last.",
        )


@compact_repr
@dataclass(frozen=True, eq=False)
class FrictionContact(TractionContact):
    """Contact of a half-space with a rigid surface, with friction, at the end of a step of a load path.

    Made by `HalfSpace.press` with `friction`, and by `HalfSpace.press_path`; see `TractionContact`. Slip is that during
    the step.

    Attributes
    ----------
    shift : (float, float)
        Displacement of the counter-surface along x and y since the unloaded state.
    twist : float
        Its rotation about the normal since the unloaded state.
    parts : tuple of FrictionContact
        Of a step that was cut: the ends of its parts before the last, to which slip and solver belong. Work and sliding
        are of all.
    time : float
        At the end of the step; zero unless steps have times.
    retarded : (n, 3, nx, ny) array or None
        Of a visco-elastic half-space: what each term of its creep remembers of tractions and pressures.
    time_change : (1 + n, nx, ny) array, optional
        Of a visco-elastic half-space: estimated changes of the pressures, and of what each term remembers of them, by
        small steps in time.
    worn : (nx, ny) array, optional
        Worn depth of both surfaces together since the path began; None without wear.
    wear_change : (nx, ny) array, optional
        Estimated change of the worn depth by smaller steps.
    cycles : float, optional
        How often the step was passed; work and sliding are of one passage, the last.
    origin : FrictionContact, optional
        With wear: state from which slip is counted, in a steady cycle its other end.
    """

    shift: tuple[float, float]
    twist: float
    parts: tuple[FrictionContact, ...] = field(default=(), repr=False)
    time: float = 0.0
    retarded: Array | None = field(default=None, repr=False)
    time_change: Array | None = field(default=None, kw_only=True, repr=False)
    worn: Array | None = field(default=None, kw_only=True, repr=False)
    wear_change: Array | None = field(default=None, kw_only=True, repr=False)
    cycles: float | None = field(default=None, kw_only=True, repr=False)
    origin: FrictionContact | None = field(default=None, kw_only=True, repr=False)

    dissipated, work = renamed("dissipated", "friction_work"), renamed("work", "work_density")
    friction_residuals = renamed("friction_residuals", "residuals")

    @property
    def motion(self) -> Array:
        """Shift and twist (3,)."""
        return np.array([*self.shift, self.twist])

    @property
    def _parts(self) -> tuple[TractionContact, ...]:
        return self.parts

    @property
    def worn_volume(self) -> float:
        """Volume worn off since the path began; zero without wear."""
        return 0.0 if self.worn is None else float(self.worn.sum()) * self.grid.area

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures by name, with worn volume and largest worn depth where it wears."""
        if self.worn is None:
            return super().figures
        return {**super().figures, "worn_volume": self.worn_volume, "worn_depth": float(self.worn.max())}

    @property
    def wear_error(self) -> float:
        """Estimated error of the worn depth by the size of the steps, over the largest depth; zero without wear."""
        if self.worn is None or self.wear_change is None or not self.worn.any():
            return 0.0
        return float(np.abs(self.wear_change).max() / self.worn.max())

    @property
    def time_error(self) -> TimeError | None:
        """Estimated errors by the steps in time, see `viscoelastic`; None unless the half-space remembers."""
        if self.time_change is None:
            return None
        change, size = self.time_change[0], float(np.linalg.norm(self.pressure)) or 1.0
        force = abs(float(change.sum())) * self.grid.area
        return TimeError(float(np.linalg.norm(change)) / size, force / (self.force or 1.0))

    @property
    def warnings(self) -> tuple[str, ...]:
        """As of a contact without friction, and of steps that are large for their wear or what they remember."""
        late = () if self.time_error is None else self.time_error.warnings
        return *super().warnings, *wear_warnings(self.wear_error), *late

    def columns(self) -> dict[str, Array]:
        """Fields (nx, ny) on the cells by name."""
        return {**super().columns(), **({} if self.worn is None else {"worn": self.worn})}

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        more: dict[str, Any] = {} if self.worn is None else {"wear_error": self.wear_error}
        more |= {} if self.time_error is None else {"time_error": self.time_error._asdict()}
        return RenamedKeys(super().summary(), shift=list(self.shift), **more)

    @property
    def _reports(self) -> tuple[object, ...]:
        return *super()._reports, *(() if self.time_error is None else (self.time_error,))

    @property
    def _motions(self) -> dict[str, float]:
        return {"shift x": self.shift[0], "shift y": self.shift[1]}

    @property
    def _printed(self) -> dict[str, float]:
        turned = {"torque": self.torque, "twist": self.twist} if self.twist or self.torque else {}
        names = () if self.worn is None else ("worn_volume", "worn_depth")
        wear = {name.replace("_", " "): self.figures[name] for name in names}
        return {**super()._printed, **turned, **wear}
