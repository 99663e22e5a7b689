"""Every figure of a contact has one value under one name, wherever it is read."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fecontact as fc
from fecontact.scene.load_path import LoadPath

#: Digits that a door shows: pages and maps 4, the printed report 6, all others all.
EXACT, SIX, FIVE, FOUR = 1e-12, 6e-6, 6e-5, 6e-4
RUBBER, STEEL = fc.Material(1.0, 0.3), fc.Material(210e3, 0.3)
NUMBER = r"([-+.\deE]+)"
Doors = Iterator[tuple[str, str, float, float]]


def ball_on(body: Any, **options: Any) -> tuple[fc.Scene, fc.RigidBody]:
    """A ball beside the axis of a body of unit height, so that nothing is symmetric."""
    ball = fc.RigidBody(fc.Sphere(1.0), name="ball").placed((0.02, 0.013, 1.0))
    return fc.Scene([body, ball], [fc.Contact(ball, body, **options)]), ball


def block(n: int = 8) -> fc.Mesh:
    return fc.shapes.block((1.0, 1.0, 1.0), (n, n, 4)).translated((-0.5, -0.5, 0.0))


def finite_elements(**options: Any) -> tuple[fc.Scene, fc.RigidBody]:
    return ball_on(fc.ElasticBody(block(), RUBBER, "top", {"bottom": "xyz"}, name="block"), **options)


def soft(**options: Any) -> tuple[fc.Scene, fc.RigidBody]:
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (8, 8, 4), element="hex8").translated((-0.5, -0.5, 0.0))
    return ball_on(fc.ElasticBody(mesh, fc.NeoHookean(1.0, 0.3), "top", {"bottom": "xyz"}, name="block"), **options)


def bricks(**options: Any) -> tuple[fc.Scene, fc.RigidBody]:
    return ball_on(fc.AncfBody(block(), RUBBER, "top", {"bottom": "xyz"}, name="block"), **options)


def section(**options: Any) -> tuple[fc.Scene, fc.RigidBody]:
    mesh = fc.sections.rectangle((1.0, 1.0), (9, 5)).translated((-0.5, 0.0, 0.0))
    body = fc.PlaneBody(mesh, RUBBER, "top", {"bottom": "xz"}, name="block")
    roller = fc.RigidBody(fc.surfaces.Cylinder(1.0), name="ball").placed((0.02, 0.0, 1.0))
    return fc.Scene([body, roller], [fc.Contact(roller, body, **options)]), roller


def half_space(**options: Any) -> tuple[fc.Scene, fc.RigidBody]:
    half = fc.HalfSpace(RUBBER, size=(1.0, 1.0), cells=(24, 24), name="block").placed((0.0, 0.0, 1.0))
    return ball_on(half, **options)


def local_body(**options: Any) -> tuple[fc.Scene, fc.RigidBody]:
    mesh = fc.shapes.block((2.0, 2.0, 1.0), (4, 4, 2)).translated((-1.0, -1.0, 0.0))
    body = fc.ElasticBody(mesh, RUBBER, "top", {"bottom": "xyz"}, name="block")
    return ball_on(fc.LocalBody(body, (0.0, 0.0, 1.0), 0.6, (18, 18)), **options)


def doors(path: LoadPath, folder: Path) -> Doors:
    """Figures of the only contact of a path's last step, as every door shows them, with the accuracy shown."""
    result = path[-1]
    contact = result.contacts[0]
    with pytest.warns(PendingDeprecationWarning, match="within the outline"):  # they meant what the points give
        area, mean = contact.area, contact.mean_pressure
    yield "object", "area", area, EXACT
    yield "object", "mean_pressure", mean, EXACT
    for name in ("point_area", "max_pressure"):
        yield "object", name, float(getattr(contact, name)), EXACT
    with pytest.warns(PendingDeprecationWarning, match="force is that on 'ball'"):  # it was on the block
        force = contact.force
    for k, axis in enumerate("xyz"):
        yield "object", f"force_{axis}", float(force[k]), EXACT
    yield "parts", "area", sum(region.area for region in contact.regions), EXACT
    yield "parts", "force_z", sum(region.force[2] for region in contact.regions), EXACT
    if not contact._is_curve:
        sides = contact.split_by_plane((0.05, 0.0, 0.0), (1.0, 0.2, 0.0))
        yield "sides", "area", sum(side.area for side in sides), EXACT
        yield "sides", "force_z", sum(side.force[2] for side in sides), EXACT
    yield from _of_summary("summary", result.summary()["contacts"][0])
    saved = json.loads(result.save(folder / "result.json").read_text())
    yield from _of_summary("JSON", saved["contacts"][0])
    table = path.table()
    yield from _of_summary("row", table[-1]["contacts"][0])
    for name, values in table.figures.items():
        if name in FIGURES:
            yield "column", name, values[-1], EXACT
    rows = list(csv.DictReader(table.save(folder / "table.csv").open()))
    for name, value in rows[-1].items():
        if name in FIGURES:
            yield "CSV", name, float(value), EXACT
    yield from _of_text("table", str(table), lambda text: _last_line(text), FOUR)
    yield from _of_text("print", str(result), _printed, SIX)
    yield from _of_text("page", result._repr_html_(), _page, FIVE)
    title = result.plot("pressure").axes[0].get_title()
    yield from _of_text("map", title, _title, FOUR)
    force = float(re.search(rf"force {NUMBER}", repr(result))[1])
    yield "repr", "force", force, FOUR
    if len(path) == 1:
        yield "repr of the table", "force", float(re.search(rf"force {NUMBER}", repr(table))[1]), FOUR
    if contact.friction is not None:
        yield from _of_friction(path, folder)


