"""Rigid bodies: planes, spheres and other surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body, Outside, Reduced
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import file_path, instance, spelled, text, texts
from fecontact.common.arrays import Array
from fecontact.common.checks import number_array, positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.rigid import rigid_modes
from fecontact.mesh.read import read_surface
from fecontact.surfaces import Ellipsoid, Facets, FunctionSurface, HeightMap
from fecontact.surfaces.facet_surface import Projection
from fecontact.surfaces.rigid.shapes import Indenter, heights_of

#: Points along each side of the square on which a rigid surface given by heights is sampled.
ALONG = 33


class RigidShape(Protocol):
    """The surface of a rigid body in its own axes."""

    @property
    def size(self) -> float:
        """A length of the shape."""

    def project(self, points: Array) -> Projection:
        """Projection of points (n, 3)."""


@compact_repr
@dataclass(frozen=True)
class Plane:
    """The plane z = 0; the body fills z <= 0.

    Examples
    --------
    >>> import numpy as np
    >>> Plane().project(np.array([[0.0, 0.0, 2.0]])).gap.tolist()
    [2.0]
    """

    size: float = 1.0

    def __post_init__(self) -> None:
        positive("a plane's size", self.size)

    def project(self, points: Array) -> Projection:
        """Projection along z."""
        normals = np.zeros_like(points)
        normals[:, 2] = 1.0
        projection = points * np.array([1.0, 1.0, 0.0])
        return Projection(projection, normals, points[:, 2].copy(), np.zeros(len(points), bool))


@dataclass(frozen=True)
class Sphere(Indenter):
    """A sphere that touches z = 0 at the origin from above: its centre is at (0, 0, radius).

    Parameters
    ----------
    radius : float
    """

    kind = "sphere"
    radius: float

    def __post_init__(self) -> None:
        positive("a sphere's radius", self.radius)

    @property
    def size(self) -> float:
        """Diameter."""
        return 2 * self.radius

    def heights(self, x: Array, y: Array) -> Array:
        """Heights over the plane z = 0 at coordinates that broadcast together; infinite beyond the radius."""
        r2 = np.asarray(x) ** 2 + np.asarray(y) ** 2
        under = self.radius**2 - r2
        # radius - sqrt(radius^2 - r^2) without cancellation
        return np.where(under >= 0, r2 / (self.radius + np.sqrt(np.maximum(under, 0.0))), np.inf)

    def project(self, points: Array) -> Projection:
        """Projection along the radius; small gaps near the pole are accurate."""
        x, y, z = points.T
        height = z - self.radius
        distance = np.sqrt(x**2 + y**2 + height**2)
        # distance - radius = (x^2 + y^2 + z^2 - 2 z radius) / (distance + radius), without cancellation at the pole
        gap = (x**2 + y**2 + z**2 - 2 * z * self.radius) / (distance + self.radius)
        normals = np.broadcast_to([0.0, 0.0, -1.0], points.shape).copy()  # any direction at the centre
        away = distance > 0
        normals[away] = np.stack([x, y, height], axis=1)[away] / distance[away, None]
        return Projection(points - gap[:, None] * normals, normals, gap, np.zeros(len(points), bool))


def _over(heights: Callable[[Array, Array], Array], size: float) -> Array:
    """Points (n, 3) of a surface sampled over a square, where it exists."""
    t = np.linspace(-0.5, 0.5, ALONG) * size
    x, y = (c.ravel() for c in np.meshgrid(t, t, indexing="ij"))
    z = np.asarray(heights(x, y)) + np.zeros(len(x))
    return np.stack([x, y, z], axis=1)[np.isfinite(z)]


@spelled
@compact_repr
@dataclass(frozen=True, eq=False)
class RigidBody(Body):
    """A rigid body. It is held unless a load or a motion is prescribed for it.

    Parameters
    ----------
    shape : Plane, Sphere or another shape with `project` and `size`
    name : str, optional

    Examples
    --------
    >>> import fecontact as fc
    >>> fc.RigidBody(fc.Plane()).describe()
    'rigid: rigid Plane'
    """

    shape: RigidShape
    name: str = "rigid"
    pose: Pose = field(default_factory=Pose)
    is_rigid = True
    contact: tuple[str, ...] = ("surface",)

    def __post_init__(self) -> None:
        text("the name of a body", self.name)
        instance(f"the pose of {self.name!r}", self.pose, Pose)
        object.__setattr__(self, "contact", texts(f"the surfaces of {self.name!r}", self.contact))
        if isinstance(self.shape, type) or not all(hasattr(self.shape, member) for member in ("project", "size")):
            raise InputError(
                f"The shape of {self.name!r} must have `project` and `size`, such as fc.Plane() or fc.Sphere(10.0); "
                f"found {shown(self.shape)}."
            )

    @classmethod
    def from_heights(cls, z: ArrayLike, size: tuple[float, float], name: str = "rigid") -> RigidBody:
        """The rigid surface z(x, y) over the plane z = 0, its lowest point on the plane.

        Parameters
        ----------
        z : (nx, ny) array_like
            Heights at the centres of equal cells, centred on the origin.
        size : (float, float)
            Sides of the grid.

        Examples
        --------
        >>> import numpy as np
        >>> RigidBody.from_heights(np.eye(4), size=(1.0, 1.0)).describe()
        'rigid: rigid HeightMap'
        """
        return cls(HeightMap(number_array("the heights", z), size), name)

    @classmethod
    def from_surface(
        cls, path: str | Path, scale: float = 1.0, name: str = "rigid", part: str | None = None
    ) -> RigidBody:
        """The rigid surface of a file, in its coordinates; its facets face outwards. See `read_surface` for its types.

        `part` is a shell or a surface by its name in a mesh or deck.

        Corrections by `read_surface` are in `notes`, in `describe` and in the notes of results.

        Examples
        --------
        >>> import fecontact as fc, meshio, numpy as np, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
        ...     meshio.Mesh(points, [("triangle", [[0, 1, 2]])]).write(f"{folder}/one.stl")
        ...     fc.RigidBody.from_surface(f"{folder}/one.stl").describe()
        'rigid: rigid Facets; one.stl: the surface is open: its outside is where the corners of most facets run \
counter-clockwise.'
        """
        return cls(Facets(read_surface(path, part, scale)), name)

    @classmethod
    def from_stl(cls, path: str | Path, scale: float = 1.0, name: str = "rigid") -> RigidBody:
        """The rigid surface of an .stl file, see `from_surface`."""
        if file_path("the path of a surface", path).suffix.lower() != ".stl":
            raise InputError(f"Expected an .stl file; found {str(path)!r}. Others are read by RigidBody.from_surface.")
        return cls.from_surface(path, scale, name)

    @classmethod
    def from_function(cls, z: Callable[[Array, Array], Array], size: float, name: str = "rigid") -> RigidBody:
        """The rigid surface z(x, y), a function of arrays; `size` is a length over which it varies."""
        return cls(FunctionSurface(z, size), name)

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its surface was read."""
        return self.shape.notes if isinstance(self.shape, Facets) else ()

    @property
    def _dimension(self) -> None:
        """None: used with sections, its surface must be constant along y or rotationally symmetric."""
        return None

    @property
    def _is_cut_off(self) -> bool:
        """Whether the surface continues beyond its ends: True for measured maps and open facets."""
        return isinstance(self.shape, HeightMap | Facets)

    @property
    def _farthest(self) -> float:
        """Largest coordinate of the mesh of its surface, if it has one."""
        return float(np.abs(self.shape.mesh.points).max()) if isinstance(self.shape, Facets) else 0.0

    def _outside(self, displacement: Array) -> Outside:
        """Its outer surface, as far as its shape encloses a volume; see `Outside`."""
        shape, size = self.shape, self.size
        if isinstance(shape, Plane):
            return Outside(np.zeros((0, 3)), shape, math.inf)
        if isinstance(shape, Sphere):
            centre = np.array([[0.0, 0.0, shape.radius]])
            return Outside(centre, shape, size, shape.radius, is_bounded=True, depth=size)
        if isinstance(shape, Facets):
            closed = None if shape.is_open else shape
            return Outside(shape.mesh.points, closed, size, is_bounded=True, depth=size)
        heights = heights_of(shape)
        points = np.zeros((0, 3)) if heights is None else _over(heights, size)
        if isinstance(shape, Ellipsoid):
            return Outside(points, shape, size, may_hold=shape.may_hold)
        return Outside(points, shape, size, depth=size)

    def _size_lines(self, twin: str = "") -> list[str]:
        """Report lines."""
        return [f"{self.name}: rigid, nothing to factorise"]

    @property
    def n_dofs(self) -> int:
        """Six: its rigid motions."""
        return 6

    @property
    def size(self) -> float:
        """A length of the shape."""
        return self.shape.size

    @property
    def reference_point(self) -> Array:
        """The origin of its axes."""
        return np.zeros(3)

    @property
    def contact_modulus(self) -> float:
        """Infinite."""
        return math.inf

    @property
    def rigid_modes(self) -> Array:
        """The rigid motions are the generalised displacements."""
        return np.eye(6)

    @property
    def free_motions(self) -> Array:
        """None: a rigid body is held in every component that is not free."""
        return np.zeros((6, 0))

    def surface(self, name: str) -> RigidShape:
        """Its only surface."""
        if name not in self.contact:
            raise InputError(f"A rigid body has the one surface 'surface'; found {name!r}.", code="unknown-surface")
        return self.shape

    def _trace(self, projection: Projection, directions: Array) -> sp.csr_matrix:
        """Rows (n, 6) for the rigid displacement at closest points along directions (n, 3)."""
        modes = rigid_modes(projection.points, np.zeros(3)).reshape(-1, 3, 6)
        return sp.csr_matrix(np.einsum("ni,nic->nc", directions, modes))

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, 6) for the rigid displacement at a point along a direction."""
        return sp.csr_matrix(direction @ rigid_modes(point[None, :], np.zeros(3)))

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """No compliance."""
        return Reduced(None, np.zeros(rows.shape[0]))

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """No elastic displacement."""
        return np.zeros(6)

    def describe(self) -> str:
        """One-line description of the model."""
        return self._described(f"rigid {type(self.shape).__name__}")
