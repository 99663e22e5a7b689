"""Going on from a state or a record: to another load, and never to an answer of something else."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    GeneralisedAlpha,
    Stage,
    State,
    equilibrium,
    move,
    traction,
)

FLOOR = fc.RigidBody(fc.Plane())
#: Both ways end with forces out of balance of 1e-9 of the largest; the displacements of a bar ten times longer than
#: thick are some hundred times as soft as its forces.
SAME = 1e-7


def bar():
    mesh = fc.shapes.block((4.0, 1.0, 0.5), (4, 1, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=100.0, nu=0.3))
    return Assembly.of([solid], [{"x_min": "xyz"}]), solid.space


def cube_on_floor():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 1), element="hex8")
    solid = AncfSolid(AncfSpace(mesh), fc.Material(E=10.0, nu=0.3))
    return Assembly.of([solid], [{"top": "xyz"}], [fc.Contact(solid.side("bottom"), FLOOR)])


def moved(a: Assembly, state: State):
    """Displacements of nodes and changes of gradients, as lengths."""
    return a.lengths * (state.q - a.q0)


@pytest.mark.by_day(
    "from nothing-larger", "from the first load-none", "from nothing-smaller", "from nothing-another direction"
)
@pytest.mark.parametrize(
    ("first", "second"),
    [
        ((0, 0, -1.0), (0, 0, -2.0)),
        ((0, 0, -2.0), (0, 0, -0.5)),
        ((0, 0, -1.0), (0, 1.5, 0.5)),
        ((0, 0, -1.0), (0, 0, 0)),
    ],
    ids=["larger", "smaller", "another direction", "none"],
)
@pytest.mark.parametrize("onwards", [False, True], ids=["from nothing", "from the first load"])
def test_a_finished_path_leads_to_another_load(first, second, onwards):
    a, space = bar()
    f1, f2 = (traction(space, "x_max", f) for f in (first, second))
    begun = equilibrium(lambda s: Stage(a, forces=s * f1), steps=2)
    # the new loads may grow from nothing or from the first load: either way leads to the second
    path = equilibrium(lambda s: Stage(a, forces=s * f2 + (1 - s) * onwards * f1), steps=2, start=begun.last)
    scratch = equilibrium(lambda s: Stage(a, forces=s * f2), steps=2).last
    assert path.success
    assert path.last.level == 1.0
    assert np.abs(moved(a, path.last) - moved(a, scratch)).max() < SAME * np.abs(moved(a, begun.last)).max()
    # nothing that remains of the first load is in the reactions
    lift = np.array([a.translation(e) for e in np.eye(3)])
    assert np.abs(lift @ (path.last.reactions + f2)).max() < 1e-7


@pytest.mark.parametrize("deep", [0.15, 0.05, -0.1], ids=["deeper", "less deep", "apart"])
def test_a_finished_path_with_contact_leads_to_another_place_of_the_floor(deep):
    a = cube_on_floor()

    def to(depth):
        return lambda s: Stage(a.with_rigid(FLOOR.placed((0, 0, depth * s))))

    begun = equilibrium(to(0.1), steps=2)
    path, scratch = equilibrium(to(deep), steps=4, start=begun.last), equilibrium(to(deep), steps=4)
    assert path.success
    assert np.abs(moved(a, path.last) - moved(a, scratch.last)).max() < SAME * 0.1
    assert np.abs(path.last.forces[0] - scratch.last.forces[0]).max() < SAME * begun.last.forces[0].max()
    assert (path.last.forces[0].sum() > 0) == (deep > 0)


def test_a_finished_path_leads_to_another_motion_of_the_supports():
    a = cube_on_floor()
    top = np.flatnonzero(a.solids[0].space.mesh.points[a.solids[0].space.nodes][:, 2] > 0.99)
    down, sideways = np.zeros((2, a.n_dofs))
    down.reshape(-1, 3)[a.solids[0].space.start[top], 2] = -0.1
    sideways.reshape(-1, 3)[a.solids[0].space.start[top]] = (0.1, 0.0, -0.05)
    begun = equilibrium(lambda s: Stage(a, motion=s * down), steps=2)
    path = equilibrium(lambda s: Stage(a, motion=s * sideways), steps=2, start=begun.last)
    scratch = equilibrium(lambda s: Stage(a, motion=s * sideways), steps=2)
    assert path.success
    assert np.abs(moved(a, path.last) - moved(a, scratch.last)).max() < SAME * 0.1


def test_a_state_on_the_way_goes_on_from_its_level_and_a_finished_one_is_done():
    a, space = bar()
    load = traction(space, "x_max", (0, 0, -1.0))

    def stage(s):
        return Stage(a, forces=s * load)

    whole = equilibrium(stage, steps=4)
    rest = equilibrium(stage, steps=4, start=whole.steps[1])
    assert [s.level for s in rest.steps] == [0.5, 0.75, 1.0]
    assert rest.message == "Full load reached in 2 steps."
    assert np.abs(moved(a, rest.last) - moved(a, whole.last)).max() < SAME
    again = equilibrium(stage, steps=4, start=whole.last)
    assert again.success
    assert "in balance" in again.message
    assert again.steps == (whole.last,)


def test_a_state_of_other_solids_is_refused():
    a, _ = bar()
    other = equilibrium(lambda s: Stage(cube_on_floor()), steps=1).last
    with refused(fc.InputError, "start-differs"):
        equilibrium(lambda s: Stage(a), start=other)
    with refused(fc.InputError, "start-differs"):
        equilibrium(lambda s: Stage(a), start=replace(other, level=0.5))


def test_a_path_without_a_state_says_so():
    a, space = bar()
    a = replace(a, solids=[replace(a.solids[0], material=fc.NeoHookean(E=100.0, nu=0.3, density=1.0))])
    crush = traction(space, "x_max", (-1e6, 0, 0))
    path = equilibrium(lambda s: Stage(a, forces=crush), steps=1)
    assert not path.success
    with refused(fc.SolverError, "no-last"):
        _ = path.last


def fallen(path, *, E=100.0, size=1.0, law=fc.StVenantKirchhoff, support=None, floor=0.0, **others):
    """A cube just above the floor, for a few steps."""
    mesh = fc.shapes.block((1.0, 1.0, size), (1, 1, 1), element="hex8").translated((0, 0, 0.2))
    solid = AncfSolid(AncfSpace(mesh), law(E=E, nu=0.3, density=1.0), points=3)
    a = Assembly.of([solid], [support or {}], [fc.Contact(solid.side("bottom"), FLOOR.placed((0, 0, floor)))])
    chosen = {"until": 0.04, "step": 0.02, "gravity": (0, 0, -10.0), "path": path} | others
    return move(a, **chosen)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"E": 101.0}, "the bodies"),
        ({"size": 1.1}, "the bodies"),
        ({"law": fc.NeoHookean}, "the bodies"),
        ({"support": {"top": "x"}}, "the supports"),
        ({"floor": 0.01}, "the contacts"),
        ({"gravity": (0, 0, -9.0)}, "the loads"),
        ({"gravity": None}, "the loads"),
        ({"forces": np.ones(96)}, "the loads"),
        ({"velocity": (0.1, 0, 0)}, "the initial velocity"),
        ({"scheme": GeneralisedAlpha(0.5)}, "the scheme"),
        ({"scheme": EnergyMomentum()}, "the scheme"),
        ({"step": 0.01}, "the scheme"),
        ({"accuracy": 1e-3}, "the scheme"),
        ({"tolerance": 1e-6}, "the scheme"),
    ],
    ids=str,
)
def test_a_record_of_another_motion_is_refused_by_what_differs(change, named, tmp_path):
    fallen(tmp_path / "run.npz")
    before = (tmp_path / "run.npz").read_bytes()
    with pytest.raises(fc.InputError) as refusal:
        fallen(tmp_path / "run.npz", **change)
    text = str(refusal.value)
    assert f"it differs in {named}" in text
    assert text.count(" and the ") == 0  # one thing was changed, one is named
    assert "run.npz" in text
    assert "Choose another path" in text
    assert (tmp_path / "run.npz").read_bytes() == before


def test_the_record_of_this_motion_is_gone_on_with(tmp_path):
    fallen(tmp_path / "run.npz")
    longer = fallen(tmp_path / "run.npz", until=0.1, every=1)
    whole = fallen(None, until=0.1)
    assert np.abs(longer.time - whole.time).max() < 1e-12  # rounding of sums of steps
    assert np.abs(longer.now.q - whole.now.q).max() < 1e-9  # the tolerance of the iterations


def test_several_differences_are_all_named(tmp_path):
    fallen(tmp_path / "run.npz")
    with refused(fc.InputError, "record-of-another", "the bodies", "and the loads"):
        fallen(tmp_path / "run.npz", E=1.0, gravity=(0, 0, 1.0), step=0.005)


def test_a_record_without_fingerprints_is_refused(tmp_path):
    fallen(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as data:
        old = {name: data[name] for name in data.files if name != "prints"}
    np.savez(tmp_path / "run.npz", **old)
    with refused(fc.InputError, "record-too-old"):
        fallen(tmp_path / "run.npz")


def test_a_path_is_a_sequence_with_a_table_that_is_saved(tmp_path):
    a, space = bar()
    load = traction(space, "x_max", (0.0, 0.0, -0.1))
    path = equilibrium(lambda level: Stage(a, forces=level * load), steps=2)
    assert (len(path), path[0].level, path[-1] is path.last) == (2, 0.5, True)
    assert path.figures["level"].tolist() == [0.5, 1.0]
    assert path.column("equilibrium").max() < 1e-9
    lines = path.save(tmp_path / "path.csv").read_text().splitlines()
    assert lines[0] == "level,iterations,energy,penetration,tension,complementarity,equilibrium"
    assert len(lines) == 3
    assert len(str(path).splitlines()) == 4
    with pytest.warns(DeprecationWarning, match=r"Path\.states is now steps"):
        assert path.states == path.steps


def test_a_snap_that_stops_statics_is_followed_in_time_from_the_last_state():
    """One brick under a ball moved in by over a quarter of its height: the stop names the way on, and it goes on."""
    size, at = (0.777, 0.916, 1.336), np.array([0.255, 0.384, 1.336])
    mesh = fc.shapes.block(size, (1, 1, 1), element="hex8")
    material = fc.NeoHookean(E=1.0, nu=0.3, density=1.0)
    solid = AncfSolid(AncfSpace(mesh), material, points=3)
    ball = fc.RigidBody(fc.Sphere(2.91)).placed(at)
    a = Assembly.of([solid], [{"bottom": "xyz"}], [fc.Contact(solid.side("top"), ball)])

    def pushed(level):
        return Stage(a.with_rigid(ball.placed((0.0, 0.0, -0.365 * level))))

    path = equilibrium(pushed, steps=2)
    assert not path.success
    assert "`move(.., start=path.last)` follows it" in path.message
    begin = path.last.level
    onwards = GeneralisedAlpha(0.5)
    motion = move(lambda t: pushed(begin + t * (1 - begin)), until=1.0, step=0.2, scheme=onwards, start=path.last)
    assert motion.success
    # it moves on from where it stood, and by no more than the ball does
    moved = np.abs(motion.now.q - path.last.q).max()
    assert 1e-3 < moved < 0.365