FIGURES = (
    *(f"force_{axis}" for axis in "xyz"), "force", "area", "point_area", "max_pressure", "mean_pressure",
    "stick_area", "slip_area", "friction_work",
)  # fmt: skip


def _of_summary(door: str, row: Mapping[str, Any]) -> Doors:
    for k, axis in enumerate("xyz"):
        yield door, f"force_{axis}", row["force"][k], EXACT
    for name in ("area", "point_area", "max_pressure", "mean_pressure"):
        yield door, name, row[name], EXACT
    yield door, "area", sum(region["area"] for region in row["region_resultants"]), EXACT
    for name in ("stick_area", "slip_area", "friction_work"):
        if name in row.get("friction", {}):
            yield door, name, row["friction"][name], EXACT


def _of_friction(path: LoadPath, folder: Path) -> Doors:
    contact = path[-1].contacts[0]
    for name in ("stick_area", "slip_area", "friction_work"):
        yield "summary", name, float(contact.summary()["friction"][name]), EXACT
    for name in ("stick_area", "slip_area"):
        yield "object", name, getattr(contact, name), EXACT
    yield "object", "friction_work", contact.friction.friction_work, EXACT
    yield "path", "friction_work", path.friction_work[-1, 0], EXACT
    yield "stick and slip", "area", contact.stick_area + contact.slip_area, EXACT
    stick, slip, work = map(float, str(path).splitlines()[-1].split()[-3:])
    for name, value in (("stick_area", stick), ("slip_area", slip), ("friction_work", work)):
        yield "print of the path", name, value, FIVE


def _of_text(door: str, text: str, read: Callable[[str], Mapping[str, float]], digits: float) -> Doors:
    for name, value in read(text).items():
        yield door, name, value, digits


def _printed(text: str) -> dict[str, float]:
    found = dict(zip(("max_pressure", "mean_pressure"), _numbers(text, "pressure max, mean"), strict=True))
    found |= dict(zip(("force_x", "force_y", "force_z"), _numbers(text, "force on ball"), strict=True))
    found["area"] = _numbers(text, "area  ")[0]
    if "area stuck" in text:
        found |= dict(zip(("stick_area", "slip_area"), _numbers(text, "area stuck, sliding"), strict=True))
        found["friction_work"] = _numbers(text, "work of friction")[0]
    return found


