"""A stiffness assembled elsewhere, on scikit-fem's forms or by hand, as a body of a scene."""

import pickle

import numpy as np
import pytest
import scipy.sparse as sp
from refusals import refused
from skfem import (
    Basis,
    ElementHex1,
    ElementHex2,
    ElementTetP1,
    ElementTetP2,
    ElementVector,
    ElementWedge1,
    MeshHex,
    MeshHex2,
    MeshTet,
    MeshWedge1,
)
from skfem.models.elasticity import linear_elasticity
from skfem.quadrature import get_quadrature
from skfem.refdom import RefLine, RefTri

import fecontact as fc
from fecontact import InputError
from fecontact.common.fingerprint import fingerprint

RUBBER = fc.Material(E=2.0, nu=0.3)
HELD = {"top": "xyz"}
CASES = {
    "hex8": (MeshHex().refined(2), ElementHex1, 3),
    "hex27": (MeshHex().refined(1), ElementHex2, 5),
    "tet4": (MeshTet().refined(1), ElementTetP1, 1),
    "tet10": (MeshTet().refined(1), ElementTetP2, 2),
    "wedge6": (MeshWedge1(), ElementWedge1, 5),
}


def _basis(case):
    mesh, element, order = CASES[case]
    mesh = mesh.with_boundaries({"top": lambda x: x[2] == 1, "bottom": lambda x: x[2] == 0})
    if case == "wedge6":
        return Basis(mesh, ElementVector(element()), quadrature=_wedge_rule(order))
    return Basis(mesh, ElementVector(element()), intorder=order)


def _wedge_rule(order):
    """Triangle times line; the weights of scikit-fem's own rule for wedges add up to half the volume (12.0.2)."""
    (X, W), (Z, V) = get_quadrature(RefTri, order), get_quadrature(RefLine, order)
    points = np.concatenate([np.repeat(X, len(V), axis=1), np.tile(Z, len(W))])
    return points, np.outer(W, V).ravel()


def _assembled(case):
    basis = _basis(case)
    return basis, linear_elasticity(RUBBER.lame, RUBBER.shear_modulus).assemble(basis)


def _forces(body):
    """Contact forces of a body that is pressed on a ball that is not in its middle."""
    ball = fc.RigidBody(fc.Sphere(3.0), name="ball").placed((0.47, 0.52, -6.0))
    result = fc.Scene([body, ball], contacts=[fc.Contact(body, ball)]).solve(forces={body: (0, 0, -0.05)})
    return result.contacts[0].forces


@pytest.mark.by_day("hex8", "tet10", "wedge6")
@pytest.mark.parametrize("case", CASES)
def test_contact_forces_are_those_of_our_own_stiffness(case):
    basis, K = _assembled(case)
    given = fc.AssembledBody.from_skfem(basis, K, RUBBER, contact="bottom", supports=HELD)
    assert list(given.mesh.kinds) == [case]
    assert given.describe().startswith(given.name)
    assert given.notes == given.mesh.notes
    own = fc.ElasticBody(given.mesh, RUBBER, "bottom", HELD, pressure="nodal", integration="full")
    ours, theirs = own.model.stiffness, given.model.stiffness
    # two orders of summation
    assert np.abs((ours - theirs).toarray()).max() < 1e-12 * ours.data.max()
    forces = _forces(own)
    assert np.abs(forces - _forces(given)).max() < 1e-9 * forces.max()


def test_another_law_gives_other_forces():
    basis, K = _assembled("hex8")
    forces = [_forces(fc.AssembledBody.from_skfem(basis, k * K, RUBBER, "bottom", HELD)) for k in (1.0, 4.0)]
    # the same load on fewer nodes by a stiffer body
    assert np.abs(forces[0] - forces[1]).max() > 1e-3 * forces[0].max()


def test_a_copy_in_another_process_and_the_fingerprint():
    basis, K = _assembled("hex8")
    body = fc.AssembledBody.from_skfem(basis, K, RUBBER, "bottom", HELD)
    again = pickle.loads(pickle.dumps(body))
    assert (again.model.stiffness != body.model.stiffness).nnz == 0
    assert fingerprint(again) == fingerprint(body)
    assert fingerprint(fc.AssembledBody.from_skfem(basis, 2 * K, RUBBER, "bottom", HELD)) != fingerprint(body)


def test_a_stiffness_that_is_not_of_a_free_body_is_refused():
    basis, K = _assembled("hex8")
    make = fc.AssembledBody.from_skfem
    with refused(InputError, "no-sparse-stiffness", "375"):
        make(basis, K[:-3, :-3], RUBBER)
    with refused(InputError, "no-sparse-stiffness", "ndarray"):
        make(basis, K.toarray(), RUBBER)
    with refused(InputError, "stiffness-not-symmetric", "0.214"):
        make(basis, sp.triu(K), RUBBER)
    with refused(InputError, "stiffness-holds", "0.515"):
        make(basis, K + sp.eye(basis.N), RUBBER)
    with refused(InputError, "not-finite", "1 entries"):
        make(basis, sp.csr_matrix(K) + sp.csr_matrix(([np.nan], ([0], [0])), K.shape), RUBBER)
    with refused(InputError, "input", "needs stiffness"):
        fc.AssembledBody(fc.shapes.block((1, 1, 1), (1, 1, 1)), RUBBER)


def test_a_basis_that_is_none_of_displacements_is_refused():
    scalar = Basis(MeshHex(), ElementHex1())
    with refused(InputError, "no-skfem-basis", "ElementHex1", "MeshHex1"):
        fc.AssembledBody.from_skfem(scalar, sp.eye(scalar.N), RUBBER)
    flat = Basis(MeshHex2(), ElementVector(ElementHex1()))
    with refused(InputError, "basis-too-low", "has 27", "element 8"):
        fc.AssembledBody.from_skfem(flat, sp.eye(flat.N), RUBBER)
    part = Basis(MeshHex().refined(1), ElementVector(ElementHex1()), elements=[0, 1])
    with refused(InputError, "input", "spans 2", "of 8"):
        fc.AssembledBody.from_skfem(part, sp.eye(part.N), RUBBER)
