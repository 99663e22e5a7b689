"""Long windows: a crowned roller on a block, a contact thirty times as long as it is wide."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.surfaces import Paraboloid

SOLID = fc.Material(E=1.0, nu=0.3)
FORCE = 0.012


def _pressed(divisions):
    mesh = fc.shapes.block((6.0, 3.0, 2.0), divisions)
    block = fc.ElasticBody(mesh, SOLID, supports={"bottom": "xyz"})
    top = (3.0, 1.5, 2.0)
    local = fc.LocalBody(block, at=top, window=(4.0, 0.4), cells=(160, 32))
    roller = fc.RigidBody(Paraboloid(200.0, 1.0), pose=fc.Pose(translation=top))
    scene = fc.Scene([local, roller], [fc.Contact(local, roller)])
    result = scene.solve(forces={roller: (0.0, 0.0, -FORCE)}, finite_motion=False)
    return float(-result.rigid_motion(roller).translation[2]), result.contacts[0], local.remainder.defect


@pytest.mark.full
def test_a_crowned_roller_needs_no_more_mesh_than_a_ball():
    coarse, contact, defect = _pressed((8, 6, 4))
    fine, _, _ = _pressed((12, 8, 6))
    assert coarse == pytest.approx(fine, rel=1e-3)
    assert defect < 1e-3
    exact = fc.hertz.ellipse(((200.0, 1.0), (np.inf, np.inf)), (None, SOLID), force=FORCE)
    # the block is finite: its approach is far from a half-space's, its pressure near
    assert contact.max_pressure == pytest.approx(exact.p0, rel=0.05)
    assert abs(coarse / exact.approach - 1) > 0.1
    reach = np.abs(contact.points[contact.active, :2] - [3.0, 1.5]).max(axis=0)
    assert reach[0] / reach[1] > 20