def _numbers(text: str, head: str) -> list[float]:
    line = next(line for line in text.splitlines() if line.strip().startswith(head))
    return [float(x) for x in re.findall(r"-?\d\S*", line.split(head, 1)[1].split("in ")[0])]


def _last_line(text: str) -> dict[str, float]:
    heads = re.split(r"\s{2,}", text.splitlines()[0].strip())
    last = re.split(r"\s{2,}", next(line for line in text.splitlines()[::-1] if line.startswith("step")))
    return {name: float(value) for name, value in zip(heads, last, strict=True) if name in FIGURES}


def _page(text: str) -> dict[str, float]:
    cells = re.findall(r"<td>(.*?)</td>", text)
    force = [float(x) for x in cells[1].strip("()").split(",")]
    names = ("force_x", "force_y", "force_z", "area", "max_pressure", "mean_pressure")
    return dict(zip(names, [*force, *map(float, cells[2:5])], strict=True))


def _title(text: str) -> dict[str, float]:
    names = {"force": "force", "area": "area", "peak": "max_pressure", "mean": "mean_pressure"}
    return {name: float(re.search(rf"{word} {NUMBER}", text)[1]) for word, name in names.items()}


def single(scene: fc.Scene, ball: fc.RigidBody) -> LoadPath:
    """One solution without friction as a path of one step, for its table."""
    return LoadPath((scene.solve(motions={ball: {"z": -0.05}}),), (1,), ({},))


SCENES = {
    "elements": finite_elements, "soft": soft, "bricks": bricks, "section": section, "half-space": half_space,
    "window": local_body,
}  # fmt: skip


# half-spaces and windows in a scene have no friction
@pytest.mark.by_day(
    "section-0.0", "section-0.3", "half-space-0.0", "window-0.0", "elements-0.3", "soft-0.0", "bricks-0.0"
)
@pytest.mark.parametrize(
    ("kind", "mu"), [(k, mu) for k in SCENES for mu in (0.0, 0.3) if not mu or k not in ("half-space", "window")]
)
def test_every_door_shows_the_same_number(kind: str, mu: float, tmp_path: Path) -> None:
    """Object, print, summary, JSON, table, CSV, map and page: equal to the digits that each shows."""
    scene, ball = SCENES[kind](friction=mu)
    steps = [{"motions": {ball: {"z": -0.05}}}, {"motions": {ball: {"z": -0.05, "x": 0.004}}}]
    path = scene.solve_path(steps) if mu else single(scene, ball)
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for door, name, value, digits in doors(path, tmp_path):
        kept = found.setdefault(name, {})
        before, _ = kept.get(door, (value, digits))
        assert abs(before - value) <= EXACT * abs(value), (door, name)
        kept[door] = (value, digits)
    for name, values in found.items():
        exact = values.get("object", values.get("column"))
        assert exact is not None, name
        scale = max(abs(exact[0]), 1e-9)
        for door, (value, digits) in values.items():
            assert abs(value - exact[0]) <= digits * scale, (name, door, value, exact[0])
    assert {"print", "summary", "JSON", "row", "column", "CSV", "table", "map", "page"} <= set(found["area"])
    assert found["force_z"]["object"][0] > 0  # on the ball, which is named first
    point, area = found["point_area"]["object"][0], found["area"]["object"][0]
    assert abs(point / area - 1) > 0.01  # else the doors could not be told apart


