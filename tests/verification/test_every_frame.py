"""The law of frames and units: what is solved in one is solved in all of them, and the answer is the same.

Each scene is built in a frame: lengths and moduli in other units, everything turned and moved, by poses or in the
coordinates of the meshes themselves. Nodal forces over the load are compared with those of the scene at home.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
from refusals import refused
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact import SupportError

# rounding of two factorisations, condition numbers of some 1e5; what VERIFICATION 14 promises
SAME = 1e-9
HOME = np.eye(3)
FAR = 1e4


@dataclass(frozen=True)
class Setup:
    """Units and place in which a scene of sizes of about one is built."""

    length: float = 1.0
    modulus: float = 1.0
    turn: np.ndarray = field(default_factory=lambda: HOME)
    shift: np.ndarray = field(default_factory=lambda: np.zeros(3))
    by_pose: bool = True

    @property
    def force(self):
        return self.modulus * self.length**2

    def vector(self, v, unit=1.0):
        return unit * self.turn @ np.asarray(v, dtype=float)

    def block(self, size, divisions, contact, supports=None, at=(0.0, 0.0, 0.0), name="block"):
        length = self.length
        mesh = fc.shapes.block(tuple(length * np.array(size)), divisions).translated(tuple(length * np.array(at)))
        material = fc.Material(E=1000.0 * self.modulus, nu=0.3, density=2.0)
        if self.by_pose:
            body = fc.ElasticBody(mesh, material, contact, supports or {}, name=name)
            return body.placed(self.shift * length, self.turn)
        there = mesh.mapped(lambda x: x @ self.turn.T + self.shift * length)
        return fc.ElasticBody(there, material, contact, supports or {}, name=name)

    def rigid(self, shape, at=(0.0, 0.0, 0.0), name="floor", turn=None):
        body = fc.RigidBody(shape, name=name).placed(self.length * np.array(at), turn)
        return body.placed(self.shift * self.length, self.turn)


def touching(*pairs, **options):
    bodies = list({id(b): b for pair in pairs for b in pair[:2]}.values())
    contacts = [fc.Contact(*pair[:2], surfaces=pair[2] if len(pair) > 2 else None) for pair in pairs]
    return fc.Scene(bodies, contacts, **options)


def floating_block(s):
    block, floor = s.block((1.0, 1.2, 0.9), (3, 2, 2), "bottom"), s.rigid(fc.Plane())
    return block, touching((block, floor))


def pressed(s):
    block, scene = floating_block(s)
    return scene.solve(pressures={(block, "top"): s.modulus})


def pushed_off_centre(s):
    block, scene = floating_block(s)
    moment = s.vector((0.1, 0.05, 0.0), s.force * s.length)
    return scene.solve(forces={block: s.vector((0, 0, -1), s.force)}, moments={block: moment})


def plate(s, n):
    return s.block((2.0, 2.0, 1.0), (n, n, 2), "top", {"bottom": "xyz"}, (-1.0, -1.0, -1.0), "plate")


def at_rest_on_a_plate(s):
    block, below = s.block((1.0, 1.0, 1.0), (2, 2, 2), "bottom", at=(-0.5, -0.5, 0.0)), plate(s, 4)
    return touching((block, below)).solve(gravity=s.vector((0, 0, -1), s.modulus / s.length))


def on_a_plate_that_does_not_match(s):
    block, below = s.block((1.0, 1.0, 1.0), (3, 3, 2), "bottom", at=(-0.5, -0.5, 0.0)), plate(s, 5)
    return touching((block, below)).solve(forces={(block, "top"): s.vector((0, 0, -1), s.force)})


def ball_on_a_plate(s):
    ball, below = s.rigid(fc.Sphere(3.0 * s.length), name="ball"), plate(s, 6)
    return touching((below, ball)).solve(forces={ball: s.vector((0, 0, -20), s.force)})


def stack_of_two(s):
    upper = s.block((1.0, 1.0, 1.0), (2, 2, 2), "bottom", at=(-0.5, -0.5, 0.0), name="upper")
    lower = s.block((1.0, 1.0, 1.0), (3, 3, 2), ("top", "bottom"), at=(-0.5, -0.5, -1.0), name="lower")
    floor = s.rigid(fc.Plane(), (0.0, 0.0, -1.0))
    scene = touching((upper, lower, ("bottom", "top")), (lower, floor, ("bottom", "surface")))
    return scene.solve(pressures={(upper, "top"): s.modulus})


SCENES: dict[str, Callable] = {
    "floating block under pressure": pressed,
    "floating block pushed off its centre": pushed_off_centre,
    "block at rest on a plate": at_rest_on_a_plate,
    "block on a plate that does not match": on_a_plate_that_does_not_match,
    "rigid ball pressed on a plate": ball_on_a_plate,
    "stack of two floating blocks": stack_of_two,
}


def forces_over_load(scene, s):
    return np.concatenate([c.forces for c in scene(s).contacts]) / s.force


@pytest.mark.parametrize("name", SCENES)
def test_scenes_are_the_same_in_every_frame_and_unit(name, row):
    """Scenes turned, moved and in other units, by poses and in the coordinates of their meshes.

    Source: the same scene at home. 1e-9: two factorisations. Coordinates of a mesh that stands 1e4 of its sizes away
    have lost four digits: an approach of 1e-3 of the size is left with 10 eps 1e4 / 1e-3 = 2.2e-8 of either body.
    """
    at_home = forces_over_load(SCENES[name], Setup())
    rng = np.random.default_rng(7)
    worst = dict.fromkeys((True, False), 0.0)
    lost = 0.0
    for _ in range(2):
        turn, direction = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3)
        length, modulus = 10 ** rng.uniform(-3, 3), 10 ** rng.uniform(-9, 9)
        for by_pose in (True, False):
            for distance in (0.0, FAR):
                shift = distance * direction / np.linalg.norm(direction)
                found = forces_over_load(SCENES[name], Setup(length, modulus, turn, shift, by_pose))
                change = float(np.abs(found - at_home).max() / np.abs(at_home).max())
                if by_pose or not distance:
                    worst[by_pose] = max(worst[by_pose], change)
                else:
                    lost = max(lost, change)
    for by_pose, change in worst.items():
        case = f"14 {name}: other units, {'posed elsewhere' if by_pose else 'mesh turned'}"
        row(case, "largest change of a force / largest", 0.0, change, SAME)
    row(f"14 {name}: mesh 1e4 sizes away", "largest change of a force / largest", 0.0, lost, 4.4e-8)


def test_a_floating_block_in_any_rotation(row):
    """A floating block on a floor, the whole scene turned at random.

    Source: statics. A balanced load is carried to rounding; no slope is read from a rounded normal.
    """
    rng = np.random.default_rng(40)
    worst = 0.0
    for _ in range(12):
        result = pressed(Setup(turn=Rotation.random(random_state=rng).as_matrix()))
        worst = max(worst, abs(result.contacts[0].total_force - 1.2), result.residuals().worst)
    row("14 floating block, twelve random rotations", "force carried and residuals", 0.0, worst, 1e-12)


@pytest.mark.parametrize("side", [0.01, 5.0, 10.0])
def test_uniform_pressure_on_a_floating_cube(side, row):
    """A floating cube under uniform pressure. Source: statics; what cancels in the nodal forces is no load."""
    s = Setup(length=side)
    cube, floor = s.block((1.0, 1.0, 1.0), (2, 2, 2), "bottom"), s.rigid(fc.Plane())
    result = touching((cube, floor)).solve(pressures={(cube, "top"): 1.0})
    error = np.abs(result.contacts[0].pressure - 1).max()
    row(f"14 floating cube, side {side:g}", "largest pressure error", 0.0, error, 1e-11)
    assert result.residuals().worst < 1e-12


@pytest.mark.parametrize("turn", [HOME, fc.rotation_about((1, 2, 3), 0.7)])
def test_small_loads_that_nothing_carries_are_still_refused(turn):
    # rounding is cut off at 1e-12; a sideways load of a millionth, or a slope of a millionth, is not rounding
    s = Setup(turn=turn)
    block, scene = floating_block(s)
    with refused(SupportError, "free-motion", "translation along"):
        scene.solve(forces={block: s.vector((1e-6, 0, -1))})
    slope = s.rigid(fc.Plane(), turn=fc.rotation_about((0, 1, 0), 1e-6))
    with refused(SupportError, "free-motion", "translation along"):
        touching((block, slope)).solve(forces={block: s.vector((0, 0, -1))})
