"""What members remember, and what it does in a step of time: plastic flow, and the branches of visco-elastic ones.

A member's `memory` is a row of numbers, those of plastic flow at its points first, then the internal strains of its
branches. `remembering` gives the member with another one; its energy, forces and tangent are those of a step from it,
which `relaxed` ends at rest and `lapse` in time. A virgin member has zeros.

Kelvin and Voigt's damper t_r D dE/dt and Maxwell's branches g_i D (E - A_i), dA_i/dt = (E - A_i) / t_i, stand beside
the elastic stresses of strains E and moduli D. A step of length h is integrated by the mid-point rule,

    E_m - A_m = (E_m - A_0) / (1 + h/2t_i),    A_1 - A_0 = h/t_i (E_m - A_m),

so that the work of the stresses is exactly the change of the branches' energy (E - A) g D (E - A) / 2 and what is
dissipated, (E_1 - E_0) t_r D (E_1 - E_0) / h + h/t_i (E_m - A_m) g D (E_m - A_m) >= 0.
"""

from __future__ import annotations

import copy
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from fecontact.common.arrays import Array
from fecontact.fem.plastic import MODERATE

if TYPE_CHECKING:
    from fecontact.ancf.bricks.viscosity import Viscosity


@dataclass(frozen=True, eq=False)
class Lapse:
    """What a member's memory does in a step of time.

    Attributes
    ----------
    forces : (n_dofs,) array
        Viscous ones over the step, to be added to those of the energy.
    memory : (n,) array
        At its end.
    lost, stored : float
        Energy lost to viscosity and plastic flow in the step, and that of the branches at its end.
    """

    forces: Array
    memory: Array
    lost: float
    stored: float


@dataclass(frozen=True, eq=False)
class Strained:
    """Strains of a part of a member at its points.

    Attributes
    ----------
    strain : callable
        Strains (n_cells, n_q, m) at coordinates (n_dofs,).
    stress : callable
        Elastic stresses (..., n_cells, n_q, m) of strains of that shape.
    drag : callable
        Stresses (n_cells, n_q, m) of a liquid at coordinates (n_dofs,), by rates of strains of that shape.
    weights : (n_cells, n_q) array
    """

    strain: Callable[[Array], Array]
    stress: Callable[[Array], Array]
    drag: Callable[[Array, Array], Array] | None
    weights: Array

    def work(self, one: Array, other: Array) -> Array:
        """Integrals (...) of the stresses of strains (..., n_cells, n_q, m) by others."""
        return np.asarray(((self.stress(one) * other).sum(axis=-1) * self.weights).sum(axis=(-1, -2)))


class Remembering:
    """What members with plastic flow and viscosity have in common."""

    if TYPE_CHECKING:

        @property
        def n_dofs(self) -> int:
            """Coordinates."""

        @property
        def viscous(self) -> Viscosity | None:
            """Damper and branches."""

    @property
    @abstractmethod
    def n_flowing(self) -> int:
        """Numbers that plastic flow remembers."""

    @abstractmethod
    def flowed(self, q: Array) -> Array:
        """The memory of plastic flow (n,) after a step to coordinates q."""

    @property
    @abstractmethod
    def dissipated(self) -> float:
        """Energy lost to plastic flow up to its memory."""

    @abstractmethod
    def strained(self) -> Sequence[Strained]:
        """Strains of its parts, beside whose elastic stresses a damper and branches may stand."""

    @abstractmethod
    def step_forces(self, q0: Array, q1: Array, stresses: Sequence[Array]) -> Array:
        """Forces (n_dofs,) whose work from q0 to q1 is that of stresses of the parts by the change of their strains."""

    @abstractmethod
    def _share(self) -> None:
        """Make what does not depend on the memory, for others with another one."""

    @property
    @abstractmethod
    def plastic_strain(self) -> Array:
        """Accumulated plastic strain of its points, up to its memory."""

    @property
    def cautions(self) -> tuple[str, ...]:
        """What results should warn of."""
        most = float(self.plastic_strain.max(initial=0.0))
        if most <= MODERATE:
            return ()
        return (
            f"The plastic strain reaches {most:.2g}; strains are additive, as in metals, up to about {MODERATE:g}. In "
            f"tension its yield stress is off by a share of {2 * most:.2g}: trust shapes, not stresses.",
        )

    @property
    def remembers(self) -> bool:
        """Whether its state depends on what was before."""
        return bool(self.n_flowing) or self.viscous is not None

    @cached_property
    def memory(self) -> Array:
        """What it remembers (n,): zeros of a virgin one, unless it is `remembering`."""
        n = 0 if self.viscous is None else len(self.viscous.branches)
        q = np.zeros(self.n_dofs)
        return np.zeros(self.n_flowing + sum(n * part.strain(q).size for part in (self.strained() if n else ())))

    def remembering(self, memory: Array) -> Self:
        """The member after a memory (n,)."""
        self._share()
        other = copy.copy(self)
        other.__dict__["memory"] = memory
        return other

    def relaxed(self, q: Array) -> Array:
        """Its memory (n,) at rest at coordinates q, where all branches are relaxed: A_i = E."""
        n = 0 if self.viscous is None else len(self.viscous.branches)
        each = [np.repeat(part.strain(q)[None], n, axis=0).ravel() for part in (self.strained() if n else ())]
        return np.concatenate([self.flowed(q), *each])

    def lapse(self, q0: Array, q1: Array, h: float) -> Lapse:
        """What its memory does in a step of length h from coordinates q0 to q1."""
        flowed, n = self.flowed(q1), self.n_flowing
        lost = self.remembering(flowed).dissipated - self.dissipated if n else 0.0
        if self.viscous is None:
            return Lapse(np.zeros(self.n_dofs), flowed, lost, 0.0)
        by = self._viscous_lapse(self.viscous, q0, q1, h)
        return replace(by, memory=np.concatenate([flowed, by.memory]), lost=by.lost + lost)

    def _viscous_lapse(self, viscous: Viscosity, q0: Array, q1: Array, h: float) -> Lapse:
        """Of its branches and damper."""
        branches, retardation, start = viscous.branches, viscous.retardation, self.n_flowing
        kept, stresses, lost, stored = [np.zeros(0)], [], 0.0, 0.0
        shares, times = branches.T
        g, t = (c[:, None, None, None] for c in branches.T)
        for part in self.strained():
            E0, E1 = part.strain(q0), part.strain(q1)
            size = len(branches) * E0.size
            A0 = self.memory[start : start + size].reshape(len(branches), *E0.shape)
            start += size
            away = ((E0 + E1) / 2 - A0) / (1 + h / (2 * t))
            A1 = A0 + h / t * away
            rate = retardation / h * (E1 - E0)
            stresses.append(part.stress(rate + (g * away).sum(axis=0)))
            if viscous.newtonian and part.drag is not None:
                dragged = part.drag((q0 + q1) / 2, (E1 - E0) / h)
                stresses[-1] = stresses[-1] + dragged
                lost += float(((dragged * (E1 - E0)).sum(axis=-1) * part.weights).sum())
            lost += float(part.work(rate, E1 - E0) + (shares * h / times * part.work(away, away)).sum())
            stored += float((shares / 2 * part.work(E1 - A1, E1 - A1)).sum())
            kept.append(A1.ravel())
        return Lapse(self.step_forces(q0, q1, stresses), np.concatenate(kept), lost, stored)
