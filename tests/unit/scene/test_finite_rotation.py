"""Steps of finite motions: how far one goes, when they run away, which result is kept, and when it is refused."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import SolverError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.loads import LoadStep
from fecontact.results.linearisation import BEARABLE, CarriedMotion
from fecontact.scene import finite_rotation as finite
from fecontact.scene.finite_rotation import CARRIED
from fecontact.scene.linear import Settings

SIZE = 2.0


class Block:
    """What of a body the steps look at."""

    size, pose, reference_point = SIZE, fc.Pose(), np.zeros(3)


@dataclass(frozen=True)
class Found:
    """What of a result the steps look at."""

    error: float = 0.0
    _motions: tuple = ()
    _loading: object = None
    scene: object = field(
        default_factory=lambda: SimpleNamespace(bodies=("the body",), sizes=np.array([SIZE]), twists=False)
    )
    _originals: tuple = ()
    _linearisation: object = None
    contacts: tuple = ()
    _carried: object = None


def moving(x=0.0, ry=0.0, error=0.0, moved=0.0):
    """A result that asks for a shift and a turn of one body."""
    frame = SimpleNamespace(prescribed=np.array([moved, 0, 0, 0, 0, 0]))
    return Found(error, (np.array([x, 0, 0, 0, ry, 0]),), SimpleNamespace(frames=(frame,)))


@pytest.fixture
def path(monkeypatch):
    """A path of one body of size 2 at the origin."""
    monkeypatch.setattr(finite, "linearisation_error", lambda r: SimpleNamespace(worst=r.error, gap=r.error))
    monkeypatch.setattr(finite, "driven_motions", lambda r: r._motions)
    monkeypatch.setattr(finite, "newton_step", lambda r, steps: steps)
    return finite._Path(
        SimpleNamespace(bodies=[Block()], sizes=np.array([SIZE]), has_friction=False, twists=False),
        LoadStep(),
        Settings(),
        Stopwatch(),
    )


@pytest.mark.parametrize(
    ("asked", "gone"),
    [
        # up to 0.2 of the size, whatever its error
        ({"x": 0.39, "error": 1e9}, 0.39),
        # far, but where its gaps come true to 0.2 of the size
        ({"x": 4.0, "error": 0.39}, 4.0),
        # the error of 1.6 is four times what is allowed: half of the way
        ({"x": 4.0, "error": 1.6}, 2.0),
        # never less than a step
        ({"x": 4.0, "error": 1e9}, 0.4),
        # turns by 0.2 at the most, and shifts with them
        ({"ry": 0.19, "x": 0.1}, 0.1),
        ({"ry": 1.0, "x": 0.1}, 0.02),
        ({"ry": 1.0, "x": 4.0, "error": 1e9}, 0.4),
        ({"ry": -0.5, "x": 4.0, "error": 1e9}, 0.4),
    ],
)
def test_a_step_is_as_long_as_what_was_linearised_bears(path, asked, gone):
    path.begin(moving(**asked))
    assert abs(path._place[0, 0] / gone - 1) < 1e-12
    assert abs(path._place[0, 4] - asked.get("ry", 0.0) * gone / asked["x"]) < 1e-12
    # the next one goes on from there, and is turned as a rotation
    path._guide.settle = lambda: None
    path.go_on(moving(x=asked["x"], error=asked.get("error", 0.0)))
    assert path._place[0, 0] > gone


def test_steps_go_on_from_where_the_last_one_ended_and_are_cut_as_it_was(path):
    path._guide.settle = lambda: None
    far, near = moving(x=4.0, error=1.6), moving(x=0.1)
    path.begin(far)
    for result, place in ((far, 4.0), (near, 4.1)):
        path.go_on(result)
        assert abs(path._place[0, 0] / place - 1) < 1e-12


def test_a_turn_alone_is_cut_too(path):
    path.begin(moving(ry=0.8))
    assert abs(path._place[0, 4] / 0.2 - 1) < 1e-12


def test_what_is_prescribed_is_no_step(path):
    path.begin(moving(x=0.3, moved=0.1))
    assert abs(path._place[0, 0] / 0.2 - 1) < 1e-12


@pytest.mark.parametrize(("first", "then", "away"), [(0.3, 1.0, True), (0.3, 0.8, False), (0.01, 0.3, False)])
def test_corrections_run_away_beyond_three_times_the_motion_and_a_step(path, first, then, away):
    path.begin(moving(x=first))
    assert path.runs_away(moving(x=then)) is away


@pytest.mark.parametrize(
    ("before", "step", "newton", "left"),
    [
        # a step that is a tenth of the last one is followed by a tenth and a hundredth and so on of its own length
        (0.3, 0.03, 1.0, 0.01 / 9),
        # unless Newton's step adds more
        (0.3, 0.03, 1.5, 0.01 * 0.5),
        # steps that do not become shorter promise nothing, nor do those after one that was cut
        (0.3, 0.3, 1.0, 0.01),
        (0.5, 0.03, 1.0, 0.01),
    ],
)
def test_what_is_left_goes_by_how_steps_become_shorter(path, monkeypatch, before, step, newton, left):
    path.begin(moving(x=before, error=1e9))
    monkeypatch.setattr(finite, "newton_step", lambda r, steps: newton * steps)
    change = CarriedMotion(0.0, 0.0, 0.01)
    assert path.left(moving(x=step), change) == pytest.approx(left, rel=1e-12)


def test_rest_is_measured_by_elastic_displacements_but_not_by_less_than_1e_9_of_a_body(monkeypatch):
    monkeypatch.setattr(finite, "driven_motions", lambda r: r._motions)
    frame = SimpleNamespace(modes=lambda motions: np.full((3, 1), 0.25), body=SimpleNamespace(size=SIZE))
    for elastic, measure in ((0.5, 0.5), (1e-8, 1e-8), (1e-10, SIZE * 1e-9), (-0.5, 0.5)):
        state = SimpleNamespace(displacements=(np.array([0.25, 0.25, 0.25 + elastic]),))
        scene = SimpleNamespace(sizes=np.array([SIZE]), twists=False)
        result = SimpleNamespace(
            scene=scene, _state=state, _loading=SimpleNamespace(frames=(frame,)), _motions=(np.zeros(6),)
        )
        assert abs(finite._elastic_size(result) / measure - 1) < 1e-6


def followed(monkeypatch, first, errors, away=(), rest=(), goes_on=(0.0,)):
    """What `follow` makes of results with these errors, and how many it asked for; an exception is raised.

    `goes_on` are the motions that are left of each.
    """
    asked = []

    class Path:
        originals = ("the body",)

        def __init__(self, scene, step, settings, timer, history=None):
            pass

        def begin(self, result):
            pass

        def solved(self):
            error = errors[len(asked)] if len(asked) < len(errors) else errors[-1]
            asked.append(error)
            if isinstance(error, Exception):
                raise error
            return Found(error)

        def carried(self, result):
            return CarriedMotion(0.0, 0.0, goes_on[min(len(asked), len(goes_on)) - 1])

        def left(self, result, change):
            return change.rest

        def finished(self, result):
            return ("finished", result)

        def runs_away(self, result):
            return len(asked) in away

        def at_rest(self, result):
            return len(asked) in rest

        def go_on(self, result):
            pass

    monkeypatch.setattr(finite, "_Path", Path)
    monkeypatch.setattr(finite, "linearisation_error", lambda r: SimpleNamespace(worst=r.error, gap=r.error))
    return finite.follow(Found(first), LoadStep(), Settings(), Stopwatch()), len(asked)


def test_what_is_bearable_is_not_followed(monkeypatch):
    result, asked = followed(monkeypatch, 0.999 * BEARABLE, [1.0])
    assert (result.error, result._originals, asked) == (0.999 * BEARABLE, (), 0)
    (word, result), asked = followed(monkeypatch, 1.001 * BEARABLE, [0.999 * BEARABLE])
    assert (word, result.error, asked) == ("finished", 0.999 * BEARABLE, 1)
    (word, result), asked = followed(monkeypatch, 0.5, [0.2, 1.001 * BEARABLE, 0.0])
    assert (word, result.error, asked) == ("finished", 0.0, 3)


def test_what_is_bearable_goes_on_until_its_motions_settle(monkeypatch):
    (word, result), asked = followed(monkeypatch, 0.5, [0.0], goes_on=(0.1, 1.001 * CARRIED, 0.999 * CARRIED))
    assert (word, result._carried.rest, asked) == ("finished", 0.999 * CARRIED, 3)
    # where they do not, the bearable one that had settled best
    result, asked = followed(monkeypatch, 0.5, [0.0], goes_on=(0.1, 0.05, 0.2))
    assert (result._originals, result._carried.rest, asked) == (("the body",), 0.05, 2 + 9)


@pytest.mark.parametrize(
    ("first", "errors", "away", "best", "asked"),
    [
        # nine in a row that are no better than the best
        (0.5, [0.3, 0.2, 0.4], (), 0.2, 2 + 9),
        (0.5, [0.6], (), 0.5, 9),
        # the count begins anew with a better one
        (0.5, [*[0.6] * 8, 0.4, 0.7], (), 0.4, 9 + 9),
        # running away ends it, with what was best
        (0.5, [0.3, 0.9, 0.1], (2,), 0.3, 2),
        # so does a pose without an answer
        (0.5, [0.3, SolverError("none")], (), 0.3, 2),
    ],
)
def test_where_motions_do_not_settle_the_best_result_stands(monkeypatch, first, errors, away, best, asked):
    result, count = followed(monkeypatch, first, errors, away)
    assert (result.error, result._originals, count) == (best, ("the body",), asked)


def test_poses_at_rest_are_not_solved_again(monkeypatch):
    # what is left then, as by a deflection, another pose cannot mend
    result, count = followed(monkeypatch, 0.5, [0.7, 0.6, 0.8], rest=(2,))
    assert (result.error, result._originals, count) == (0.5, ("the body",), 2)


def test_poses_that_have_not_settled_are_refused_with_what_is_left(monkeypatch):
    monkeypatch.setattr(finite, "MAX_ITERATIONS", 1)
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (2, 2, 1)).translated((-2.0, -2.0, -1.0))
    pad = fc.ElasticBody(mesh, fc.Material(E=1000.0, nu=0.3), "top", {"bottom": "xyz"}, name="pad")
    ball = fc.RigidBody(fc.Sphere(radius=5.0), name="ball").placed((0.0, 0.0, 3.0))
    scene = fc.Scene([pad, ball], [fc.Contact(pad, ball)])
    with refused(SolverError, "not-settled", "after 1"):
        scene.solve(forces={ball: (0.0, 0.0, -20.0)}, finite_motion=True)
