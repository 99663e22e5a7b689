"""Estimates of the error held against true errors, on the coarsest and the next mesh of every family of the page."""

import sys
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

import fecontact as fc
from fecontact.analytic import axisymmetric
from fecontact.bodies import AxisymmetricBody
from fecontact.mesh import section_shapes
from fecontact.surfaces import FunctionSurface

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from estimate_cases import CONTACT, HALF_TURN, MODULUS, SOFT, positions
from estimate_runs import runs

#: The first two sizes of every family; the others are in docs/error_estimates.md.
RUNS = [run for _, family in groupby(runs(), key=lambda run: run[0]) for run in list(family)[:2]]
#: Error below which a straight edge along the cells may by chance have nearly none.
BY_CHANCE = 2e-3


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("name", "size", "solve"), RUNS, ids=[f"{name}, {size}" for name, size, _ in RUNS])
def test_estimate_over_error(name, size, solve, row, request):
    """Estimated over true error of the pressure.

    Between 0.8 and 3 is asked for: an estimate below misleads, one above costs time.
    """
    if "gmsh" in name or "tet10" in name:
        request.getfixturevalue("gmsh")
    found = solve()
    ratio = found.estimate / found.error
    largest = 5.0 if "wavy" in name and found.error < BY_CHANCE else 3.0
    row(f"{name}, {size}", "estimate over error", 1.55, ratio, largest / 1.55 - 0.99, found.n_dofs)
    assert 0.8 <= ratio <= largest


@pytest.mark.parametrize("n", [2, 4, 6])
@pytest.mark.parametrize("first", [0.17, 0.1])
def test_peak_and_area_below_a_flat_tip(n, first, row):
    """Estimated over true error of the largest pressure and of the area, half-sections below z = r^n.

    The flatter the tip the nearer the largest pressure is to the edge. Errors that vanish by chance are far below the
    estimate; it is never above that of the pressure.
    """
    rise = 0.02
    exact = axisymmetric.indent(
        modulus=MODULUS, slope=lambda r: rise * n * (r / CONTACT) ** (n - 1) / CONTACT, a=CONTACT
    )
    x, z = positions(first, size=20.0), positions(first, 0.3, 20.0)
    mesh = section_shapes.rectangle((20.0, 20.0), (x, z), names=("sx", "side", "cap", "base"))
    body = AxisymmetricBody(mesh, SOFT, "cap", {"base": "xz"})
    tip = FunctionSurface(lambda x, y: rise * (np.hypot(x, y) / CONTACT) ** n, size=CONTACT)
    rigid = fc.RigidBody(tip).placed(rotation=HALF_TURN)
    result = fc.Scene([body, rigid], [fc.Contact(body, rigid)]).solve(forces={rigid: (0, 0, exact.force)})
    contact = result.contacts[0]
    estimate = contact.error_estimate
    known = exact.pressure(np.array([1e-9, *np.linspace(0.5, 0.98, 25) * CONTACT])).max()
    for name, told, error in (
        ("peak", estimate.peak, abs(contact.max_pressure / known - 1)),
        ("area", estimate.area, abs(contact.area / (np.pi * CONTACT**2) - 1)),
    ):
        # below half is never right, three is asked for, the pressure's error is the bound
        most = max(3.0, estimate.pressure / error)
        row(
            f"tip r^{n}, faces of {first}", f"estimated over true error, {name}", 1.0, told / error, most, result.n_dofs
        )
        assert 0.5 <= told / error <= most