@pytest.mark.parametrize("mu", [None, 0.3])
def test_a_half_space_alone_shows_the_same_number_at_every_door(mu: float | None, tmp_path: Path) -> None:
    """Object, print, summary, JSON, curve, path and picture; the mean times the area is the force."""
    half = fc.HalfSpace(RUBBER, size=(1.0, 1.0), cells=(24, 24))
    ball = fc.surfaces.Paraboloid(1.0)
    if mu is None:
        contact = half.press(ball, force=0.015)
    else:
        path = half.press_path(ball, [fc.PressStep(force=0.015, tangential=(0.003, 0.0))], mu)
        contact = path.last
    with pytest.warns(PendingDeprecationWarning, match="with its edge within the cells"):
        area, mean, share = contact.area, contact.mean_pressure, contact.area_fraction
    exact = {"area": area, "mean_pressure": mean, "area_fraction": share, "point_area": contact.point_area}
    found = [("summary", contact.summary()), ("JSON", json.loads(contact.save(tmp_path / "found.json").read_text()))]
    words = ("area", "area of its cells", "mean pressure", "stick area", "slip area", "work of friction")
    names = ("area", "point_area", "mean_pressure", "stick_area", "slip_area", "friction_work")
    printed = {
        name: re.search(rf"^  {word} +{NUMBER}$", str(contact), re.M) for word, name in zip(words, names, strict=True)
    }
    found.append(("print", {name: float(match[1]) for name, match in printed.items() if match}))
    title = contact.plot().get_suptitle()
    if mu is None:
        found.append(("picture", {"area": float(re.search(rf"area {NUMBER}", title)[1])}))
        curve = half.curve(ball, [0.015], progress=False)
        found.append(("curve", {name: float(curve.column(name)[0]) for name in ("area", "mean_pressure")}))
    else:
        exact |= {name: float(getattr(contact, name)) for name in ("stick_area", "slip_area", "friction_work")}
        found.append(("path", path.rows()[0]))
        saved = list(csv.DictReader(path.save(tmp_path / "path.csv").open()))
        found.append(("CSV", {name: float(value) for name, value in saved[0].items()}))
        assert abs(contact.stick_area + contact.slip_area - area) <= EXACT * area
    for door, figures in found:
        shared = exact.keys() & figures.keys()
        assert "area" in shared
        for name in shared:
            digits = {"picture": FOUR, "print": SIX}.get(door, EXACT if door != "curve" else 1e-6)
            assert abs(figures[name] - exact[name]) <= digits * exact[name], (door, name)
    assert abs(mean * area - 0.015) < 1e-12
    assert abs(contact.point_area / area - 1) > 0.01


def test_a_half_space_in_a_scene_is_the_one_alone() -> None:
    """The same pressures have the same area and, but for the coarser grid that a scene has not, the same estimate."""
    half = fc.HalfSpace(RUBBER, size=(1.0, 1.0), cells=(48, 48), name="half")
    surface = fc.surfaces.Paraboloid(1.0)
    alone = half.press(surface, approach=0.05)
    bowl = fc.RigidBody(surface, name="bowl")
    (contact,) = fc.Scene([half, bowl], [fc.Contact(half, bowl)]).solve(motions={bowl: {"z": -0.05}}).contacts
    assert abs(contact._whole.area / alone.figures["area"] - 1) < 1e-6
    assert abs(contact._whole.mean_pressure / alone.figures["mean_pressure"] - 1) < 1e-6
    ours, theirs = contact.error_estimate, alone.error_estimate
    assert abs(ours.pressure / theirs.pressure - 1) < 0.3  # 2.3 % and 1.1 % before
    assert ours.faces_across == theirs.faces_across


def stacked(first: str, mu: float, **options: Any) -> tuple[fc.LoadPath, fc.ElasticBody]:
    """A block pressed and dragged on one whose faces do not match; the contact names either first."""
    upper = fc.ElasticBody(
        fc.shapes.block((1.0, 1.0, 1.0), (2, 3, 2)).translated((0.1, 0.2, 0.0)),
        RUBBER,
        "bottom",
        {"top": "xyz"},
        name="upper",
    )
    lower = fc.ElasticBody(
        fc.shapes.block((2.0, 2.0, 1.0), (7, 7, 2)).translated((-0.3, -0.4, -1.0)),
        RUBBER,
        "top",
        {"bottom": "xyz"},
        name="lower",
    )
    pair = (upper, lower) if first == "upper" else (lower, upper)
    scene = fc.Scene([upper, lower], [fc.Contact(*pair, friction=mu, **options)])
    steps = [{"motions": {upper: {"z": -0.01}}}, {"motions": {upper: {"z": -0.01, "x": 0.002}}}]
    return scene.solve_path(steps), upper


