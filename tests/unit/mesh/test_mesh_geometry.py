"""The way to scikit-fem and back, and scikit-fem's own assembly as an independent stiffness."""

import numpy as np
import pytest
from skfem import Basis, BilinearForm, ElementVector, MeshHex, MeshTet
from skfem.helpers import ddot, eye, sym_grad, trace

import fecontact as fc
from fecontact.common.errors import InputError, MeshError
from fecontact.fem.loads import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.skfem_mesh import MeshHex20, from_skfem, to_skfem

ELEMENTS = ["hex8", "hex20", "hex27"]
ORDER = {"hex8": 3, "hex20": 5, "hex27": 5}


@pytest.mark.parametrize("element", ELEMENTS)
def test_round_trip(curved, element):
    mesh = curved(element).with_group("left", lambda x: x[:, 0] < 0.5)
    back = from_skfem(to_skfem(mesh))
    assert back.cell_type == element
    assert np.array_equal(back.points[back.cells], mesh.points[mesh.cells])
    assert np.array_equal(back.groups["left"], mesh.groups["left"])
    for name in mesh.boundaries:
        assert sorted(map(tuple, back.faces(name))) == sorted(map(tuple, mesh.faces(name)))


@pytest.mark.parametrize("element", ELEMENTS)
def test_round_trip_of_a_sphere(element):
    mesh = fc.shapes.half_sphere(2.0, contact_radius=0.1, level=1, sector="half", element=element)
    back = from_skfem(to_skfem(mesh))
    check_mesh(back)
    assert set(back.boundaries) == set(mesh.boundaries)
    for name in mesh.boundaries:
        assert len(back.faces(name)) == len(mesh.faces(name))


def test_midface_nodes_are_left_behind():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    assert len(from_skfem(to_skfem(mesh.with_midface_nodes(("top",)))).points) == len(mesh.points)


def test_left_handed_cells_are_put_right():
    theirs = MeshHex().refined().with_defaults()
    mesh = from_skfem(theirs)
    check_mesh(mesh)
    assert abs(moments_of_volume(mesh)[0] - 1) < 1e-14  # a sum of eight volumes
    for name, axis, value in (("left", 0, 0.0), ("right", 0, 1.0), ("front", 2, 0.0), ("back", 2, 1.0)):
        assert (mesh.points[mesh.boundary_nodes(name)][:, axis] == value).all()


def test_default_mesh_is_one_curved_element():
    theirs = MeshHex20()
    assert theirs.doflocs.shape == (3, 20)
    assert from_skfem(theirs).cell_type == "hex20"


def test_degenerate_cells_and_other_meshes_are_refused(degenerate):
    with pytest.raises(InputError, match=r"degenerate"):
        to_skfem(degenerate("wedge"))
    with pytest.raises(MeshError, match=r"MeshTet1"):
        from_skfem(MeshTet())


@pytest.mark.parametrize("element", ELEMENTS)
def test_stiffness_equals_scikit_fems(curved, dense_stiffness, element):
    material = fc.Material(E=7.0, nu=0.29)
    mesh = curved(element, (1, 2, 1))
    theirs = to_skfem(mesh)
    basis = Basis(theirs, ElementVector(theirs.elem()), intorder=ORDER[element])

    @BilinearForm
    def elasticity(u, v, w):
        e = sym_grad(u)
        return ddot(material.lame * eye(trace(e), 3) + 2 * material.shear_modulus * e, sym_grad(v))

    ours = dense_stiffness(mesh, material)
    # their degrees of freedom by position and component
    distance = np.linalg.norm(basis.doflocs.T[:, None, :] - mesh.points[None, :, :], axis=2)
    assert distance.min(axis=1).max() == 0
    component = np.empty(basis.N, dtype=int)
    for c, dofs in enumerate(_components(basis)):
        component[dofs] = c
    where = 3 * distance.argmin(axis=1) + component
    K = elasticity.assemble(basis).toarray()
    # two orders of summation over 27 points and 60 x 60 entries
    assert np.abs(K - ours[np.ix_(where, where)]).max() < 1e-13 * np.abs(K).max()


def _components(basis):
    """Degrees of freedom of each displacement component."""
    n = basis.dofs.element_dofs.shape[0]
    return [np.unique(basis.dofs.element_dofs[c:n:3]) for c in range(3)]
