"""Objects in a notebook and on a page: texts, tables and pictures as HTML that leaves what is around it alone."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Rules of what the package shows, in its own element only.
STYLE = """
.fecontact { font: 15px/1.45 system-ui, sans-serif; color: #222; }
.fecontact table { border-collapse: collapse; margin: .6rem 0; display: block; overflow-x: auto; }
.fecontact th, .fecontact td { padding: .2rem .8rem .2rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid #ddd; font-variant-numeric: tabular-nums; }
.fecontact img { max-width: 100%; display: block; margin: .8rem 0; }
.fecontact pre { overflow-x: auto; }
.fecontact .warning { border-left: 4px solid #c33; padding-left: .7rem; margin: .5rem 0; }
.fecontact .note { border-left: 4px solid #bbb; padding-left: .7rem; margin: .5rem 0; }
"""
#: Dots per inch of pictures on a page and in a notebook.
DPI = 110


def wrapped(body: str) -> str:
    """HTML in an element with the package's style."""
    return f'<style>{STYLE}</style><div class="fecontact">{body}</div>'


def image(figure: Figure) -> str:
    """A picture that needs no other file."""
    file = BytesIO()
    figure.savefig(file, dpi=DPI, format="png", bbox_inches="tight")
    return f'<img alt="" src="data:image/png;base64,{b64encode(file.getvalue()).decode()}">'


def cell(text: object, draw: Callable[[], Any] | None = None) -> str:
    """A text as it is printed, and a picture below it.

    Examples
    --------
    >>> "<pre>a &lt; b</pre>" in cell("a < b")
    True
    """
    return wrapped(f"<pre>{escape(str(text))}</pre>{'' if draw is None else image(draw())}")
