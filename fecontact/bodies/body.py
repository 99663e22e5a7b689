"""Bodies of a scene: compliance, rigid motions, contact surfaces, pose.

Other modules use the members of `Body` instead of the class of a body, so that a new kind of body needs no change
there.

The whole outer surface of a body, for checks of overlap.
"""

from __future__ import annotations

import inspect
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.linalg import LinearOperator

from fecontact.bodies.inner_fields import InnerFields
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import text
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.errors import InputError, shown
from fecontact.common.html import cell
from fecontact.common.renamed import FormerNames, warn
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.fem.expansion import Heated
from fecontact.fem.finite_strain import FiniteStrain, State
from fecontact.mesh.section_mesh import Extent
from fecontact.surfaces.facet_surface import Projection, Surface
from fecontact.surfaces.nodal_weights import components_along


@dataclass(frozen=True, eq=False)
class Outside:
    """Outer surface of a body, in its own axes.

    Attributes
    ----------
    points : (n, 3) array
        Points spread over it; none for infinite surfaces.
    surface : Surface or None
        None where it is unknown or encloses no volume.
    length : float
        Size of the body; infinite for a plane.
    radius : float
        Distance from its points within which everything belongs to the body.
    is_bounded : bool
        Whether the body lies within a box round its points.
    depth : float
        Depth behind the surface to which a point is known to be inside.
    may_hold : function (points, radius) -> mask, optional
        Whether a ball round a point may reach into the body, where projections do not decide it.
    """

    points: Array
    surface: Surface | None
    length: float
    radius: float = 0.0
    is_bounded: bool = False
    depth: float = np.inf
    may_hold: Callable[[Array, float], Mask] | None = None


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


