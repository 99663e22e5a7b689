"""Plane and axisymmetric elastic bodies: sections in the x-z plane, at about a hundredth of the cost of a solid model.

Both are elastic bodies with y held (`fem.section_model`) and are used in scenes like solids. A plane body has the
rigid motions x, z and ry; forces are those on its thickness. A body of revolution (x is the radius, z the axis) has the
axial motion, with torsion also the rotation about its axis; forces, areas and resultants are those of the whole ring.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.elastic import ON_NODE, ElasticBody
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import flag
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.fem.laws import Law, at_rest
from fecontact.fem.model import AnyMaterial
from fecontact.fem.section_model import SectionModel, on_axis
from fecontact.fem.support import symmetry_planes
from fecontact.mesh.section_mesh import Extent, SectionMesh
from fecontact.surfaces.section_curve import CurveSurface

STATES = ("strain", "stress")


@dataclass(frozen=True, eq=False)
class SectionBody(ElasticBody):
    """Base of plane and axisymmetric bodies; make a `PlaneBody` or an `AxisymmetricBody`."""

    pressures: ClassVar = ("sides",)
    meshes: ClassVar = SectionMesh

    mesh: SectionMesh  # type: ignore[assignment]
    material: AnyMaterial | Law | Mapping[str, AnyMaterial] | Mapping[str, Law]
    contact: str | Sequence[str] = ()
    supports: Mapping[str, str] = field(default_factory=dict)
    pressure: str = field(default="sides", init=False, repr=False)
    name: str = "body"
    backend: str = "auto"
    integration: str = "auto"
    condensation: str = field(default="auto", init=False, repr=False)
    pose: Pose = field(default_factory=Pose)
    geometry: str = field(default="plain", init=False, repr=False)

    def _checked_mesh(self, names: tuple[str, ...]) -> SectionMesh:  # type: ignore[override]
        for name in names:
            self.mesh.boundary_nodes(name)
        return self.mesh

    @property
    def notes(self) -> tuple[str, ...]:
        """What takes a material for isotropic; sections are not read from files."""
        return self._notes_of_materials

    @property
    def _out_of_plane(self) -> Extent:
        """Out-of-plane extent of the section."""
        raise InputError("Make a PlaneBody or an AxisymmetricBody.")

    @property
    def _dimension(self) -> str:
        """'plane', 'axis' or 'twist'."""
        return "twist" if self._out_of_plane.torsion else "axis" if self._out_of_plane.revolved else "plane"

    @property
    def plane_stress(self) -> bool:
        """Whether the state is plane stress."""
        return False

    @property
    def state(self) -> str:
        """State of its elements, in words."""
        return "axisymmetric"

    @cached_property
    def model(self) -> SectionModel:
        """The finite element model of the section, in the body's own axes; the same object in every pose."""
        return SectionModel(
            self.mesh,
            at_rest(self.material),
            self.supports,
            self._out_of_plane,
            self.plane_stress,
            self.backend,
            self.integration,
            self.conditions,
        )

    def _made_surface(self, facets: IntArray, name: str) -> CurveSurface:
        nodes, across = symmetry_planes(self.mesh, self.supports)
        if self._out_of_plane.revolved:
            axis = on_axis(self.mesh.points, self.size)
            nodes, across = np.append(nodes, axis), np.concatenate([across, np.tile([1.0, 0.0, 0.0], (len(axis), 1))])
        return CurveSurface(self.mesh.points, facets, name, planes=(nodes, across), out_of_plane=self._out_of_plane)

    def _skin(self, points: Array) -> CurveSurface:
        return CurveSurface(
            points, self.mesh.face_nodes(self.mesh.outer_sides), self.name, out_of_plane=self._out_of_plane
        )

    def _size_lines(self, twin: str = "") -> list[str]:
        """Report lines, including the reduction to a section."""
        return [*super()._size_lines(twin), f"{self.name}: a section instead of a solid"]

    def describe(self) -> str:
        """One-line description of the model."""
        m = self.mesh
        return self._described(f"{m.size_line}{self._ties}, {self.state}, {self.n_unknowns} dofs{self._law_words}")


