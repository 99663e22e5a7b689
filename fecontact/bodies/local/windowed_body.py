"""A body with several windows: contacts that are coupled through it."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
from scipy.spatial import cKDTree

from fecontact.analytic.face_loads import displacements
from fecontact.bodies.elastic import ElasticBody
from fecontact.bodies.local.body import LocalBody
from fecontact.bodies.local.factored import Factored
from fecontact.bodies.local.meshed_windows import MeshedWindows
from fecontact.bodies.local.remainder import MAX_DEFECT, surface_weights
from fecontact.bodies.local.surface import WindowSurface
from fecontact.bodies.local.window import Window
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import text
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.one_line import one_line
from fecontact.surfaces.nodal_weights import components_along

APART = 0.25
"""Least distance of two windows, relative to the longer side: nearer ones are not smooth to each other."""


@one_line
@dataclass(frozen=True, eq=False, init=False)
class WindowedBody(MeshedWindows):
    """An elastic body with several windows, each as that of a `LocalBody`.

    Parameters
    ----------
    parts : LocalBody
        Two or more, of the same elastic body, with windows that do not touch.
    name : str, optional
        The body's unless given.

    Attributes
    ----------
    contact : tuple of str
        Its contact surfaces, ``"window 1"``, ``"window 2"``, ... in the order of the parts.

    Raises
    ------
    InputError
        If the parts are of different bodies, have no windows yet, or the windows are too near to each other.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((4.0, 2.0, 1.0), (8, 4, 2))
    >>> beam = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), supports={"bottom": "xyz"})
    >>> two = fc.WindowedBody(*(fc.LocalBody(beam, (x, 1.0, 1.0), 0.8, (24, 24)) for x in (1.0, 3.0)))
    >>> balls = [fc.RigidBody(fc.Sphere(5.0), pose=fc.Pose(translation=(x, 1.0, 1.0))) for x in (1.0, 3.0)]
    >>> contacts = [fc.Contact(two, b, surfaces=(w, "surface")) for b, w in zip(balls, two.contact, strict=True)]
    >>> result = fc.Scene([two, *balls], contacts).solve(forces={b: (0.0, 0.0, -0.002) for b in balls})
    >>> [round(float(np.abs(c.force[2])), 9) for c in result.contacts]
    [0.002, 0.002]
    """

    parts: tuple[LocalBody, ...]
    name: str
    pose: Pose
    shared: dict[str, Any] = field(repr=False)

    def __init__(self, *parts: LocalBody, name: str | None = None) -> None:
        _check(parts)
        first = parts[0]
        values = {
            "parts": parts,
            "name": first.body.name if name is None else text("the name of a body", name),
            "pose": first.pose,
            "shared": {},
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def body(self) -> ElasticBody:  # type: ignore[override]
        """The elastic body."""
        return self.parts[0].body

    @property
    def contact(self) -> tuple[str, ...]:
        """Names of its windows."""
        return tuple(f"window {i}" for i in range(1, len(self.parts) + 1))

    @property
    def placed_windows(self) -> tuple[Window, ...]:
        """The windows of its parts."""
        return tuple(part.window for part in self.parts)

    @property
    def windows(self) -> tuple[LocalBody, ...]:
        """The parts, with one factor of the stiffness; the same objects in every pose."""
        if "windows" not in self.shared:
            origins = np.array([part.window.origin for part in self.parts])
            factored = Factored.of(self.body.model, origins)
            self.shared["windows"] = tuple(_with_factor(part, factored) for part in self.parts)
        return cast(tuple[LocalBody, ...], self.shared["windows"])

    @property
    def across(self) -> dict[tuple[int, int], Array]:
        """Displacements into the body (k_i, k_j) at the nodes of window i by unit forces at those of another, j."""
        return self._across[0]

    @property
    def _across(self) -> tuple[dict[tuple[int, int], Array], float]:
        if "across" not in self.shared:
            self.shared["across"] = _across(self.windows, self.name)
        return cast(tuple[dict[tuple[int, int], Array], float], self.shared["across"])

    @property
    def defect(self) -> float:
        """Largest violation of Betti's theorem within and between windows, see `Remainder.defect`."""
        return max(self._across[1], *(part.remainder.defect for part in self.windows))

    def surface(self, name: str) -> WindowSurface:
        """One of its windows."""
        if name not in self._surfaces:
            raise InputError(f"The windows of {self.name!r} are {', '.join(self.contact)}; found {name!r}.")
        return self._surfaces[name]

    def describe(self) -> str:
        """One-line description of the model."""
        sizes = ", ".join(" x ".join(map(str, part.window.shape)) for part in self.parts)
        known = f", Betti defect {self.defect:.1e}" if "across" in self.shared else ""
        return f"{self.name}: {len(self.parts)} windows of {sizes} cells{known}; on {self.body.describe()}"


