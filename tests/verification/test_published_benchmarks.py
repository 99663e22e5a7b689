"""Benchmarks of contact that other programs publish figures of."""

import math

import numpy as np
import pytest

import fecontact as fc
from fecontact.mesh.section_mesh import merge_sections
from fecontact.mesh.section_shapes import grid


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


def between(inner, outer, names, n):
    """Cells between two curves, functions of a parameter from 0 to 1; names at 0, the outer one, 1, the inner one."""

    def mapped(index):
        s, t = index[:, :1] / n, index[:, 1] / n
        return inner(t) + s * (outer(t) - inner(t))

    return grid((n, n), names, mapped)


def arc(radius, start, end):
    return lambda t: radius * np.stack([np.cos(start + (end - start) * t), np.sin(start + (end - start) * t)], axis=1)


def line(start, end):
    return lambda t: np.outer(1 - t, start) + np.outer(t, end)


def half_sheet(n):
    """Upper half of a sheet about a hole of radius 50: round on the right, and held 200 left of the hole's middle."""
    turns = np.pi * np.array([[0, 0.5], [0.5, 0.75], [0.75, 1.0]])
    right, top, left = (arc(50.0, *turn) for turn in turns)
    corner, side = line((-100, 100), (-100, 0)), line((-200, 100), (-200, 0))
    parts = [
        between(right, arc(100.0, *turns[0]), ("sym", None, None, "hole"), n),
        between(top, line((0, 100), (-100, 100)), (None, None, None, "hole"), n),
        between(left, corner, (None, None, "sym", "hole"), n),
        between(corner, side, (None, "wall", "sym", None), n),
    ]
    return merge_sections(parts, 1e-6)


def half_pin(n):
    """Upper half of a pin of radius 50 about a core of radius 1, in which its load acts; the rings become wider."""
    rings = between(arc(1.0, 0, np.pi), arc(50.0, 0, np.pi), ("sym", "round", "sym", "core"), n)

    def wider(x):
        r = np.hypot(x[:, 0], x[:, 2])
        return x * (50.0 ** ((r - 1) / 49) / r)[:, None]

    return rings.mapped(wider)


def test_loaded_pin(row):
    """A steel pin pulls an aluminium sheet by its hole, without play, mu = .1, 20 kN per mm: displacement and pressure.

    Source: A. W. A. Konter, as above, benchmark 3; code_aster, V6.03.156 (SSNP156), plane strain, large displacements.
    The sheet's point on the axis, where the pin presses, is moved by .736165 mm under 160.40 MPa. That pressure is
    extrapolated from stresses in the cells of its mesh; here it tends to 152.
    """
    steel, aluminium = fc.StVenantKirchhoff(210e3, 0.3), fc.StVenantKirchhoff(70e3, 0.3)
    sheet = fc.PlaneBody(half_sheet(12), aluminium, "hole", {"wall": "xz", "sym": "z"}, name="sheet")
    pin = fc.PlaneBody(half_pin(16), steel, "round", {"sym": "z"}, name="pin")
    scene = fc.Scene([pin, sheet], [fc.Contact(pin, sheet, friction=0.1)])
    result = scene.solve(forces={(pin, "core"): (10e3, 0, 0)})
    at = np.argmin(np.hypot(sheet.mesh.points[:, 0] - 50, sheet.mesh.points[:, 2]))
    contact = result.contacts[0]
    pressed = np.argmin(np.hypot(contact.points[:, 0] - 50.736, contact.points[:, 2]))
    moved = result.displacement(sheet)[at, 0]
    case = "NAFEMS contact benchmark 3, loaded pin"
    row(case, "DX [mm]", 0.736165, moved, within=1e-3, dofs=result.n_dofs)
    row(case, "pressure [MPa]", 160.40, contact.pressure[pressed], within=0.06)
