"""Elastic layer on a rigid body: an elastic (Winkler) foundation, a fast model of cartilage and liners."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.pose import Pose
from fecontact.bodies.surface_body import SurfaceBody, boundary_surface
from fecontact.common.arguments import instance, spelled, text
from fecontact.common.arrays import Array
from fecontact.common.checks import among, number_array, positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.mesh.check import check_skin
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.surfaces.facet_surface import FacetSurface
from fecontact.surfaces.nodal_weights import contact_weights

LAWS = ("bonded", "frictionless", "uniaxial")


def foundation_modulus(material: Material, law: str = "bonded") -> float:
    """Pressure per strain of a layer much thinner than the contact width.

    Parameters
    ----------
    material : Material
    law : {'bonded', 'frictionless', 'uniaxial'}
        'bonded': no strain along the layer, E (1 - nu)/((1 + nu)(1 - 2 nu)). Infinite for an incompressible material,
        for which a thin bonded layer is not a foundation (see `analytic.layer`); 'frictionless': plane strain,
        E/(1 - nu^2), finite for every nu; 'uniaxial': free to spread, E.

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
    instance("the material of a layer", material, Material)
    among("law", law, LAWS)
    if law == "uniaxial":
        return material.E
    if law == "frictionless":
        return material.plane_strain_modulus
    return material.lame + 2 * material.shear_modulus


@spelled
@compact_repr
@dataclass(frozen=True, eq=False, init=False)
class ElasticLayer(SurfaceBody):
    """A layer of springs on a rigid body whose surface is given by a mesh.

    Every node of the surface is displaced along the line of action in proportion to its own pressure only.

    Parameters
    ----------
    material : Material
    thickness : float or (n_points,) array
        One for all, or one at each point of a `SurfaceMesh`.
    surface_of : (Mesh, str) or SurfaceMesh
        Mesh and the name of its boundary, or a surface, of whose facets the corners count; keyword `surface`.
    law : {'bonded', 'frictionless', 'uniaxial'}
        See `foundation_modulus`.
    name : str, optional

    Raises
    ------
    InputError
        If the thickness is not positive, or the law or boundary is unknown.

    Examples
    --------
    >>> import fecontact as fc
    >>> plate = fc.shapes.block((1.0, 1.0, 0.1), (4, 4, 1), element="hex8")
    >>> layer = fc.ElasticLayer(fc.Material(E=5.0, nu=0.45), thickness=2.0, surface=(plate, "top"))
    >>> layer.describe()
    'layer: elastic layer, thickness 2, 25 nodes'
    """

    material: Material
    thickness: float | Array
    surface_of: tuple[Mesh, str] | SurfaceMesh
    law: str
    name: str
    pose: Pose
    _is_foundation = True  # a node is displaced by its own pressure only

    def __init__(
        self,
        material: Material,
        thickness: float | Array,
        surface: tuple[Mesh, str] | SurfaceMesh,
        law: str = "bonded",
        name: str = "layer",
        pose: Pose | None = None,
    ) -> None:
        if isinstance(surface, SurfaceMesh):
            each = np.broadcast_to(number_array("a layer's thickness", thickness), len(surface.points))
            if not (np.isfinite(each) & (each > 0)).all():
                raise InputError(
                    f"A layer's thickness must be positive; found {each.min():g}.", code="thickness-not-positive"
                )
            thickness = each
        elif isinstance(surface, tuple) and len(surface) == 2 and isinstance(surface[0], Mesh):
            thickness = float(positive("a layer's thickness", cast(float, thickness)))
        else:
            raise InputError(
                "An elastic layer needs surface=(mesh, 'boundary'), the surface that it covers, or a SurfaceMesh."
            )
        text("the name of a layer", name)
        instance("the pose of a layer", pose, (Pose, type(None)))
        foundation_modulus(material, law)
        fields = {"material": material, "thickness": thickness, "surface_of": surface, "law": law, "name": name}
        for key, value in {**fields, "pose": pose or Pose()}.items():
            object.__setattr__(self, key, value)
        if isinstance(surface, tuple):
            check_skin(surface[0], (surface[1],))

    @cached_property
    def facets(self) -> FacetSurface:  # type: ignore[override]
        """Facets of the boundary that it covers."""
        surface = self.surface_of
        if isinstance(surface, tuple):
            return boundary_surface(*surface)
        return FacetSurface(surface.points, surface.facets[:, :4], "surface")

    @property
    def notes(self) -> tuple[str, ...]:
        """Corrections made when its mesh was read."""
        return (self.surface_of[0] if isinstance(self.surface_of, tuple) else self.surface_of).notes

    @property
    def contact_modulus(self) -> float:
        """Modulus of the foundation, for estimates."""
        return foundation_modulus(self.material, self.law)

    @cached_property
    def flexibility(self) -> sp.spmatrix:  # type: ignore[override]
        """Displacements (n_dofs, n_dofs) by unit forces at the same degrees of freedom; zero off the surface.

        Hanging nodes follow from the others, which take their forces.
        """
        areas, ties = contact_weights(self.facets), self.facets.ties
        per_area = self.thickness / foundation_modulus(self.material, self.law)
        nodes = np.divide(per_area, areas, out=np.zeros(len(areas)), where=areas > 0)
        each = sp.diags(nodes, format="csr")
        if ties is not None:
            free = np.setdiff1d(self.facets.nodes, ties.nodes)
            follow = ties.at_nodes(free, ties.weights)
            each = follow @ each[free][:, free] @ follow.T
        return sp.kron(each, sp.eye_array(3), format="csr")

    def describe(self) -> str:
        """One-line description of the model."""
        told = " to ".join(f"{t:g}" for t in sorted({float(np.min(self.thickness)), float(np.max(self.thickness))}))
        return self._described(f"elastic layer, thickness {told}, {len(self.facets.nodes)} nodes")
