"""Pictures of a result: maps of its contacts, or its bodies. Needs matplotlib only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from fecontact.common.arguments import flag, items, known_options, text
from fecontact.common.checks import among, positive, whole
from fecontact.common.directions import Directions
from fecontact.common.errors import InputError
from fecontact.common.files import save_figure
from fecontact.common.units import Units
from fecontact.results.contact_fields import ContactFields
from fecontact.results.field_map import FIELDS, field_map, scale_top
from fecontact.results.pictures.case_pictures import draw_convergence
from fecontact.results.pictures.contact_map import (
    draw_field,
    draw_friction,
    draw_outlines,
    draw_sensels,
    map_window,
)
from fecontact.results.pictures.map_projection import map_of
from fecontact.results.pictures.section_curve import draw_curve

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
    units: str = "",
    length: str = "",
    force: str = "",
    axes: Mapping[str, ArrayLike] | None = None,
    style: str = "smooth",
    pitch: float | None = None,
    contacts: Sequence[int] | None = None,
    same_colours: bool = True,
) -> Figure:
    """Map a field of every contact, flat or unrolled (`map_projection`), with its regions outlined.

    Parameters
    ----------
    result : ContactResult, or another with contacts
    what : {'pressure', 'gap', 'friction'}
        'friction': sizes and directions of tractions, and what sticks and slides.
    path : str or Path, optional
        File to write; the suffix decides the format.
    units, length, force : str
        Units of pressures, of lengths and of forces, for labels; those of the scene unless given.
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

    Raises
    ------
    InputError
        For an unknown field, style or contact, gaps with sensels, or a pitch that is not positive.
    """
    _check_map(result, what, style, pitch, contacts, same_colours)
    if style == "sensels" and any(c._is_curve for c in result.contacts):
        raise InputError("A contact of sections is a curve, on which no film of sensels fits; leave style='smooth'.")
    shown = [result.contacts[k] for k in (range(len(result.contacts)) if contacts is None else contacts)]
    if axes is not None:
        shown = [replace(contact, directions=Directions.of(axes)) for contact in shown]
    names = Units(length, force, units).with_defaults(result.unit_names)
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=_figure_size(shown, columns, rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
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
        panel.set_title(_title(contact, names), fontsize="medium")
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


def _title(contact: ContactFields, units: Units) -> str:
    whole = contact._whole
    if not contact.active.any():
        return f"{contact.label}\nno contact"
    return (
        f"{contact.label}\nforce {units.number(float(np.linalg.norm(whole.force)), 'force')}, "
        f"area {units.number(whole.area, 'length', '²')}, "
        f"peak {units.number(whole.max_pressure, 'stress')}, "
        f"mean {units.number(whole.mean_pressure, 'stress')}"
    )


def _figure_size(contacts: Sequence[ContactFields], columns: int, rows: int) -> tuple[float, float]:
    """Size in inches for maps with colour bar and title, in the contacts' proportions, or for curves."""
    if any(c._is_curve for c in contacts):
        return 6.4 * columns, 4.6 * rows
    sides = [np.subtract(*reversed(map_window(c, map_of(c)))) for c in contacts]
    tallest = max(float(height / width) if width > 0 else 1.0 for width, height in sides)
    return 6.4 * columns, rows * (min(max(4.6 * tallest, 1.6), 6.5) + 1.2)
