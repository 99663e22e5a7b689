"""Windows of local bodies that are not given: placed where bodies touch first, and fitted to the contact found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from fecontact.bodies.body import Body
from fecontact.bodies.halfspace import HalfSpace
from fecontact.bodies.local import LocalBody
from fecontact.bodies.local.placing import first_touch, onto_planes, planes_through
from fecontact.bodies.pose import Pose, turned
from fecontact.bodies.rigid import Plane
from fecontact.common.errors import InputError
from fecontact.contact.candidates import KnownContact
from fecontact.contact.loads import Loading, LoadStep
from fecontact.contact.model import SceneModel
from fecontact.results.result import ContactResult
from fecontact.scene.carried import with_bodies
from fecontact.surfaces.facet_surface import FacetSurface

#: Half a window relative to the reach of the contact.
WIDE = 1.15

#: Reach of a contact, relative to the window, from which the window is grown.
NEAR_RIM = 0.96

#: Factor by which it is grown.
GROWTH = 1.5

#: Reach of a contact, relative to the window, below which the window is fitted to it.
SMALL = 0.6

#: Distance of the first touch from a plane of symmetry, relative to the contact, within which it lies on it.
ON_PLANE = 1.0

#: Windows tried in turn.
MAX_WINDOWS = 8

Solve = Callable[[SceneModel, LoadStep, Sequence[KnownContact | None]], ContactResult]


def has_open_windows(model: SceneModel) -> bool:
    """Whether local bodies of a scene have no window yet, or windows that do not face each other."""
    if not any(b._has_window for b in model.bodies):
        return False
    return any(map(_is_open, model.bodies)) or any(
        body._met_by(other) is not body for c in model.contacts for body, other in (c.bodies[::-1], c.bodies)
    )


def _is_open(body: Body) -> bool:
    """Whether it is a local body without a window."""
    return body._has_window and not cast(LocalBody, body).is_placed


def solve_with_windows(model: SceneModel, step: LoadStep, solve: Solve) -> ContactResult:
    """Solution with windows where the bodies touch, as large as the contacts found.

    Parameters
    ----------
    model : SceneModel
    step : LoadStep
    solve : callable
        Function ``solve(scene, step, known)`` for one solution.

    Raises
    ------
    InputError
        If a contact still reaches the rim of its window after `MAX_WINDOWS` windows.
    """
    # the bodies move by their prescribed motions before they touch
    loading = step.on(model.bodies)
    bodies = list(model.bodies)
    number = {id(b): k for k, b in enumerate(bodies)}
    leading = []
    for contact in model.contacts:
        pair = contact.bodies
        # the one without a window first; of two with windows the master follows the slave
        for body, partner in (pair, pair[::-1]) if _is_open(pair[0]) else (pair[::-1], pair):
            k = number[id(body)]
            bodies[k] = bodies[k]._met_by(bodies[number[id(partner)]])
            if _is_open(bodies[k]):
                leading.append(k)
                bodies[k] = _first_window(cast(LocalBody, body), model, loading)
    for _ in range(MAX_WINDOWS):
        carried = with_bodies(model, bodies)
        _check_facing(carried.scene)
        result = solve(carried.scene, carried.step(step), ())
        fitted = list(bodies)
        for k in leading:
            fitted[k] = _fitted(cast(LocalBody, bodies[k]), result)
        if all(new is old for new, old in zip(fitted, bodies, strict=True)):
            return replace(result, _unrefined=tuple(model.bodies))
        bodies = fitted
    told = ", ".join(f"{bodies[k].name!r} {cast(LocalBody, bodies[k]).window.grid.size}" for k in leading)
    raise InputError(
        f"The contact still reaches the rim of its window after {MAX_WINDOWS} windows; the last: {told}. It is not "
        "small beside the body: use the ElasticBody itself with accuracy= when the scene is solved."
    )


def _first_window(body: LocalBody, model: SceneModel, loading: Loading) -> LocalBody:
    """A body with its window at the first touch, as large as Hertz's contact."""
    contacts = [c for c in model.contacts if body is c.slave or body is c.master]
    if len(contacts) != 1:
        raise InputError(
            f"{body.name!r} is in {len(contacts)} contacts; a local body has one window. Leave it an ElasticBody, or "
            "give it one contact.",
            code="several-contacts",
        )
    (contact,) = contacts
    assert contact.surfaces is not None
    partner = int(body is contact.slave)
    other, name = contact.bodies[partner], contact.surfaces[partner]
    return window_at_touch(body, body.surface("window"), (body, other), name, loading)


