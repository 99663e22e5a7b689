"""Shares of a stiffness against the whole one; messages. What needs PETSc is in unit/scene/test_engine.py."""

import socket
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse as sp

import fecontact as fc
from fecontact.fem.petsc.job import START, _package
from fecontact.fem.petsc.parts import bisected, cells_of, layout
from fecontact.fem.petsc.shared import block_rows, receive, send

STEEL, RUBBER = fc.Material(2.0, 0.3), fc.Material(1.0, 0.4995)


def bodies():
    """A block of 20-node elements of a nearly incompressible material, and a ball with collapsed elements."""
    block = fc.shapes.block((2.0, 1.7, 1.0), (3, 2, 2))
    ball = fc.shapes.quarter_sphere(1.0, contact_radius=0.3, level=1)
    return [
        fc.ElasticBody(block, RUBBER, "top", {"bottom": "xyz"}, name="block"),
        fc.ElasticBody(ball, STEEL, "cap", {"base": "xyz"}, name="ball"),
    ]


def whole(rows, n):
    """The matrix of block rows of all processes."""
    return sp.vstack([sp.bsr_matrix((v, j, i), shape=(3 * (len(i) - 1), 3 * n)) for i, j, v in rows])


@pytest.mark.parametrize("n_ranks", [1, 3])
def test_the_shares_are_the_stiffness(n_ranks):
    """Every process' rows, put together, are the stiffness that one process assembles (its source)."""
    models = [body.model for body in bodies()]
    placed = layout(models, n_ranks)
    points = np.empty((placed.node_ends[-1], 3))
    cells = []
    for model, number in zip(models, placed.nodes, strict=True):
        points[number] = model.mesh.points
        cells += cells_of(model, number)
    ends = placed.node_ends
    found = whole([block_rows(points, cells, a, b) for a, b in pairwise(ends)], len(points))
    for model, number in zip(models, placed.nodes, strict=True):
        K = model.stiffness + sp.triu(model.stiffness, 1).T
        dofs = (3 * number[:, None] + np.arange(3)).ravel()
        assert abs(found.tocsr()[dofs][:, dofs] - K).max() < 1e-13 * abs(K).max()
    assert found.nnz >= sum((m.stiffness + sp.triu(m.stiffness, 1).T).nnz for m in models)


def test_every_solved_unknown_has_its_own_place():
    models = [body.model for body in bodies()]
    placed = layout(models, 4)
    every = np.concatenate(placed.places)
    assert len(np.unique(every)) == len(every) == sum(len(m.solved_dofs) for m in models)
    assert every.max() < placed.size == sum(m.n_dofs for m in models)
    assert np.ptp(np.diff(placed.node_ends)) <= 1


def test_bisection_makes_compact_parts_of_equal_size():
    """Of a cube in eight, each part is a smaller cube; three parts of a bar are slices."""
    x = np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    part = bisected(x, 8)
    assert np.bincount(part).tolist() == [8] * 8
    assert all(np.ptp(x[part == k], axis=0).max() == 1.0 for k in range(8))
    bar = np.random.default_rng(0).random((90, 3)) * (30.0, 1.0, 1.0)
    thirds = [bar[bisected(bar, 3) == k, 0] for k in range(3)]
    assert [len(each) for each in thirds] == [30, 30, 30]
    assert thirds[0].max() < thirds[1].min() < thirds[1].max() < thirds[2].min()


def test_a_message_that_breaks_off_is_an_end():
    here, there = socket.socketpair()
    send(here, what="rows", x=np.arange(5))
    assert receive(there)["x"].tolist() == [0, 1, 2, 3, 4]
    here.sendall(b"\x10\0\0\0\0\0\0\0half")
    here.close()
    with pytest.raises(ConnectionError):
        receive(there)
    there.close()


#: Finds no packages but NumPy and a stand-in for petsc4py.
BARE = """
import sys, types
class Bare:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] not in {*sys.stdlib_module_names, "numpy", "fecontact"}:
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Bare())
sys.modules["petsc4py"] = types.SimpleNamespace(PETSc=types.SimpleNamespace(COMM_WORLD=None))
"""


def test_a_process_needs_numpy_and_petsc4py_only():
    """Processes may run in the system's Python, without what the program has."""
    begin = START.removesuffix(" main()")
    assert begin != START
    said = subprocess.run([sys.executable, "-c", BARE + begin, _package()], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stderr) == (0, "")
    other = BARE + "import fecontact.fem.petsc.job"
    refused = subprocess.run([sys.executable, "-c", other], capture_output=True, text=True, check=False)
    assert "ModuleNotFoundError" in refused.stderr
