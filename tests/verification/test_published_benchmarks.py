"""Benchmarks of contact that other programs publish figures of."""

import math

import numpy as np
import pytest

import fecontact as fc


@pytest.mark.parametrize("level", [1, 3])
def test_roller_on_a_block(level, row):
    """A steel roller on a block of aluminium, plane strain, 35 kN per mm: peak pressure and half-width.

    Source: A. W. A. Konter, Advanced Finite Element Contact Benchmarks, FENET-UNOTT-DLE-09, 2005 (NAFEMS R0094),
    benchmark 1, R = 50 mm on 200 mm x 200 mm; Hertz gives 3585 MPa and 6.21 mm.
    """
    steel, aluminium = fc.Material(210e3, 0.3), fc.Material(70e3, 0.3)
    force, radius, a = 35e3, 50.0, 6.21
    cap = fc.sections.half_disc(radius, contact_radius=a, level=level)
    flat = fc.sections.cap(math.inf, 100.0, 200.0, contact_radius=a, level=level)
    roller = fc.PlaneBody(cap, steel, "cap", {"base": "z", "sym_x": "x"}, name="roller")
    block = fc.PlaneBody(flat, aluminium, "cap", {"base": "xz", "sym_x": "x"}, name="block")
    block = block.placed(rotation=fc.rotation_about((1, 0, 0), math.pi))
    result = fc.Scene([roller, block], [fc.Contact(roller, block)]).solve(forces={roller: (0, 0, -force / 2)})
    case = f"NAFEMS contact benchmark 1, level {level}"
    row(case, "max_pressure [MPa]", 3585.37, result.contacts[0].max_pressure, within=2e-3, dofs=result.n_dofs)
    row(case, "half-width [mm]", 6.2146, result.contacts[0].area, within=3e-3, dofs=result.n_dofs)


@pytest.mark.parametrize("mu", [0.1, 0.2, 0.3])
def test_block_pushed_up_a_wedge(mu, row):
    """The force that pushes a block up a wedge over the weight on it, tan(alpha) = .1, on meshes that do not match.

    Source: Q. Feng & N. K. Prinja, NAFEMS Benchmark Tests for Finite Element Modelling of Contact, Gap and Sliding,
    R0081, 2001, CGS-4: F/G = (tan(alpha) + mu) / (1 - mu tan(alpha)), .412371 at mu = .3; statics, on any mesh.
    """
    material, weight = fc.Material(206e3, 0.3), 1000.0
    upper = fc.PlaneBody(fc.sections.rectangle((4.0, 2.0), (6, 3)), material, "bottom", {"top": "xz"}, name="block")
    base = fc.sections.rectangle((6.0, 1.5), (7, 2)).translated((-1, 0, -1.5))
    lower = fc.PlaneBody(base, material, "top", {"bottom": "xz"}, name="wedge")
    tilt = fc.rotation_about((0, 1, 0), -math.atan(0.1))
    block, wedge = upper.placed(rotation=tilt), lower.placed(rotation=tilt)
    scene = fc.Scene([block, wedge], [fc.Contact(block, wedge, friction=mu)])
    steps = [{"forces": {block: (0, 0, -weight)}, "motions": {block: {"x": along}}} for along in (0.0, 0.01)]
    force = scene.solve_path(steps)[-1].contacts[0].force
    exact = (0.1 + mu) / (1 - 0.1 * mu)
    row(f"NAFEMS CGS-4, mu = {mu:g}", "F/G", exact, abs(force[0]) / abs(force[2]), within=1e-9)
    assert np.abs(force[2]) == pytest.approx(weight, rel=1e-10)
