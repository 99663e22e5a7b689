"""Two deformable bodies whose surfaces turn together: iterations, and the same equilibrium with the sides swapped."""

from __future__ import annotations

import numpy as np
import pytest

import fecontact as fc
from fecontact.contact.hold import IndefiniteError
from fecontact.scene import finite_strain


def pressed(swap: str = "never", stiffer: float = 1.0, depth: float = 0.5, mu: float = 0.0) -> fc.ContactResult:
    """A rubber tube on a rigid core, pressed into a rubber strip as thick as its wall; plane strain, half."""
    tube = fc.sections.annulus(1.0, 2.0, (6, 2))
    strip = fc.sections.rectangle((3.0, 1.0), (6, 2))
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
    assert step.residual < 1e-8
    assert result.residuals().worst < 1e-8


def test_sides_swapped_give_the_same_force() -> None:
    plain, swapped = (pressed(swap=swap, depth=0.3).contacts[0] for swap in ("never", "always"))
    assert abs(plain.total_force / swapped.total_force - 1) < 1e-2


def test_points_that_slide_turn_too() -> None:
    rough = pressed(mu=0.3)
    assert rough.finite_strain[0].iterations <= 10
    assert rough.contacts[0].friction.sliding.any()


@pytest.mark.parametrize("kind", ["plane", "revolved"])
def test_a_following_pressure_keeps_convergence_quadratic(kind: str) -> None:
    """Rivlin's tube blown up by half: as in `tests/verification/test_finite_strain.py`, by sections."""
    law, inner = fc.NeoHookean(E=1.0, nu=0.499), 1.5
    outer = np.sqrt(1 + (inner**2 - 1) / 4)
    pressure = law.at_rest.shear_modulus * (np.log(inner / outer) + (outer**-2 - inner**-2) / 2)
    if kind == "plane":
        tube = fc.PlaneBody(fc.sections.annulus(1.0, 2.0, (6, 4)), law, "sym_z", {"sym_x": "x", "sym_z": "z"})
    else:
        tube = fc.AxisymmetricBody(fc.sections.ring(1.0, 2.0, 0.5, (4, 2)), law, "bottom", {"bottom": "z", "top": "z"})
    far = fc.RigidBody(fc.Plane()).placed((0, 0, -9.0))
    result = fc.Scene([tube, far], [fc.Contact(tube, far)]).solve(pressures={(tube, "inner"): pressure})
    (step,) = result.finite_strain
    assert step.iterations <= 6
    x = (tube.mesh.points + result.displacement(tube))[tube.mesh.boundary_nodes("inner")]
    across = np.hypot(x[:, 0], x[:, 2]) if kind == "plane" else x[:, 0]
    assert np.abs(across / inner - 1).max() < 3e-3


def test_rubber_that_hardly_changes_its_volume_takes_one_step() -> None:
    """Cells of 20 nodes at nu = .499 under a ball, by 40 % of the height; the last changes fall quadratically."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2), element="hex20")
    body = fc.ElasticBody(mesh, fc.NeoHookean(E=1.0, nu=0.499), "top", {"bottom": "xyz"}, geometry="plain")
    ball = fc.RigidBody(fc.Sphere(1.5)).placed((0.5, 0.5, 1.0))
    result = fc.Scene([body, ball], [fc.Contact(body, ball)]).solve(motions={ball: {"z": -0.4}})
    (step,) = result.finite_strain
    assert step.iterations <= 8
    assert step.residual < 1e-8


def test_tangents_that_are_not_stable_are_damped_to_the_same_equilibrium(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every iteration is refused until its tangent is damped, in the last way alone: the equilibrium is the same."""
    newton, plain, tried = finite_strain._Newton, pressed(depth=0.2), []
    solved, converged = newton._solved, newton.converged

    def stubborn(self, scene, loading, turning):
        if len(self._changes) < 3 and not self._damping:
            raise IndefiniteError("Not stable.")
        return solved(self, scene, loading, turning)

    def noted(self):
        tried.append((self._turning, self._damped))
        return converged(self)

    monkeypatch.setattr(newton, "_solved", stubborn)
    monkeypatch.setattr(newton, "converged", noted)
    monkeypatch.setattr(finite_strain, "HALVINGS", 0)  # a whole step is the smallest
    damped = pressed(depth=0.2)
    assert tried == [(1.0, False), (0.0, False), (1.0, True)]
    assert damped.residuals().worst < 1e-8
    assert abs(damped.contacts[0].total_force / plain.contacts[0].total_force - 1) < 1e-8
    for one, other in zip(damped._condensed.parts, plain._condensed.parts, strict=True):
        K = other.body.model.stiffness
        assert abs(one.body.model.stiffness - K).max() < 1e-6 * abs(K).max()
