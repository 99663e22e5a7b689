"""The data in meshes/: each file with its source and licence, read by the package, used by an example or a test."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import fecontact as fc
from fecontact.app.decks.ccx import beside_ccx

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "meshes"
PAGE = "MESHES.md"
FILES = sorted(p.relative_to(FOLDER).as_posix() for p in FOLDER.rglob("*") if p.is_file() and p.name != PAGE)
#: Decks after published problems: differences from CalculiX 2.20 of displacements and forces, relative to the largest,
#: as measured, rounded up. Where bodies meet at edges of a few faces its quadrature of the overlap is another one; node
#: to surface, in which alone it has tables of pressure and overlap, it fails the patch test.
DECKS = {
    "decks/hertz-ball.inp": (0.01, 2e-4),
    "decks/hertz-cylinder.inp": (0.01, 2e-4),
    "decks/lap-joint.inp": (0.01, 2e-4),
    "decks/patch-test.inp": (1e-4, 1e-5),
    "decks/press-fit.inp": (1e-4, 1e-4),
    "decks/punch.inp": (2e-4, 1e-4),
    "decks/shrink-fit.inp": (1e-4, 1e-4),
    "decks/soft-layer.inp": (0.1, 0.01),
    "decks/spinning-disc.inp": (1e-5, 1e-5),
    "decks/tied-beam.inp": (2e-5, 2e-5),
}


def test_every_file_has_its_source_and_a_licence_that_allows_to_pass_it_on():
    rows = [line for line in (FOLDER / PAGE).read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    named = {}
    for row in rows:
        files, what, source, licence = (cell.strip() for cell in row.strip("|").split("|"))
        assert what
        assert source
        assert licence.startswith(("BSD-3-Clause", "public domain", "Apache-2.0"))
        named |= dict.fromkeys(re.findall(r"`([^`]+)`", files), licence)
    assert sorted(named) == FILES
    assert len(FILES) >= 4


@pytest.mark.parametrize("name", [name for name in FILES if not name.startswith("LICENSE")])
def test_every_file_is_used(name):
    users = [*(ROOT / "examples").glob("*.py"), Path(__file__)]
    assert any(name in path.read_text(encoding="utf-8") for path in users)


def test_the_pin_is_a_cylinder():
    mesh = fc.read_mesh(FOLDER / "pin.msh")
    assert set(mesh.boundaries) == {"side", "top", "bottom"}
    x = mesh.points[mesh.boundary_nodes("side")]
    # nodes in the middles of edges lie on the cylinder, as the mesher placed them
    assert np.abs(np.hypot(x[:, 0], x[:, 1]) - 4.95).max() < 1e-9


@pytest.mark.parametrize("name", ["blocks_abaqus.inp", "blocks_calculix.inp", "blocks_febio.feb"])
def test_decks_of_three_programs_are_one_scene(name):
    (contact,) = fc.read_scene(FOLDER / name, laws="small-strain").solve().contacts
    # the same blocks in Python
    lower = fc.shapes.block((40.0, 40.0, 20.0), (4, 4, 3), element="hex8")
    upper = fc.shapes.block((20.0, 20.0, 10.0), (3, 3, 2), element="hex8").translated((10.0, 10.0, 20.0))
    low = fc.ElasticBody(lower, fc.Material(5.0, 0.45), "top", {"bottom": "xyz"})
    up = fc.ElasticBody(upper, fc.Material(200.0, 0.3), "bottom", {"top": "xyz"})
    (same,) = fc.Scene([low, up], [fc.Contact(up, low)]).solve(motions={up: {"z": -0.2}}).contacts
    assert abs(contact.total_force - same.total_force) < 1e-9 * same.total_force


def test_decks_that_have_a_closed_form():
    """Lame's rings with an interference of .002, and by a temperature; an even pressure; a beam of two tied parts."""
    fit = fc.read_scene(FOLDER / "decks/press-fit.inp").solve().contacts[0]
    lame = 1000.0 * 0.002 / 2 * (2**2 - 1) * (3**2 - 2**2) / (2 * 2**2 * (3**2 - 1))
    assert abs(fit.total_force / (lame * fit.area) - 1) < 3e-3
    shrunk = fc.read_scene(FOLDER / "decks/shrink-fit.inp").solve().contacts[0]
    lame *= 1e-5 * 100 * 2 / 0.002
    assert abs(shrunk.total_force / (lame * 0.5 * 2 * np.pi / 12 * 2) - 1) < 0.02
    assert np.abs(fc.read_scene(FOLDER / "decks/patch-test.inp").solve().contacts[0].pressure - 0.1).max() < 1e-12
    beam = fc.read_scene(FOLDER / "decks/tied-beam.inp").solve()
    (body,) = beam.scene.bodies
    # of length 8 and height 1: bending and shear (Timoshenko and Goodier, article 21); the clamp, which keeps its end
    # from widening, takes an eighth of the height off the length
    deflection = 0.05 * 8**3 / (3 * 1000 / 12) + 1.2 * 0.05 * 8 / (1000 / 2.6)
    assert abs(np.abs(beam.displacement(body)[:, 2]).max() / deflection - 1) < 0.02