def window_at_touch(
    body: LocalBody, own: FacetSurface, pair: tuple[Body, Body], surface: str, loading: Loading
) -> LocalBody:
    """A local body with its window where its surface touches that of another first, as large as Hertz's contact.

    Parameters
    ----------
    body : LocalBody
        Without a window.
    own : FacetSurface
        Its surface.
    pair : (Body, Body)
        The body as it is in the scene, and the other one.
    surface : str
        Name of the other's surface.
    loading : Loading

    Raises
    ------
    InputError
        If they do not touch, conform, or the window is not within one smooth face.
    """
    other = pair[1]
    met = Plane() if isinstance(other, HalfSpace) else other.surface(surface)
    moved = [_after_motion(b, loading) for b in pair]
    modulus = 1 / (1 / body.contact_modulus + 1 / other.contact_modulus)
    find = partial(
        first_touch, own, met, moved[0].relative_to(moved[1]), modulus,
        names=(body.name, other.name), start=body.wish.at,
    )  # fmt: skip
    touch = find(force=loading.magnitude)
    at = onto_planes(body.body, touch.point, ON_PLANE * touch.semi_axes[0]) if body.wish.at is None else body.wish.at
    images = 2 ** len(planes_through(body.body, at))
    if images > 1:  # the load is that of the modelled part
        touch = find(force=images * loading.magnitude, start=at)
    if body.wish.sides is not None:
        return body.with_window(at, body.wish.sides)
    side = 2 * WIDE * touch.semi_axes[1]
    square = body.with_window(at, (side, side))
    half = touch.extents(square.window.axes[:, :2].T)
    return body.with_window(at, (2 * WIDE * float(half[0]), 2 * WIDE * float(half[1])))


def _check_facing(model: SceneModel) -> None:
    """Refuse windows that do not face each other, as those of a body between two others."""
    for contact in model.contacts:
        for body, other in (contact.bodies, contact.bodies[::-1]):
            if body._met_by(other) is not body:
                raise InputError(
                    f"The cells of {body.name!r} cannot lie opposite the window of {other.name!r} and of another local "
                    "body too: it has one window. Give it one contact with a local body, or leave it an ElasticBody.",
                    code="two-windows",
                )


def _after_motion(body: Body, loading: Loading) -> Pose:
    """Pose of a body after its prescribed motion."""
    frame = next(f for f in loading.frames if f.body is body)
    return turned(body.pose, frame.prescribed, frame.point)


def _fitted(body: LocalBody, result: ContactResult) -> LocalBody:
    """The body with a window that fits the contact found; itself if it does."""
    window, wish = body.window, body.wish
    posed = result.solved(body)
    ((contact, interface),) = [
        (c, i) for c, i in zip(result.contacts, result._interfaces, strict=True) if posed in (i.slave, i.master)
    ]
    cells = interface.pairing.nodes[contact.active]
    if len(cells) == 0 or wish.sides is not None:
        return body
    low, high = np.zeros(2), np.zeros(2)
    for axis, places in enumerate(window.places):
        low[axis], high[axis] = places[cells].min(), places[cells].max()
    low = np.where(window.mirrored, -high, low)
    reach = np.maximum(-low, high) / window.half
    if (reach < NEAR_RIM).all() and (reach > SMALL).any():
        return body
    middle = np.where(reach < NEAR_RIM, (low + high) / 2, 0.0) if wish.at is None else np.zeros(2)
    extent = np.maximum(high - middle, middle - low)
    half = np.where(reach < NEAR_RIM, WIDE * extent, GROWTH * window.half)
    at = window.origin if wish.at is not None or not middle.any() else window.on_surface(*middle)
    return body.with_window(at, (2 * float(half[0]), 2 * float(half[1])))
