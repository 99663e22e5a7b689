"""End of a load step: all that friction carries on to the next one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.one_line import one_line
from fecontact.contact.interface import UnilateralConstraints

#: Share of new candidates up to which those of the last step serve: what is missing is found by the certificate, and
#: other candidates would need another factorisation.
FEW_NEW = 0.05


@one_line
@dataclass(frozen=True, eq=False)
class Moved:
    """Displacement of the slave's points against the master, at the end of a load step.

    Attributes
    ----------
    nodes : (n,) int array
        Slave nodes of the points: those of a later step may be others, where bodies slide over a rim.
    by : (n, 3) array
        Since the unloaded state, in the master's axes, which carry it along where both bodies turn. Without the rigid
        motion that poses have.
    pressed : (n,) bool array
        Points with a normal force.
    change : (n,) array, optional
        Estimated change of the points' friction forces by smaller load steps; zero where they have slid since, and by
        default.
    """

    nodes: IntArray
    by: Array
    pressed: Mask
    change: Array | None = None

    @property
    def changes(self) -> Array:
        """`change`, in numbers."""
        return np.zeros(len(self.nodes)) if self.change is None else self.change

    def at(self, nodes: IntArray) -> tuple[Array, Mask]:
        """Displacement (m, 3) at nodes (m,) and whether they were pressed; zero and no where it is not known."""
        out, pressed = np.zeros((len(nodes), 3)), np.zeros(len(nodes), bool)
        known = np.isin(nodes, self.nodes)
        order = np.argsort(self.nodes)
        place = order[np.searchsorted(self.nodes, nodes[known], sorter=order)]
        out[known], pressed[known] = self.by[place], self.pressed[place]
        return out, pressed


@one_line
@dataclass(frozen=True, eq=False)
class StepEnd:
    """End of a load step.

    Attributes
    ----------
    poses : tuple of Pose
        Poses of the scene's bodies.
    moved : mapping of int to Moved
        By the number of each contact with friction.
    chosen : sequence of int arrays
        Candidates of each interface.
    forces, motion : (N,) and (m,) arrays
        Solution of the condensed problem, from which the next one begins.
    """

    poses: tuple[Pose, ...]
    moved: Mapping[int, Moved] = field(default_factory=dict)
    chosen: Sequence[IntArray] = ()
    forces: Array = field(default_factory=lambda: np.zeros(0))
    motion: Array = field(default_factory=lambda: np.zeros(0))

    def candidates(self, conditions: Sequence[UnilateralConstraints], chosen: Sequence[IntArray]) -> list[IntArray]:
        """Candidates together with those of the last step, where the points are the same; the latter if few are new."""
        out = list(chosen)
        for k, moved in self.moved.items():
            contact = conditions[k].as_contact
            if contact is not None and np.array_equal(contact.pairing.nodes, moved.nodes):
                last, both = self.chosen[k], np.union1d(out[k], self.chosen[k])
                out[k] = last if len(both) <= (1 + FEW_NEW) * len(last) else both
        return out

    def start(self, chosen: Sequence[IntArray], n_forces: int, n_motions: int) -> tuple[Array, Array] | None:
        """Forces and motion to begin with; None where the candidates are others."""
        same = len(chosen) == len(self.chosen) and all(map(np.array_equal, chosen, self.chosen))
        fits = same and (len(self.forces), len(self.motion)) == (n_forces, n_motions)
        return (self.forces, self.motion) if fits else None

    def as_dict(self) -> dict[str, Any]:
        """The same in lists, for a file."""
        return {
            "poses": [[p.rotation.tolist(), p.translation.tolist()] for p in self.poses],
            "moved": {
                str(k): [v.tolist() for v in (m.nodes, m.by, m.pressed, m.changes)] for k, m in self.moved.items()
            },
            "chosen": [c.tolist() for c in self.chosen],
            "forces": self.forces.tolist(),
            "motion": self.motion.tolist(),
        }

    @classmethod
    def from_dict(cls, given: Mapping[str, Any]) -> StepEnd:
        """The inverse of `as_dict`."""
        return cls(
            tuple(Pose(np.array(q), np.array(t)) for q, t in given["poses"]),
            {
                int(k): Moved(np.array(n, np.int64), np.reshape(m, (-1, 3)), np.array(pressed, bool), np.array(change))
                for k, (n, m, pressed, change) in given["moved"].items()
            },
            [np.array(c, dtype=np.int64) for c in given["chosen"]],
            np.array(given["forces"], dtype=float),
            np.array(given["motion"], dtype=float),
        )
