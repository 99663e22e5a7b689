"""Pictures of meshes: boundaries in colours, numbered and listed."""

import re

import meshio
import numpy as np
import pytest
from refusals import refused

import fecontact as fc
from fecontact import SurfaceMesh
from fecontact.app.cli import main
from fecontact.mesh.picture import PLAIN


@pytest.fixture(scope="module")
def block():
    return fc.shapes.block((2.0, 1.0, 1.0), (2, 1, 1))


def colours(figure):
    """Hues (n, 3) of the picture where light does not matter: over the largest component."""
    rgba = np.asarray(figure.axes[0].images[0].get_array())
    rgb = rgba[rgba[..., 3] > 0.99][:, :3]
    return rgb / rgb.max(axis=1, keepdims=True)


def test_boundaries_that_face_the_eye_are_coloured_numbered_and_listed(block):
    figure = block.plot(view="z", edges=False, length="mm")
    axes = figure.axes[0]
    (legend,) = figure.legends
    listed = [text.get_text() for text in legend.get_texts()]
    assert listed == [f"{k}  {name}, {n} faces" for k, (name, n) in enumerate(
        {"x_min": 1, "x_max": 1, "y_min": 2, "y_max": 2, "bottom": 2, "top": 2}.items(), start=1)]  # fmt: skip
    numbers = [text for text in axes.texts if text.get_text().isdigit()]
    assert [text.get_text() for text in numbers] == ["6"]  # only the top is seen from above
    # on one of the two faces of the top, whose middles are half a length from its own
    assert abs(np.subtract(numbers[0].get_position(), (1.0, 0.5))).max() <= 0.5 + 1e-9
    handle = legend.legend_handles[5].get_facecolor()[:3]
    hues = colours(figure)
    assert np.abs(hues - np.array(handle) / max(handle)).max(axis=1).mean() <= 0.05  # all that is seen is the top


def test_faces_in_no_boundary_are_grey(block):
    bare = fc.Mesh(block.points, block.cells)
    figure = bare.plot(view="z", edges=False)
    assert not figure.legends
    assert np.abs(colours(figure) - np.array(PLAIN) / max(PLAIN)).max() <= 0.02


def test_long_names_stay_in_the_picture(block):
    name = "the_face_on_which_the_bracket_is_screwed_down"
    figure = block.with_boundary(name, fc.pick.facing((0, 0, 1))).plot()
    figure.draw_without_rendering()
    inside, legend = figure.bbox, figure.legends[0].get_window_extent()
    assert inside.x0 <= legend.x0 < legend.x1 <= inside.x1
    assert legend.x0 >= figure.axes[0].get_window_extent().x1


def test_surfaces_with_triangles_are_drawn(tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0.5, 0.0]])
    surface = SurfaceMesh(points, np.array([[0, 1, 2, 3], [1, 4, 2, 2]]))
    for direction in ("z", "-z"):  # an open surface is seen from both sides
        drawn = colours(surface.plot(tmp_path / "s.png", view=direction))
        assert len(drawn) > 1000


def test_a_mesh_is_viewed_from_the_command_line(block, tmp_path, capsys):
    source = tmp_path / "part.stl"
    corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0"
    source.write_text(f"solid s\nfacet normal 0 0 1\nouter loop\n{corners}\nendloop\nendfacet\nendsolid s\n")
    assert main(["view", str(source), "--view", "z", "--length", "mm"]) == 0
    assert (tmp_path / "part.png").stat().st_size > 3000
    assert "SurfaceMesh(1 facets" in capsys.readouterr().out
    assert main(["view", str(source), "--field", "von_mises"]) != 0
    assert "leave --field out" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"colour": "red"}, ("unknown-option", "colour")),
        ({"view": "up"}, ("input", "view")),
        ({"length": 3}, ("not-a-text", "The unit of length")),
    ],
)
def test_bad_options_are_refused(block, options, message):
    with refused(fc.InputError, *message):
        block.plot(**options)


def test_sections_show_their_sides_in_colours_numbered_and_listed(tmp_path):
    section = fc.sections.rectangle((2.0, 1.0), (4, 2))
    figure = section.plot(tmp_path / "section.png", length="mm")
    (legend,) = figure.legends
    listed = [text.get_text() for text in legend.get_texts()]
    assert listed == ["1  bottom, 4 sides", "2  right, 2 sides", "3  top, 4 sides", "4  left, 2 sides"]
    axes = figure.axes[0]
    lines = {tuple(c.get_colors()[0][:3]): np.concatenate(c.get_segments()) for c in axes.collections}
    for handle, (k, place) in zip(legend.legend_handles, ((1, 0.0), (0, 2.0), (1, 1.0), (0, 0.0)), strict=True):
        drawn = lines[handle.get_facecolor()[:3]]
        assert np.abs(drawn[:, k] - place).max() <= 1e-12  # x to the right, z upwards
    numbers = {text.get_text(): text.get_position() for text in axes.texts if text.get_text().isdigit()}
    assert set(numbers) == {"1", "2", "3", "4"}
    assert abs(numbers["1"][1]) <= 1e-12


def test_a_section_is_viewed_from_the_command_line(tmp_path, capsys):
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]
    meshio.Mesh(points, [("quad", [[0, 1, 2, 3]])]).write(tmp_path / "plate.inp")
    text = (tmp_path / "plate.inp").read_text()
    (tmp_path / "plate.inp").write_text(re.sub("TYPE=[A-Z0-9]+", "TYPE=CPS4", text))
    assert main(["view", str(tmp_path / "plate.inp")]) == 0
    assert "SectionMesh" in capsys.readouterr().out
    assert (tmp_path / "plate.png").stat().st_size > 2000
