"""What acts on an assembly at one load level or at one time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from fecontact.ancf.bricks.loads import Follower
from fecontact.ancf.system.assembly import Assembly
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

#: Share of a prescribed motion that is rounding.
FREE = 1e-8
#: Stages by load level or time.
StageAt = Callable[[float], "Stage"]


@dataclass(frozen=True, eq=False)
class Stage:
    """Assembly, loads and prescribed motions at one load level (statics) or time (dynamics).

    Parameters
    ----------
    assembly : Assembly
        The same solids at every level; supports may differ, rigid bodies may move.
    forces : (n_dofs,) array or None
        Dead loads.
    motion : (n_dofs,) array or None
        Prescribed change of the supported coordinates from the initial ones; zero in all others. Of a state at
        coordinates q that is ``assembly.held(q - assembly.q0)``.
    follow : sequence of FollowerPressure, Moment or other Follower
        Loads that change with the deformation.

    Raises
    ------
    InputError
        For arrays that do not fit or are not finite, a motion of what the supports leave free, and loads that follow on
        what has no gradients.

    Examples
    --------
    >>> import fecontact as fc
    >>> from fecontact.ancf import AncfSolid, AncfSpace, FollowerPressure
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    >>> cube = AncfSolid(AncfSpace(mesh), fc.Material(E=1.0, nu=0.3))
    >>> a = Assembly.of([cube], [{"bottom": "xyz"}])
    >>> stage = Stage(a, follow=[FollowerPressure(0, "top", 0.1)])
    >>> float((a.translation(np.array([0.0, 0.0, 1.0])) @ stage.load(a.q0)).round(12))
    -0.1
    """

    assembly: Assembly
    forces: Array | None = None
    motion: Array | None = None
    follow: Sequence[Follower] = ()

    def __post_init__(self) -> None:
        n = self.assembly.n_dofs
        for name in ("forces", "motion"):
            given = getattr(self, name)
            if given is not None and (np.shape(given) != (n,) or not np.isfinite(given).all()):
                raise InputError(
                    f"The {name} of a stage must be {n} finite numbers, one per coordinate of its assembly; found the "
                    f"shape {np.shape(given)}{'' if np.shape(given) != (n,) else ' with numbers that are not finite'}.",
                    code="stage-shape",
                )
        if self.motion is not None:
            a, motion = self.assembly, np.asarray(self.motion)
            if a.largest_change(motion - a.held(motion)) > FREE * a.largest_change(motion):
                raise InputError(
                    "The motion of a stage moves coordinates that the supports of its assembly leave free: hold them, "
                    "or give assembly.held(motion), which leaves them where equilibrium has them.",
                    code="motion-not-held",
                )
        _ = self._followed

    @cached_property
    def _followed(self) -> list[tuple[Follower, Any, slice]]:
        """Loads that follow, with the spaces or structures that they act on, and their coordinates."""
        a, out = self.assembly, []
        for load in self.follow:
            member = a.solids[load.solid] if 0 <= load.solid < len(a.solids) else None
            carrier = getattr(member, "space", member)
            if getattr(carrier, "gradient_weights", None) is None:
                raise InputError(
                    "A load that follows the deformation acts on a solid of bricks or a structure with gradients; "
                    f"number {load.solid} is none of the {len(a.solids)} members, counted from 0.",
                    code="no-bricks",
                )
            out.append((load, carrier, slice(a.starts[load.solid], a.starts[load.solid + 1])))
        return out

    def remembering(self, memory: Array) -> Stage:
        """The same stage after a memory (n,) of the members."""
        after = self.assembly.remembering(memory)
        return self if after is self.assembly else replace(self, assembly=after)

    def acts_as(self, other: Stage) -> bool:
        """Whether the same loads and motions act on the same assembly; loads that follow are not compared."""
        pairs = (self.forces, other.forces), (self.motion, other.motion)
        same = all(
            one is two or (one is not None and two is not None and np.array_equal(one, two)) for one, two in pairs
        )
        return same and self.assembly is other.assembly and not (self.follow or other.follow)

    def load(self, q: Array) -> Array:
        """Generalised forces (n_dofs,) of all loads at coordinates q."""
        total = np.zeros(self.assembly.n_dofs) if self.forces is None else np.array(self.forces, dtype=float)
        for load, space, own in self._followed:
            total[own] += load.forces(space, q[own])
        return total

    def load_tangent(self, q: Array) -> sp.csr_matrix | None:
        """Their derivative (n_dofs, n_dofs); None for dead loads.

        Symmetric for loads with a potential: pressure on closed surfaces or up to held edges, moments in a plane.
        """
        if not self.follow:
            return None
        n = self.assembly.n_dofs
        total = sp.csr_matrix((n, n))
        for load, space, own in self._followed:
            before, after = sp.csr_matrix((own.start,) * 2), sp.csr_matrix((n - own.stop,) * 2)
            total = total + sp.block_diag([before, load.tangent(space, q[own]), after], format="csr")
        return sp.csr_matrix(total)

    def jump(self, q: Array) -> Array:
        """What the supported coordinates of q are still short of their prescribed values (n_dofs,)."""
        a = self.assembly
        return a.held(a.q0 - q if self.motion is None else self.motion + a.q0 - q)


@dataclass(frozen=True, eq=False)
class Start:
    """Where a motion begins: what states of statics and instants of motions have in common.

    Attributes
    ----------
    q : (n_dofs,) array
    v : (n_dofs,) array or None
        Velocities; None at rest.
    forces : (n_multipliers,) array
        Contact forces of all contacts.
    time : float
    memory : (n,) array or None
        Of the members, see `system.memory`; None for virgin ones whose branches are relaxed.
    stored : float
        Energy of their branches.
    """

    q: Array
    v: Array | None
    forces: Array
    time: float
    memory: Array | None = None
    stored: float = 0.0


def rate(at: StageAt, now: Stage, time: float, step: float) -> Array:
    """Velocity (n_dofs,) of the prescribed motion, from the stage now, at `time`, and those up to two steps before it.

    Of second order, exact for motions up to the second power of time; a negative step looks ahead.
    """
    if now.motion is None:
        return np.zeros(now.assembly.n_dofs)
    before, first = at(time - step).motion, at(time - 2 * step).motion
    each = [np.zeros_like(now.motion) if m is None else m for m in (before, first)]
    return now.assembly.held((3 * now.motion - 4 * each[0] + each[1]) / (2 * step))