def _check(parts: Sequence[LocalBody]) -> None:
    if len(parts) < 2 or not all(isinstance(part, LocalBody) for part in parts):
        raise InputError(f"Expected two or more LocalBody; found {parts!r}.", code="too-few-windows")
    if any(part.body is not parts[0].body for part in parts):
        raise InputError("Expected windows of one elastic body; found LocalBody of several. Make them of the same one.")
    if not all(part.is_placed for part in parts):
        raise InputError("Expected windows with at= and window=; found one that is placed when it is touched.")
    for i, part in enumerate(parts):
        for other in parts[:i]:
            apart = float(cKDTree(other.window.cells).query(part.window.cells)[0].min())
            least = APART * max(*part.window.grid.size, *other.window.grid.size)
            if apart < least:
                raise InputError(
                    f"Two windows of {part.body.name!r}, about {np.array2string(part.window.origin, precision=4)} and "
                    f"{np.array2string(other.window.origin, precision=4)}, are {apart:.4g} apart; expected "
                    f"{least:.4g} or more. Take smaller ones, or one window for both contacts.",
                    code="windows-too-close",
                )


def _with_factor(part: LocalBody, factored: Factored) -> LocalBody:
    """A copy of a local body with another factor of its stiffness."""
    other = copy.copy(part)
    vars(other).pop("cell_model", None)
    object.__setattr__(other, "shared", {"factored": factored})
    return other


def _across(parts: Sequence[LocalBody], name: str) -> tuple[dict[tuple[int, int], Array], float]:
    """Displacements between the nodes of windows, made symmetric, and their largest asymmetry.

    Raises
    ------
    InputError
        If they are too far from symmetric.
    """
    pairs = [(i, j) for i in range(len(parts)) for j in range(len(parts)) if i != j]
    found = {(i, j): _seen(parts[i], parts[j]) for i, j in pairs}
    scale = min(part.remainder.mean for part in parts)
    defect = max(float(np.abs(found[i, j] - found[j, i].T).max()) for i, j in pairs) / 2 / scale
    if defect > MAX_DEFECT:
        raise InputError(
            f"The compliance of {name!r} between its windows contradicts Betti's theorem by {100 * defect:.2g} %, more "
            f"than {100 * MAX_DEFECT:g} %: its mesh is too coarse. Take a finer mesh, or smaller windows."
        )
    return {(i, j): (found[i, j] + found[j, i].T) / 2 for i, j in pairs}, defect


def _seen(part: LocalBody, loaded: LocalBody) -> Array:
    """Displacements (k_i, k_j) into the body at the nodes of a window by unit forces at those of another."""
    points, inwards = part.remainder.points, -part.window.normal
    nodes = surface_weights(part.body.model.mesh, part.window, points)
    smooth = components_along(nodes, np.tile(inwards, (len(points), 1))) @ loaded.remainder.fields
    direct = [(displacements(points, load, loaded.material) @ inwards).sum(axis=0) for load in loaded.remainder.sources]
    return np.asarray(smooth + np.stack(direct, axis=1))
