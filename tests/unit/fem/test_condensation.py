"""Ways to the compliance: Schur complement, columns and operator give one answer, and the choice between them."""

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused

import fecontact as fc
from fecontact import InputError
from fecontact.bodies import rotation_about
from fecontact.common.stopwatch import Stopwatch
from fecontact.fem import condensation, model
from fecontact.fem.condensation import FEW_ROWS, MANY_NODES, MANY_PRODUCTS, choose_route, memory_budget
from fecontact.fem.factor import available_backends, bordered, factorise, has_bordered
from fecontact.fem.stiffness import assemble_stiffness
from fecontact.scene import linear as scene_module

# projected conjugate gradients stop at 1e-12 of the deflection; the forces have that times the condition of S, 1e2
SAME = 1e-9
ROUTES = ("schur", "columns", "operator")


def ball_on_block(route, backend="auto", **supports):
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (5, 4, 3))
    material = fc.Material(E=1.0, nu=0.3)
    held = supports or {"bottom": "xyz"}
    body = fc.ElasticBody(mesh, material, "top", held, name="block", backend=backend, condensation=route)
    ball = fc.RigidBody(fc.Sphere(3.0), name="ball").placed(translation=(0.1, 0.05, 4.0))
    return body, ball, fc.Scene([body, ball], [fc.Contact(body, ball)])


def same(a, b):
    return np.abs(a - b).max() <= SAME * np.abs(b).max()


@pytest.mark.parametrize("backend", available_backends())
@pytest.mark.parametrize("route", ["columns", "operator"])
def test_routes_give_the_same_answer(route, backend):
    results = []
    for way in ("schur", route):
        body, ball, scene = ball_on_block(way, backend)
        loads = {ball: (0.0, 0.0, -0.02), (body, "x_max"): (0.01, 0.0, 0.005)}
        # one linear problem: poses would end within the tolerance of their steps only, 1e-4 of the deflection
        results.append((scene.solve(forces=loads, finite_motion=False), body))
    (first, a), (second, b) = results
    assert second.condensation == {"block": f"{route}: as asked"}
    assert f"compliance of block by {route}" in str(second)
    assert first.n_active == second.n_active
    assert same(second.contacts[0].forces, first.contacts[0].forces)
    assert same(second.displacement(b), first.displacement(a))


@pytest.mark.parametrize("route", ["columns", "operator"])
def test_floating_body_between_two_routes(route):
    """A body on rollers under a dense one, its mean position held in the plane: operators and arrays are added."""
    forces = []
    for way in ("schur", route):
        mesh = fc.shapes.block((1.0, 1.0, 0.6), (4, 4, 2))
        material = fc.Material(E=1.0, nu=0.3)
        base = fc.ElasticBody(mesh, material, "top", {"bottom": "xyz"}, name="base", condensation="schur")
        lid = fc.ElasticBody(mesh, material, ("bottom", "top"), name="lid", condensation=way)
        lid = lid.placed(translation=(0.0, 0.0, 0.6))
        scene = fc.Scene([base, lid], [fc.Contact(lid, base, surfaces=("bottom", "top"))])
        loads = {(lid, "top"): (0.0, 0.0, -0.01)}
        forces.append(scene.solve(forces=loads, motions={lid: {"x": 0.0, "y": 0.0, "rz": 0.0}}).contacts[0].forces)
    assert same(forces[1], forces[0])


def test_dense_solvers_get_an_array():
    _, ball, scene = ball_on_block("operator")
    expected = scene.solve(forces={ball: (0.0, 0.0, -0.02)}, finite_motion=False)
    found = scene.solve(forces={ball: (0.0, 0.0, -0.02)}, finite_motion=False, solver="nnls")
    assert expected.solution.solver == "projected-cg"
    assert found.solution.solver == "nnls"
    assert same(found.contacts[0].forces, expected.contacts[0].forces)


