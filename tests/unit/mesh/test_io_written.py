"""Results in VTU files: cells as what they are, so that other programs show and measure them right."""

import meshio
import numpy as np
import pytest

import fecontact as fc
from fecontact.fem.stiffness import moments_of_volume
from fecontact.mesh.facets import nodal_areas
from fecontact.mesh.kinds import KINDS
from fecontact.results.pictures.solids import solids_of_file

# numbers of order one, written as doubles; sums of a few hundred of them
ROUNDING = 1e-13
NAMES = {
    "hex8": {"hexahedron"},
    "hex20": {"hexahedron20"},
    "wedge6": {"wedge"},
    "wedge15": {"wedge15"},
    "tet4": {"tetra"},
    "tet10": {"tetra10"},
    "mixed": {"hexahedron20", "wedge15"},
}
# edges of VTK's cells in the order of their mid-edge nodes (VTK file formats, figure 3)
VTK_EDGES = {
    "wedge15": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "tetra10": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
}


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A block of each kind pressed on a plane: its result and file, made once."""
    done = {}

    def make(mesh, kind):
        if kind not in done:
            body = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "bottom", {"top": "xyz"}, name=kind)
            floor = fc.RigidBody(fc.Plane())
            result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
            done[kind] = result, result.save(tmp_path_factory.mktemp("vtu") / f"{kind}.vtu")
        return done[kind]

    return make


@pytest.mark.parametrize("kind", NAMES)
def test_cells_are_written_as_what_they_are(kind, block, written):
    mesh = block(kind)
    result, path = written(mesh, kind)
    file = meshio.read(path)
    assert {b.type for b in file.cells} == NAMES[kind]
    assert len(file.points) == len(mesh.points)
    for b in file.cells:
        x = file.points[b.data]
        # corners of a cell are its own, and each mid-edge node lies nearest to the middle of its edge
        assert all(len(set(c)) == len(c) for c in b.data.tolist())
        for k in range(len(VTK_EDGES.get(b.type, ()))):
            n = b.data.shape[1] - len(VTK_EDGES[b.type])
            middles = np.stack([(x[:, p] + x[:, q]) / 2 for p, q in VTK_EDGES[b.type]], axis=1)
            away = np.linalg.norm(middles - x[:, n + k, None], axis=2)
            assert (away.argmin(axis=1) == k).all()
    # nodes in the middles of contact faces stand last and are left out
    ours, theirs = result.displacement(result._elastic_bodies[0])[: len(mesh.points)], file.point_data["displacement"]
    assert np.abs(np.sort(ours, axis=0) - np.sort(theirs, axis=0)).max() < ROUNDING


@pytest.mark.parametrize("kind", NAMES)
def test_a_result_file_is_read_back_as_the_same_mesh(kind, block, written):
    mesh = block(kind)
    read = fc.read_mesh(written(mesh, kind)[1])
    assert read.kinds == mesh.kinds
    assert len(read.points) == len(mesh.points)
    assert abs(moments_of_volume(read)[0] - moments_of_volume(mesh)[0]) < ROUNDING
    assert len(read.groups["body_0"]) == len(mesh.cells)
    assert len(read.outer_faces) == len(mesh.outer_faces)
    for name, axis, at in (("bottom", 2, 0.0), ("top", 2, 1.0), ("x_max", 0, 1.0)):
        named = read.with_boundary(name, lambda x, axis=axis, at=at: np.abs(x[:, axis] - at) < 1e-12)
        assert len(named.faces(name)) == len(mesh.faces(name))
        area = nodal_areas(named.points, named.face_nodes(named.faces(name))).sum(axis=0)
        assert abs(np.linalg.norm(area) - 1) < ROUNDING


@pytest.mark.parametrize("kind", NAMES)
def test_a_result_file_is_seen_as_one_body_without_inner_faces(kind, block, written):
    mesh = block(kind)
    result, path = written(mesh, kind)
    (solid,) = solids_of_file(path)
    assert len(solid.mesh.outer_faces) == len(mesh.outer_faces)
    stress = result.stress(result._elastic_bodies[0])[: len(mesh.points)]
    pairs = ((mesh.points, stress), (solid.mesh.points, solid.fields["stress"]))
    both = [np.concatenate([x, s], axis=1) for x, s in pairs]
    one, other = (x[np.lexsort(x[:, :3].round(9).T)] for x in both)
    assert np.abs(one - other).max() < ROUNDING * np.abs(stress).max()


@pytest.mark.parametrize("kind", NAMES)
def test_vtk_finds_the_same_volume_and_normals_outwards(kind, block, written):
    pyvista = pytest.importorskip("pyvista")
    mesh = block(kind, amount=0.0)
    grid = pyvista.read(written(mesh, f"flat {kind}")[1])
    volumes = np.asarray(grid.compute_cell_sizes()["Volume"])
    assert len(volumes) == len(mesh.cells)
    # VTK draws wedges of six nodes with their first triangle outwards but measures them the other way round
    assert ((volumes < 0) if kind == "wedge6" else (volumes > 0)).all()
    assert abs(abs(volumes.sum()) - 1) < ROUNDING
    skin = grid.extract_surface(algorithm="dataset_surface", nonlinear_subdivision=0).triangulate()
    outwards = np.einsum("ij,ij->i", skin.face_normals, skin.cell_centers().points - 0.5)
    assert (outwards > 0).all()


def test_odd_cells_stay_hexahedra_and_pyramids_are_pyramids():
    points = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex20").points
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    pyramid = fc.mesh.mesh.Mesh(mesh.points, mesh.cells[:, list(KINDS["pyramid5"].embedding)])
    assert [(name, c.shape) for name, c, _ in pyramid.native_cells()] == [("pyramid", (1, 5))]
    odd = fc.mesh.mesh.Mesh(points[:8], mesh.cells[:, [0, 1, 1, 3, 4, 5, 6, 7]])
    assert [(name, c.shape) for name, c, _ in odd.native_cells()] == [("hexahedron", (1, 8))]
