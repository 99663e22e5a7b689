"""Plane and axisymmetric bodies in scene files."""

import pytest
from refusals import refused

import fecontact as fc

RING = """
[materials.steel]
E = 2.0e6
nu = 0.3
[bodies.ball]
type = "axisymmetric"
shape = {kind = "half_disc", radius = 25.0, contact_radius = 0.18, level = 1}
material = "steel"
contact = "cap"
supports = {base = "xz"}
[bodies.floor]
type = "rigid"
shape = {kind = "plane"}
[[contacts]]
slave = "ball"
master = "floor"
[loads]
forces.ball = [0, 0, -700.0]
"""

STRIP = """
[materials.cork]
E = 10.0
nu = 0.0
[bodies.strip]
type = "plane"
shape = {kind = "rectangle", size = [2.0, 1.0], divisions = [4, [0, 0.3, 1]], element = "quad9"}
material = "cork"
contact = "bottom"
supports = {top = "xz"}
thickness = 0.5
plane = "stress"
[bodies.floor]
type = "rigid"
shape = {kind = "plane"}
[[contacts]]
slave = "strip"
master = "floor"
[loads]
motions.strip = {z = -0.01}
"""


def read(text, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    return fc.read_scene(path)


def test_a_ball_on_the_floor(tmp_path):
    file = read(RING, tmp_path)
    assert "axisymmetric" in file.describe()
    result = file.solve()
    assert abs(result.contacts[0].force[2] - 700) < 1e-6
    assert isinstance(file.bodies["ball"], fc.AxisymmetricBody)


def test_a_strip_of_cork(tmp_path):
    result = read(STRIP, tmp_path).solve()
    assert abs(result.contacts[0].force[2] - 0.1) < 1e-12
    assert abs(result.contacts[0].area - 1.0) < 1e-12


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"half_disc"', '"half_disk"', ("scene-file",)),
        ('contact = "cap"', 'contact = "cup"', ("scene-file", "'cap'")),
        ('supports = {base = "xz"}', 'supports = {base = "xyz"}', ("scene-file", "'x'", "'z'")),
        ('supports = {base = "xz"}', 'supports = {bass = "xz"}', ("scene-file", "'base'")),
        ("level = 1", "level = 9", ("scene-file",)),
        ('contact = "cap"', 'contact = "cap"\nthickness = 2.0', ("scene-file",)),
        ('contact = "cap"', 'contact = "cap"\npressure = "nodal"', ("scene-file",)),
    ],
)
def test_faults_are_told(old, new, message, tmp_path):
    with refused(fc.InputError, *message):
        read(RING.replace(old, new), tmp_path)
