import numpy as np
import pytest
from refusals import refused

from fecontact import InputError, Material
from fecontact.analytic import cylinder

STEEL = Material(E=210e3, nu=0.3)
BRONZE = Material(E=110e3, nu=0.34)


@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("radii", [(1.0, 2.0), (1.0, 1.0001), (1e-3, 5.0)])
def test_fields_satisfy_the_equations(plane, radii):
    a, b = radii
    tube = cylinder.lame(
        inner_radius=a, outer_radius=b, inner_pressure=30.0, outer_pressure=12.0, material=STEEL, plane=plane
    )
    assert float(tube.radial(a)) == pytest.approx(-30.0, rel=1e-11)
    assert float(tube.radial(b)) == pytest.approx(-12.0, rel=1e-11)
    r, h = (a + b) / 2, 1e-3 * (b - a)
    scale = float(np.abs(tube.hoop(a)))

    def slope(field):
        return float(8 * (field(r + h) - field(r - h)) - field(r + 2 * h) + field(r - 2 * h)) / (12 * h)

    # Fourth-order differences with a step of 1e-3 of the wall: 1e-12 of the field; rounding 1e-16/1e-3 of it.
    tolerance = 1e-10 * scale / (b - a)
    equilibrium = slope(tube.radial) + float(tube.radial(r) - tube.hoop(r)) / r
    assert abs(equilibrium) < tolerance
    radial, hoop, axial = float(tube.radial(r)), float(tube.hoop(r)), float(tube.axial(r))
    E, nu = STEEL.E, STEEL.nu
    assert abs(slope(tube.displacement) - (radial - nu * (hoop + axial)) / E) < tolerance * b / E
    assert float(tube.displacement(r)) / r == pytest.approx((hoop - nu * (radial + axial)) / E, rel=1e-12)
    along = axial - nu * (radial + hoop) if plane == "strain" else axial
    assert along == pytest.approx(0.0, abs=1e-9)


def test_textbook_hoop_stress():
    tube = cylinder.lame(inner_radius=1.0, outer_radius=2.0, inner_pressure=3.0, material=STEEL)
    assert float(tube.hoop(1.0)) == pytest.approx(3.0 * (4 + 1) / (4 - 1), rel=1e-15)  # p (b^2 + a^2)/(b^2 - a^2)
    assert float(tube.hoop(2.0)) == pytest.approx(3.0 * 2 / (4 - 1), rel=1e-15)


def test_thin_wall_is_the_boiler_formula():
    tube = cylinder.lame(inner_radius=1.0, outer_radius=1.0 + 1e-6, inner_pressure=1.0, material=STEEL)
    # p r/t with corrections of order t/r; the radius 1 + 1e-6 itself is rounded to 1e-10 of the wall.
    assert float(tube.hoop(1.0)) == pytest.approx(1e6, rel=1e-6)


def test_solid_disc():
    disc = cylinder.lame(inner_radius=0.0, outer_radius=2.0, outer_pressure=5.0, material=STEEL)
    r = np.array([0.0, 1.0, 2.0])
    np.testing.assert_allclose(disc.radial(r), -5.0, rtol=1e-15)
    np.testing.assert_allclose(disc.hoop(r), -5.0, rtol=1e-15)
    np.testing.assert_allclose(disc.displacement(r), -5.0 * 0.7 * r / 210e3, rtol=1e-14)


@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("bore", [0.0, 0.4])
def test_shrink_fit(plane, bore):
    b, c, d = 1.0, 2.5, 2e-3
    fit = cylinder.shrink_fit(radii=(bore, b, c), materials=(BRONZE, STEEL), interference=d, plane=plane)
    moduli = [(BRONZE.E, BRONZE.nu), (STEEL.E, STEEL.nu)]
    if plane == "strain":
        moduli = [(E / (1 - nu**2), nu / (1 - nu)) for E, nu in moduli]
    (Ei, ni), (Eo, no) = moduli
    # VERIFICATION 9.
    give = ((c**2 + b**2) / (c**2 - b**2) + no) / Eo + ((b**2 + bore**2) / (b**2 - bore**2) - ni) / Ei
    assert fit.pressure == pytest.approx(d / (b * give), rel=1e-13)
    closed = float(fit.outer.displacement(b) - fit.inner.displacement(b))
    assert closed == pytest.approx(d, rel=1e-13)
    assert float(fit.outer.radial(b)) == pytest.approx(-fit.pressure, rel=1e-14)
    assert float(fit.inner.radial(b)) == pytest.approx(-fit.pressure, rel=1e-14)
    assert "Shrink fit" in str(fit)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: cylinder.lame(inner_radius=2.0, outer_radius=1.0, material=STEEL),
            ("input", "inner_radius < outer_radius"),
        ),
        (lambda: cylinder.lame(inner_radius=-1.0, outer_radius=1.0, material=STEEL), ("input", "0 <= inner_radius")),
        (
            lambda: cylinder.lame(inner_radius=0.0, outer_radius=1.0, material=STEEL, inner_pressure=1.0),
            ("input", "solid disc"),
        ),
        (
            lambda: cylinder.lame(inner_radius=0.5, outer_radius=1.0, material=STEEL, plane="thin"),
            ("unknown-plane", "'thin'"),
        ),
        (
            lambda: cylinder.lame(inner_radius=0.5, outer_radius=1.0, material=STEEL).radial(2.0),
            ("radius-outside", "2.0"),
        ),
        (
            lambda: cylinder.shrink_fit(radii=(0.5, 1.0), materials=(STEEL, STEEL), interference=1.0),
            ("input", "three radii"),
        ),
        (
            lambda: cylinder.shrink_fit(radii=(0.5, 1.0, 2.0), materials=(STEEL, STEEL), interference=0.0),
            ("not-positive", "The interference"),
        ),
    ],
)
def test_bad_input_is_named(make, message):
    with refused(InputError, *message):
        make()
