"""A block on a rigid plane: held by friction for ten thousand steps, refused beyond, dragged to and fro."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fecontact.app.friction.figures import StudyFigures
from fecontact.bodies import Body, ElasticBody, Plane, RigidBody
from fecontact.common import checks
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, SupportError
from fecontact.common.files import save_figure, save_rows
from fecontact.common.material import Material
from fecontact.common.units import Units
from fecontact.contact.contact import Contact
from fecontact.mesh import shapes
from fecontact.results.pictures.contact_map import draw_friction
from fecontact.scene.load_path import LoadPath
from fecontact.scene.scene import Scene

STEPS = 10_000
"""Steps of constant load."""

FAR = 8.0
"""Drag to each side, in shifts of the top under which an elastic block that sticks would slide."""

BRANCH = 12
"""Steps of a branch of the drag."""

BEYOND = 1.05
"""Load over what friction holds that is to be refused."""


@dataclass(frozen=True, eq=False)
class BlockStudy(StudyFigures):
    """Figures of a block, its paths, and how the load beyond friction was refused.

    Attributes
    ----------
    held, dragged : LoadPath
        Pressed, then pulled by a constant load; pressed, then dragged by its top to and fro.
    shift : (n,) array
        Shift of the top in the steps of the drag.
    refusal : str
    limit : float
        What friction holds.
    """

    held: LoadPath
    dragged: LoadPath
    shift: Array
    refusal: str
    limit: float

    @property
    def friction(self) -> Array:
        """Force (n,) on the top along the drag."""
        return -self.dragged.forces[:, 0, 0]

    def as_dict(self) -> dict[str, Any]:
        """All figures for scripts, with a row per step of the drag."""
        return {**super().as_dict(), "refusal": self.refusal, "steps": self._rows()}

    def __str__(self) -> str:
        return f"{super().__str__()}\n{BEYOND:g} of what friction holds is refused:\n  {self.refusal}"

    def save(self, path: str | Path) -> Path:
        """Write a CSV file, one row per step of the drag."""
        rows = self._rows()
        return save_rows(path, list(rows[0]), (row.values() for row in rows))

    def plot(self, path: str | Path | None = None, length: str = "", force: str = "", stress: str = "") -> Figure:
        """Tractions, stick and slip under the constant load; force over shift of the drag."""
        units = Units(length, force, stress)
        figure = Figure(figsize=(12.0, 5.0), layout="constrained")
        left, right = figure.subplots(1, 2)
        contact = self.held[-1].contacts[0]
        assert contact.friction is not None
        draw_friction(left, contact, contact.friction, units)
        left.set_title("held by friction: sticks and slides")
        _draw_drag(right, self.shift, self.friction, self.limit, units)
        figure.suptitle(f"{self.name}, {self.setting}")
        return save_figure(figure, path)

    def _rows(self) -> list[dict[str, float]]:
        values = zip(self.shift, self.friction, self.dragged.friction_work[:, 0], strict=True)
        return [{"shift": float(s), "friction": float(f), "friction_work": float(w)} for s, f, w in values]


def block_study(
    material: Material, side: float, force: float, mu: float, tangential: float | None, cells: int
) -> BlockStudy:
    """A block pressed on a rigid plane by its top, which stays level; then pulled, or dragged along x.

    Parameters
    ----------
    material : Material
    side : float
        Side of the square block; it is half as high.
    force : float
        Normal force.
    mu : float
        Coulomb's mu.
    tangential : float or None
        Force that pulls; None: 0.6 of what friction holds.
    cells : int
        Cells along a side, at least two.

    Returns
    -------
    BlockStudy
        Coulomb's law beside: friction when everything slides, its work, no slip under a constant load.

    Raises
    ------
    InputError
        For numbers that are not positive, or a load beyond what friction holds.
    """
    checks.lengths(radius=side, force=force, friction=mu)
    checks.whole("the number of cells", cells, 2)
    limit = mu * force
    pull = 0.6 * limit if tangential is None else checks.positive("tangential", tangential)
    if pull >= limit:
        raise InputError(
            f"The block slides as a whole: friction holds {limit:g}; found a tangential force of {pull:g}.",
            code="slides-as-a-whole",
        )
    mesh = shapes.block((side, side, side / 2), (cells, cells, max(cells // 2, 1)))
    block = ElasticBody(mesh, material, "bottom", {"top": "xyz"}, name="block")
    plane = RigidBody(Plane(), name="plane")
    scene = Scene([block, plane], [Contact(block, plane, friction=mu)])
    pressed = _pulled(block, 0.0, force)
    held = scene.solve_path([pressed, *[_pulled(block, pull, force)] * (STEPS + 1)], progress=False)
    shift = _shifts(FAR * limit / (material.shear_modulus * side**2) * side / 2)
    drag = [{"forces": {block: (0, 0, -force)}, "free": {block: "z"}, "motions": {block: {"x": x}}} for x in shift]
    dragged = scene.solve_path(drag)
    slid = abs(shift[-1] - shift[-2])
    stuck = held[-1].contacts[0]
    first, last = held[1].contacts[0].friction, stuck.friction
    assert first is not None
    assert last is not None
    figures: dict[str, tuple[float, float | None]] = {
        "friction under the pull": (-float(last.force[0]), pull),
        f"slip in {STEPS:,} steps of this load": (float(np.abs(last.moved - first.moved).max()), 0.0),
        "share of the area that sticks": (stuck.stick_area / stuck.whole.area, None),
        "friction when all slides": (abs(float(dragged.forces[-1, 0, 0])), limit),
        "work of friction of a slide": (float(dragged.friction_work[-1, 0]), limit * slid),
        "least work of a step": (min(float(dragged.friction_work.min()), 0.0), 0.0),
    }
    worst = max(r.friction.residuals.worst for r in (held[0], held[1], held[-1], *dragged.steps) if r.friction)
    setting = f"friction {mu:g}, {cells} x {cells} faces, {STEPS:,} steps held, {len(shift)} dragged"
    return BlockStudy(
        "block on a rigid plane",
        "Coulomb",
        figures,
        setting,
        worst,
        held,
        dragged,
        shift,
        _refused(scene, block, limit, force),
        limit,
    )


def _pulled(block: Body, pull: float, force: float) -> dict[str, Any]:
    return {"forces": {block: (pull, 0, -force)}, "free": {block: "x z"}}


def _shifts(far: float) -> Array:
    """Shifts of the top: out, back to the other side, and out again, in fine steps after each turn."""
    share = np.linspace(0, 1, BRANCH + 1) ** 2
    back = 1 - 2 * share[1:]
    return far * np.concatenate([share, back, -back])


def _refused(scene: Scene, block: Body, limit: float, force: float) -> str:
    """What the refusal of a load beyond friction says."""
    try:
        scene.solve(**_pulled(block, BEYOND * limit, force))
    except SupportError as refusal:
        return str(refusal)
    return "it was not"


def _draw_drag(axes: Any, shift: Array, friction: Array, limit: float, units: Units) -> None:
    """Draw force over shift, with the limit by Coulomb's law."""
    axes.plot(shift, friction, "o-", markersize=4, linewidth=1.0, color="tab:blue", label="found")
    for side in (-limit, limit):
        axes.axhline(
            side, color="black", linewidth=1.0, linestyle="--", label="mu times the normal force" if side > 0 else None
        )
    axes.set_xlabel(units.after("shift of the top", "length"))
    axes.set_ylabel(units.after("force", "force"))
    axes.set_title("dragged to and fro")
    axes.grid(alpha=0.3)
    axes.ticklabel_format(axis="x", style="sci", scilimits=(-2, 3))
    axes.legend(loc="lower center", bbox_to_anchor=(0.45, 0.12), fontsize="small")
