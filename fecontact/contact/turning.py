"""How contact forces turn with the surfaces they press on: the second variation of the gap in the tangent.

At a closed point the gap g = n . (x_s - x_m), with the master's normal n, tangents a_a and curvature b_ab, varies by
(Wriggers, Computational Contact Mechanics, 2nd ed. 2006, section 6.2; Laursen, Computational Contact and Impact
Mechanics, 2002, section 5.2)

    D d g = -(t^a n . du_m,a + dt^a n . Du_m,a + b_ab t^a dt^b),   t^a = a^a . (Du_s - Du_m),

which couples the bodies, while these are condensed one by one. But surfaces that stay in contact turn together,
n . u_m,a + b_ab t^b = n . u_s,a. With that the terms with displacements of both cancel, and a force F adds to each
body, with its own outward normal, tangents and curvature, the stiffness

    K(U, v) = -F [ (n . U,a)(a^a . v) + (n . v,a)(a^a . U) - b_ab (a^a . U)(a^b . v) ].

It is exact where the conditions of contact hold at every point, and an approximation where their weighted means do.
Where the master is rigid or linear, its geometry does not follow its displacements: normals turn with the slave's point
alone, and K = -F U . (dn/dx) v. A rigid or linear master that is free to turn takes the slave's surface with it: the
slave has the stiffness of two bodies with laws. A point that sticks has none: it stays on its material point.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from fecontact.common.arrays import Array, IntArray
from fecontact.contact.coupling.mortar import quadrature
from fecontact.contact.coupling.nodal import facets_at_nodes
from fecontact.contact.interface import Interface
from fecontact.surfaces.facet_surface import FacetSurface, Projection, Surface, own_facets, with_nodes
from fecontact.surfaces.nodal_weights import components_along
from fecontact.surfaces.normals import field_derivative, normal_derivative


def turning_stiffness(surface: FacetSurface, facet: IntArray, local: Array, forces: Array) -> sp.csr_matrix:
    """Stiffness (n_dofs, n_dofs) of forces (n,) that press on points of a surface in contact."""
    _, _, at, sloped, dual = _rows(surface, facet, local)
    normals, turned = field_derivative(surface, facet, local)
    half = sp.csr_matrix((3 * at.shape[1], 3 * at.shape[1]))
    for a in range(2):
        turn = components_along(sloped[a], normals)
        turn = turn + components_along(at, turned[..., a] / 2)
        half = half - components_along(at, dual[..., a]).T @ sp.diags_array(forces) @ turn
    return sp.csr_matrix(half + half.T)


def _rows(
    surface: FacetSurface, facet: IntArray, local: Array
) -> tuple[Array, Array, sp.csr_matrix, list[sp.csr_matrix], Array]:
    """Points (n, 3), tangents, weights of nodes, those of both slopes, and the dual tangents (n, 3, 2)."""
    x, tangents, N = surface.evaluate(facet, local)
    slopes = surface.slopes(facet, local)
    dual = np.asarray(np.linalg.pinv(tangents).swapaxes(1, 2), dtype=float)
    return x, tangents, surface.rows_of(facet, N), [surface.rows_of(facet, slopes[..., a]) for a in range(2)], dual


def following_stiffness(surface: FacetSurface, pressure: float) -> sp.csr_matrix:
    """Symmetric part of the stiffness (n_dofs, n_dofs) of a pressure that follows a surface.

    Its force -p n da varies by -p [(div U) n - (n . U,a) a^a] da. What is not symmetric in that is of the rim alone,
    and zero on planes of symmetry (Simo, Taylor & Wriggers, Commun. Appl. Numer. Methods 7 (1991) 513).
    """
    facet, local, weight = quadrature(surface)
    x, tangents, at, sloped, dual = _rows(surface, facet, local)
    across = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    area = np.linalg.norm(across, axis=1)
    outward = np.sign((across * field_derivative(surface, facet, local)[0]).sum(axis=1))
    normals = across * (outward / area)[:, None]
    radial = np.zeros_like(x)
    if surface.revolved:
        radial[:, 0] = 1 / x[:, 0]
    swelling, turns = components_along(at, radial), []
    for a in range(2):
        swelling = swelling + components_along(sloped[a], dual[..., a])
        turns.append((components_along(at, dual[..., a]), components_along(sloped[a], normals)))
    forces = sp.diags_array(pressure * weight * area * surface.extent(x) / 2)
    half = components_along(at, normals).T @ forces @ swelling - sum(b.T @ forces @ t for b, t in turns)
    return sp.csr_matrix(half + half.T)


def turning_with(points: Array, forces: Array) -> Array:
    """Stiffness (3, 3) against rotations of a body of dead forces (n, 3) that move with its points (n, 3).

    A turn t has the moments (t x r) x F, so that K = sum (F . r) I - sym(F r^T), with r from the centre of the turn
    (Simo & Vu-Quoc, Comput. Methods Appl. Mech. Eng. 58 (1986) 79; the symmetric part is that of a conserved moment).
    """
    virial = points.T @ forces
    return np.asarray(np.trace(virial) * np.eye(3) - (virial + virial.T) / 2)


def press(interface: Interface, forces: Array, share: float = 1.0, turns: bool = False) -> None:
    """Add a share of the stiffness of forces (n,) at the contact points to the bodies at a state.

    On a rigid or linear partner all of it; `turns` tells whether that is free to turn.
    """
    pairing = interface.pairing
    pressing = np.asarray(pairing.average.T @ forces)
    used = np.flatnonzero(pressing)
    soft, other = (body._inner_forces is not None for body in (interface.slave, interface.master))
    if not len(used):
        return
    if soft and not other and not turns:
        turn, each = pairing.rotation, np.arange(len(used) + 1)
        master = interface.master
        gradients = normal_gradients(
            master.surface(interface.surfaces[1]), pairing.projection.chosen(used), master.size
        )
        H = -pressing[used, None, None] * (turn.T @ gradients @ turn)
        wide = sp.kron(pairing.slave_weights[used], sp.eye_array(3), format="csr")
        interface.slave._bend(sp.csr_matrix(wide.T @ sp.bsr_matrix((H, each[:-1], each)) @ wide))
    elif soft and share:
        points, facet, local = _on_slave(interface, used)
        parts = share * pressing[points] / np.bincount(points)[points]
        interface.slave._bend(turning_stiffness(interface.slave_surface, facet, local, parts))
    projection = pairing.projection.chosen(used)
    if other and share and projection.facet is not None and projection.local is not None:
        surface = with_nodes(interface.master.surface(interface.surfaces[1]))
        interface.master._bend(turning_stiffness(surface, projection.facet, projection.local, share * pressing[used]))


def _on_slave(interface: Interface, used: IntArray) -> tuple[IntArray, IntArray, Array]:
    """Numbers (k,) of samples, facets (k,) and coordinates (k, 2) of those used; a node is on several facets."""
    pairing = interface.pairing
    if pairing.slave_facet is not None and pairing.slave_local is not None:
        return used, pairing.slave_facet[used], pairing.slave_local[used]
    facet, local, node = facets_at_nodes(interface.slave_surface)
    number = np.full(len(interface.slave_nodes), -1)
    number[pairing.nodes[used]] = used
    kept = np.flatnonzero(number[node] >= 0)
    return number[node[kept]], facet[kept], local[kept]


def normal_gradients(surface: Surface, projection: Projection, size: float) -> Array:
    """Derivatives (n, 3, 3) of a surface's normals by the positions of points, from their projection on it.

    `size` is that of its shape, for differences where it has no facets.
    """
    facets = own_facets(surface)
    if facets is None or projection.facet is None or projection.local is None:
        points = projection.points + projection.gap[:, None] * projection.normals
        return normal_derivative(surface, points, size)
    along = facets.evaluate(projection.facet, projection.local)[1]
    H = field_derivative(facets, projection.facet, projection.local)[1] @ np.linalg.pinv(along)
    return np.asarray(H + H.swapaxes(1, 2)) / 2
