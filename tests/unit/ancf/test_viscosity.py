"""Visco-elastic bricks: relaxation and creep of a bar against closed forms, rigid motions, balance of energy."""

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
    Viscosity,
    equilibrium,
    move,
    traction,
)

SMALL, E = 1e-4, 10.0
#: Shares beside the modulus after a long time, and what they are of that at t = 0.
BESIDE = np.array([(0.5, 0.3), (0.25, 2.0)])
PRONY = BESIDE / [1 + BESIDE[:, 0].sum(), 1.0]


def bar(viscosity, density=1e-6, law=fc.Material, volumetric=None, supports=None, prony=None):
    """One brick of side one, so light that its inertia does not matter; E is the modulus after a long time."""
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    nu = 0.0 if volumetric is None else 0.3
    material = law(E, nu, density=density)
    if prony is not None:
        material = fc.Viscoelastic(law(E / (1 - sum(g for g, _ in prony)), nu, density=density), prony)
    solid = AncfSolid(AncfSpace(mesh), material, points=3, volumetric=volumetric, viscosity=viscosity)
    return Assembly.of([solid], [supports or {}])


def end_force(a, stresses):
    """Resultant along x on the end, of generalised forces."""
    x = a.solids[0].space
    pull = np.where(np.arange(x.n_functions) % 4 == 0, x.q0.reshape(-1, 3)[:, 0], 0.0)
    return float(pull @ stresses.reshape(-1, 3)[:, 0])


def test_relaxation():
    """Pulled at a constant rate to a strain e in the time T, then held: E e (1 + sum g t/T (1 - exp(-T/t)) exp(..))."""
    a, T, h = bar(None, supports={"x_min": "xyz", "x_max": "xyz"}, prony=PRONY), 0.1, 0.05
    stretch = a.held(a.solids[0].space.affine(np.diag([SMALL, 0.0, 0.0])))
    for until in (0.5, 1.5):
        motion = move(
            lambda t: Stage(a, motion=min(t / T, 1.0) * stretch), until=until, step=h, scheme=EnergyMomentum(), every=1
        )
        assert motion.success
        assert motion.viscous_work[-1] > 0
        assert np.ptp(motion.energy - motion.work + motion.viscous_work) < 1e-9 * motion.work.max()
        # loads and supports are those of the middle of the last step
        g, t = BESIDE.T
        fade = g * t / T * (1 - np.exp(-T / t)) * np.exp(-(until - h / 2 - T) / t)
        force = end_force(a, motion.now.applied)
        assert abs(force / (E * SMALL * (1 + fade.sum())) - 1) < 3e-3  # (h/t)^2 / 12 of the fastest branch


@pytest.mark.parametrize("scheme", [EnergyMomentum(), GeneralisedAlpha(0.0)], ids=["energy", "alpha"])
def test_creep(scheme):
    """Kelvin and Voigt under a constant force: e (1 - exp(-t/t_r)); half of the work is dissipated in the end."""
    time, h = 0.5, 0.05
    a = bar(Viscosity(retardation=time), supports={"x_min": "x", "y_min": "y", "bottom": "z"})
    load = traction(a.solids[0].space, "x_max", (E * SMALL, 0.0, 0.0))
    motion = move(lambda t: Stage(a, forces=load), until=2.5, step=h, scheme=scheme, every=1)
    strain = np.array([end_force(a, q - a.q0) for q in motion.frames]) / 4  # at four nodes
    exact = SMALL * (1 - np.exp(-motion.frame_times / time))
    # the damped scheme takes the rate of the step for that of its end
    assert np.abs(strain - exact).max() < (1e-3 if isinstance(scheme, EnergyMomentum) else 3e-2) * SMALL
    if isinstance(scheme, EnergyMomentum):
        assert abs(motion.viscous_work[-1] / (motion.work[-1] / 2) - 1) < 1e-2  # exp(-5)
        assert np.ptp(motion.energy - motion.work + motion.viscous_work) < 1e-9 * motion.work[-1]