@pytest.mark.by_day("auto")
@pytest.mark.parametrize("swap", ["auto", "never", "always"])
def test_a_contact_s_force_is_on_the_body_named_first(swap: str) -> None:
    """Source: equilibrium. Force and moment on the upper block are the opposite of what holds it."""
    slaves = set()
    for first, sign in (("upper", -1.0), ("lower", 1.0)):
        path, upper = stacked(first, 0.3, swap=swap)
        result = path[-1]
        (contact,) = result.contacts
        slaves.add((first, contact.slave.name))
        held = result.reaction(upper)
        shift = result.solved(upper).pose.to_world(upper.reference_point) - contact.reference_point
        moment = held[3:] + np.cross(shift, held[:3])
        figures, scale = contact.summary(), np.abs(held).max()
        for force in (
            contact._whole.force,
            path.forces[-1, 0],
            figures["force"],
            sum(r.force for r in contact.regions),
        ):
            np.testing.assert_allclose(force, sign * held[:3], atol=1e-9 * scale)
        np.testing.assert_allclose(contact._whole.moment, sign * moment, atol=1e-9 * scale)
        np.testing.assert_allclose(figures["friction"]["force"][0], sign * held[0], rtol=0.2)  # the rest leans
        np.testing.assert_allclose(path.table().column("force_x")[-1], sign * held[0], atol=1e-9 * scale)
        assert contact.label.startswith(first)
        assert figures["force_on"] == contact.bodies[0].name == first
        sides = contact.split_by_plane((0.6, 0.0, 0.0), (1.0, 0.0, 0.0))
        np.testing.assert_allclose(sum(side.force for side in sides), sign * held[:3], atol=1e-9 * scale)
    assert len({slave for _, slave in slaves}) == (1 if swap == "auto" else 2)


@pytest.mark.parametrize("n", [6, 12])
def test_a_force_through_three_points_has_an_area(n: int) -> None:
    """No mean pressure exceeds the peak: where no outline surrounds what carries the force, its points count.

    Source: force = mean times area, mean at most the peak. Three nodes stand out by a hundredth; an outline round them
    has no area, or too little.
    """
    mesh = fc.shapes.block((1.0, 1.0, 0.5), (n, n, 3), element="hex8")
    points = mesh.points.copy()
    for x, y in ((0.25, 0.25), (0.75, 0.25), (0.5, 0.75)):
        points[np.argmin(np.linalg.norm(points - [x, y, 0.5], axis=1)), 2] += 0.01
    body = fc.ElasticBody(replace(mesh, points=points), STEEL, "top", {"bottom": "xyz"}, name="body")
    plate = fc.RigidBody(fc.Plane(), name="plate").placed(rotation=fc.rotation_about((1, 0, 0), np.pi))
    plate = plate.placed((0.0, 0.0, 0.51))
    contact = fc.Scene([body, plate], [fc.Contact(body, plate)]).solve(forces={plate: (0, 0, -10.0)}).contacts[0]
    assert contact.active.sum() == 3
    assert contact.outline.area * contact.max_pressure < 10.0  # what was printed before, as area 0 for the coarser
    assert contact._whole.area * contact.max_pressure >= 10.0 * (1 - 1e-9)
    assert abs(contact._whole.area * contact._whole.mean_pressure / 10.0 - 1) < 0.01  # forces lean on the facets
    assert abs(sum(region.area for region in contact.regions) / contact._whole.area - 1) < EXACT


def test_former_names_warn_and_give_what_they_did() -> None:
    contact = stacked("upper", 0.3)[0][-1].contacts[0]
    for owner, old, new in (
        (contact, "edge_area", contact._whole.area),
        (contact, "edge_mean_pressure", contact._whole.mean_pressure),
        (contact.friction, "dissipated", contact.friction.friction_work),
        (contact.friction, "stick_area", contact.friction.point_stick_area),
    ):
        with pytest.warns(DeprecationWarning, match=f"{old} is now"):
            assert getattr(owner, old) == new
    with pytest.warns(DeprecationWarning, match="'outline_area' is now 'area'"):
        assert contact.summary()["outline_area"] == contact._whole.area
