"""The way to scikit-fem and back, and scikit-fem's own assembly as an independent stiffness."""

import numpy as np
import pytest
from refusals import refused
from skfem import Basis, BilinearForm, ElementVector, MeshHex, MeshTet, MeshTet2, MeshTri, MeshWedge1
from skfem.helpers import ddot, eye, sym_grad, trace

import fecontact as fc
from fecontact import InputError, MeshError
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.check import check_mesh
from fecontact.mesh.skfem_mesh import MeshHex20

ELEMENTS = ["hex8", "hex20", "hex27"]
ORDER = {"hex8": 3, "hex20": 5, "hex27": 5}


@pytest.mark.parametrize("element", ELEMENTS)
def test_round_trip(curved, element):
    mesh = curved(element).with_group("left", lambda x: x[:, 0] < 0.5)
    back = fc.Mesh.from_skfem(mesh.to_skfem())
    assert back.cell_type == element
    assert np.array_equal(back.points[back.cells], mesh.points[mesh.cells])
    assert np.array_equal(back.groups["left"], mesh.groups["left"])
    for name in mesh.boundaries:
        assert sorted(map(tuple, back.faces(name))) == sorted(map(tuple, mesh.faces(name)))


@pytest.mark.parametrize("element", ELEMENTS)
def test_round_trip_of_a_sphere(element):
    mesh = fc.shapes.half_sphere(2.0, contact_radius=0.1, level=1, sector="half", element=element)
    back = fc.Mesh.from_skfem(mesh.to_skfem())
    check_mesh(back)
    assert set(back.boundaries) == set(mesh.boundaries)
    for name in mesh.boundaries:
        assert len(back.faces(name)) == len(mesh.faces(name))


def test_midface_nodes_are_left_behind():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    assert len(fc.Mesh.from_skfem(mesh.with_midface_nodes(("top",)).to_skfem()).points) == len(mesh.points)


def test_left_handed_cells_are_put_right():
    theirs = MeshHex().refined().with_defaults()
    mesh = fc.Mesh.from_skfem(theirs)
    check_mesh(mesh)
    assert abs(moments_of_volume(mesh)[0] - 1) < 1e-14  # a sum of eight volumes
    for name, axis, value in (("left", 0, 0.0), ("right", 0, 1.0), ("front", 2, 0.0), ("back", 2, 1.0)):
        assert (mesh.points[mesh.boundary_nodes(name)][:, axis] == value).all()


def test_default_mesh_is_one_curved_element():
    theirs = MeshHex20()
    assert theirs.doflocs.shape == (3, 20)
    assert fc.Mesh.from_skfem(theirs).cell_type == "hex20"


def test_degenerate_cells_and_other_meshes_are_refused(degenerate):
    with refused(InputError, "no-skfem-mesh"):
        degenerate("wedge").to_skfem()
    with refused(MeshError, "no-skfem", "MeshTri1"):
        fc.Mesh.from_skfem(MeshTri())


def _tetrahedra_and_wedges():
    """Meshes of scikit-fem's of the unit cube, one half of whose cells are inside out, with sets."""
    tets = MeshTet().refined(2)
    return (
        tets,
        MeshTet2.from_mesh(tets),
        MeshTet2.from_mesh(tets).translated((0.5, 0.1, 0.3)).mirrored((1.0, 0.0, 0.0)).translated((1.5, -0.1, -0.3)),
        MeshWedge1(),
    )


@pytest.mark.parametrize("number", range(4))
def test_tetrahedra_and_wedges_there_and_back(number):
    theirs = _tetrahedra_and_wedges()[number].with_defaults()
    theirs = theirs.with_subdomains({"low": lambda x: x[2] < 0.5})
    mesh = fc.Mesh.from_skfem(theirs)
    check_mesh(mesh)
    assert abs(moments_of_volume(mesh)[0] - 1) < 1e-13  # a sum of up to 320 volumes
    for name, axis, value in (("left", 0, 0.0), ("right", 0, 1.0), ("bottom", 1, 0.0), ("top", 1, 1.0)):
        assert np.abs(mesh.points[mesh.boundary_nodes(name)][:, axis] - value).max() < 1e-14
        assert {tuple(f) for f in mesh.faces(name)} <= {tuple(f) for f in mesh.outer_faces}
    back = mesh.to_skfem()
    assert type(back) is type(theirs)
    again = fc.Mesh.from_skfem(back)
    assert again.kinds == mesh.kinds
    assert np.array_equal(again.points[again.cells], mesh.points[mesh.cells])
    assert np.array_equal(again.groups["low"], mesh.groups["low"])
    for name in mesh.boundaries:
        assert sorted(map(tuple, again.faces(name))) == sorted(map(tuple, mesh.faces(name)))


def test_an_inner_face_keeps_its_side():
    block = fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1), element="hex8")
    for face in ((0, 1), (1, 0)):
        mesh = fc.Mesh(block.points, block.cells, {"inner": [face]})
        assert fc.Mesh.from_skfem(mesh.to_skfem()).faces("inner").tolist() == [list(face)]


def test_points_without_a_cell_are_left_out():
    block = fc.shapes.block((1.0, 1.0, 1.0), (2, 1, 1), element="hex8").to_skfem()
    theirs = type(block)(np.concatenate([np.full((3, 1), 9.0), block.doflocs], axis=1), block.t + 1)
    check_mesh(fc.Mesh.from_skfem(theirs))


@pytest.mark.parametrize("element", ELEMENTS)
def test_stiffness_equals_scikit_fems(curved, dense_stiffness, element):
    material = fc.Material(E=7.0, nu=0.29)
    mesh = curved(element, (1, 2, 1))
    theirs = mesh.to_skfem()
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
