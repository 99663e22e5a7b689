"""A result as a page: contacts, warnings, pictures, reactions, certificate and model in one HTML file."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from fecontact.common.arguments import text
from fecontact.common.arrays import Array, without_rounding
from fecontact.common.files import write_atomically
from fecontact.common.html import image, wrapped
from fecontact.common.table import Column, Table
from fecontact.common.units import UnitNames, Units
from fecontact.results.pictures.draw import plot_result
from fecontact.results.report import model_size

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult

#: Distance of a contact from the end of the bodies, over their size, from which on a cut shows more than their side.
EDGE = 0.1
#: The width of a page, which a notebook keeps for itself.
PAGE = "body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }"


def write_page(
    result: ContactResult,
    path: str | Path,
    *,
    title: str = "Contact of bodies",
    units: UnitNames = (),
) -> Path:
    """Write one self-contained HTML page.

    Parameters
    ----------
    result : ContactResult
    path : str or Path
        File to write, ``.html``.
    title : str
    units : (length, force) or (length, force, stress)
        Names of units; those of the scene unless given.

    Raises
    ------
    InputError
        If the file cannot be written, or the title is no text.
    """
    text("the title", title)
    names = Units.of(units).with_defaults(result.unit_names)
    load = max((float(np.linalg.norm(c._whole.force)) for c in result.contacts), default=0.0)
    parts = [
        f"<h1>{escape(title)}</h1>",
        _summary(result, names),
        *(f"<h2>{name}</h2>{image(figure)}" for name, figure in _pictures(result, names)),
        "<h2>Reactions</h2>",
        Table(
            (
                "body",
                Column("force", unit=names.force),
                Column("moment about its frame", unit=names.suffix("moment").strip()),
            ),
            [
                (b.name, _vector(r[:3], load), _vector(r[3:], load * b.size))
                for b in result.scene.bodies
                for r in (result.reaction(b),)
            ],
        ).html(),
        "<h2>Certificate</h2>",
        _certificate(result),
        "<h2>Model</h2>",
        Table(("body",), [(b.describe(),) for b in result.scene.bodies]).html(),
        "".join(f"<div>{escape(line)}</div>" for line in model_size(result)),
        Table(("stage", Column("seconds", ".3f")), list(result.seconds.items())).html(),
    ]
    head = f'<!doctype html><html lang="en"><head><meta charset="utf-8"><style>{PAGE}</style>'
    head += f"<title>{escape(title)}</title>"
    body = "\n".join(parts)
    page = f'{head}<meta name="viewport" content="width=device-width"></head><body>{wrapped(body)}</body></html>'
    return write_atomically(path, page)


def notebook_cell(result: ContactResult) -> str:
    """HTML of a result in a notebook: what it found, and its map of pressure."""
    return wrapped(_summary(result, result.unit_names) + image(plot_result(result, "pressure")))


def table_cell(table: Table) -> str:
    """HTML of a table in a notebook, with its notes below."""
    return wrapped(table.html() + "".join(f'<p class="note">{escape(text)}</p>' for text in table.notes))


def _summary(result: ContactResult, units: Units) -> str:
    """What was found: status, one row for each contact, warnings and notes."""
    columns: tuple[Column | str, ...] = (
        *(
            "contact",
            Column("force on the first", unit=units.force),
            Column("area", ".5g", units.suffix("length", "²").strip()),
        ),
        *(Column(f"{name} pressure", ".5g", units.stress) for name in ("peak", "mean")),
        *("estimated error", Column("centre of pressure", unit=units.length)),
    )
    rows = [
        (
            c.label,
            _vector(c._whole.force),
            c._whole.area if c.active.any() else "no contact",
            *(c.max_pressure, c._whole.mean_pressure),
            *((str(c.error_estimate), _vector(c.centre_of_pressure, c.bodies[0].size)) if c.active.any() else ("", "")),
        )
        for c in result.contacts
    ]
    messages = [f'<p class="warning">Warning: {escape(w)}</p>' for w in result.warnings]
    messages += [f'<p class="note">Note: {escape(n)}</p>' for n in result.notes]
    counts = f"{result.n_active} of {result.n_candidates} candidates in contact, {result.n_dofs} degrees of freedom"
    found = f"{result.status} by {result.solution.solver}: {counts}"
    return f"<p>{escape(found)}</p>{Table(columns, rows).html()}{''.join(messages)}"


def _pictures(result: ContactResult, units: Units) -> Iterator[tuple[str, Figure]]:
    yield "Pressure", plot_result(result, "pressure", units=units)
    yield "Gap", plot_result(result, "gap", units=units)
    if all(c.friction is not None for c in result.contacts):
        yield "Friction", plot_result(result, "friction", units=units)
    if result._meshed_bodies:
        yield "Stress", plot_result(result, "von_mises", units=units)
    if (cut := _through_the_contact(result)) is not None:
        yield f"Stress, {escape(cut)}", plot_result(result, "von_mises", units=units, cut=cut)
    if result.convergence is not None:
        yield "Steps to the accuracy", plot_result(result, "convergence")


def _through_the_contact(result: ContactResult) -> str | None:
    """A cut of solids through the contact with the largest force, along it, that is open to the eye of the picture."""
    found = [c for c in result.contacts if c.active.any() and not c._is_curve]
    solid = bool(result._meshed_bodies) and not any(b.mesh.is_flat for b in result._meshed_bodies)
    if not (found and solid):
        return None
    contact = max(found, key=lambda c: float(np.linalg.norm(c._whole.force)))
    share = np.abs(contact._whole.force) / np.linalg.norm(contact._whole.force)
    across = np.round(share, 2) + np.array([0.001, 0.0, 0.002])  # of equal ones that which faces the eye most
    k = int(np.argmin(across))
    sign, middle = "<><"[k], contact.centre_of_pressure[k]
    ends = np.concatenate([b.pose.to_world(b.mesh.points)[:, k] for b in result._meshed_bodies])
    low, high = float(ends.min()), float(ends.max())
    if not low + EDGE * (high - low) < middle < high - EDGE * (high - low):
        return None  # the contact is at the side already, as on a plane of symmetry
    centres = [b.pose.to_world(b.mesh.points)[b.mesh.cells[:, :8]].mean(axis=1)[:, k] for b in result._meshed_bodies]
    beyond = np.concatenate(centres) - middle
    if not (beyond < 0 if sign == "<" else beyond > 0).any():
        return None  # bodies of one cell
    return f"{'xyz'[k]}{sign}{middle:.4g}"


def _certificate(result: ContactResult) -> str:
    """Residuals recomputed from the problem."""
    rows = list(result.residuals().as_dict().items())
    return Table(("residual, relative", Column("", ".1e")), rows).html()


def _vector(v: Array, size: float = 0.0) -> str:
    """Components, with those of rounding shown as zero, also beside a size."""
    return f"({', '.join(f'{x:.5g}' for x in without_rounding(v, size))})"
