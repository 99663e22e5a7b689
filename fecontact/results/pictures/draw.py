"""Pictures of a result: maps of its contacts, or its bodies. Needs matplotlib only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from fecontact.bodies.pose import Pose
from fecontact.common.arguments import flag, items, known_options, text
from fecontact.common.checks import among, positive, whole
from fecontact.common.directions import Directions
from fecontact.common.errors import InputError
from fecontact.common.files import save_figure
from fecontact.common.units import UnitNames, Units
from fecontact.results.contact_fields import ContactFields
from fecontact.results.field_map import FIELDS, field_map, scale_top
from fecontact.results.pictures.case_pictures import draw_convergence
from fecontact.results.pictures.contact_map import (
    draw_division,
    draw_field,
    draw_friction,
    draw_outlines,
    draw_sensels,
    map_window,
)
from fecontact.results.pictures.map_projection import map_of
from fecontact.results.pictures.section_curve import draw_curve
from fecontact.results.resultants import DividingPlane

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult

STYLES = ("smooth", "sensels")


def plot_result(
    result: ContactResult, what: str = "pressure", path: str | Path | None = None, **options: Any
) -> Figure:
    """Draw a field: of the contacts (`plot_contacts`), or of the bodies (`bodies.plot_bodies`).

    Parameters
    ----------
    result : ContactResult
    what : str
        'pressure', 'gap' or 'friction' of the contacts; 'convergence' of a result solved to an accuracy; 'von_mises',
        'displacement', 'contact_pressure', 'stress_xx', ... on the bodies.
    path : str or Path, optional
        File to write; the suffix decides the format.
    **options
        Options of the function that draws it.

    Raises
    ------
    InputError
        If there is no such field.
    """
    text("the field", what)
    if what == "convergence":
        known_options(plot_contacts, options)
        return save_figure(draw_convergence(result.convergence), path)
    if what in FIELDS:
        known_options(plot_contacts, options)
        return plot_contacts(result, what, path, **options)
    from fecontact.results.pictures import bodies

    among("field", what, (*FIELDS, "convergence", *bodies.FIELDS))
    known_options(bodies.plot_solids, options)
    return bodies.plot_bodies(result, what, path, **options)


class SolvedContacts(Protocol):
    """What maps are drawn of: a result, or a state of gradient coordinates."""

    @property
    def contacts(self) -> Sequence[ContactFields]:
        """Its contacts."""

    @property
    def unit_names(self) -> Units:
        """Units of its numbers."""


def plot_contacts(
    result: SolvedContacts,
    what: str = "pressure",
    path: str | Path | None = None,
    *,
    units: UnitNames = (),
    length: str = "",
    force: str = "",
    axes: Mapping[str, ArrayLike] | None = None,
    style: str = "smooth",
    pitch: float | None = None,
    contacts: Sequence[int] | None = None,
    same_colours: bool = True,
    split: DividingPlane | None = None,
    ax: Axes | None = None,
) -> Figure:
    """Map a field of every contact, flat or unrolled (`map_projection`), with its regions outlined.

    Parameters
    ----------
    result : ContactResult, or another with contacts
    what : {'pressure', 'gap', 'friction'}
        'friction': sizes and directions of tractions, and what sticks and slides.
    path : str or Path, optional
        File to write; the suffix decides the format.
    units : (length, force) or (length, force, stress), or str
        Names for labels, ``("mm", "N", "MPa")``; those of the scene unless given. A text is that of pressures.
    length, force : str
        Names of the other units beside a text.
    axes : mapping of str to (3,) array, optional
        Names of directions along which maps are drawn, see `Scene`; those of the scene unless given.
    style : {'smooth', 'sensels'}
        'sensels' shows the pressure on a film of square sensors: the force on each over its area.
    pitch : float, optional
        Side of a sensel; a round length that puts about 24 across the contact unless given.
    contacts : sequence of int, optional
        Contacts of the result to draw, by number; all unless given.
    same_colours : bool
        Whether all maps share one scale.
    split : DividingPlane, optional
        A plane in the world's axes or those of a body of the result, drawn where it meets the contacts, with the names
        of its sides.
    ax : matplotlib Axes, optional
        Where to draw a single contact.

    Raises
    ------
    InputError
        For an unknown field, style or contact, gaps with sensels, a pitch that is not positive, or axes for several.
    """
    _check_map(result, what, style, pitch, contacts, same_colours)
    if style == "sensels" and any(c._is_curve for c in result.contacts):
        raise InputError("A contact of sections is a curve, on which no film of sensels fits; leave style='smooth'.")
    shown = [result.contacts[k] for k in (range(len(result.contacts)) if contacts is None else contacts)]
    if axes is not None:
        shown = [replace(contact, directions=Directions.of(axes)) for contact in shown]
    names = Units.labels(units, length=length, force=force).with_defaults(result.unit_names)
    if ax is not None and len(shown) != 1:
        raise InputError(f"One contact is drawn into given axes; found {len(shown)}: contacts=[0].", code="one-axes")
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    if ax is None:
        figure = Figure(figsize=_figure_size(shown, columns, rows), layout="compressed")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
    else:
        figure, grid = cast(Figure, ax.figure), np.array([ax])
    top = max(map(scale_top, shown)) if same_colours and what != "worn" else None
    for panel, contact in zip(grid, shown, strict=False):
        if what == "friction":
            draw_friction(panel, contact, names)
        else:
            kept = field_map(contact, what)
            if contact._is_curve:
                draw_curve(panel, kept, names, top)
            elif style == "sensels":
                draw_sensels(panel, contact, pitch, names, top)
                draw_outlines(panel, map_of(kept), kept, names)
            else:
                draw_field(panel, kept, names, top, outlined=True)
        if split is not None and not contact._is_curve:
            draw_division(panel, contact, split.sides, *split.in_world(_pose_of(split, result.contacts)))
        panel.set_title(_title(contact, what, names), fontsize="medium")
    for panel in grid[len(shown) :]:
        panel.set_axis_off()
    return save_figure(figure, path)


def _check_map(
    result: SolvedContacts,
    what: str,
    style: str,
    pitch: float | None,
    contacts: Sequence[int] | None,
    same_colours: bool,
) -> None:
    among("field of a contact", what, FIELDS)
    among("style", style, STYLES)
    if style == "sensels" and what != "pressure":
        raise InputError(f"Sensels feel pressure; found the field {what!r}. Draw it with style='smooth'.")
    if pitch is not None:
        positive("the pitch of the sensels", pitch)
    if what == "friction" and any(c.friction is None for c in result.contacts):
        raise InputError("A contact without friction has no tractions to draw; give Contact(..., friction=...).")
    given = (0,) if contacts is None else items("contacts", contacts, "numbers")
    if wrong := [k for k in given if not whole("the number of a contact", k, 0) < len(result.contacts)]:
        raise InputError(f"There is no contact {wrong[0]}; the result has {len(result.contacts)} (0, 1, ...).")
    if not given:
        raise InputError("No contacts selected: give contacts=[0], or leave it out for all.")
    flag("same_colours", same_colours)


def _pose_of(split: DividingPlane, contacts: Sequence[ContactFields]) -> Pose:
    """Pose of the body with which a plane moves."""
    if split.body is None:
        return Pose()
    found = [body.pose for contact in contacts for body in contact.bodies if body.name == split.body.name]
    if not found:
        raise InputError(f"The dividing plane is of {split.body.name!r}, in no contact here.", code="no-contact")
    return found[0]


def _title(contact: ContactFields, what: str, units: Units) -> str:
    """Figures of a contact, of friction those of its tractions; the estimated error where a result warns of it."""
    whole, friction = contact._whole, contact.friction
    if not contact.active.any():
        return f"{contact.label}\nno contact"
    kinds: list[tuple[str, Any, str, str]] = [
        ("force", np.linalg.norm(whole.force), "force", ""),
        ("area", whole.area, "length", "²"),
    ]
    if what == "friction" and friction is not None:
        kinds.insert(1, ("friction", np.linalg.norm(friction.force), "force", ""))
        kinds.append(("largest traction", np.linalg.norm(friction.traction, axis=1).max(), "stress", ""))
    else:
        kinds += [("peak", whole.max_pressure, "stress", ""), ("mean", whole.mean_pressure, "stress", "")]
    figures = ", ".join(f"{name} {units.number(float(value), *unit)}" for name, value, *unit in kinds)
    return "\n".join(filter(None, (contact.label, figures, contact.error_estimate.caution)))


def _figure_size(contacts: Sequence[ContactFields], columns: int, rows: int) -> tuple[float, float]:
    """Size in inches for maps with colour bar and title, in the contacts' proportions, or for curves."""
    if any(c._is_curve for c in contacts):
        return 6.4 * columns, 4.6 * rows
    sides = [np.subtract(*reversed(map_window(c, map_of(c)))) for c in contacts]
    tallest = max(float(height / width) if width > 0 else 1.0 for width, height in sides)
    return 6.4 * columns, rows * (min(max(4.6 * tallest, 1.6), 6.5) + 1.2)
