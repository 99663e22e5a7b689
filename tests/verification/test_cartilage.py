"""A rigid ball pressed into thin cartilage on bone: closed form at small strains, felupe's curve at finite ones."""

from __future__ import annotations

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import layer

#: Force over E h^2 by depth over the thickness h, under a ball of radius 4 h on a neo-Hookean layer of radius 6 h; by
#: Poisson's ratio. felupe 11.3.0 (tests/benchmarks/peers/felupe_cartilage.py, settings 64:0.45 and 64:0.49, the latter
#: in 20 load steps for each depth), cells of 4 nodes, penalty with gaps below 2e-5 h; extrapolated by the square of the
#: cells' size from 32 and 64 cells through the thickness, from which they differ by 0.01 % and 0.1 %.
FELUPE = {
    0.45: {0.1: 0.255402, 0.2: 1.051956, 0.3: 2.504239, 0.4: 4.739123},
    0.49: {0.1: 0.291852, 0.2: 1.254982, 0.3: 3.068626, 0.4: 5.906530},
}


def indented(nu: float, radius: float, depth: float, cells: int, element: str = "quad8") -> fc.ContactResult:
    """A layer of thickness 1, bonded to bone, under a ball."""
    r = np.concatenate(
        [np.linspace(0, 2.5, round(2.5 * cells) + 1), 2.5 + 3.5 * np.linspace(0, 1, cells + 1)[1:] ** 1.5]
    )
    mesh = fc.sections.rectangle((6.0, 1.0), (r, cells), element=element)
    cartilage = fc.AxisymmetricBody(mesh, fc.NeoHookean(E=1.0, nu=nu), "top", {"bottom": "xz"}, name="cartilage")
    ball = fc.RigidBody(fc.Sphere(radius), name="ball").placed((0.0, 0.0, 1.0))
    return fc.Scene([cartilage, ball], [fc.Contact(cartilage, ball)]).solve(motions={ball: {"z": -depth}})


@pytest.mark.parametrize("nu", [0.45, 0.49])
def test_small_indentation_of_cartilage(nu: float) -> None:
    """Hayes, Keer, Herrmann & Mockros, J. Biomech. 5 (1972) 541; their equation is that of Lebedev & Ufliand (1958)."""
    law = fc.NeoHookean(E=1.0, nu=nu)
    exact = layer.paraboloid(radius=1e5, thickness=1.0, material=law.at_rest, a=1.0)
    contact = indented(nu, 1e5, exact.approach, 8).contacts[0]
    # strains of 1e-6; cells of an eighth of the contact's radius, whose edge lies in one of them
    assert abs(contact.force[2]) == pytest.approx(exact.force, rel=0.004)
    assert contact.max_pressure == pytest.approx(exact.p0, rel=0.01)


@pytest.mark.parametrize(("nu", "depth"), [(nu, depth) for nu, curve in FELUPE.items() for depth in curve])
def test_deep_indentation_of_cartilage(nu: float, depth: float) -> None:
    result = indented(nu, 4.0, depth, 8)
    assert abs(result.contacts[0].force[2]) == pytest.approx(FELUPE[nu][depth], rel=0.002)
    assert not result.warnings
