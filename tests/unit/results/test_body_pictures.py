"""Pictures of bodies: what is drawn where, in which colours, and what is refused."""

import sys

import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact.mesh.picture import AMBIENT, LIGHT, VIEWS, Camera, draw_facets, subdivided
from fecontact.results.pictures.bodies import plot_bodies, plot_solids, show
from fecontact.results.pictures.solids import Solid, chosen, cut, solids_of_file, solids_of_result

SMALL = (120, 100)


def grey(values):
    return np.repeat(values[:, None], 3, axis=1)


@pytest.fixture(scope="module")
def result():
    mesh = fc.shapes.block((2.0, 1.0, 1.0), (4, 2, 2))
    block = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "bottom", {"top": "z", "x_min": "x", "y_min": "y"})
    pillar = fc.ElasticBody(mesh, fc.Material(E=50.0, nu=0.3), "top", {"bottom": "z", "x_min": "x", "y_min": "y"})
    pillar = pillar.placed((0, 0, -1), name="pillar")
    scene = fc.Scene([block, pillar], [fc.Contact(block, pillar)])
    return scene.solve(motions={block: {"z": -0.04}})


# the drawing


@pytest.mark.parametrize("view", [*VIEWS, (33.0, 71.0)])
def test_cameras_are_right_handed(view):
    axes = Camera.looking(view).axes
    assert np.abs(axes @ axes.T - np.eye(3)).max() <= 1e-15  # sines and cosines of doubles
    assert np.linalg.det(axes) > 0


def test_a_linear_field_is_drawn_where_it_is():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    image = draw_facets(square, np.array([[0, 1, 2, 3]]), square[:, 0], grey, Camera.looking("z"), SMALL, edges=False)
    rows, columns = image.rgba.shape[:2]
    left, right, bottom, top = image.extent
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    inside = np.ix_((y > 0.03) & (y < 0.97), (x > 0.03) & (x < 0.97))
    light = image.rgba[inside][..., 0].max() / x[(x > 0.03) & (x < 0.97)].max()
    drawn = image.rgba[inside][..., 0] / light
    # a pixel shows samples up to one pixel away, and there are about 100 of them
    assert np.abs(drawn - x[(x > 0.03) & (x < 0.97)]).max() <= 1.5 / 98


def test_the_nearer_facet_is_seen_in_whatever_order():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    points = np.concatenate([square, square + np.array([0, 0, 1])])
    values = np.repeat([0.0, 1.0], 4)
    for facets in ([[0, 1, 2, 3], [4, 5, 6, 7]], [[4, 5, 6, 7], [0, 1, 2, 3]]):
        image = draw_facets(points, np.array(facets), values, grey, Camera.looking("z"), SMALL, edges=False)
        assert image.rgba[20:80, 20:80, 0].min() > 0.5
        image = draw_facets(points, np.array(facets), values, grey, Camera.looking("-z"), SMALL, edges=False)
        assert image.rgba[20:80, 20:80, 0].max() == 0.0


