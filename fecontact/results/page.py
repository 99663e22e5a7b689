"""A result as a page: contacts, warnings, pictures, reactions, certificate and model in one HTML file."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from fecontact.common.arguments import text
from fecontact.common.arrays import Array
from fecontact.common.files import replacing
from fecontact.results.pictures.draw import plot_result
from fecontact.results.report import model_size
from fecontact.results.solved_scene import SolvedScene

STYLE = """
body, .fecontact { font: 15px/1.45 system-ui, sans-serif; color: #222; }
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
.fecontact table { border-collapse: collapse; margin: .6rem 0; display: block; overflow-x: auto; }
.fecontact th, .fecontact td { padding: .2rem .8rem .2rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid #ddd; font-variant-numeric: tabular-nums; }
.fecontact img { max-width: 100%; display: block; margin: .8rem 0; }
.fecontact .warning { border-left: 4px solid #c33; padding-left: .7rem; margin: .5rem 0; }
.fecontact .note { border-left: 4px solid #bbb; padding-left: .7rem; margin: .5rem 0; }
"""
#: Dots per inch of pictures on a page and in a notebook.
DPI = 110
#: Component of a vector, relative to its largest, that is shown as zero.
ROUNDING = 1e-9


def write_page(
    result: SolvedScene,
    warnings: Sequence[str],
    notes: Sequence[str],
    path: str | Path,
    *,
    title: str = "Contact of bodies",
) -> Path:
    """Write one self-contained HTML page.

    Parameters
    ----------
    result : SolvedScene
    warnings, notes : sequence of str
    path : str or Path
        File to write, ``.html``.
    title : str

    Raises
    ------
    InputError
        If the file cannot be written, or the title is no text.
    """
    text("the title", title)
    parts = [
        f"<h1>{escape(title)}</h1>",
        _summary(result, warnings, notes),
        *(f"<h2>{name}</h2>{_image(figure)}" for name, figure in _pictures(result)),
        "<h2>Reactions</h2>",
        _table(
            ("body", f"force{_unit(result.scene.unit_names.force)}", "moment about its frame"),
            ((b.name, _vector(r[:3]), _vector(r[3:])) for b in result.scene.bodies for r in (result.reaction(b),)),
        ),
        "<h2>Certificate</h2>",
        _certificate(result),
        "<h2>Model</h2>",
        _table(("body",), ((b.describe(),) for b in result.scene.bodies)),
        "".join(f"<div>{escape(line)}</div>" for line in model_size(result)),
        _table(("stage", "seconds"), ((k, f"{v:.3f}") for k, v in result.seconds.items())),
    ]
    head = f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
    body = "\n".join(parts)
    page = f'{head}<meta name="viewport" content="width=device-width"></head><body>{_wrapped(body)}</body></html>'
    with replacing(path) as file:
        file.write_text(page, encoding="utf-8")
    return Path(path)


def notebook_cell(result: SolvedScene, warnings: Sequence[str], notes: Sequence[str]) -> str:
    """HTML of a result in a notebook: what it found, and its map of pressure."""
    return _wrapped(_summary(result, warnings, notes) + _image(plot_result(result, "pressure")))


def table_cell(columns: Sequence[str], rows: Iterable[Sequence[str]], remarks: Iterable[str]) -> str:
    """HTML of a table in a notebook, with remarks below."""
    return _wrapped(_table(columns, rows) + "".join(f'<p class="note">{escape(text)}</p>' for text in remarks))


def _wrapped(body: str) -> str:
    return f'<style>{STYLE}</style><div class="fecontact">{body}</div>'


def _summary(result: SolvedScene, warnings: Sequence[str], notes: Sequence[str]) -> str:
    """What was found: status, one row for each contact, warnings and notes."""
    units = result.scene.unit_names
    columns = (
        "contact", units.after("force on the first", "force"), f"area{_unit(units.length and units.length + '²')}",
        units.after("peak pressure", "stress"), units.after("mean pressure", "stress"), "estimated error",
        units.after("centre of pressure", "length"),
    )  # fmt: skip
    rows = (
        (
            c.label,
            _vector(c.whole.force),
            f"{c.whole.area:.5g}" if c.active.any() else "no contact",
            f"{c.max_pressure:.5g}",
            f"{c.whole.mean_pressure:.5g}",
            str(c.error_estimate) if c.active.any() else "",
            _vector(c.centre_of_pressure) if c.active.any() else "",
        )
        for c in result.contacts
    )
    said = [f'<p class="warning">Warning: {escape(w)}</p>' for w in warnings]
    said += [f'<p class="note">Note: {escape(n)}</p>' for n in notes]
    counts = f"{result.n_active} of {result.n_candidates} candidates in contact, {result.n_dofs} degrees of freedom"
    found = f"{result.status} by {result.solution.solver}: {counts}"
    return f"<p>{escape(found)}</p>{_table(columns, rows)}{''.join(said)}"


def _pictures(result: SolvedScene) -> Iterable[tuple[str, Figure]]:
    yield "Pressure", plot_result(result, "pressure")
    yield "Gap", plot_result(result, "gap")
    if all(c.friction is not None for c in result.contacts):
        yield "Friction", plot_result(result, "friction")
    if result.meshed_bodies:
        yield "Stress", plot_result(result, "von_mises")
    if result.convergence is not None:
        yield "Steps to the accuracy", plot_result(result, "convergence")


def _certificate(result: SolvedScene) -> str:
    """Residuals recomputed from the problem."""
    r = result.residuals()
    rows = [(n, f"{getattr(r, n):.1e}") for n in ("penetration", "tension", "complementarity", "equilibrium")]
    if result.friction is not None:
        law = result.friction.residuals
        rows += [(f"friction: {n}", f"{getattr(law, n):.1e}") for n in ("cone", "slip", "dissipation")]
    return _table(("residual, relative", ""), rows)


def _image(figure: Figure) -> str:
    file = BytesIO()
    figure.savefig(file, dpi=DPI, format="png")
    return f'<img alt="" src="data:image/png;base64,{b64encode(file.getvalue()).decode()}">'


def _table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    head = "".join(f"<th>{escape(c)}</th>" for c in columns)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _vector(v: Array) -> str:
    """Components, with those of rounding shown as zero."""
    largest = float(np.abs(v).max(initial=0.0))
    return "(" + ", ".join(f"{x:.5g}" if abs(x) > ROUNDING * largest else "0" for x in v) + ")"


def _unit(name: str) -> str:
    return f" [{name}]" if name else ""
