"""Two deformable bodies whose surfaces turn together: iterations, and the same equilibrium with the sides swapped."""

from __future__ import annotations

import numpy as np
import pytest

import fecontact as fc


def pressed(swap: str = "never", stiffer: float = 1.0, depth: float = 0.5, mu: float = 0.0) -> fc.ContactResult:
    """A rubber tube on a rigid core, pressed into a rubber strip as thick as its wall; plane strain, half."""
    tube = fc.sections.annulus(1.0, 2.0, (8, 3))
    strip = fc.sections.rectangle((3.0, 1.0), (8, 3))
    law, below = fc.NeoHookean(E=1.0, nu=0.4), fc.NeoHookean(E=stiffer, nu=0.4)
    upper = fc.PlaneBody(tube, law, contact="outer", supports={"inner": "xz", "sym_x": "x"}, name="tube")
    upper = upper.placed((0, 0, 2.0), rotation=np.diag([1.0, -1, -1]))
    lower = fc.PlaneBody(strip, below, contact="top", supports={"bottom": "xz", "left": "x"}, name="strip")
    lower = lower.placed((0, 0, -1.0))
    scene = fc.Scene([upper, lower], [fc.Contact(upper, lower, friction=mu, swap=swap, coupling="mortar")])
    return scene.solve(motions={upper: {"z": -depth}})


@pytest.mark.parametrize("stiffer", [0.2, 1.0, 5.0])
def test_two_soft_bodies_take_one_step_of_few_iterations(stiffer: float) -> None:
    result = pressed(stiffer=stiffer)
    (step,) = result.finite_strain
    assert step.iterations <= 9
    assert step.residual < 1e-6
    assert result.residuals().worst < 1e-8


def test_sides_swapped_and_friction_have_the_same_few_iterations() -> None:
    plain, swapped = (pressed(swap=swap).contacts[0] for swap in ("never", "always"))
    assert abs(plain.total_force / swapped.total_force - 1) < 1e-3
    rough = pressed(mu=0.3)
    assert rough.finite_strain[0].iterations <= 10
    assert rough.contacts[0].friction.sliding.any()
