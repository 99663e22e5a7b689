"""Result of pressing and dragging a rigid surface on a half-space with friction."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arrays import Array, Mask
from fecontact.common.errors import InputError
from fecontact.common.one_line import one_line
from fecontact.common.renamed import RenamedKeys, renamed
from fecontact.common.units import Units
from fecontact.halfspace import inside
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.grid_error import edge_area, edge_cells
from fecontact.solvers.coulomb import friction_limit, sticks


@dataclass(frozen=True)
class TangentialReport:
    """Statistics of the tractions.

    Attributes
    ----------
    turns : int
        Turns of pressures and tractions.
    newton : int
        Newton steps on the finest grid.
    nit : int
        Steps of conjugate gradients on the finest grid.
    seconds : float
        For the step, pressures included.
    """

    turns: int
    newton: int
    nit: int
    seconds: float


@one_line
@dataclass(frozen=True, eq=False)
class FrictionContact(HalfSpaceContact):
    """Contact of a half-space with a rigid surface, with friction, at the end of a step of a load path.

    Made by `HalfSpace.press` with `friction`, and by `HalfSpace.press_path`. Tractions act on the half-space, slip is
    its motion against the counter-surface; so slip opposes the traction.

    Attributes
    ----------
    friction : float
        Coulomb's mu.
    traction : (2, nx, ny) array
        Tangential tractions along x and y.
    slip : (2, nx, ny) array
        Slip along x and y during the step; zero where nothing touches at its end.
    shift : (float, float)
        Displacement of the counter-surface along x and y since the unloaded state.
    twist : float
        Its rotation about the normal since the unloaded state.
    position : (float, float)
        Where the counter-surface's own origin is.
    residuals : Residuals
        Recomputed from the problem, relative; in those of friction forces are over the largest pressure, displacements
        over the largest normal one, loads over the normal force.
    tangential_solver : TangentialReport
    parts : tuple of FrictionContact
        Of a step that was cut: the ends of its parts before the last, to which slip and solver belong. Work and sliding
        are of all.
    """

    friction: float
    traction: Array
    slip: Array
    shift: tuple[float, float]
    twist: float
    position: tuple[float, float]
    tangential_solver: TangentialReport
    parts: tuple[FrictionContact, ...] = field(default=(), repr=False)

    @cached_property
    def tangential(self) -> tuple[float, float]:
        """Tangential force along x and y, on the half-space by the counter-surface."""
        x, y = self.traction.sum(axis=(1, 2)) * self.grid.area
        return float(x), float(y)

    @cached_property
    def torque(self) -> float:
        """Torque of the tractions about the normal through `position`."""
        x, y = self.grid.x[:, None] - self.position[0], self.grid.y[None, :] - self.position[1]
        return float((x * self.traction[1] - y * self.traction[0]).sum()) * self.grid.area

    @cached_property
    def slipping(self) -> Mask:
        """Cells (nx, ny) in contact whose traction is at its limit mu p."""
        return self.active & ~sticks(self.traction, friction_limit(self.friction, self.pressure))

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
        left = self.friction * self.pressure - np.hypot(self.traction[0], self.traction[1])
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
        """Work of friction in the step, per area (nx, ny), not negative."""
        own = np.asarray(-(self.traction * self.slip).sum(axis=0))
        return sum((part.work_density for part in self.parts), start=own)

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
            return sum((part.sliding_integral for part in self.parts), start=own)
        return self.work_density / self.friction

    dissipated, work = renamed("dissipated", "friction_work"), renamed("work", "work_density")
    friction_residuals = renamed("friction_residuals", "residuals")

    def stress(self, points: ArrayLike, chunk: int = 200_000) -> Array:
        """Stress (n, 6) inside the half-space by pressures and tractions, see `HalfSpaceContact.stress`.

        Raises
        ------
        InputError
            If a point lies outside, or the half-space is periodic or layered.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3), size=(3.0, 3.0), shape=(32, 32))
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

    def plot(self, path: str | Path | None = None, *, length: str = "", force: str = "", stress: str = "") -> Any:
        """Picture of what sticks and slips, with arrows along the tractions, and of the tractions' size.

        Parameters and errors as in `HalfSpaceContact.plot`.
        """
        from fecontact.halfspace.pictures import plot_dragged

        return plot_dragged(self, path, Units(length, force, stress))

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        return RenamedKeys(
            super().summary(),
            friction=self.friction,
            tangential=list(self.tangential),
            shift=list(self.shift),
            stick_area=self.stick_area,
            slip_area=self.slip_area,
            friction_work=self.friction_work,
        )

    def columns(self) -> dict[str, Array]:
        """Fields (nx, ny) on the cells by name."""
        (tx, ty), (sx, sy) = self.traction, self.slip
        return {**super().columns(), "traction_x": tx, "traction_y": ty, "slip_x": sx, "slip_y": sy}

    def __str__(self) -> str:
        s, report = super().__str__(), self.tangential_solver
        rows = [
            ("friction", self.friction),
            ("tangential force x", self.tangential[0]),
            ("tangential force y", self.tangential[1]),
            ("shift x", self.shift[0]),
            ("shift y", self.shift[1]),
            ("stick area", self.stick_area),
            ("slip area", self.slip_area),
            ("work of friction", self.friction_work),
        ]
        if self.twist or self.torque:
            rows += [("torque", self.torque), ("twist", self.twist)]
        return "\n".join(
            [
                s,
                *(f"  {name:19}{value:>14.6g}" for name, value in rows),
                f"  {report.turns} turns, {report.newton} Newton steps, {report.nit} iterations, "
                f"{report.seconds:.3f} s",
            ]
        )