@pytest.mark.parametrize("view", ["iso", "x", (17.0, -44.0)])
def test_a_ball_is_a_full_disc_from_everywhere(view):
    mesh = fc.shapes.sphere(1.0, level=fc.shapes.Level(core=1, rings=2, edge=0.25, layer=0.4, growth=2.5))
    faces = mesh.face_nodes(mesh.outer_faces)
    image = draw_facets(mesh.points, faces, np.ones(len(mesh.points)), grey, Camera.looking(view), SMALL)
    left, right, bottom, top = image.extent
    area = image.rgba[..., 3].mean() * (right - left) * (top - bottom)
    # 98 pixels across: half a pixel round the rim is 1 % of the radius
    assert abs(area / np.pi - 1) <= 0.025
    middle = image.rgba[image.rgba.shape[0] // 4 : -(image.rgba.shape[0] // 4)]
    middle = middle[:, middle.shape[1] // 4 : -(middle.shape[1] // 4)]
    assert (middle[..., 3] == 1.0).all()  # no holes between samples


def test_light_and_field_follow_a_curved_face():
    mesh = fc.shapes.sphere(1.0, level=fc.shapes.Level(core=1, rings=2, edge=0.25, layer=0.4, growth=2.5))
    faces = mesh.face_nodes(mesh.outer_faces)
    camera = Camera.looking("iso")
    height = (mesh.points - mesh.points.mean(axis=0)) @ camera.axes[1]
    for values, share in ((np.ones(len(height)), 0.0), ((height + 1) / 2, 1.0)):
        image = draw_facets(mesh.points, faces, values, grey, camera, SMALL, edges=False, closed=True)
        rows, columns = image.rgba.shape[:2]
        x, y = np.meshgrid(*((np.arange(n) + 0.5) / (n / 2) - 1 for n in (columns, rows)))
        x, y = x * columns / (columns - 2), y * rows / (rows - 2)  # a margin of a pixel
        inside = np.hypot(x, y) < 0.9
        normals = np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)
        light = AMBIENT + (1 - AMBIENT) * np.clip(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)
        seen = light * (1 - share + share * (y + 1) / 2)
        # a pixel is a 49th of the radius; the normals of quadratic faces are off by about their distance from the ball
        assert np.abs(image.rgba[..., 0] - seen)[inside].max() <= 0.03


def test_triangles_are_drawn_whole():
    # a triangle in the form that meshes use: the last two corners are one node
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    image = draw_facets(points, np.array([[0, 1, 2, 2]]), np.ones(3), grey, Camera.looking("z"), SMALL)
    left, right, bottom, top = image.extent
    area = image.rgba[..., 3].mean() * (right - left) * (top - bottom)
    assert abs(area / 0.5 - 1) <= 0.05  # half a pixel along sides of 3.4 in all


def test_subdivision_keeps_curved_facets():
    mesh = fc.shapes.half_sphere(1.0, level=1)
    faces = mesh.face_nodes(mesh.faces("flank"))
    fine, quads = subdivided(mesh.points, faces, 4)
    radius = np.linalg.norm(fine - [0, 0, 1], axis=1)
    # 20-node faces of an eighth of a circle miss the sphere by less than this
    assert np.abs(radius - 1).max() <= 5e-3
    assert quads.shape == (16 * len(faces), 4)


# bodies


def test_bodies_of_a_result_and_of_its_file_are_the_same(result, tmp_path):
    ours = solids_of_result(result)
    theirs = solids_of_file(result.save(tmp_path / "r.vtu"))
    assert [s.name for s in ours] == ["body", "pillar"]
    assert [s.name for s in theirs] == ["0", "1"]
    for a, b in zip(ours, theirs, strict=True):
        for field in ("von_mises", "displacement", "displacement_z", "stress_xz", "contact_pressure"):
            one, other = a.scalar(field)[a.mesh.cells], b.scalar(field)[b.mesh.cells]
            assert np.abs(one - other).max() <= 1e-12 * max(1.0, np.abs(one).max())  # written as doubles
        assert np.abs(a.deformed(50)[a.mesh.cells] - b.deformed(50)[b.mesh.cells]).max() <= 1e-12


def test_deformation_is_exaggerated_by_the_scale(result):
    block, _ = solids_of_result(result)
    moved = block.deformed(10) - block.mesh.points
    assert np.abs(moved - 10 * result.displacement(result._elastic_bodies[0])).max() <= 1e-14
    assert block.deformed(0) is block.mesh.points


def test_mirrored_cells_are_drawn_from_outside_too():
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    mirrored = mesh.mapped(lambda x: x * [-1, 1, 1])
    colours = []
    for m in (mesh, mirrored):
        solid = Solid("cube", m, {"height": m.points[:, 2]})
        image = plot_solids([solid], "height", view="z", edges=False, pixels=SMALL).axes[0].images[0].get_array()
        colours.append(image[50, 50])
    # the upper face is seen, in the colour of height one, and not the lower one through it
    assert np.abs(np.subtract(*colours)).max() <= 1e-12


def test_a_cut_keeps_the_cells_on_one_side(result):
    solids = solids_of_result(result)
    (left,) = chosen(solids[:1], None, "x<1")
    assert left.mesh.points[left.mesh.cells].max(axis=(0, 1))[0] == 1.0
    assert len(left.mesh.cells) == len(solids[0].mesh.cells) / 2
    assert cut(solids[1], "z > 0.5") is None
    assert [s.name for s in chosen(solids, None, "z>0.5")] == ["body"]


@pytest.mark.parametrize("where", ["x<0.37", "x>0.37", "z>0.5", "y<0.8"])
@pytest.mark.parametrize("order", [4, 10])
def test_a_cut_of_tetrahedra_is_plane(where, order):
    """Six tetrahedra in each of 3 x 2 x 2 cubes: volume, skin and a linear field of the part, by hand."""
    cubes = fc.shapes.block((1.0, 1.0, 1.0), (3, 2, 2), element="hex8")
    corners = ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))
    cells = cubes.cells[:, [[0, a, b, b, 6, 6, 6, 6] for a, b in corners]].reshape(-1, 8)
    mesh = fc.Mesh(cubes.points, cells)
    mesh = mesh.upgraded(20) if order == 10 else mesh
    field = mesh.points @ [1.0, 2.0, 3.0]
    part = cut(Solid("a", mesh, {"height": field, "displacement": 0.1 * mesh.points}), where)
    axis, level = "xyz".index(where[0]), float(where[2:])
    x, faces = part.mesh.points, part.mesh.skin
    inside = level - x[:, axis] if where[1] == "<" else x[:, axis] - level
    assert inside.min() > -1e-15
    assert np.abs(part.fields["height"] - x @ [1.0, 2.0, 3.0]).max() < 1e-14
    assert np.abs(part.deformed(1.0) - 1.1 * x).max() < 1e-15
    size, sides = (level if where[1] == "<" else 1 - level), x[faces[:, :4]]
    area = np.cross(sides[:, 2] - sides[:, 0], sides[:, 3] - sides[:, 1]) / 2
    volume = sum(np.linalg.det(sides[:, [0, k, k + 1]]).sum() / 6 for k in (1, 2))
    assert abs(volume - size) < 1e-12
    assert abs(np.linalg.norm(area, axis=1).sum() - 2 - 4 * size) < 1e-12
    on_plane = np.abs(inside[faces[:, :4]]).max(axis=1) < 1e-14
    assert abs(np.linalg.norm(area[on_plane], axis=1).sum() - 1) < 1e-12
    outwards = area[on_plane][:, axis] * (1 if where[1] == "<" else -1)
    assert outwards.min() > -1e-15
    assert cut(Solid("a", mesh, {"height": field}), "x>1.0") is None


