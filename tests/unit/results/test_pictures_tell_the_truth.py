"""Pictures of twenty objects: texts lie within and apart, colours cover the data, numbers lie on what is seen."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.axis import Tick
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from matplotlib.image import AxesImage
from matplotlib.text import Text

import fecontact as fc
from tests.refusals import refused

STEEL = fc.Material(E=210e3, nu=0.3)
SOFT = fc.Material(E=10.0, nu=0.3)
UNITS = ("mm", "N", "MPa")
#: Pixels by which texts may reach beyond the figure or into each other: rounding of their boxes.
SLACK = 2.0


def half_space(**options):
    return fc.HalfSpace(**{"material": STEEL, "size": (1.2, 1.2), "cells": (32, 32), **options})


def scene(mu=0.0):
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (4, 4, 2))
    block = fc.ElasticBody(mesh, STEEL, contact="top", supports={"bottom": "xyz"}, name="block")
    ball = fc.RigidBody(fc.Sphere(5.0), name="ball").placed((1.0, 1.1, 1.0))
    return fc.Scene([block, ball], [fc.Contact(block, ball, friction=mu)], units=UNITS)


def solved(mu=0.0, **options):
    made = scene(mu)
    return made.solve({made.bodies[1]: (0, 0, -3000.0)}, finite_motion=False, **options)


def row():
    ball = fc.ElasticBody(fc.shapes.ball(10.0), SOFT, contact=("z_min", "z_max"))
    balls = [ball.placed((0, 0, 20.0 * k), name=f"ball {k + 1}") for k in range(3)]
    floor = fc.RigidBody(fc.Plane(), name="floor").placed((0, 0, -10.0))
    pairs = [(balls[0], floor), (balls[0], balls[1]), (balls[1], balls[2])]
    return fc.Scene([floor, *balls], [fc.Contact(*pair) for pair in pairs], units=UNITS)


def table():
    made = scene()
    cases = [{"forces": {made.bodies[1]: (0, 0, -f)}, "finite_motion": False} for f in (1e3, 2e3, 3e3)]
    return made.sweep(cases, keep="pressure")


def rough():
    half = half_space(size=(1.0, 1.0), periodic=True)
    heights = fc.surfaces.self_affine((32, 32), (1.0, 1.0), hurst=0.8, seed=2, rms_slope=0.1, longest=0.5, shortest=0.1)
    return half.press(heights.z - heights.z.min(), force=1000.0)


PICTURES = {
    "hertz circle": lambda: fc.hertz.spheres((10.0, 10.0), (STEEL, STEEL), force=100.0).plot(units=UNITS),
    "hertz line": lambda: fc.hertz.line((10.0, 10.0), (STEEL, STEEL), force=100.0).plot(units=UNITS),
    "ball on a half-space": lambda: half_space().press(fc.surfaces.Paraboloid(10.0), force=100.0).plot(units=UNITS),
    "no units": lambda: half_space().press(fc.surfaces.Paraboloid(10.0), force=100.0).plot(),
    "coated": lambda: (
        half_space(layers=[fc.Layer(SOFT, 0.05)]).press(fc.surfaces.Paraboloid(10.0), force=1.0).plot(units=UNITS)
    ),
    "rough": lambda: rough().plot(units=UNITS),
    "friction": lambda: (
        half_space(against=STEEL)
        .press(fc.surfaces.Paraboloid(10.0), force=100.0, friction=0.3, tangential=(15.0, 0.0))
        .plot(units=UNITS)
    ),
    "curve": lambda: half_space().curve(fc.surfaces.Paraboloid(10.0), forces=[10.0, 30.0, 100.0]).plot(units=UNITS),
    "scene": lambda: scene().plot(),
    "scene from below": lambda: scene().plot(view="below"),
    "row of balls": lambda: row().plot(),
    "ball": lambda: fc.shapes.ball(1.0).plot(length="mm"),
    "ring": lambda: fc.shapes.thick_ring(1.0, 2.0, 1.0, sector="half").plot(length="mm"),
    "section": lambda: fc.sections.rectangle((2.0, 1.0), (4, 2)).plot(length="mm"),
    "pressure": lambda: solved().plot("pressure"),
    "gap": lambda: solved().plot("gap"),
    "tractions": lambda: solved(0.3).plot("friction"),
    "stress": lambda: solved().plot("von_mises"),
    "steps to an accuracy": lambda: solved(accuracy=0.5).plot("convergence"),
    "table": lambda: table().plot(),
    "maps of a table": lambda: table().montage(),
}
#: Those of every day: one of each kind that is quick.
QUICK = ("hertz circle", "ball on a half-space", "row of balls", "pressure")


def texts_of(figure, renderer):
    """What texts say, and their boxes; the numbers of axes are left to matplotlib."""
    ticks = figure.findobj(Tick)
    numbers = {id(label) for tick in ticks for label in (tick.label1, tick.label2)}
    hidden = {
        id(text)
        for axes in figure.axes
        if not axes.axison
        for axis in (axes.xaxis, axes.yaxis)
        for text in axis.findobj(Text)
    }
    shown = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip()]
    return [(t.get_text(), t.get_window_extent(renderer)) for t in shown if id(t) not in numbers | hidden]


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.full) for n in PICTURES])
def test_a_picture(name):
    figure = PICTURES[name]()
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    texts = texts_of(figure, renderer)
    width, height = figure.bbox.width, figure.bbox.height
    for said, box in texts:
        assert box.x0 > -SLACK, said
        assert box.y0 > -SLACK, said
        assert box.x1 < width + SLACK, said
        assert box.y1 < height + SLACK, said
    for (one, a), (other, b) in combinations(texts, 2):
        across = min(a.x1, b.x1) - max(a.x0, b.x0)
        along = min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(across, along) < SLACK, (one, other)
    for shown in figure.findobj(lambda a: isinstance(a, QuadMesh | AxesImage)):
        values = np.ma.masked_invalid(shown.get_array())
        if values.ndim > 2 or values.count() == 0 or shown.norm is None:
            continue
        low, high = shown.get_clim()
        assert low <= values.min() + 1e-9 * abs(high)
        assert high >= np.quantile(values.compressed(), 0.85)


def test_numbers_of_boundaries_lie_where_their_colour_is_seen():
    """Of balls in a row, one of which hides the pole of the next: not on the ball before it."""
    ball = fc.ElasticBody(fc.shapes.ball(10.0), SOFT, contact=("z_min", "z_max"))
    other = ball.placed((0, 0, 20.0), name="next")
    figure = fc.Scene([ball, other], [fc.Contact(ball, other)]).plot()
    axes = figure.axes[0]
    (image,) = axes.images
    left, right, bottom, top = image.get_extent()
    rgba = image.get_array()
    seen = {}
    for note in axes.texts:
        if note.get_text().isdigit() and hasattr(note, "xy"):
            x, y = note.xy
            row, column = (y - bottom) / (top - bottom) * len(rgba), (x - left) / (right - left) * rgba.shape[1]
            found = rgba[int(row), int(column), :3]
            seen[int(note.get_text())] = found / found.max()
    colours = [np.array(patch.get_facecolor()[:3]) for patch in figure.legends[0].legend_handles]
    assert len(seen) >= 3
    for number, found in seen.items():
        wanted = colours[number - 1] / colours[number - 1].max()
        assert np.abs(found - wanted).max() < 0.1


def test_a_map_tells_large_errors_and_the_sides_of_a_plane():
    result = solved()
    assert result.contacts[0].error_estimate.largest > 0.1
    plane = fc.DividingPlane((1.1, 0.0, 0.0), (1.0, 0.0, 0.0), sides=("lateral", "medial"))
    axes = result.plot("pressure", split=plane).axes[0]
    assert "estimated errors: pressure" in axes.get_title()
    places = {note.get_text(): note.xy[0] for note in axes.texts}
    assert places["medial"] < 1.0 < places["lateral"]
    (line,) = [c for c in axes.collections if type(c).__name__ == "TriContourSet"]
    assert np.allclose(np.concatenate([p.vertices for p in line.get_paths()])[:, 0], 1.1)
    pads = fc.merge([fc.shapes.block((1.0, 1.0, 0.5), (2, 2, 1)).translated((2.0 * k, 0, 0)) for k in (0, 1)], 1e-9)
    pads = fc.ElasticBody(pads, STEEL, contact="bottom", supports={"top": "xyz"})
    floor = fc.RigidBody(fc.Plane())
    two = fc.Scene([pads, floor], [fc.Contact(pads, floor)]).solve(motions={pads: {"z": -1e-4}})
    between = fc.DividingPlane((1.4, 0.0, 0.0), (1.0, 0.0, 0.0), sides=("lateral", "medial"))
    (line,) = [n for n in two.plot(split=between).axes[0].lines if n.get_linestyle() == "--"]
    assert np.allclose([line.get_xy1()[0], line.get_xy2()[0]], 1.4)
    other = fc.DividingPlane((0, 0, 0), (1, 0, 0), fc.RigidBody(fc.Plane(), name="elsewhere"))
    with refused(fc.InputError, "no-contact"):
        result.plot("pressure", split=other)


def test_pressure_is_drawn_where_there_is_a_counter_surface_and_its_outlier_is_written():
    heights = np.full((32, 32), np.inf)
    heights[8:24, 8:24] = 1e-3 * np.random.default_rng(1).random((16, 16))
    heights[10, 10] = -2e-2
    axes = half_space().press(heights, force=500.0).plot(units=UNITS).axes[0]
    shown = axes.images[0].get_array()
    assert np.ma.masked_invalid(shown).count() == 16**2
    assert axes.images[0].get_clim()[1] < np.nanmax(shown)
    assert axes.get_title() == f"largest {np.nanmax(shown):.4g} MPa"


def test_curves_over_decades_are_logarithmic_and_others_begin_at_zero():
    curve = half_space().curve(fc.surfaces.Paraboloid(10.0), forces=[0.1, 3.0, 100.0])
    assert curve.plot().axes[0].get_xscale() == "log"
    axes = table().plot("force").axes[0]
    assert axes.get_xscale() == axes.get_yscale() == "linear"
    assert axes.get_ylim()[0] == 0.0 < 3e3 < axes.get_ylim()[1]
