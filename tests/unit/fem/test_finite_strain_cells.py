"""Cells at finite strain: forces and tangent against differences by order, limits, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from skfem import MeshTet, MeshTet2

import fecontact as fc
from fecontact.bodies.elastic import ElasticBody
from fecontact.fem.finite_strain import KEPT, State, at_state
from fecontact.fem.laws import InvertedError
from tests.refusals import refused

NEO = fc.NeoHookean(E=1.0, nu=0.45)
NEARLY = fc.NeoHookean(E=1.0, nu=0.495)
MOONEY = fc.MooneyRivlin(c10=0.15, c01=0.05, bulk=30.0)
OGDEN = fc.Ogden(mu=(0.3, 0.1), alpha=(2.0, -2.0), bulk=3.0)
SECTION = fc.sections.rectangle((1.0, 1.0), (2, 2))


def solid(element: str) -> fc.Mesh:
    if element.startswith("tet"):
        axis = np.linspace(0, 1, 2)
        return fc.Mesh.from_skfem(MeshTet2.from_mesh(MeshTet.init_tensor(axis, axis, axis)))
    return fc.shapes.block((1.0, 1.0, 1.0), (1, 2, 1), element=element)


BODIES = {
    **{
        f"{element}-{name}": (ElasticBody, lambda e=element: solid(e), law)
        for element in ("hex8", "hex20", "hex27", "tet10")
        for name, law in {"neo": NEO, "nearly": NEARLY, "mooney": MOONEY}.items()
    },
    **{
        f"{kind.__name__}-{name}": (kind, lambda: SECTION, law)
        for kind in (fc.PlaneBody, fc.AxisymmetricBody)
        for name, law in {"neo": NEO, "nearly": NEARLY, "ogden": OGDEN}.items()
    },
}


def deformed(kind, mesh, law):
    """Cells, a state of random displacements with its pressures, and a direction; without y in sections."""
    body = kind(mesh, law, supports={})
    cells = body._finite_strain
    random = np.random.default_rng(3)
    u, d = (random.uniform(-1, 1, (len(mesh.points), 3)) for _ in range(2))
    if kind is not ElasticBody:
        on_axis = mesh.points[:, 0] == 0
        for v in (u, d):
            v[:, 1] = 0.0
            v[on_axis, 0] = 0.0
    u, d = 0.01 * u.ravel(), d.ravel()
    return body, cells, cells.advanced(State(u, cells.rest.pressures), np.zeros_like(u)), d


@pytest.mark.parametrize(("kind", "mesh", "law"), BODIES.values(), ids=BODIES)
def test_forces_and_tangent_are_derivatives_by_order(kind, mesh, law) -> None:
    body, cells, state, d = deformed(kind, mesh(), law)
    assert body.model.selective == (law is not NEO and law is not OGDEN)
    at = cells.at(state)
    K = at.stiffness + sp.triu(at.stiffness, 1).T
    moving = np.ones(len(d), bool) if kind is ElasticBody else np.arange(len(d)) % 3 != 1
    errors = []
    for h in (1e-3, 5e-4):
        ahead, behind = (cells.at(State(state.u + s * h * d, state.pressures), tangent=False) for s in (1, -1))
        forces = (ahead.forces - behind.forces) / (2 * h) - K @ d
        errors.append([np.abs(forces[moving]).max(), abs((ahead.energy - behind.energy) / (2 * h) - at.forces @ d)])
    assert np.divide(*errors) == pytest.approx(4.0, abs=0.15)
    assert errors[1][0] < 3e-3 * np.abs(K @ d).max()


@pytest.mark.parametrize("element", ["hex8", "hex20", "hex27", "tet10"])
@pytest.mark.parametrize("law", [NEO, NEARLY], ids=["full", "selective"])
def test_the_tangent_at_rest_is_the_linear_stiffness(element: str, law: fc.NeoHookean) -> None:
    body = fc.ElasticBody(solid(element), law)
    K = body._finite_strain.at(body._finite_strain.rest).stiffness
    assert abs(K - body.model.stiffness).max() < 1e-14 * abs(K).max()


def test_a_rotated_body_has_no_forces_and_a_stretched_one_those_of_its_law() -> None:
    mesh = solid("hex20")
    for law in (NEO, NEARLY, MOONEY, fc.StVenantKirchhoff(1.0, 0.3), fc.HolmesMow(1.0, 0.2, beta=0.5)):
        cells = fc.ElasticBody(mesh, law)._finite_strain
        turn = fc.rotation_about((1.0, 2.0, 3.0), 1.0)
        turned = cells.at(State((mesh.points @ turn.T - mesh.points).ravel(), cells.rest.pressures), tangent=False)
        assert np.abs(turned.forces).max() < 1e-12
        assert abs(turned.energy) < 1e-13
        F = turn @ np.diag([1.3, 0.9, 0.8])
        u = (mesh.points @ (F - np.eye(3)).T).ravel()
        stress, strain = cells.fields(u)
        exact = law.cauchy(F)
        assert np.abs(stress - exact[(0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)]).max() < 1e-11
        logarithm = turn @ np.diag(np.log([1.3, 0.9, 0.8])) @ turn.T
        assert np.abs(strain[..., 3] - logarithm[0, 1]).max() < 1e-12
        assert cells.at(State(u, cells.rest.pressures), tangent=False).energy == pytest.approx(
            float(law.response(F).energy), rel=1e-12
        )


def test_two_laws_by_element_sets_are_those_of_two_bodies() -> None:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 1, 1), element="hex8")
    both = replace(mesh, groups={"one": np.array([0]), "two": np.array([1])})
    u = 0.02 * np.random.default_rng(0).standard_normal(3 * len(mesh.points))

    def forces(material) -> np.ndarray:
        cells = fc.ElasticBody(both, material)._finite_strain
        return cells.at(State(u, cells.rest.pressures), tangent=False).forces

    apart = forces({"one": NEO, "two": OGDEN}) + forces({"one": OGDEN, "two": NEO})
    assert np.abs(apart - forces(NEO) - forces(OGDEN)).max() < 1e-14


@pytest.mark.parametrize("kind", ["one edge", "wedge", "pyramid", "tetrahedron"])
@pytest.mark.parametrize("law", [NEO, NEARLY], ids=["full", "selective"])
def test_coalesced_cells_have_the_forces_of_their_energy(degenerate, kind: str, law: fc.NeoHookean) -> None:
    """In one cell of any kind, unusual ones too; uniform states are exact in it."""
    mesh = degenerate(kind)
    cells = fc.ElasticBody(mesh, law)._finite_strain
    F = fc.rotation_about((1.0, 2.0, 3.0), 1.0) @ np.diag([1.3, 0.9, 0.8])
    u, d = (mesh.points @ (F - np.eye(3)).T).ravel(), np.random.default_rng(0).uniform(-1, 1, mesh.points.size)
    volume = sum(part.points.dV.sum() for part in cells.parts)
    at = cells.at(cells.advanced(State(u, cells.rest.pressures), 0 * u))
    assert at.energy == pytest.approx(float(law.response(F).energy) * volume, rel=1e-12)
    errors = []
    for h in (2e-3, 1e-3):
        ahead, behind = (cells.at(State(u + s * h * d, cells.rest.pressures), tangent=False) for s in (1, -1))
        K = at.stiffness + sp.triu(at.stiffness, 1).T
        forces = np.abs((ahead.forces - behind.forces) / (2 * h) - K @ d).max()
        errors.append([forces, abs((ahead.energy - behind.energy) / (2 * h) - at.forces @ d)])
    assert np.divide(*errors) == pytest.approx(4.0, abs=0.15)


def test_pressure_follows_the_change_of_volume() -> None:
    body, cells, state, _ = deformed(fc.ElasticBody, solid("hex20"), NEARLY)
    again = cells.advanced(State(state.u, tuple(0 * p for p in state.pressures)), np.zeros(body.n_dofs), 0.25)
    assert all(np.abs(a - 0.25 * b).max() < 1e-14 for a, b in zip(again.pressures, state.pressures, strict=True))


def test_what_is_not_offered_is_refused() -> None:
    mesh = solid("hex8")
    with refused(fc.InputError, "no-volumetric-part", "HolmesMow"):
        fc.ElasticBody(mesh, fc.HolmesMow(1.0, 0.49, beta=0.3))
    with refused(fc.InputError, "finite-strain-section", "plane stress"):
        fc.PlaneBody(SECTION, NEO, plane="stress")
    with refused(fc.InputError, "finite-strain-section", "torsion"):
        fc.AxisymmetricBody(SECTION, NEO, torsion=True)
    body = fc.ElasticBody(mesh, NEO)
    u = (mesh.points * [-1.5, 0.0, 0.0]).ravel()
    with refused(InvertedError, "inverted-material", "-0.5"):
        body._finite_strain.at(State(u, body._finite_strain.rest.pressures))
    both = replace(mesh, groups={"one": np.array([0]), "two": np.array([1])})
    with refused(fc.InputError, "some-laws", "Material"):
        fc.ElasticBody(both, {"one": NEO, "two": fc.Material(1.0, 0.3)})


@pytest.mark.parametrize(("kind", "mesh"), [(ElasticBody, solid("hex8")), (fc.AxisymmetricBody, SECTION)])
def test_a_model_at_a_state_keeps_the_coordinates_that_are_solved(kind, mesh) -> None:
    """Pinned ones among them: chosen anew on present points they may be others than those left out of the solve."""
    body, cells, state, _ = deformed(kind, mesh, NEO)
    at = at_state(cells, state)
    assert all(getattr(at, name) is getattr(body.model, name) for name in ("pinned_dofs", "solved_dofs", "held"))
    assert kind is ElasticBody or all(hasattr(body.model, name) for name in KEPT)