def test_two_poses_of_one_model_share_the_factor(monkeypatch):
    calls = []
    monkeypatch.setattr(model, "factorise", lambda K, backend: calls.append(K.shape) or factorise(K, backend))
    monkeypatch.setattr(model, "bordered", lambda K, C: calls.append(K.shape) or bordered(K, C))
    forces = []
    for route in ROUTES:
        mesh = fc.shapes.quarter_sphere(1.0, contact_radius=0.1, level=1, element="hex8")
        supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
        upper = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "cap", supports, name="upper", condensation=route)
        turn = rotation_about((1.0, 1.0, 0.0), np.pi)
        lower = upper.placed(rotation=turn, name="lower")
        scene = fc.Scene([upper, lower], [fc.Contact(upper, lower)])
        out = scene.solve(motions={upper: {"z": -0.01}})
        forces.append(out.contacts[0].forces)
        assert list(out.condensation) == ["upper"]
    assert len(calls) == 2  # columns and operator, one each
    assert same(forces[1], forces[0])
    assert same(forces[2], forces[0])


def test_a_plain_factor_serves_any_candidates():
    body, *_ = ball_on_block("operator")
    top, side = (body.mesh.boundary_nodes(n) for n in ("top", "x_max"))
    first = body.model.condensed(top, Stopwatch())
    assert body.model.condensed(side, Stopwatch()) is first


@pytest.mark.skipif(not has_bordered("auto"), reason="without PARDISO rows are solved for one by one")
def test_many_poses_are_condensed_once_after_a_case_by_columns(monkeypatch):
    body, *_ = ball_on_block("auto")
    top = body.mesh.boundary_nodes("top")
    rows = sp.csr_matrix((np.ones(len(top)), (np.arange(len(top)), 3 * top + 2)), shape=(len(top), body.n_dofs))
    rows = body.model.solved_rows(rows)
    chosen = ["columns"]
    monkeypatch.setattr(model, "choose_route", lambda *given: (chosen[0], ""))
    first = body.model.condensed(top, Stopwatch(), rows=rows)
    assert first.route == "columns"
    assert body.model.condensed(top, Stopwatch(), poses=2) is first
    chosen[0] = "schur"
    assert body.model.condensed(top, Stopwatch()) is first
    shared = body.model.condensed(top, Stopwatch(), poses=20)
    assert shared.route == "schur"
    assert body.model.condensed(top, Stopwatch(), rows=rows) is shared
    assert same(first.compliance(rows), shared.compliance(rows))