def test_picture_has_units_title_and_limits(result, tmp_path):
    path = tmp_path / "p.png"
    figure = plot_bodies(result, "stress_zz", path, units="MPa", length="mm", scale=50, pixels=SMALL)
    assert path.read_bytes()[:4] == b"\x89PNG"
    axes, bar = figure.axes[:2]
    assert bar.get_ylabel() == "stress zz [MPa]"
    assert axes.get_title() == "bodies body, pillar, displacements × 50"
    low, high = bar.get_ylim()
    assert low == -high  # signed fields about zero
    assert any(t.get_text().endswith(" mm") for t in axes.texts)
    pressure = plot_bodies(result, "contact_pressure", limits=(0.0, 2.0), pixels=SMALL)
    assert pressure.axes[1].get_ylim() == (0.0, 2.0)


def test_plot_draws_bodies_too(result, tmp_path):
    result.plot("von_mises", tmp_path / "v.png", pixels=SMALL)
    assert (tmp_path / "v.png").is_file()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"field": "von_mise"}, ("unknown-field", "'von_mise', did you mean 'von_mises'")),
        ({"field": "stress_q"}, ("unknown-field", "displacement, displacement_x")),
        ({"bodies": ["femur"]}, ("unseen", "'femur'", "body, pillar")),
        ({"cut": "left"}, ("no-cut", "'left'")),
        ({"cut": "x>99"}, ("empty-cut",)),
        ({"scale": "big"}, ("unknown-name", "scale")),
        ({"view": "front"}, ("input", "'front'", "iso")),
        ({"path": "/no/such/folder/p.png"}, ("no-folder", "/no/such/folder/p.png")),
    ],
)
def test_what_cannot_be_drawn_is_refused(result, options, message):
    with refused(fc.InputError, *message):
        plot_solids(solids_of_result(result), **options)


def test_files_that_hold_no_bodies_are_refused(tmp_path):
    with refused(fc.InputError, "no-file"):
        solids_of_file(tmp_path / "none.vtu")
    (tmp_path / "bad.vtu").write_text("no file of this kind")
    with refused(fc.FecontactError, "mesh", "bad.vtu"):
        solids_of_file(tmp_path / "bad.vtu")


def test_missing_pyvista_is_named_with_the_remedy(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with refused(fc.MissingPackageError, "missing-package", "pip install 'fecontact[view]'"):
        show(solids_of_result(result))


def test_a_scene_without_meshed_bodies_says_what_can_be_drawn():
    half = fc.HalfSpace(fc.Material(E=1.0, nu=0.3), size=(1.0, 1.0), cells=(16, 16))
    ball = fc.RigidBody(fc.Sphere(1.0)).placed((0.0, 0.0, 1.0))
    result = fc.Scene([half, ball], [fc.Contact(half, ball)]).solve(motions={ball: {"z": -0.01}})
    with refused(fc.InputError, "nothing-to-draw"):
        result.plot("von_mises")


def test_automatic_scale_shows_the_largest_displacement(result):
    # two unit cubes on each other, 1 % pressed together: a round factor between 2.5 and 5 % of the size
    figure = plot_bodies(result, "displacement", scale="auto", pixels=SMALL)
    factor = float(figure.axes[0].get_title().rpartition(" ")[2])
    solids = solids_of_result(result)
    points = np.concatenate([s.mesh.points for s in solids])
    moved = max(np.linalg.norm(s.deformed(1.0) - s.mesh.points, axis=1).max() for s in solids)
    share = factor * moved / np.linalg.norm(np.ptp(points, axis=0))
    assert 0.02 <= share <= 0.05 * (1 + 1e-9)
    assert float(f"{factor:.0e}"[0]) in (1, 2, 5)