@compact_repr
@dataclass(frozen=True, eq=False)
class PlaneBody(SectionBody):
    """A linear elastic body in plane strain or plane stress.

    Parameters
    ----------
    mesh : SectionMesh
    material : Material, or mapping of element set to Material
        Or `OrthotropicMaterial`, `AnisotropicMaterial`, whose axes are those of space, y across the section.
    contact : str or sequence of str
        Boundaries that may come into contact.
    supports : mapping of boundary name to components, optional
        ``"x"``, ``"z"`` or ``"xz"``; see `ElasticBody`.
    name : str, optional
    backend : {'auto', 'pardiso', 'rslab', 'superlu'}
    integration : {'auto', 'full', 'selective'}
        Selective reduced integration against locking in plane strain; 'auto' chooses it for Poisson's ratios above
        0.48. Plane stress does not lock.
    thickness : float
        Thickness along y. Forces, areas and contact weights are those of the whole thickness; unit thickness unless
        given.
    plane : {'strain', 'stress'}

    Raises
    ------
    InputError, MeshError

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    >>> body = fc.PlaneBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    >>> round(float(result.contacts[0].force[2]), 12)
    0.01
    """

    thickness: float = 1.0
    plane: str = "strain"

    def __post_init__(self) -> None:
        among("plane", self.plane, STATES)
        positive("the thickness", self.thickness)
        if self.plane_stress and self.integration == "selective":
            raise InputError("Plane stress does not lock: integration='selective' has no meaning there.", code="stress")
        super().__post_init__()

    @property
    def _out_of_plane(self) -> Extent:
        """The thickness."""
        return Extent(float(self.thickness))

    @property
    def plane_stress(self) -> bool:
        """Whether the state is plane stress."""
        return self.plane == "stress"

    @property
    def state(self) -> str:
        """State of its elements, in words."""
        return f"plane {self.plane}, thickness {self.thickness:g}"

    @property
    def contact_modulus(self) -> float:
        """E / (1 - nu^2) of the softest material; E in plane stress."""
        return min(m.E if self.plane_stress else m.plane_strain_modulus for m in self.model.materials)


@compact_repr
@dataclass(frozen=True, eq=False)
class AxisymmetricBody(SectionBody):
    """A linear elastic body of revolution about the z axis under axial loads; its section has x as the radius.

    Parameters
    ----------
    mesh : SectionMesh
        At x >= 0. Nodes on the axis are held radially.
    material : Material, or mapping of element set to Material
        Or `OrthotropicMaterial`, `AnisotropicMaterial`, whose axes are those of space, y across the section.
    contact : str or sequence of str
        Boundaries that may come into contact.
    supports : mapping of boundary name to components, optional
        ``"x"`` (radial), ``"z"`` or ``"xz"``, with torsion also ``"y"`` (circumferential); see `ElasticBody`.
    name, backend, integration
        As in `ElasticBody`.
    torsion : bool
        Whether it can be twisted: a circumferential displacement at every node, along y in the plane of the section,
        the rotation rz, moments about the axis, and friction with a circumferential component. All bodies of revolution
        of a scene have it or none has.

    Raises
    ------
    InputError, MeshError

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.sections.rectangle((1.0, 1.0), (2, 2))
    >>> body = fc.AxisymmetricBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    >>> round(float(result.contacts[0].force[2]) / 3.141592653589793, 12)
    0.01
    """

    torsion: bool = False

    def __post_init__(self) -> None:
        flag("torsion", self.torsion)
        super().__post_init__()

    @property
    def _out_of_plane(self) -> Extent:
        """Circumference."""
        return Extent(None, self.torsion)

    @property
    def state(self) -> str:
        """State of its elements, in words."""
        return "axisymmetric with torsion" if self.torsion else "axisymmetric"

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """One row (1, n_dofs) for the displacement at a node along a direction.

        Raises
        ------
        InputError
            If the point is not a node.
        """
        nearest, distance = self._nearest(point)
        if distance > ON_NODE * self.size:
            raise InputError(
                f"The point {np.array2string(point, precision=4)} lies on no node of {self.name!r}; the nearest is "
                f"{np.array2string(self._initial_points[nearest], precision=4)}."
            )
        return super().attachment(point, direction)