class Body(FormerNames):
    """A body of a scene. All arrays are in its own axes; the pose is separate from them.

    A kind of body defines the abstract members. Those that begin with an underscore are asked by the package alone;
    they have defaults: nodal displacements, no mesh, and no loads on boundaries.

    Attributes
    ----------
    name : str
        For messages and tables.
    pose : Pose
    is_rigid : bool
    """

    name: str
    pose: Pose
    is_rigid = False
    #: Whether a surface node is displaced by its own pressure only.
    _is_foundation = False
    #: Whether parts of it are tied to each other, so that it is a problem without any contact.
    _is_tied = False
    #: Whether its contact surface is a window, placed and fitted when a scene is solved, see `scene.windows`.
    _has_window = False

    def __init_subclass__(cls) -> None:
        """A body that defines a default under its former name is understood, with a warning."""
        for name in [n for n in vars(cls) if n != "described" and f"_{n}" in vars(Body)]:
            warn(f"{cls.__name__}.{name} is now _{name}; the old name will be removed.", stacklevel=3)
            setattr(cls, f"_{name}", vars(cls)[name])

    @property
    @abstractmethod
    def contact(self) -> Sequence[str]:
        """Names of its contact surfaces."""

    @property
    @abstractmethod
    def n_dofs(self) -> int:
        """Number of generalised displacements."""

    @property
    @abstractmethod
    def size(self) -> float:
        """Length that scales rotations to translations."""

    @property
    @abstractmethod
    def reference_point(self) -> Array:
        """Reference point (3,) of rotations and moments."""

    @property
    @abstractmethod
    def contact_modulus(self) -> float:
        """E / (1 - nu^2) of the softest material, infinite for a rigid body; for estimates only."""

    @property
    @abstractmethod
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""

    @property
    @abstractmethod
    def free_motions(self) -> Array:
        """Rigid motions (6, k) that the body's supports do not resist."""

    @abstractmethod
    def surface(self, name: str) -> Surface:
        """A contact surface."""

    @abstractmethod
    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a point (3,) along a direction (3,)."""

    @abstractmethod
    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance and response along rows (n, n_dofs), under external loads (n_dofs,)."""

    @abstractmethod
    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces (n,) along rows and external loads."""

    @abstractmethod
    def describe(self) -> str:
        """One-line description of the model."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its mesh or surface was read."""
        return ()

    def _trace(self, projection: Projection, directions: Array) -> sp.csr_matrix:
        """Rows (n, n_dofs) for the displacement at closest points along directions (n, 3), interpolated from nodes."""
        assert projection.weights is not None
        return components_along(projection.weights, directions)

    def placed(
        self,
        translation: ArrayLike | Pose = (0.0, 0.0, 0.0),
        rotation: ArrayLike | None = None,
        name: str | None = None,
    ) -> Self:
        """The same body rotated about the world's origin by `rotation` (3, 3), then translated by `translation`.

        Stiffness, factor and surfaces are shared by both. A plane body stays in the plane y = 0: it rotates about y, or
        by pi about an axis in the plane. A body of revolution stays on its axis: it is translated along z, or rotated
        by pi about x.

        Parameters
        ----------
        translation : (3,), or a Pose that holds both, optional
        rotation : (3, 3), optional
        name : str, optional
            Name of the copy; unchanged unless given.

        Returns
        -------
        Body
            A body of the same class.

        Examples
        --------
        >>> import fecontact as fc
        >>> floor = fc.RigidBody(fc.Plane(), name="floor")
        >>> floor.placed((0.0, 0.0, -1.0), name="cellar").pose.translation
        array([ 0.,  0., -1.])
        >>> floor.placed(fc.Pose(translation=(0.0, 0.0, -2.0))).pose.translation
        array([ 0.,  0., -2.])
        """
        if isinstance(translation, Pose):
            if rotation is not None:
                raise InputError("A Pose has a rotation already: give the pose alone.", code="two-rotations")
            rotation, translation = translation.rotation, translation.translation
        pose = self.pose.then(np.eye(3) if rotation is None else rotation, translation)
        other = object.__new__(type(self))
        # bodies are frozen; set before the copy escapes
        named = self.name if name is None else text("the name of a body", name)
        vars(other).update(vars(self) | {"pose": pose, "name": named})
        return other

    def _repr_html_(self) -> str:
        mesh = getattr(self, "mesh", None)
        return cell(self.describe(), None if mesh is None else mesh.plot)

    def _described(self, what: str) -> str:
        """One-line description with notes."""
        return "; ".join((f"{self.name}: {what}", *self.notes))

    @property
    def _finite_strain(self) -> FiniteStrain | None:
        """Its cells, of a body with a law of finite strain; None for a linear one."""
        return None

    def _linearised(self, state: State, pose: Pose) -> Self:
        """The linear body at a state of finite strain, in a pose; only of bodies with a law."""
        raise InputError(f"{self.name!r} has no law of finite strain.", code="finite-strain")

    @property
    def _inner_forces(self) -> Array | None:
        """Internal forces (n_dofs,) of a body at a state of finite strain; None for others."""
        return None

    def _stiffen(self, rows: sp.csr_matrix) -> float:
        """Give a body at a state springs along rows, see `contact.hold`, in place of others; return their stiffness."""
        raise InputError(f"{self.name!r} has no law of finite strain.", code="finite-strain")

    def _bend(self, stiffness: sp.csr_matrix) -> None:
        """Add a stiffness (n_dofs, n_dofs) of loads that turn with a surface to that of a body at a state."""
        raise InputError(f"{self.name!r} has no law of finite strain.", code="finite-strain")

    @property
    def _deformation(self) -> Array | None:
        """Displacements (n_points, 3) of its mesh by a state of finite strain, in its axes; None where it has none."""
        return None

    def _present(self, point: Array) -> Array:
        """Place (3,) in its axes of a point of its initial shape: another at a state of finite strain."""
        return point

    @property
    def _modulus(self) -> float | None:
        """Young's modulus to which all its displacements are inversely proportional; None where there is none such."""
        return None

    @property
    def _dimension(self) -> str | None:
        """'space', 'plane' or 'axis'; None: compatible with all."""
        return "space"

    @property
    def _out_of_plane(self) -> Extent | None:
        """Out-of-plane extent of a section; None for a body in space."""
        return None

    @property
    def _matrix_free(self) -> bool:
        """Whether the compliance of many rows is an operator, never a matrix."""
        return False

    def _met_by(self, partner: Body) -> Self:
        """The body as it meets a partner in a contact; itself unless its surface follows the partner's."""
        return self

    @property
    def _is_cut_off(self) -> bool:
        """Whether its surface is part of a larger one that is not known, as measured maps are."""
        return False

    @property
    def _farthest(self) -> float:
        """Largest coordinate of its mesh; zero without one."""
        return 0.0

    def _boundary_force(self, name: str, force: Array) -> Array:
        """Nodal forces (n_dofs,) of a resultant (3,) uniform over a boundary.

        Raises
        ------
        InputError
            For a body without boundaries, as from all members on loads of boundaries.
        """
        raise _refused(self, "A force on a boundary")

    def _boundary_traction(self, name: str, field: Callable[[Array, Array], Array]) -> Array:
        """Nodal forces (n_dofs,) of ``field(points (n, 3), outward normals (n, 3)) -> (n, 3)``, all in its axes."""
        raise _refused(self, "A pressure or traction")

    def _over_boundary(self, name: str, values: Array) -> Callable[[Array], Array]:
        """Function of points (n, 3) on a boundary that interpolates values at its nodes (n_nodes, ...)."""
        raise _refused(self, "A pressure or traction")

    def _count_nodes(self, name: str) -> int:
        """Number of nodes of a boundary."""
        raise _refused(self, "A pressure or traction")

    def _point_force(self, point: Array, force: Array) -> Array | None:
        """Nodal forces (n_dofs,) of a force (3,) at a point (3,); None where it acts on the body as a whole."""
        return None

    def _prescribed(self, supports: Mapping[str, Array], values: Array | None) -> Array:
        """Displacements (n_dofs,) that supports (n_nodes, 3) and linear conditions (m,) prescribe, zero elsewhere."""
        raise _refused(self, "A prescribed displacement")

    def _heated(self, change: Callable[[Array], Array]) -> Heated:
        """Forces and free strains of a change of temperature, a function of the points of its mesh."""
        raise _refused(self, "A change of temperature")

    def _body_force(self, field: Callable[[Array], Array]) -> Array | None:
        """Nodal forces (n_dofs,) of forces per mass (n, 3) at points (n, 3); None where they do not act."""
        return None

    @property
    def _weighted_modes(self) -> Array:
        """Nodal forces (n_dofs, 6) of unit accelerations in the rigid motions; InputError for a body without mass."""
        raise _refused(self, "A floating body")

    def _shared_faces(self, one: str, other: str) -> int:
        """Number of common faces of two of its contact surfaces."""
        return int(one == other)

    def _energy_error(
        self, displacement: Array, points: Array, reach: float, heated: Heated | None = None
    ) -> EnergyError:
        """Error of displacements (n_dofs,) in the cells within `reach` of points (n, 3)."""
        return NO_CELLS

    def _outside(self, displacement: Array) -> Outside:
        """Its whole outer surface, displaced by (n_dofs,)."""
        return Outside(np.zeros((0, 3)), None, np.inf)

    def _at_points(self, displacement: Array) -> Array | None:
        """Displacements (n_points, 3) of its mesh's points by generalised ones (n_dofs,); None where it has no mesh."""
        return None

    def _inner_fields(self, displacement: Array, rows: sp.csr_matrix, forces: Array) -> InnerFields | None:
        """Fields inside by displacements (n_dofs,) under forces (n,) along rows; None where it has no mesh."""
        return None

    def _planes_through(self, nodes: IntArray) -> int:
        """Number of its planes of symmetry on which any of these nodes lies."""
        return 0

    def _divided(self, marked: Mapping[str, IntArray], cells: IntArray | None = None) -> Self:
        """The body on a finer mesh: cells at marked facets of its contact surfaces divided; itself if it has none."""
        return self

    def _size_lines(self, twin: str = "") -> list[str]:
        """Report lines on the size that the model represents; `twin` names a body of the same model."""
        return []


def _refused(body: Body, what: str) -> InputError:
    return InputError(
        f"{what} needs an elastic body; {body.name!r} is not. Give the force on the body as a whole.",
        code="needs-elastic-body",
    )


def check_body(body: Body) -> None:
    """Refuse an object that is no body, or lacks members of one; the message names them.

    Raises
    ------
    InputError
    """
    if isinstance(body, type):
        raise InputError(f"{shown(body)} is a class of bodies: make one, such as RigidBody(Plane()).")
    advice = "A subclass of bodies.SurfaceBody needs `facets` and `flexibility` only; docs/extending.md has an example."
    if not isinstance(body, Body):
        raise InputError(
            f"{shown(body)} is no body: its class does not derive from bodies.Body. {advice}", code="no-body"
        )
    needed = [name for name in (*Body.__annotations__, *vars(Body)) if not name.startswith("_")]
    needed += getattr(type(body), "required", ())
    # looked up without evaluation, as some are costly
    found = {name: inspect.getattr_static(body, name, None) for name in needed}
    if missing := [k for k, v in found.items() if v is None or getattr(v, "__isabstractmethod__", False)]:
        raise InputError(f"{shown(body)} is no whole body: it lacks {', '.join(missing)}. {advice}", code="no-body")
