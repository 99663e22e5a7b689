"""Members of a body that a scene uses: compliance, rigid motions, contact surfaces."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator

from fecontact.bodies.inner_fields import InnerFields
from fecontact.bodies.outside import Outside
from fecontact.bodies.pose import Pose
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, shown
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.energy_error import EnergyError
from fecontact.mesh.section_mesh import Extent
from fecontact.surfaces.facet_surface import Projection, Surface


@dataclass(frozen=True, eq=False)
class Reduced:
    """Compliance and load response of a body along the rows of a contact problem.

    Attributes
    ----------
    compliance : (n, n) array, LinearOperator or None
        Displacements along the rows by unit forces along the rows, without rigid motion; None: rigid.
    response : (n,) array
        Displacements along the rows by the external loads, without rigid motion.
    """

    compliance: Array | LinearOperator | None
    response: Array


class Body(Protocol):
    """Interface of bodies in a scene. All arrays are in the body's own axes.

    Members from `is_rigid` on have defaults in `answers.Answers`, the base of user-defined bodies.
    """

    @property
    def name(self) -> str:
        """Name for messages and tables."""

    @property
    def pose(self) -> Pose:
        """Pose of the body."""

    @property
    def contact(self) -> Sequence[str]:
        """Names of its contact surfaces."""

    @property
    def n_dofs(self) -> int:
        """Number of generalised displacements."""

    @property
    def size(self) -> float:
        """Length that scales rotations to translations."""

    @property
    def reference_point(self) -> Array:
        """Reference point (3,) of rotations and moments."""

    @property
    def contact_modulus(self) -> float:
        """E / (1 - nu^2) of the softest material, infinite for a rigid body; for estimates only."""

    @property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""

    @property
    def free_motions(self) -> Array:
        """Rigid motions (6, k) that the body's supports do not resist."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its mesh or surface was read."""

    def surface(self, name: str) -> Surface:
        """A contact surface."""

    def trace(self, projection: Projection, directions: Array) -> sp.csr_matrix:
        """Rows (n, n_dofs) for the displacement at closest points along directions (n, 3)."""

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a point (3,) along a direction (3,)."""

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance and response along rows (n, n_dofs), under external loads (n_dofs,)."""

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces (n,) along rows and external loads."""

    def describe(self) -> str:
        """One-line description of the model."""

    @property
    def is_rigid(self) -> bool:
        """Whether the body is rigid."""

    @property
    def dimension(self) -> str | None:
        """'space', 'plane' or 'axis'; None: compatible with all."""

    @property
    def out_of_plane(self) -> Extent | None:
        """Out-of-plane extent of a section; None for a body in space."""

    @property
    def matrix_free(self) -> bool:
        """Whether the compliance of many rows is an operator, never a matrix."""

    @property
    def is_placed(self) -> bool:
        """Whether its contact surface is known before a scene is solved; False: see `scene.windows`."""

    def met_by(self, partner: Body) -> Self:
        """The body as it meets a partner in a contact; itself unless its surface follows the partner's."""

    @property
    def is_foundation(self) -> bool:
        """Whether a surface node is displaced by its own pressure only."""

    @property
    def is_cut_off(self) -> bool:
        """Whether its surface is part of a larger one that is not known, as measured maps are."""

    @property
    def farthest(self) -> float:
        """Largest coordinate of its mesh; zero without one."""

    def boundary_force(self, name: str, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a resultant (3,) uniform over a boundary; InputError without boundaries."""

    def boundary_traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points (n, 3), outward normals (n, 3)) -> (n, 3)``, all in its axes."""

    def over_boundary(self, name: str, values: Array) -> Callable[[Array], Array]:
        """Function of points (n, 3) on a boundary that interpolates values at its nodes (n_nodes, ...)."""

    def count_nodes(self, name: str) -> int:
        """Number of nodes of a boundary."""

    def point_force(self, point: Array, force: Array) -> Array | None:
        """Nodal forces (n_dofs,) of a force (3,) at a point (3,); None where it acts on the body as a whole."""

    def body_force(self, gravity: Array) -> Array | None:
        """Nodal forces (n_dofs,) of gravity (3,); None where it does not act."""

    @property
    def weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions; InputError for a body without mass."""

    def shared_faces(self, one: str, other: str) -> int:
        """Number of common faces of two of its contact surfaces."""

    def energy_error(self, displacement: Array, points: Array, reach: float) -> EnergyError:
        """Error of displacements (n_dofs,) in the cells within `reach` of points (n, 3)."""

    def outside(self, displacement: Array) -> Outside:
        """Its whole outer surface, displaced by (n_dofs,)."""

    def at_points(self, displacement: Array) -> Array | None:
        """Displacements (n_points, 3) of its mesh's points by generalised ones (n_dofs,); None where it has no mesh."""

    def inner_fields(self, displacement: Array, rows: sp.csr_matrix, forces: Array) -> InnerFields | None:
        """Fields inside by displacements (n_dofs,) under forces (n,) along rows; None where it has no mesh."""

    def planes_through(self, nodes: IntArray) -> int:
        """Number of its planes of symmetry on which any of these nodes lies."""

    def divided(self, marked: Mapping[str, IntArray], cells: IntArray | None = None) -> Self:
        """The body on a finer mesh: cells at marked facets of its contact surfaces divided; itself if it has none."""

    def size_lines(self, twin: str = "") -> list[str]:
        """Report lines on the size that the model represents; `twin` names a body of the same model."""


def check_body(body: Body) -> None:
    """Refuse an object that lacks members of a body; the message names them.

    Raises
    ------
    InputError
    """
    members = (*(name for name in vars(Body) if not name.startswith("_")), *getattr(type(body), "required", ()))
    if isinstance(body, type):
        raise InputError(f"{shown(body)} is a class of bodies: make one, such as RigidBody(Plane()).")
    nothing = object()
    # looked up without evaluation, as some are costly
    if missing := [name for name in members if inspect.getattr_static(body, name, nothing) is nothing]:
        raise InputError(
            f"{shown(body)} is no body: it lacks {', '.join(missing)}. A subclass of bodies.SurfaceBody needs `facets` "
            "and `flexibility` only; docs/extending.md has an example.",
            code="no-body",
        )
