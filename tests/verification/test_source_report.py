"""The report of 1978: its own route beside the package's, and its unequal spheres."""

import numpy as np

import fecontact as fc
from fecontact.app.studies.report import press
from fecontact.app.studies.spheres import CASES, moment_radius
from fecontact.surfaces import Paraboloid


def test_by_the_report_route_and_by_ours(row):
    """A floating sphere of 2.5 cm on one of 25 cm: Gram-Schmidt, dense compliance and Wolfe's simplex, and our route.

    Source: Elangovan 1978, equations 6 to 18, A-2 to A-16; Hertz. Both routes solve the same equations: what differs is
    rounding, 1e-16 times the ratio of the stiffnesses of the largest and smallest cells and the free motion (1e-10).
    The mesh has two rings in the contact radius, hence the percent against Hertz.
    """
    case = CASES["unequal"]
    source, approach = press(case, case.hertz.a, "gram-schmidt", "wolfe")
    ours, _ = press(case, case.hertz.a, "auto", "auto")
    name = "two spheres, by the route of 1978"
    forces = ours.contacts[0].forces
    apart = np.abs(source.contacts[0].forces - forces).max() / forces.max()
    row(name, "forces beside the fast route", 0.0, apart, within=1e-9, dofs=source.n_dofs)
    row(name, "contact radius", case.hertz.a, moment_radius(source.contacts[0]), within=0.03, dofs=source.n_dofs)
    row(name, "approach", case.hertz.approach, approach, within=0.03, dofs=source.n_dofs)


def test_unequal_spheres_as_half_spaces(row):
    """Spheres of 25 and 2.5 cm, 454 kgf, on a grid of cells.

    Source: Elangovan 1978, section IV; Hertz. Bounds are those of a ball on as many cells (docs/half-space.md).
    """
    case, n = CASES["unequal"], 128
    exact = case.hertz
    half = fc.HalfSpace(case.material, size=(3 * exact.a,) * 2, cells=(n, n), against=case.material)
    # the relative curvature: a paraboloid of both
    shape = Paraboloid(1 / sum(1 / r for r in case.radii))
    found = half.press(shape, force=case.force)
    name = "spheres of 25 and 2.5 cm as half-spaces"
    row(name, "pressure at the centre", exact.p0, found.pressure.max(), within=1e-3, dofs=n * n)
    row(name, "approach", exact.approach, found.approach, within=1e-4, dofs=n * n)
    row(name, "contact radius", exact.a, np.sqrt(found.figures["area"] / np.pi), within=2e-3, dofs=n * n)
