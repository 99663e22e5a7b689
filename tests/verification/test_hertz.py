"""The main job against Hertz: every case, model and element at its stated accuracy (figures are printed)."""

import dataclasses

import numpy as np
import pytest

import fecontact as fc
from fecontact.spheres import CASES, Spheres, solve_spheres
from fecontact.spherestable import report_table

# pressure L2, centre pressure, contact radius, approach: what the project promises at the default level
PROMISED = {
    ("equal", "two-bodies", "hex20"): (0.015, 0.005, 0.001, 0.01),
    ("equal", "symmetric", "hex20"): (0.015, 0.005, 0.001, 0.01),
    ("unequal", "two-bodies", "hex20"): (0.03, 0.005, 0.005, 0.01),
    ("light", "two-bodies", "hex20"): (0.03, 0.005, 0.005, 0.01),
    ("light", "symmetric", "hex20"): (0.03, 0.005, 0.005, 0.01),
    ("equal", "symmetric", "hex27"): (0.03, 0.005, 0.005, 0.01),
    # the straight-sided 8-node element: 8 % pressure; it is too stiff far from the contact for a claim on the approach
    ("equal", "two-bodies", "hex8"): (0.08, 0.03, 0.005, 0.05),
    ("unequal", "two-bodies", "hex8"): (0.08, 0.03, 0.005, 0.05),
}


@pytest.mark.parametrize(("case", "model", "element"), PROMISED)
def test_default_level_reaches_what_is_promised(case, model, element):
    out = solve_spheres(case, model=model, element=element)
    l2, centre, radius, approach = PROMISED[case, model, element]
    print("\n" + str(out))
    assert abs(out.pressure_l2_error) <= l2
    assert abs(out.errors["centre_pressure"]) <= centre
    assert abs(out.errors["contact_radius"]) <= radius
    assert abs(out.errors["approach"]) <= approach
    certified(out)


def certified(out):
    residuals = out.result.residuals()
    assert abs(residuals.equilibrium) <= 1e-10
    assert abs(residuals.complementarity) <= 1e-10
    assert abs(residuals.tension) <= 1e-10
    assert abs(residuals.penetration) <= 1e-9
    # round-off of a sum of a few hundred forces
    assert abs(out.total_force / out.case.force - 1) <= 1e-10


def test_level_three_is_within_half_a_percent_in_the_centre_and_one_percent_in_the_field():
    out = solve_spheres("equal", level=3)
    print("\n" + str(out))
    assert abs(out.pressure_l2_error) <= 0.01
    assert abs(out.errors["centre_pressure"]) <= 0.005
    certified(out)


def test_symmetric_model_and_two_bodies_agree():
    # the same meshes mirrored: the pairs' normals differ from the mirror plane's by (r/R) and forces by (r/R)^2 = 5e-5
    two, one = (solve_spheres("equal", level=1, model=m) for m in ("two-bodies", "symmetric"))
    assert abs(two.contact_radius / one.contact_radius - 1) <= 2e-4
    assert abs(two.centre_pressure / one.centre_pressure - 1) <= 2e-4
    assert abs(two.approach / one.approach - 1) <= 2e-4


def test_equal_spheres_are_factorised_once():
    out = solve_spheres("equal", level=1)
    assert out.result.n_dofs == 2 * out.result.n_dofs_factorised


def test_edge_fit_pays():
    fitted, plain = (solve_spheres("equal", model="symmetric", edge_fit=fit) for fit in (True, False))
    print(f"\nL2 error with edge fit {fitted.pressure_l2_error:.4f}, without {plain.pressure_l2_error:.4f}")
    assert abs(fitted.pressure_l2_error) < abs(plain.pressure_l2_error)


def test_first_pass_knows_the_edge_to_half_a_percent():
    # it has to be better than the 5 % at which the fit still pays
    for case in CASES.values():
        model = "two-bodies"
        out = solve_spheres(case, model=model, level=1)
        error = out.fitted_radius / case.hertz.a - 1
        print(f"\n{case.name}: first pass radius {error:+.3%}")
        assert abs(error) <= 0.005


def test_plain_twenty_node_faces_lose_their_corners():
    # serendipity faces turn uniform pressure into pulling corner forces (-1/12), so no corner node can carry any;
    # the centre is a corner node, and the pressure that is left is far from Hertz
    out = solve_spheres("equal", model="symmetric", level=1, pressure="nodal")
    assert out.centre_pressure == 0
    assert abs(out.pressure_l2_error) > 0.5
    certified(out)


def test_units_do_not_matter():
    # the same spheres in mm and N, and in m and Pa: pure numbers agree to rounding through the factorisation
    kgf = 9.80665
    base = CASES["equal"]
    steel_mm = fc.Material(base.material.E * kgf / 100, base.material.nu)
    steel_m = fc.Material(base.material.E * kgf * 1e4, base.material.nu)
    cases = [
        base,
        Spheres("mm", (250.0, 250.0), base.force * kgf, steel_mm, "mm", "N"),
        Spheres("m", (0.25, 0.25), base.force * kgf, steel_m, "m", "N"),
    ]
    outs = [solve_spheres(c, level=1, model="symmetric") for c in cases]
    ratios = np.array([[o.errors["contact_radius"], o.errors["centre_pressure"], o.pressure_l2_error] for o in outs])
    assert np.abs(ratios - ratios[0]).max() <= 1e-9


@pytest.mark.parametrize("solver", [s for s in fc.available_solvers() if s != "active-set"])
def test_every_solver_finds_the_same_pressure(solver):
    reference = solve_spheres("equal", level=1, model="symmetric", solver="active-set")
    out = solve_spheres("equal", level=1, model="symmetric", solver=solver)
    difference = np.abs(out.contact.forces - reference.contact.forces).max()
    assert abs(difference) <= 1e-8 * reference.contact.forces.max()
    certified(out)


def test_superlu_gives_the_same_answer():
    # two factorisations of one matrix: equal to its condition number (1e6) times rounding
    a, b = (solve_spheres("equal", level=1, model="symmetric", backend=x) for x in ("auto", "superlu"))
    assert np.abs(a.contact.forces - b.contact.forces).max() <= 1e-9 * a.contact.forces.max()


def test_report_table_shows_the_reports_own_figures():
    text = report_table(level=1)
    print("\n" + text)
    assert "9990" in text
    assert "1.7845" in text


def test_bad_options_are_named():
    for options, message in (
        ({"case": "oval"}, "Unknown case 'oval'"),
        ({"element": "tet4"}, "Unknown element 'tet4'"),
        ({"pressure": "mean"}, "Unknown pressure 'mean'"),
        ({"model": "half"}, "Unknown model 'half'"),
        ({"level": 0}, "level must be 1"),
        ({"case": "unequal", "model": "symmetric"}, "needs equal spheres"),
    ):
        with pytest.raises(fc.InputError, match=message):
            solve_spheres(**options)


def test_cases_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        CASES["equal"].force = 1.0