@pytest.mark.parametrize("volumetric", [None, 2])
def test_rigid_motions_are_not_resisted_and_forces_are_derivatives(volumetric):
    solid = bar(Viscosity(0.7), volumetric=volumetric, prony=[(1 / 3, 0.3)]).solids[0]
    rng, space, h = np.random.default_rng(0), solid.space, 0.1
    q = space.q0 + 0.05 * rng.standard_normal(space.n_dofs)
    turn = fc.rotation_about((1, 2, 3), 1.1)
    turned = (q.reshape(-1, 3) @ turn.T).ravel()
    memory = solid.relaxed(q)
    solid = solid.remembering(memory)
    step = solid.lapse(q, turned, h)
    assert np.abs(step.forces).max() < 1e-12 * E
    assert step.lost < 1e-24
    assert step.stored < 1e-24
    assert np.abs(solid.relaxed(turned) - memory).max() < 1e-13
    # work = stored + dissipated, from any state to any other
    other = q + 0.05 * rng.standard_normal(space.n_dofs)
    step = solid.lapse(q, other, h)
    work = step.forces @ (other - q)
    assert abs(work - step.stored - step.lost) < 1e-12 * work
    d = rng.standard_normal(space.n_dofs)
    ahead, behind = (solid.lapse(q, q + s * 1e-6 * d, h).forces for s in (1, -1))
    change = (ahead - behind) / 2e-6
    # at the beginning of a step there is no viscous stress, so that the tangent is exact
    assert np.abs(solid.viscous_tangent(q, h) @ d - change).max() < 1e-7 * np.abs(change).max()


@pytest.mark.full
def test_a_blow_fades_and_the_energy_is_accounted_for(tmp_path):
    a = bar(Viscosity(0.01), density=1.0, law=fc.NeoHookean, supports={"x_min": "xyz"}, prony=[(0.5, 0.2)])
    blow = a.solids[0].space.affine(np.diag([0.3, 0.0, 0.0]))
    run = {"step": 0.05, "scheme": EnergyMomentum(), "velocity": blow, "every": 10}
    motion = move(a, until=1.5, **run)
    assert motion.success
    assert motion.drift < 1e-8
    assert motion.energy[-1] < 0.1 * motion.energy[0]
    assert (np.diff(motion.viscous_work) >= 0).all()
    # memory is kept in files and by what goes on; the last digit of the times differs
    half = move(a, until=1.0, path=tmp_path / "run.npz", **run)
    assert np.abs(move(a, until=1.5, path=tmp_path / "run.npz", **run).now.q - motion.now.q).max() < 1e-10
    onwards = move(a, until=1.5, start=half.now, step=0.05, scheme=EnergyMomentum())
    assert np.abs(onwards.now.q - motion.now.q).max() < 1e-9
    # statics knows the relaxed material, which stays at rest
    pull = traction(a.solids[0].space, "x_max", (1.0, 0.0, 0.0))
    still = equilibrium(lambda s: Stage(a, forces=s * pull), steps=2)
    after = move(a, until=0.1, step=0.05, start=still.last, forces=pull)
    assert np.abs(after.now.q - still.last.q).max() < 1e-8


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({}, ("retardation",)),
        ({"retardation": -1.0}, ("retardation",)),
        ({"prony": [(0.5, 0.0)]}, ("retardation",)),
        ({"prony": [(0.5, np.inf)]}, ("retardation",)),
        ({"prony": [0.5, 1.0]}, ("prony-series", "[0.5, 1.0]")),
    ],
)
def test_refused(given, match):
    with refused(fc.InputError, *match):
        Viscosity(**given)


def test_former_branches_warn_and_are_the_same():
    with pytest.warns(DeprecationWarning, match="Viscoelastic"):
        former = bar(Viscosity(0.7, prony=BESIDE)).solids[0]
    now = bar(Viscosity(0.7), prony=PRONY).solids[0]
    assert abs(now.materials[0].E / former.materials[0].E - 1) < 1e-14
    assert now.viscous.retardation == former.viscous.retardation
    assert np.abs(now.viscous.branches - former.viscous.branches).max() < 1e-14


def test_one_series_for_all_materials():
    space = AncfSpace(fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8"))
    soft = fc.Viscoelastic(fc.Material(E, 0.3), PRONY)
    with refused(fc.InputError, "prony-series", "Viscosity"):
        AncfSolid(space, soft, viscosity=Viscosity(prony=BESIDE))
    with refused(fc.InputError, "prony-series", "element sets"):
        AncfSolid(space, {"one": soft, "two": fc.Material(E, 0.3)})
