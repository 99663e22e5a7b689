"""A wheel on a rail: what is refused, warned of, printed and drawn, and patches that act on each other."""

import math

import numpy as np
import pytest

import fecontact as fc
from fecontact.scene import wheel_rail
from fecontact.surfaces import Profile
from tests.refusals import refused

STEEL = fc.Material(E=210e3, nu=0.28)
LINE = np.linspace(-60.0, 60.0, 31)
CYLINDER = Profile(np.stack([LINE, 0 * LINE], axis=1))
CONE = Profile(np.stack([LINE, LINE / 20], axis=1))


def crown(radius, angle=0.3):
    turn = np.linspace(-angle, angle, 161)
    return Profile(np.stack([radius * np.sin(turn), radius * (np.cos(turn) - 1)], axis=1))


def pair(wheel=CONE, rail=None, **options):
    return fc.WheelRail(wheel, rail or crown(300.0), 460.0, STEEL, wheel_position=0.0, rail_position=0.0, **options)


def test_the_load_is_borne_and_told():
    found = pair().roll(50e3, friction=0.3, turning=1.002, cells=20)
    assert abs(found.force_on_rail[2] + 50e3) < 1
    (patch,) = found.patches
    assert patch.creepage[0] < 0
    assert found.force_on_rail[0] < 0  # it drives: the rail is pushed backwards
    assert not found.warnings
    assert "on the rail: -" in str(found)
    assert repr(found)


def test_units_do_not_matter():
    """In metres, newtons and pascals the angle, creepages and shares are the same."""
    small = Profile(1e-3 * CONE.points), Profile(1e-3 * crown(300.0).points)
    steel = fc.Material(E=210e9, nu=0.28)
    in_metres = fc.WheelRail(*small, 0.46, steel, wheel_position=0.0, rail_position=0.0).roll(5e4, cells=10).patches[0]
    patch = pair().roll(5e4, cells=10).patches[0]
    for name, power in (
        ("angle", 0),
        ("creepage_along", 0),
        ("force", 0),
        ("along", 0),
        ("max_pressure", 6),
        ("y", -3),
    ):
        assert abs(in_metres.figures[name] / (patch.figures[name] * 10.0**power) - 1) < 1e-7, name


def test_a_right_wheel_is_the_mirror_image():
    """Shift, yaw and roll change signs, and so do what is lateral and spin; both profiles mirrored by hand."""
    mirrored = Profile(CONE.points * [-1, 1]), crown(300.0)
    other = fc.WheelRail(*mirrored, 460.0, STEEL, wheel_position=0.0, rail_position=0.0)
    position = {"shift": 2.0, "yaw": 0.004, "roll": 1e-3}
    one = pair().roll(2e4, cells=12, **position).patches[0].figures
    two = other.roll(2e4, cells=12, **{name: -value for name, value in position.items()}).patches[0].figures
    signs = {
        name: -1 if name in ("y", "on_rail", "angle", "across", "torque", "creepage_across", "spin") else 1
        for name in one
    }
    scale = {"torque": 2e4, "across": 2e4, "along": 2e4}
    for name, value in one.items():
        assert abs(two[name] - signs[name] * value) <= 1e-6 * max(abs(value), scale.get(name, 0)), name


def test_patches_beside_each_other_are_those_of_one_grid():
    """Two crowns 12 mm apart: on grids of their own, each lifted by the other, or on one grid, whose cells tell all.

    The one grid resolves half as much; each half bears half, and both yield more than two that know of no other: at
    12 mm a force F lifts by F / (pi E* 12 mm), some 5 % of its own approach.
    """
    rail = Profile(np.stack([y := np.linspace(-40, 40, 801), -((np.abs(y) - 6.0) ** 2) / 600], axis=1), 1e-4)
    both = pair(CYLINDER, rail)
    together = both.roll(20e3, friction=0.0, cells=64, join=20.0)
    assert len(together.patches) == 1
    assert together.patches[0].contact.n_regions == 2
    apart = both.roll(20e3, friction=0.0, cells=32)
    assert len(apart.patches) == 2
    assert np.allclose([patch.contact.force for patch in apart.patches], 10e3, rtol=1e-3)
    alone = pair(CYLINDER, crown(300.0)).roll(10e3, friction=0.0, cells=32)
    modulus = 210e3 / (2 * (1 - 0.28**2))
    lift = 10e3 / (math.pi * modulus * 12.0)
    sunk = {name: -found.pair.lift for name, found in (("together", together), ("apart", apart), ("alone", alone))}
    assert abs(sunk["apart"] - sunk["alone"] - lift) < 0.05 * lift
    assert abs(sunk["together"] - sunk["apart"]) < 0.05 * lift


def test_curved_contacts_are_warned_of_and_conformal_ones_refused():
    plain = pair(CYLINDER, crown(300.0)).roll(20e3, friction=0.0, cells=16)
    assert not plain.warnings
    wheel = Profile(crown(13.2, 1.2).points)  # a groove in the wheel, nearly as round as the rail
    curved = pair(wheel, crown(13.0, 1.2)).roll(20e3, friction=0.0, cells=16)
    (warning,) = [text for text in curved.warnings if "conformal" in text]
    assert f"{math.degrees(curved.patches[0].angle_across):.1f} degrees" in warning
    with refused(fc.InputError, "conformal", "degrees"):
        pair(Profile(crown(13.1, 1.2).points), crown(13.0, 1.2)).roll(50e3, friction=0.0, cells=16)


def test_what_cannot_be_is_refused():
    with refused(fc.InputError, "profiles-apart", "shift"):
        pair().roll(1e3, shift=500.0)
    with pytest.raises(fc.InputError, match="force of a wheel"):
        pair().roll(-1.0)
    with pytest.raises(fc.InputError, match="cells of a patch"):
        pair().roll(1.0, cells=2)
    with pytest.raises(fc.InputError, match="yaw"):
        pair().roll(1.0, yaw=math.nan)
    with refused(fc.InputError, "gauge-face"):
        fc.WheelRail(CONE, crown(300.0), 460.0, STEEL)
    with refused(fc.InputError, "wrong-shape", "as many"):
        pair().positions(1.0, [0.0, 1.0], yaws=[0.0, 0.0, 0.0])


def test_positions_are_a_table_and_a_picture(tmp_path):
    path = pair().positions(2e4, [0.0, 2.0], yaws=[0.0, 0.001], friction=0.2, cells=12)
    assert [row["shift"] for row in path.rows()] == [0.0, 2.0]
    assert path.last.pair.yaw == 0.001
    assert len(str(path).splitlines()) == 3
    path.save(tmp_path / "path.csv")
    assert (tmp_path / "path.csv").read_text().startswith("shift,yaw,y,on_rail,angle")
    assert len(path.plot().axes) == 6
    drawn = path.last.plot(tmp_path / "last.svg", length="mm", force="N", units="MPa")
    assert (tmp_path / "last.svg").stat().st_size > 10_000
    assert drawn.axes[1].get_title() == "at -15.0, 2.9 degrees"
    assert wheel_rail.COLUMNS[0].name == "y"
