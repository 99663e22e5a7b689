"""Mutants of the package by rule: where a guard, a tolerance or a term of a residual is, and the code without it.

A mutant is known by its function and its text: files that are moved or renamed keep their mutants.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

PACKAGE = "fecontact"

FACTOR = 1000
SMALL = 1e-3
"""A number no larger than this is a tolerance wherever it stands."""

REVERSED: dict[type[ast.cmpop], ast.cmpop] = {
    ast.Lt: ast.GtE(),
    ast.LtE: ast.Gt(),
    ast.Gt: ast.LtE(),
    ast.GtE: ast.Lt(),
    ast.Eq: ast.NotEq(),
    ast.NotEq: ast.Eq(),
    ast.Is: ast.IsNot(),
    ast.IsNot: ast.Is(),
    ast.In: ast.NotIn(),
    ast.NotIn: ast.In(),
}
EXTREMES = frozenset({"max", "min", "maximum", "minimum"})


@dataclass(frozen=True)
class Mutant:
    """One change of one module.

    Attributes
    ----------
    module : str
    function : str
        Qualified name; of the constant at module level.
    text : str
        Of the whole function, or of the statement at module level.
    rule : str
    before, after : str
        The code that is changed.
    line : int
    lines : tuple of int
        Of the statement, as far as it is executed with the change; of the whole function for its defaults.
    name : str
        Of the constant that is defined there; empty elsewhere.
    source : str
        Of the whole mutated module.
    number : int
        Among mutants of the same text in the function.
    """

    module: str
    function: str
    text: str
    rule: str
    before: str
    after: str
    line: int
    lines: tuple[int, ...]
    name: str
    source: str
    number: int

    @property
    def key(self) -> str:
        """The same for the same change of the same function, wherever that stands."""
        text = "\0".join((self.function, self.text, self.rule, self.before, self.after, str(self.number)))
        return hashlib.sha256(text.encode()).hexdigest()[:12]


def modules(root: Path) -> dict[str, Path]:
    """All modules of the package by their dotted names."""
    return {_dotted(path, root): path for path in sorted((root / PACKAGE).rglob("*.py"))}


def mutants(module: str, path: Path) -> list[Mutant]:
    """All mutants of one module, in the order of its text."""
    source = path.read_text()
    tree = ast.parse(source)
    seen: dict[tuple[str, ...], int] = {}
    out = []
    for place in _places(tree, _Place()):
        for rule, node, after in _changes(place):
            before = ast.unparse(node)
            text = after if isinstance(after, str) else ast.unparse(after)
            key = (place.function, rule, before, text)
            seen[key] = seen.get(key, -1) + 1
            out.append(
                Mutant(
                    module, place.function or place.name, place.text, rule, before, text, node.lineno, place.lines,
                    place.name, _replaced(source, node, text), seen[key],
                )
            )  # fmt: skip
    return out


@dataclass(frozen=True)
class _Place:
    """A node and where it stands."""

    node: ast.AST | None = None
    parent: ast.AST | None = None
    function: str = ""
    text: str = ""
    lines: tuple[int, ...] = ()
    name: str = ""


def _places(node: ast.AST, place: _Place) -> Iterator[_Place]:
    """All nodes that are worth a change, with where they stand."""
    here = replace(place, node=node, parent=place.node)
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        inner = f"{place.function}.{node.name}".lstrip(".")
        body = tuple(range(node.body[0].lineno, (node.end_lineno or node.lineno) + 1))
        text = ast.unparse(node) if isinstance(node, ast.FunctionDef) else place.text
        here = _Place(node, place.node, inner, text, body)
        children: list[ast.AST] = [*node.body]
        if isinstance(node, ast.FunctionDef):
            children += [*node.args.defaults, *(each for each in node.args.kw_defaults if each)]
    elif isinstance(node, ast.stmt):
        children = [each for each in ast.iter_child_nodes(node) if not isinstance(each, ast.stmt)]
        last = max((each.end_lineno or 0 for each in children if hasattr(each, "end_lineno")), default=node.lineno)
        lines = tuple(range(node.lineno, max(last, node.lineno) + 1))
        here = replace(here, lines=lines, name="", text=place.text or ast.unparse(node))
        if isinstance(node, ast.Assign | ast.AnnAssign):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            constant = isinstance(place.node, ast.Module | ast.ClassDef) and isinstance(target, ast.Name)
            here = replace(here, name=target.id if constant else "")
            children = [node.value] if node.value else []
        children += [each for each in ast.iter_child_nodes(node) if isinstance(each, ast.stmt)]
    elif isinstance(node, ast.Call) and _called(node) == "isinstance":
        children = node.args[:1]
    else:
        children = list(ast.iter_child_nodes(node))
    if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        return
    yield here
    # asserts narrow types for the checker; messages are not guards
    if not isinstance(node, ast.Assert | ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom):
        for child in children:
            yield from _places(child, here)


def _changes(place: _Place) -> Iterator[tuple[str, ast.AST, ast.AST | str]]:
    """Rule, node and what comes in its place."""
    node = place.node
    match node:
        case ast.Raise():
            yield "raise removed", node, "pass"
        case ast.Constant(value=float(value)) | ast.Constant(value=int(value)) if _is_tolerance(place, value):
            yield f"tolerance x {FACTOR}", node, repr(value * FACTOR)
            yield f"tolerance / {FACTOR}", node, repr(value / FACTOR)
        case ast.Compare():
            for k, op in enumerate(node.ops):
                ops = [*node.ops[:k], REVERSED[type(op)], *node.ops[k + 1 :]]
                yield "comparison reversed", node, ast.Compare(node.left, ops, node.comparators)
        # x or {} is a default, not a guard
        case ast.BoolOp() if not isinstance(node.values[-1], ast.Constant | ast.Dict | ast.Tuple):
            for rest in _without_one(node.values):
                yield "clause dropped", node, rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
        case ast.BinOp(op=ast.BitAnd() | ast.BitOr()) if not isinstance(place.parent, ast.Module):
            yield "clause dropped", node, node.right
            yield "clause dropped", node, node.left
        case ast.Call() if _called(node) in EXTREMES and len(node.args) > 1:
            for rest in _without_one(node.args):
                kept = rest[0] if len(rest) == 1 and not isinstance(rest[0], ast.Starred) else None
                yield "term dropped", node, kept or ast.Call(node.func, rest, node.keywords)
        case ast.Call(args=[ast.List(elts=terms)]) if _called(node) in EXTREMES and len(terms) > 1:
            for rest in _without_one(terms):
                yield "term dropped", node, ast.Call(node.func, [ast.List(rest, ast.Load())], node.keywords)
        case ast.Call() if _called(node) == "Residuals":
            nothing = ast.Constant(0.0)
            for k in range(len(node.args)):
                yield (
                    "term dropped",
                    node,
                    ast.Call(node.func, [*node.args[:k], nothing, *node.args[k + 1 :]], node.keywords),
                )
            for k, given in enumerate(node.keywords):
                words = [*node.keywords[:k], ast.keyword(given.arg, nothing), *node.keywords[k + 1 :]]
                yield "term dropped", node, ast.Call(node.func, node.args, words)


def _is_tolerance(place: _Place, value: float) -> bool:
    """A float by name at module level, a small number anywhere, a factor of something called tolerance."""
    if isinstance(value, bool) or value == 0:
        return False
    if isinstance(value, float) and (place.name.isupper() or abs(value) <= SMALL):
        return True
    parent = place.parent
    if not (isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.Mult)):
        return False
    return any("tolerance" in _word(each).lower() for each in (parent.left, parent.right))


def _without_one(values: list[ast.expr]) -> Iterator[list[ast.expr]]:
    for k in range(len(values)):
        yield [*values[:k], *values[k + 1 :]]


def _replaced(source: str, node: ast.AST, text: str) -> str:
    """The source with one node's text replaced; offsets of the syntax tree count bytes."""
    lines = source.encode().splitlines(keepends=True)
    first, last = node.lineno - 1, node.end_lineno - 1
    head = b"".join(lines[:first]) + lines[first][: node.col_offset]
    tail = lines[last][node.end_col_offset :] + b"".join(lines[last + 1 :])
    new = text if isinstance(node, ast.stmt) else f"({text})"
    return (head + new.encode() + tail).decode()


def _dotted(path: Path, root: Path) -> str:
    return ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")


def _word(node: ast.AST) -> str:
    """The name that a node defines, imports or uses."""
    match node:
        case ast.Name(id=word) | ast.Attribute(attr=word) | ast.alias(name=word):
            return word
        case ast.ClassDef(name=word) | ast.FunctionDef(name=word):
            return word
    return ""


def _called(node: ast.Call) -> str:
    return _word(node.func)
