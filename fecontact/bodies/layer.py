"""Elastic layer on a rigid body: an elastic (Winkler) foundation, the fast model of cartilage and liners."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.placed import Placed
from fecontact.bodies.pose import Pose
from fecontact.bodies.protocol import Reduced
from fecontact.common.arrays import Array
from fecontact.common.checks import positive
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem.rigid import rigid_modes
from fecontact.mesh.check import check_skin
from fecontact.mesh.mesh import Mesh
from fecontact.surfaces.facet_surface import FacetSurface, Feet
from fecontact.surfaces.nodal_weights import along, contact_weights

LAWS = ("bonded", "frictionless", "uniaxial")


def foundation_modulus(material: Material, law: str = "bonded") -> float:
    """Pressure per strain of a layer much thinner than the contact is wide.

    Parameters
    ----------
    material : Material
    law : {'bonded', 'frictionless', 'uniaxial'}
        'bonded': no strain along the layer, E (1 - nu)/((1 + nu)(1 - 2 nu)). It grows beyond bounds as the material
        becomes incompressible, where a thin bonded layer is no foundation any more (see `analytic.layer`);
        'frictionless': plane strain, E/(1 - nu^2), finite for every nu;
        'uniaxial': free to spread, E.

    Returns
    -------
    float
        Modulus (force / length^2).

    References
    ----------
    K. L. Johnson, Contact Mechanics, 1985, sections 4.3 and 5.8; L. Blankevoort et al., J. Biomech. 24 (1991) 1019.

    Examples
    --------
    >>> foundation_modulus(Material(E=5.0, nu=0.0))
    5.0
    """
    if law not in LAWS:
        raise InputError(f"Unknown law {law!r}; expected one of {', '.join(map(repr, LAWS))}.")
    if law == "uniaxial":
        return material.E
    if law == "frictionless":
        return material.plane_strain_modulus
    return material.lame + 2 * material.shear_modulus


@dataclass(frozen=True, eq=False, init=False)
class ElasticLayer(Placed):
    """A layer of springs on a rigid body whose surface is given by a mesh.

    Every node of the surface gives along the line of action in proportion to its own pressure, and to no other.

    Parameters
    ----------
    material : Material
    thickness : float
    surface_of : (Mesh, str)
        Mesh and the name of its boundary; keyword `surface`.
    law : {'bonded', 'frictionless', 'uniaxial'}
        See `foundation_modulus`.
    name : str, optional

    Raises
    ------
    InputError
        A thickness that is not positive, an unknown law or boundary.

    Examples
    --------
    >>> import fecontact as fc
    >>> plate = fc.shapes.block((1.0, 1.0, 0.1), (4, 4, 1), element="hex8")
    >>> layer = fc.ElasticLayer(fc.Material(E=5.0, nu=0.45), thickness=2.0, surface=(plate, "top"))
    >>> layer.describe()
    'layer: elastic layer, thickness 2, 25 nodes'
    """

    material: Material
    thickness: float
    surface_of: tuple[Mesh, str]
    law: str
    name: str
    pose: Pose

    def __init__(
        self,
        material: Material,
        thickness: float,
        surface: tuple[Mesh, str],
        law: str = "bonded",
        name: str = "layer",
        pose: Pose | None = None,
    ) -> None:
        positive("a layer's thickness", thickness)
        if not (isinstance(surface, tuple) and len(surface) == 2 and isinstance(surface[0], Mesh)):
            raise InputError("An elastic layer needs surface=(mesh, 'boundary'), the surface that it covers.")
        foundation_modulus(material, law)
        fields = {"material": material, "thickness": float(thickness), "surface_of": surface, "law": law, "name": name}
        for key, value in {**fields, "pose": pose or Pose()}.items():
            object.__setattr__(self, key, value)
        check_skin(surface[0], (surface[1],))

    @cached_property
    def _facets(self) -> FacetSurface:
        mesh, name = self.surface_of
        if mesh.cell_type == "hex20":
            mesh = mesh.with_midface_nodes((name,))
        return FacetSurface(mesh.points, mesh.face_nodes(mesh.faces(name)), name)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was mended in its mesh when that was read."""
        return self.surface_of[0].notes

    @property
    def contact(self) -> tuple[str, ...]:
        """The boundary that it covers."""
        return (self.surface_of[1],)

    @property
    def is_foundation(self) -> bool:
        """A node gives under its own pressure, and no other."""
        return True

    @property
    def n_dofs(self) -> int:
        """Three per node of the mesh."""
        return self._facets.points.size

    @property
    def size(self) -> float:
        """Diagonal of the surface's bounding box."""
        return self._facets.size

    @property
    def reference_point(self) -> Array:
        """Mean of the surface's nodes."""
        return np.asarray(self._facets.points[self._facets.nodes].mean(axis=0))

    @property
    def contact_modulus(self) -> float:
        """Modulus of the foundation, for estimates."""
        return foundation_modulus(self.material, self.law)

    @cached_property
    def rigid_modes(self) -> Array:
        """Displacements (n_dofs, 6) of the rigid motions about the reference point."""
        return rigid_modes(self._facets.points, self.reference_point)

    @property
    def free_motions(self) -> Array:
        """None: the body under the layer is held in every component that is not released."""
        return np.zeros((6, 0))

    @cached_property
    def _flexibility(self) -> Array:
        """Displacement (n_dofs,) by a unit force at the same degree of freedom; zero off the surface."""
        areas = contact_weights(self._facets)
        per_area = self.thickness / foundation_modulus(self.material, self.law)
        nodes = np.divide(per_area, areas, out=np.zeros(len(areas)), where=areas > 0)
        return np.repeat(nodes, 3)

    def surface(self, name: str) -> FacetSurface:
        """Facets of the boundary."""
        if name not in self.contact:
            raise InputError(f"The layer {self.name!r} covers {self.contact[0]!r}; found {name!r}.")
        return self._facets

    def trace(self, feet: Feet, directions: Array) -> sp.csr_matrix:
        """Rows (n, n_dofs) that take the displacement at feet along directions (n, 3)."""
        assert feet.weights is not None
        return along(feet.weights, directions)

    def attachment(self, point: Array, direction: Array) -> sp.csr_matrix:
        """Refused: a point load would sink into a layer of springs without end, or has no point of it to act on.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(f"A spring cannot be fastened to {self.name!r}; fasten it to the ground or to a rigid body.")

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, watch: Stopwatch) -> Reduced:
        """Compliance along rows."""
        with watch("condense"):
            S = (rows @ sp.diags(self._flexibility) @ rows.T).toarray()
            return Reduced(S, np.zeros(rows.shape[0]))

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Displacements (n_dofs,) of the layer's surface under forces along rows."""
        return np.asarray(self._flexibility * (rows.T @ forces))

    def describe(self) -> str:
        """One line: what was modelled."""
        return self._described(f"elastic layer, thickness {self.thickness:g}, {len(self._facets.nodes)} nodes")