def test_the_choice_goes_by_nodes_and_memory(monkeypatch):
    many = 3 * int(100 * MANY_NODES)
    assert choose_route(10000, 300, 1e9)[0] == "schur"
    assert choose_route(10000, many, 1e12)[0] == "columns"
    # with friction, three rows on each node
    assert choose_route(10000, many, 1e12, n_rows=many)[0] == "schur"
    assert choose_route(10000, many, 1e12, n_rows=many // 2)[0] == "columns"
    assert choose_route(10000, many, 1e12, one_by_one=True)[0] == "schur"
    assert choose_route(10000, 3 * int(100 * MANY_PRODUCTS), 1e12, one_by_one=True)[0] == "operator"
    # many rows on few nodes are few columns, whatever solves for them
    assert choose_route(10000, 3 * 8, 1e12, one_by_one=True, n_rows=int(100 * MANY_PRODUCTS))[0] == "schur"
    told = choose_route(10000, 3000, 1e12, one_by_one=True, n_rows=900)
    assert told == ("schur", "900 rows on 1000 candidate nodes, fewer than 1000")
    # few rows of a small model, once
    assert choose_route(3000, 180, 1e9, n_rows=60)[0] == "columns"
    for others in ({"n_rows": 101}, {"n_rows": 60, "poses": 20, "factor": 5e7}, {}):
        assert choose_route(3000, 300, 1e9, **others)[0] == "schur"
    assert choose_route(3000, 60, 1e9, n_rows=60)[0] == choose_route(5000, 180, 1e9, n_rows=60)[0] == "schur"
    # several poses: dense once against products, and against columns only where it is quicker in all
    # rows on many nodes, as of a mortar coupling, are solved for themselves, for many poses too
    for poses in (1, 20):
        for rows, route in ((many // FEW_ROWS, "columns"), (many // FEW_ROWS + 1, "schur")):
            assert choose_route(10000, many, 1e12, poses, one_by_one=True, n_rows=rows)[0] == route
    assert choose_route(10000, many, 1e12, poses=20, one_by_one=True)[0] == "schur"
    assert choose_route(10000, many, 1e12, poses=20, factor=5e7)[0] == "schur"
    assert choose_route(10000, 10 * many, 1e12, poses=20, factor=5e7)[0] == "columns"
    assert choose_route(10000, many, 1e12, poses=2, factor=1e6)[0] == "columns"
    # rows that are known count by their number, whatever the nodes they are on
    assert choose_route(400_000, 60_000, 4e9)[0] == "operator"
    assert choose_route(400_000, 60_000, 4e9, n_rows=300)[0] == "columns"
    assert choose_route(400_000, 60_000, 4e9, n_rows=300, one_by_one=True)[0] == "columns"
    assert choose_route(400_000, 60_000, 4e9, n_rows=15_000)[0] == "operator"
    # S of 1000 nodes takes 40 MB with its copies, the Schur complement on them 180 MB more
    assert choose_route(1000_000, 3000, 1e8)[0] == "columns"
    assert choose_route(10000, 300, 1e5) == ("operator", "a dense matrix for 100 nodes takes 0.0004 GB of 0.0001 GB")
    assert memory_budget() > 0
    monkeypatch.setattr(model, "memory_budget", lambda: 1e3)
    _, ball, scene = ball_on_block("auto")
    result = scene.solve(forces={ball: (0.0, 0.0, -0.02)})
    assert result.condensation["block"].startswith("operator: a dense matrix for")
    monkeypatch.setattr(model, "memory_budget", lambda: 1e9)
    _, ball, scene = ball_on_block("auto")
    assert scene.solve(forces={ball: (0.0, 0.0, -0.02)}).condensation["block"] == "columns: 12 rows of a small model"


@pytest.mark.parametrize("backend", available_backends())
def test_factor_solves(backend):
    rng = np.random.default_rng(3)
    A = rng.normal(size=(30, 30))
    K = A @ A.T + 30 * np.eye(30)
    b = rng.normal(size=(4, 30))
    factor = factorise(sp.csr_matrix(np.triu(K)), backend)
    # condition below 1e2
    assert np.abs(factor.solve(b) - np.linalg.solve(K, b.T).T).max() < 1e-13
    assert factor.memory > 0


def test_unknown_route():
    with refused(InputError, "unknown-name", "'schur', 'columns', 'operator'"):
        ball_on_block("banded")


def test_where_products_do_not_do_the_array_is_formed(monkeypatch):
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    material = fc.Material(E=1.0, nu=0.3)

    def force(condensation):
        block = fc.ElasticBody(mesh, material, "bottom", {"top": "xyz"}, condensation=condensation)
        floor = fc.RigidBody(fc.Plane())
        return (
            fc.Scene([block, floor], [fc.Contact(block, floor)]).solve(motions={block: {"z": -0.01}}).contacts[0].forces
        )

    expected, asked = force("schur"), []
    real = scene_module.solve

    def unable(problem, *args, **options):
        asked.append(isinstance(problem.S, np.ndarray))
        if not asked[-1]:
            raise fc.SolverError("conjugate gradients gave up")
        return real(problem, *args, **options)

    monkeypatch.setattr(scene_module, "solve", unable)
    found = force("operator")
    # the check of the solver's options asks once, with an array
    assert asked[-2:] == [False, True]
    assert np.abs(found - expected).max() < 1e-9 * expected.max()


def bordered_case(n_rows=30, route="columns"):
    body, *_ = ball_on_block(route)
    nodes = body.mesh.boundary_nodes("top")[:n_rows]
    rows = sp.csr_matrix((np.full(len(nodes), -1.0), (np.arange(len(nodes)), 3 * nodes + 2)), (len(nodes), body.n_dofs))
    C = body.model.solved_rows(rows)
    return body.model, nodes, C


@pytest.mark.skipif(not has_bordered(), reason="needs PARDISO")
def test_the_compliance_of_rows_comes_with_the_factor():
    """In any units, with rows that depend on each other; other rows cost right-hand sides or another factor."""
    model_, nodes, C = bordered_case()
    K = model_.solved_stiffness()
    plain = factorise(K.copy())
    twice = sp.vstack([C, C[3:7], sp.csr_matrix((2, C.shape[1]))], format="csr")
    expected = twice @ plain.solve(twice.toarray()).T
    for unit in (1.0, 1e-9, 1e12):
        found = bordered(unit * K, twice)
        assert same(unit * found.compliance, expected)
        assert (found.compliance == found.compliance.T).all()
        f = np.random.default_rng(1).normal(size=(2, K.shape[0]))
        assert same(unit * found.solve(f), plain.solve(f))
    known = model_.condensed(nodes, Stopwatch(), rows=C)
    assert isinstance(known, condensation.Bordered)
    assert model_.condensed(nodes[:4], Stopwatch(), rows=C[:4]) is known
    assert same(known.compliance(C[[5, 2]]), expected[np.ix_([5, 2], [5, 2])])
    other = C.copy()
    other.data *= 2.0
    assert same(known.compliance(other), 4 * expected[: len(nodes), : len(nodes)])
    assert model_.condensed(nodes, Stopwatch(), rows=other) is not known
    assert model_.condensed(nodes, Stopwatch()) is model_.condensation


@pytest.mark.skipif(not has_bordered(), reason="needs PARDISO")
def test_many_rows_on_few_nodes_are_condensed_onto_these():
    """As under cells finer than the faces: rows on the same nodes need no other factor, others do."""
    model_, nodes, C = bordered_case(4, "auto")
    mix = sp.csr_matrix(np.random.default_rng(0).normal(size=(40, 4)))
    rows = sp.csr_matrix(mix @ C)
    plain = factorise(model_.solved_stiffness().copy())
    known = model_.condensed(nodes, Stopwatch(), rows=rows)
    assert isinstance(known, condensation.Schur)
    assert known.n_retained == 12
    assert same(known.compliance(rows), rows @ plain.solve(rows.toarray()).T)
    assert model_.condensed(nodes, Stopwatch(), rows=2 * rows[::-1]) is known
    assert model_.condensed(nodes[:1], Stopwatch(), rows=C[:1]) is known
    assert model_.condensed(bordered_case(9)[1], Stopwatch(), rows=bordered_case(9)[2]) is not known


@pytest.mark.skipif(not has_bordered(), reason="needs PARDISO")
def test_the_stiffness_is_kept_where_rows_change_again(monkeypatch):
    """One condensation discards it; from the second on, as from pose to pose, it is assembled no more."""
    model_, nodes, C = bordered_case()
    calls = []
    monkeypatch.setattr(model, "assemble_stiffness", lambda *a: calls.append(1) or assemble_stiffness(*a))
    answers = []
    for size in (1.0, 2.0, 4.0, 1.0):
        rows = sp.csr_matrix(size * C)
        answers.append(model_.condensed(nodes, Stopwatch(), rows=rows).compliance(rows) / size**2)
        assert len(calls) == min(len(answers), 2)
    assert all(same(each, answers[0]) for each in answers)


@pytest.mark.skipif(not has_bordered(), reason="needs PARDISO")
def test_a_loose_body_has_no_bordered_factor():
    model_, *_ = bordered_case()
    K = model_.coordinates.stiffness(model_.stiffness)
    C = sp.csr_matrix(([1.0], ([0], [2])), shape=(1, K.shape[0]))
    with refused(fc.FecontactError, "singular"):
        bordered(K, C)


@pytest.mark.skipif(not has_bordered(), reason="needs PARDISO")
def test_a_steeply_graded_body_that_floats_is_not_taken_for_loose():
    """Rows that depend on each other replace pivots, and products with K round by more than a millionth of the load."""
    level = fc.shapes.Level(core=1, rings=3, edge=0.2, layer=0.2, growth=4.0)
    mesh = fc.shapes.quarter_sphere(25.0, contact_radius=0.01, level=level, element="hex8")
    model_ = fc.ElasticBody(mesh, fc.Material(E=2e6, nu=0.3), "cap", {"sym_x": "x", "sym_y": "y"}).model
    K = model_.solved_stiffness()
    row = sp.csr_matrix(([1.0], ([0], [K.shape[0] - 1])), shape=(1, K.shape[0]))
    found = bordered(K, sp.vstack([row, row], format="csr"))
    plain = factorise(K.copy()).solve(row.toarray())[0] @ row.toarray()[0]
    # rounding of 1e-16 times the ratio of stiffnesses: faces of 0.002 on a body of 25, and its free motion
    assert np.abs(found.compliance / plain - 1).max() < 1e-6
    f = np.random.default_rng(0).uniform(0.5, 1.5, K.shape[0])
    x = found.solve(f[None])[0]
    assert np.abs(K @ x + K.T @ x - K.diagonal() * x - f).max() > 1e-6
