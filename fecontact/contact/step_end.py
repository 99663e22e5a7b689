"""End of a load step: all that the next one begins from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar, cast

import numpy as np

from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.contact.interface import Interface, UnilateralConstraints

#: Share of new candidates up to which those of the last step are used: what is missing is found by the certificate,
#: and other candidates would need another factorisation.
FEW_NEW = 0.05

T = TypeVar("T", bound=np.ndarray[Any, Any])


@compact_repr
@dataclass(frozen=True, eq=False)
class StepEnd:
    """End of a load step of a scene: what is not given is empty.

    Attributes
    ----------
    poses : tuple of Pose
        Of all bodies, whose displacements are relative to them.
    q, forces : (m,) and (N,) arrays
        Solution: rigid motions and contact forces, normal and tangential.
    chosen : sequence of int arrays
        Candidates of each interface of a scene, to which the forces belong.
    contact, nodes : (n,) int arrays
        Contact and slave node of each point of the contacts of a scene with friction. Those of a later step may be
        others, where bodies slide over a rim.
    displacement : (n, 3) array
        Displacement of these points against the master since the unloaded state, in the master's axes, which carry it
        along where both bodies turn; without the rigid motion that poses have. The slip of the next step is measured
        from it.
    pressed : (n,) bool array
        Points with a normal force.
    change : (n,) array
        Estimated change of the points' friction forces by smaller load steps; zero where they have slid since.
    worn, wearing : mapping of int to (n_nodes,) array
        By the number of each contact that wears, at all nodes of its slave, see `Interface`. Its slip is sought without
        friction too.
    """

    poses: tuple[Pose, ...] = ()
    q: Array = field(default_factory=lambda: np.zeros(0))
    forces: Array = field(default_factory=lambda: np.zeros(0))
    chosen: Sequence[IntArray] = ()
    contact: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    nodes: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    displacement: Array = field(default_factory=lambda: np.zeros((0, 3)))
    pressed: Mask = field(default_factory=lambda: np.zeros(0, bool))
    change: Array = field(default_factory=lambda: np.zeros(0))
    worn: Mapping[int, Array] = field(default_factory=dict)
    wearing: Mapping[int, Array] = field(default_factory=dict)

    def worn_shapes(self, interfaces: Sequence[Interface]) -> list[Interface]:
        """Contacts with their worn depths and with what wears off in the step."""
        out = list(interfaces)
        for k, depth in self.worn.items():
            nodes = out[k].pairing.nodes
            wearing = self.wearing[k][nodes] if k in self.wearing else None
            out[k] = replace(out[k], worn=depth[nodes], wearing=wearing)
        return out

    def of(self, contact: int, values: T, nodes: IntArray) -> T:
        """Some of its values (n, ...) at nodes (m,) of a contact; zero or no where there is none."""
        own = self.contact == contact
        return at_nodes(values[own], self.nodes[own], nodes)

    def candidates(self, conditions: Sequence[UnilateralConstraints], chosen: Sequence[IntArray]) -> list[IntArray]:
        """Candidates together with those of this end, where the points are the same; the latter if few are new."""
        out = list(chosen)
        for k in np.unique(self.contact):
            contact = conditions[k].as_contact
            if contact is not None and np.array_equal(contact.pairing.nodes, self.nodes[self.contact == k]):
                last, both = self.chosen[k], np.union1d(out[k], self.chosen[k])
                out[k] = last if len(both) <= (1 + FEW_NEW) * len(last) else both
        return out

    def start(self, chosen: Sequence[IntArray], n_forces: int, n_motions: int) -> tuple[Array, Array] | None:
        """Forces and motions to begin with; None where the candidates are others."""
        same = len(chosen) == len(self.chosen) and all(map(np.array_equal, chosen, self.chosen))
        fits = same and (len(self.forces), len(self.q)) == (n_forces, n_motions)
        return (self.forces, self.q) if fits else None

    @classmethod
    def read(cls, row: Mapping[str, Any]) -> StepEnd:
        """A step's end from its fields, as `common.path.unpacked` finds them."""
        return cls(**{**row, "poses": tuple(Pose(**pose) for pose in row["poses"])})


def at_nodes(values: T, nodes: IntArray, wanted: IntArray) -> T:
    """Values (n, ...) at nodes (n,) for other nodes (m,); zero where there is none."""
    out = np.zeros((max(nodes.max(initial=0), wanted.max(initial=0)) + 1, *values.shape[1:]), values.dtype)
    out[nodes] = values
    return cast(T, out[wanted])
