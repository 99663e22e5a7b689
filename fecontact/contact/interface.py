"""Unilateral constraints between bodies: gaps and their dependence on displacements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.body import Body
from fecontact.common.arrays import ROUNDING, Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.contact.coupling.mortar import pair_anywhere
from fecontact.contact.coupling.mortar_basis import has_mortar_basis
from fecontact.contact.coupling.nodal import Pairing, SurfacePair
from fecontact.contact.dimension import opposite
from fecontact.contact.overclosure import SoftContact
from fecontact.contact.rigid_motion import RigidMotionConstraints, after_prescribed
from fecontact.contact.search_region import SearchRadius, SearchRegion
from fecontact.contact.springs import SpringState
from fecontact.surfaces.facet_surface import FacetSurface, has_cells, with_nodes


class UnilateralConstraints(Protocol):
    """Unilateral constraints of the problem: contact pairs or springs."""

    @property
    def gap(self) -> Array:
        """Initial gap (n,)."""

    @property
    def own_compliance(self) -> Array:
        """Gap (n,) due to a unit force on its own row, without the bodies; zero unless overridden."""
        return np.zeros(len(self.gap))

    @property
    def infeasibility_hint(self) -> str:
        """Text for the message where loads cannot be balanced; may be empty."""
        return ""

    @property
    def as_contact(self) -> Interface | None:
        """The paired contact that these are; None for springs and tangential rows."""
        return None

    @property
    def two_sided(self) -> bool:
        """Whether forces of both signs may act: friction."""
        return False

    def spring_states(self, forces: Array, gaps: Array) -> tuple[SpringState, ...]:
        """States of the springs that these are, by forces (n,) and gaps (n,); none for a contact."""
        return ()

    def rows(self, body: Body) -> sp.csr_matrix | None:
        """Opening (n, n_dofs) by the displacements of a body; None if it is not involved."""

    def held(self, rows: IntArray, closed: IntArray, stuck: Sequence[IntArray]) -> Mask:
        """Which of its rows are held, see `contact.hold`: those of closed slave nodes, or of nodes that stick."""
        return np.zeros(len(rows), bool)

    def opening_by(self, frames: Sequence[RigidMotionConstraints]) -> Array:
        """Gap (n,) after the prescribed rigid motions."""
        return after_prescribed(self.gap, self.rows, frames)


class NothingMeets(UnilateralConstraints):
    """One gap that stays open: the condition of a scene whose parts are tied only, which has no other."""

    @property
    def gap(self) -> Array:
        """One."""
        return np.ones(1)

    @property
    def own_compliance(self) -> Array:
        """One."""
        return np.ones(1)

    def rows(self, body: Body) -> None:
        """None: no body is involved."""
        return


@compact_repr
@dataclass(frozen=True, eq=False)
class Interface(UnilateralConstraints):
    """A paired contact: slave points with their closest points, and the gap's dependence on displacements.

    Attributes
    ----------
    slave, master : Body
        Bodies after a possible swap.
    surfaces : (str, str)
    pairing : Pairing
    note : str
        Note on the two meshes and the coupling.
    region : SearchRegion, optional
        Parts of the surfaces that were paired; None if all of them were.
    search_radius : SearchRadius, optional
        Search radius of the pairing, with the sides in this order.
    worn : (n_pairs,) array, optional
        Worn depth at the points, which opens the gap.
    wearing : (n_pairs,) array, optional
        Depth that wears off in this step by unit pressure: compliances of the points by themselves.
    overclosure : SoftContact, optional
        Law of a soft contact; its overlap, too, is by compliances of the points by themselves.
    lines : (n_pairs,) int array, optional
        Line of that law on which each point is; the first one by default.
    """

    slave: Body
    master: Body
    surfaces: tuple[str, str]
    pairing: Pairing
    note: str
    region: SearchRegion | None = None
    search_radius: SearchRadius | None = None
    worn: Array | None = None
    wearing: Array | None = None
    overclosure: SoftContact | None = None
    lines: IntArray | None = None

    @property
    def gap(self) -> Array:
        """Initial gap (n_pairs,), to which pressure closes it: of a soft contact beyond the start of its line."""
        gap = self.pairing.mixed(self.pairing.gap if self.worn is None else self.pairing.gap + self.worn)
        return gap if self.overclosure is None else gap + self.starts

    @property
    def starts(self) -> Array:
        """Overclosures (n_pairs,) at which the lines of the points of a soft contact have no pressure."""
        return self._of_lines(1)

    def _of_lines(self, which: int) -> Array:
        """Compliances (0) or starts (1) of the points' lines, (n_pairs,)."""
        assert self.overclosure is not None
        values = self.overclosure.lines[which]
        n = len(self.pairing.mixed(self.pairing.gap))
        return np.asarray(values[np.zeros(n, np.int64) if self.lines is None else self.lines])

    def pressures(self, forces: Array) -> Array:
        """Pressures (n_pairs,) by forces (n_pairs,) of the points."""
        return np.asarray(forces / self.pairing.areas_of_means(self.pairing.weights))

    def on_lines(self, forces: Array) -> Interface | None:
        """The same on the lines that forces (n_pairs,) belong to; None where they are its own."""
        if self.overclosure is None or len(self.overclosure.lines[0]) == 1:
            return None
        pressure = self.pressures(forces)
        before = np.zeros(len(pressure), np.int64) if self.lines is None else self.lines
        lines = self.overclosure.line(pressure, before)
        return None if np.array_equal(lines, before) else replace(self, lines=lines)

    @property
    def own_compliance(self) -> Array:
        """Depth (n_pairs,) that wears off, or by which a soft contact gives, by a unit force of each point."""
        if self.wearing is None and self.overclosure is None:
            return super().own_compliance
        by_pressure = 0.0 if self.wearing is None else self.pairing.mixed(self.wearing)
        by_pressure += 0.0 if self.overclosure is None else self._of_lines(0)
        return np.asarray(by_pressure / self.pairing.areas_of_means(self.pairing.weights))

    def worn_off(self, forces: Array) -> Array:
        """Depth (n_pairs,) that wears off in this step by forces (n_pairs,) on the points."""
        return self.pairing.unmixed(self.own_compliance * self.pairing.areas_of_means(forces))

    @cached_property
    def pointwise(self) -> Interface | None:
        """The same with a force at every sample of its faces in place of nodes or pressures; None: it has none."""
        pairing, surface = self.pairing, self.slave_surface
        if pairing.coupling != "mortar" and has_mortar_basis(surface) and not has_cells(surface):
            master = self.master.surface(self.surfaces[1])
            both = surface, master, pairing.rotation, pairing.translation
            pairing = pair_anywhere(SurfacePair(*both, share=pairing.share))
        if pairing.coupling != "mortar" or pairing.sums is not None:
            return None
        return replace(self, pairing=replace(pairing, average=sp.eye(pairing.average.shape[1], format="csr"), mix=None))

    @property
    def infeasibility_hint(self) -> str:
        """Hint that pressures of whole faces have their centres within the rim, where samples were not kept."""
        if self.pairing.coupling != "mortar" or self.pairing.sums is None:
            return ""
        return (
            "If it acts within half a face of the rim of what faces each other, finer faces of "
            f"{self.slave.name!r} there balance it. "
        )

    def reach_hint(self, forces: Array) -> str:
        """How far from contact points forces (n_samples,) at single points act that balance the load."""
        if self.pointwise is None or not forces.any():
            return ""
        single, pairing = self.pointwise.pairing, self.pairing
        samples = (single.slave_weights @ self.slave_nodes)[forces > ROUNDING * forces.max()]
        centres = pairing.mixed(pairing.average @ pairing.slave_weights @ self.slave_nodes)
        away = np.linalg.norm(samples[:, None] - centres, axis=2).min(axis=1).max()
        faces = self.slave_surface.mean_facet_size[single.covered].mean()
        where, points = "nearer to the rim of what faces each other", "the centres of the pressures on whole faces"
        if pairing.coupling != "mortar":
            where, points = "between the nodes that face the other body", "these, the only contact points"
        return (
            f"Forces {where} balance it, up to {away:.2g}, {away / faces:.2g} of a face, from {points}: finer faces of "
            f"{self.slave.name!r} there do. "
        )

    def held(self, rows: IntArray, closed: IntArray, stuck: Sequence[IntArray]) -> Mask:
        """Which of its rows are those of closed slave nodes."""
        return np.isin(self.pairing.nodes[rows], closed)

    @property
    def as_contact(self) -> Interface:
        """This."""
        return self

    @property
    def slave_surface(self) -> FacetSurface:
        """Facets of the slave, in its axes."""
        return with_nodes(self.slave.surface(self.surfaces[0]))

    @property
    def slave_nodes(self) -> Array:
        """Coordinates (n_nodes, 3) of the slave's mesh, in its axes."""
        return self.slave_surface.points

    @cached_property
    def slave_rows(self) -> sp.csr_matrix:
        """Opening by the slave's displacements (n_pairs, n_dofs)."""
        return self.pairing.mixed(self.pairing.rows_on_slave(self.slave, self.surfaces[0]))

    @cached_property
    def master_rows(self) -> sp.csr_matrix:
        """Opening by the master's displacements (n_pairs, n_dofs)."""
        rows = self.pairing.master_rows(self.master)
        if self.slave_surface.revolved and self.master.is_rigid:
            turned = replace(self.pairing, projection=opposite(self.pairing.projection, self.master.pose))
            rows = (rows + turned.master_rows(self.master)) / 2
        return self.pairing.mixed(rows)

    def rows(self, body: Body) -> sp.csr_matrix | None:
        """Opening by the displacements of a body; None if it is not in this contact."""
        if body is self.slave:
            return self.slave_rows
        return self.master_rows if body is self.master else None
