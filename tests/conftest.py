"""Meshes and matrices that several test folders share."""

import depths
import numpy as np
import pytest
from rounding import change_by_rounding

import fecontact as fc
from fecontact import Mesh, MissingPackageError
from fecontact.fem.stiffness import assemble_stiffness
from fecontact.mesh.element import hex_nodes
from fecontact.mesh.gmsh import load_gmsh


def pytest_addoption(parser, pluginmanager):
    pluginmanager.register(depths)
    parser.addoption(
        "--rounding", type=int, metavar="N", help="changes by rounding under which tests marked so run again"
    )


def pytest_configure(config):
    config.addinivalue_line("markers", "rounding(n=2): run again under n changes of coordinates by rounding")


def _changes(config, marker):
    """Numbers of the changes by rounding that are asked for."""
    given = config.getoption("rounding")
    if given is None:
        given = marker.args[0] if marker is not None and marker.args else 2
    return range(1, given + 1)


def pytest_generate_tests(metafunc):
    marker = metafunc.definition.get_closest_marker("rounding")
    changes = [] if marker is None or "changes" in metafunc.fixturenames else _changes(metafunc.config, marker)
    if len(changes):
        metafunc.fixturenames.append("rounding")
        metafunc.parametrize("rounding", [0, *changes], indirect=True, ids=["", *(f"rounding{k}" for k in changes)])


@pytest.fixture
def changes(request):
    """Numbers of the changes by rounding that are asked for."""
    return _changes(request.config, request.node.get_closest_marker("rounding"))


@pytest.fixture
def rounding(request, monkeypatch):
    """Number of the change by rounding under which the test runs; 0: none."""
    if request.param:
        change_by_rounding(monkeypatch, request.param)


# which nodes of the 20-node hexahedron fall together, as {node: node it falls on}
COALESCED = {
    "one edge": {2: 1, 9: 1},
    "wedge": {2: 1, 9: 1, 6: 5, 13: 5, 18: 17},
    "pyramid": dict.fromkeys((5, 6, 7, 12, 13, 14, 15), 4),
    "tetrahedron": dict.fromkeys((5, 6, 7, 12, 13, 14, 15), 4) | {2: 1, 9: 1, 18: 17},
}
# an affine map without symmetry, so that nothing is right by accident
AFFINE = np.array([[1.0, 0.2, 0.1], [-0.1, 0.8, 0.15], [0.05, -0.2, 1.2]])


def _degenerate(kind, n_nodes=20):
    """One straight-sided degenerate cell in general position."""
    points = hex_nodes(20).copy()
    target = np.arange(20)
    for node, other in COALESCED[kind].items():
        target[node] = other
    points[:8] = points[target[:8]]
    if kind in ("pyramid", "tetrahedron"):
        points[4:8] = points[4] + [0.3, 0.4, 0.0]
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    points[8:] = [(points[a] + points[b]) / 2 for a, b in edges]
    used, cells = np.unique(target[:n_nodes], return_inverse=True)
    return Mesh(points[used] @ AFFINE.T, cells[None, :])


def _curved(element="hex20", divisions=(2, 2, 2), amount=0.08):
    """Block with curved edges and faces everywhere: each point moved smoothly."""
    mesh = fc.shapes.block((1.0, 1.2, 0.9), divisions, element=element)

    def bend(x):
        wave = [np.sin(3 * x[:, 1] + x[:, 2]), np.cos(2 * x[:, 0] - x[:, 2]), np.sin(2 * x[:, 0] + 2 * x[:, 1])]
        return x + amount * np.stack(wave, axis=1)

    return mesh.mapped(bend)


def _dense_stiffness(mesh, material):
    n = len(mesh.cells)
    upper = assemble_stiffness(mesh, np.full(n, material.lame), np.full(n, material.shear_modulus)).toarray()
    return upper + np.triu(upper, 1).T


@pytest.fixture
def degenerate():
    return _degenerate


@pytest.fixture
def curved():
    return _curved


@pytest.fixture
def dense_stiffness():
    return _dense_stiffness


@pytest.fixture
def steel():
    return fc.Material(E=210e3, nu=0.3)


@pytest.fixture(scope="session")
def gmsh():
    """The module gmsh; tests that need it are skipped where it or a library of the system that it needs is missing."""
    try:
        return load_gmsh()
    except MissingPackageError as error:
        pytest.skip(str(error))