@pytest.mark.full
@pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX is not installed (Debian: apt-get install calculix-ccx)"
)
@pytest.mark.parametrize("name", list(DECKS))
def test_decks_beside_calculix(name):
    path = FOLDER / name
    result = fc.read_scene(path).solve()
    found = beside_ccx(path, result)
    moved, forced = DECKS[name]
    assert max(found.apart.values()) <= moved
    forces = [(ours, theirs) for what, ours, theirs in found.rows if "force" in what]
    assert forces
    assert max(abs(ours - theirs) for ours, theirs in forces) <= forced * max(map(max, forces))
    assert result.residuals().worst <= 1e-9


def test_a_deck_with_laws_is_the_scene_at_finite_strain():
    (contact,) = (result := fc.read_scene(FOLDER / "pad_febio.feb").solve()).contacts
    lower = fc.shapes.block((40.0, 40.0, 20.0), (4, 4, 2), element="hex8")
    upper = fc.shapes.block((20.0, 20.0, 10.0), (3, 3, 2), element="hex8").translated((10.0, 10.0, 20.0))
    rubber = fc.MooneyRivlin(c10=0.4, c01=0.1, bulk=50.0)
    low = fc.ElasticBody(lower, fc.NeoHookean(1.0, 0.45), "top", {"bottom": "xyz"}, geometry="plain")
    up = fc.ElasticBody(upper, rubber, "bottom", {"top": "xyz"}, geometry="plain")
    (same,) = fc.Scene([low, up], [fc.Contact(up, low)]).solve(motions={up: {"z": -2.0}}).contacts
    assert abs(contact.total_force - same.total_force) < 1e-12 * same.total_force
    assert len(result.finite_strain) == 1
    assert not any("small" in text for text in result.warnings)
    # the moduli at rest are softer by 7 %, and the result says what was done
    linear = fc.read_scene(FOLDER / "pad_febio.feb", laws="small-strain").solve()
    assert 0.92 < linear.contacts[0].total_force / same.total_force < 0.94
    assert sum("is linear, with the moduli at rest" in text for text in linear.warnings) == 2


def test_measured_heights_are_a_grid_in_the_unit_asked_for():
    z = fc.surfaces.read_topography(FOLDER / "hills.txt").z
    assert z.shape == (128, 128)
    assert np.array_equal(fc.surfaces.read_topography(FOLDER / "hills.txt", unit=1e-3).z, 1e-3 * z)


@pytest.mark.parametrize(("name", "lowest"), [("MBench_S1002_v3.prw", -27.9), ("MBench_UIC60_v3.prr", -38.5)])
def test_wheel_and_rail_have_their_origin_on_the_tread_and_the_top(name, lowest):
    profile = fc.surfaces.read_profile(FOLDER / name)
    assert abs(profile.height(0.0)) < 0.02
    assert abs(profile.points[:, 1].min() - lowest) < 0.1
