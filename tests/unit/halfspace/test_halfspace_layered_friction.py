"""Layered half-spaces under tangential tractions, each against something else."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.halfspace.compliance import tangential_compliance
from fecontact.halfspace.layered import shear_compliance, surface_waves
from fecontact.surfaces import FlatPunch, Paraboloid

SOFT = fc.Material(E=2.0, nu=0.3)
STIFF = fc.Material(E=20.0, nu=0.2)
STACK = [fc.Layer(STIFF, 0.3), fc.Layer(SOFT, 0.2)]
WAVES = np.array([0.01, 0.1, 1.0, 3.0, 10.0])


def products(**options: object) -> object:
    n = options.pop("n", 16)
    size = options.pop("size", 2.0)
    half = fc.HalfSpace(options.pop("base", SOFT), (size, size), (n, n), **options)
    return half, tangential_compliance(half.compliance, (slice(0, n), slice(0, n)))


@pytest.mark.parametrize("base", [SOFT, STIFF, None])
def test_pressures_and_tractions_are_reciprocal(base: fc.Material | None) -> None:
    pressed, sheared = (surface_waves(WAVES, STACK, base, shear=shear) for shear in (False, True))
    assert np.abs(pressed[:, 0] - sheared[:, 1]).max() < 1e-13 * np.abs(pressed).max()


def test_waves_feel_the_top_or_the_base() -> None:
    """Short waves the top layer alone, long ones the base; on a rigid base a stack shears by the sum of h/G."""
    for wave, material in ((1e3, STIFF), (1e-5, SOFT)):
        # the longest wave told apart is 1e4 stacks long: the stiff layer adds 1e-3 there
        alone = shear_compliance(np.array([wave]), [fc.Layer(material, 1.0)], material)
        assert np.abs(shear_compliance(np.array([wave]), STACK, SOFT) / alone - 1).max() < 2e-3
    k = np.array([1e-3])
    sheared = shear_compliance(k, STACK, None)[0, :2] / k
    stack = sum(layer.thickness / layer.material.shear_modulus for layer in STACK)
    np.testing.assert_allclose(sheared, stack, rtol=1e-5)


def test_a_thin_stiff_layer_is_a_membrane() -> None:
    """It adds E' h k^2 to the stiffness along the wave and G h k^2 across; its bending is of higher order.

    The base is incompressible: its pressures and tractions are not coupled. Exact to the order of k h.
    """
    base, h = fc.Material(E=1.0, nu=0.4999999), 1e-3
    k = np.array([1.0])
    layer = fc.Layer(fc.Material(E=1e3, nu=0.3), h)
    along, across, _ = shear_compliance(k, [layer], base)[0]
    G = base.shear_modulus
    assert abs(along * (2 * G + layer.material.plane_strain_modulus * h) - 1) < 5e-3
    assert abs(across * (G + layer.material.shear_modulus * h) - 1) < 5e-3


@pytest.mark.parametrize("periodic", [False, True])
def test_layers_of_the_same_material_change_nothing(periodic: bool) -> None:
    rng = np.random.default_rng(0)
    _, plain = products(periodic=periodic)
    _, layered = products(periodic=periodic, layers=[fc.Layer(SOFT, 0.3), fc.Layer(SOFT, 0.4)])
    q, p = rng.normal(size=(2, 16, 16)), rng.normal(size=(16, 16))
    for name, load in (("apply", q), ("of_pressure", p), ("normal_displacement", q)):
        one, other = getattr(plain, name)(load), getattr(layered, name)(load)
        assert np.abs(one - other).max() < 1e-12 * np.abs(one).max()


def test_free_and_periodic_surfaces_agree() -> None:
    """Hankel transforms and tables of cells, against wave numbers of a period 16 times as wide."""
    half, free = products(n=16, layers=STACK)
    _, periodic = products(n=256, size=32.0, layers=STACK, periodic=True)
    x = half.grid.x
    load = np.exp(-((x[:, None] - 0.1) ** 2 + (x[None] + 0.05) ** 2) / 0.16)
    q, p = np.stack([load, 0.5 * load]), load
    wide_q, wide_p = np.zeros((2, 256, 256)), np.zeros((256, 256))
    wide_q[:, :16, :16], wide_p[:16, :16] = q, p
    for name, one, other in (("apply", q, wide_q), ("of_pressure", p, wide_p), ("normal_displacement", q, wide_q)):
        found = getattr(free, name)(one)
        apart = found - getattr(periodic, name)(other)[..., :16, :16]
        if name == "apply":  # the mean of a periodic surface does not move
            apart -= apart.mean(axis=(1, 2), keepdims=True)
        assert np.abs(apart).max() < 0.015 * np.abs(found).max()


def test_a_stuck_layer_on_a_rigid_base_shears() -> None:
    """Full contact everywhere: the shift is the traction times the sum of h/G."""
    half = fc.HalfSpace(None, (1.0, 1.0), (8, 8), layers=STACK, periodic=True)
    found = half.press(np.zeros((8, 8)), force=1.0, friction=0.5, tangential=(0.3, -0.1))
    stack = sum(layer.thickness / layer.material.shear_modulus for layer in STACK)
    np.testing.assert_allclose(found.shift, [0.3 * stack, -0.1 * stack], rtol=1e-9)


@pytest.mark.by_day("base0-surface0")
@pytest.mark.parametrize(("base", "surface"), [(SOFT, Paraboloid(1.0)), (None, FlatPunch(1.0))])
def test_a_shape_dragged_on_layers_is_certified(base: fc.Material | None, surface: object) -> None:
    half = fc.HalfSpace(base, (3.0, 3.0), (24, 24), layers=[fc.Layer(STIFF, 0.3)])
    steps = [fc.PressStep(force=1.0), fc.PressStep(force=1.0, tangential=(0.15, 0.1))]
    path = half.press_path(surface, steps, friction=0.3)
    assert all(contact.residuals.within(1e-10) for contact in path.steps)
    assert (path.friction_work >= 0).all()
    np.testing.assert_allclose(path.last.tangential, (0.15, 0.1), rtol=1e-9)
    assert 0 < path.last.stick_area < path.last.area


def test_what_would_slide_off_or_is_not_offered_is_refused() -> None:
    loose = fc.HalfSpace(SOFT, (2.0, 2.0), (12, 12), layers=[fc.Layer(STIFF, 0.3, "frictionless")])
    with refused(fc.InputError, "input", "slides off as a whole"):
        loose.press(Paraboloid(1.0), force=0.01, friction=0.3)
    bonded = fc.HalfSpace(SOFT, (2.0, 2.0), (12, 12), layers=[fc.Layer(STIFF, 0.3)])
    with refused(fc.InputError, "stress-with-friction"):
        bonded.press(Paraboloid(1.0), force=0.1, friction=0.3).stress([[0.0, 0.0, -0.1]])
