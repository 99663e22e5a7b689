"""Settings of the site: `make docs` builds it in out/site from the pages of this folder and the docstrings."""

from __future__ import annotations

import posixpath
import re
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math import latex2mathml
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import TextLexer, get_lexer_for_filename
from pygments.util import ClassNotFound
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.util import logging

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path[:0] = [str(ROOT), str(HERE)]

import gallery  # noqa: E402
import generated_pages  # noqa: E402

import fecontact  # noqa: E402
from fecontact.common.version import VERSION  # noqa: E402

PUBLIC = frozenset(fecontact.__all__)

project = "fecontact"
author = "The fecontact developers"
copyright = author
version = release = VERSION
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_copybutton",
]
exclude_patterns = ["_build"]
templates_path = ["_templates"]
suppress_warnings = ["myst.header"]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
myst_url_schemes = ("http", "https", "mailto", "source")
autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
default_role = "name"
numpydoc_show_class_members = False
html_theme = "furo"
html_title = f"fecontact {VERSION}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = html_show_sourcelink = False


def make_pages(app: Sphinx) -> None:
    """Make the pages that are not written, before the pages are looked for."""
    generated_pages.prepare()


def list_examples(app: Sphinx, page: str, content: list[str]) -> None:
    """Show the code of the examples in the gallery, and what they print."""
    if page == "gallery":
        content[0] = gallery.with_listings(content[0])


def mark_source_links(app: Sphinx, page: str, content: list[str]) -> None:
    """Give links of a page to files outside docs/ the scheme `source`."""
    folder = posixpath.dirname(page)

    def marked(match: re.Match[str]) -> str:
        place = posixpath.normpath(posixpath.join("docs", folder, match[1]))
        return match[0] if place.startswith("docs/") else f"](source:{place})"

    content[0] = re.sub(r"\]\((\.\./[^)#\s]+)\)", marked, content[0])


def resolve_source_links(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Point such links at pages that show the files, and remember which are asked for."""
    wanted: set[str] = app.env.__dict__.setdefault("fecontact_sources", set())
    for link in doctree.findall(nodes.reference):
        place = str(link.get("refuri", ""))
        if place.startswith("source:"):
            place = place.removeprefix("source:")
            if not (ROOT / place).exists():
                logging.getLogger(__name__).warning("no file %s", place, location=link)
            wanted.add(place)
            link["refuri"] = app.builder.get_relative_uri(page, f"source/{place}")


def source_pages(app: Sphinx) -> Any:
    """A page for each of these files, or a list of what is in a folder."""
    waiting, seen = sorted(app.env.__dict__.get("fecontact_sources", ())), set()
    while waiting:
        place = waiting.pop()
        if place in seen or not (ROOT / place).exists():
            continue
        seen.add(place)
        if (ROOT / place).is_dir():
            files = [f for f in sorted((ROOT / place).iterdir()) if f.is_file() and not f.name.startswith(".")]
            waiting += [f"{place}/{f.name}" for f in files]
            here = posixpath.basename(place)
            body = "".join(f'<li><a href="{here}/{f.name}.html">{f.name}</a></li>' for f in files)
            body = f"<ul>{body}</ul>"
        else:
            body = shown(ROOT / place)
        yield f"source/{place}", {"title": place, "body": f"<h1>{place}</h1>{body}"}, "page.html"


def shown(path: Path) -> str:
    """Text of a file in colours; of a binary one its size."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        return f"<p>A binary file of {path.stat().st_size:,} bytes.</p>"
    try:
        lexer = get_lexer_for_filename(path.name)
    except ClassNotFound:
        lexer = TextLexer()
    return highlight(text, lexer, HtmlFormatter(cssclass="highlight"))


def readable(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Bars are bars in docstrings, and indented formulas keep their lines."""
    told: list[str] = []
    literal = None
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if literal is not None and line and indent < literal:
            literal = None
        above = next((text for text in reversed(told) if text), "")
        after_blank = bool(told) and not told[-1]
        deeper = indent >= len(above) - len(above.lstrip()) + 4
        if literal is None and line and above and after_blank and deeper and not above.endswith("::"):
            literal = indent
            told += [" " * (indent - 4) + "::", ""]
        told.append(line if literal is not None or line.lstrip().startswith(">>>") else escaped(line))
    lines[:] = told


def escaped(line: str) -> str:
    """Make links of names of pages, and escape the bars outside backticks, which would be substitutions."""
    line = re.sub(r"\bdocs/([\w/-]+)\.md", r":doc:`\1 </\1>`", line)
    return re.sub(r"\|(?=[^`]*(?:`[^`]*`[^`]*)*$)", r"\\|", line)


def name_role(role: str, raw: str, text: str, line: int, inliner: Any, *rest: Any) -> tuple[list[Any], list[Any]]:
    """Make of a text in single backticks a link where it begins with a public name, else code."""
    code = nodes.literal(raw, text)
    if text.split(".")[0] not in PUBLIC:
        return [code], []
    target = {"refdomain": "py", "reftype": "obj", "reftarget": f"fecontact.{text}"}
    return [addnodes.pending_xref(raw, code, **target)], []


def hidden(app: Sphinx, what: str, name: str, thing: object, skip: bool, options: object) -> bool | None:
    """Public names have pages of their own; other packages have manuals of their own."""
    elsewhere = not str(getattr(thing, "__module__", "fecontact")).startswith("fecontact")
    return True if elsewhere or name in PUBLIC else None


def inline_math(self: Any, node: nodes.math) -> None:
    """Write a formula in a line as MathML, which browsers show without a script."""
    self.body.append(mathml(node.astext(), as_block=False))
    raise nodes.SkipNode


def block_math(self: Any, node: nodes.math_block) -> None:
    """Write a formula of its own."""
    self.body.append(f'<div class="math">{mathml(node.astext(), as_block=True)}</div>')
    raise nodes.SkipNode


def mathml(text: str, as_block: bool) -> str:
    """Convert a formula of TeX."""
    return "".join(latex2mathml.tex2mathml(text, as_block=as_block))


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("builder-inited", make_pages)
    app.connect("source-read", list_examples)
    app.connect("source-read", mark_source_links)
    app.connect("doctree-resolved", resolve_source_links)
    app.connect("html-collect-pages", source_pages)
    app.connect("autodoc-process-docstring", readable, priority=400)
    app.connect("autodoc-skip-member", hidden)
    app.add_role("name", name_role)
    app.add_html_math_renderer("mathml", (inline_math, None), (block_math, None))
    return {"parallel_read_safe": True, "parallel_write_safe": False}
