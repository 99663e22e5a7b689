"""The falling bar of Campanelli, Berzeri & Shabana by bricks: they tend to the beam with their measure of strain."""

import numpy as np
import pytest

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, EnergyMomentum, Joints, move

#: Deflection of the middle from the chord at 0.1 and 0.15 s under 50 m/s^2: a hundred beams with Green-Lagrange strain,
#: then with the stretch of the axis; a Runge-Kutta integrator of the eighth order.
GREEN, STRETCH = (-0.126917, -0.29931), (-0.126258, -0.292339)


@pytest.mark.full
def test_bricks_fall_like_the_beam_with_green_lagrange_strain():
    """Hinged by a rigid hub that weighs next to nothing; 12 bricks and steps of 2.5 ms err by 1 %."""
    length, width, height, n = 1.2, 0.2, 0.009, 12
    mesh = fc.shapes.block((length, width, height), (n, 1, 1), element="hex8")
    small = fc.shapes.block((height, width, height), (1, 1, 1), element="hex8")
    bar, hub = (
        AncfSolid(
            AncfSpace(m.translated((x, -width / 2, -height / 2))), fc.Material(E=0.7e6, nu=0.0, density=rho), points=3
        )
        for m, x, rho in ((mesh, 0.0, 5540.0), (small, -height / 2, 5.54))
    )
    joints = Joints([bar, hub])
    hinge = joints.pinned((1, [(0.0, -width / 2, 0.0), (0.0, width / 2, 0.0)]))
    a = Assembly([bar, hub], [joints.affine(1), joints.follows(0, "x_min", 1), hinge], rigid=[1])
    motion = move(a, until=0.15, step=0.0025, scheme=EnergyMomentum(), gravity=(0, 0, -50.0), every=1)
    assert motion.success
    assert motion.drift < 1e-9
    cells, X = bar.space.located([(0, 0, 0), (length / 2, 0, 0), (length, 0, 0)])
    sag = []
    for q in motion.frames:
        start, middle, end = bar.space.points_at(a.part(q, 0), cells, X)[:, ::2]
        chord = (end - start) / np.linalg.norm(end - start)
        sag.append(chord[0] * (middle - start)[1] - chord[1] * (middle - start)[0])
    found = np.interp([0.1, 0.15], motion.frame_times, sag)
    assert np.abs(found / GREEN - 1).max() < 0.012
    assert abs(found[1] / STRETCH[1] - 1) > 0.02
