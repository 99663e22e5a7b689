"""Formulas in scene files, such as ``"3.0 * max(0, 1 - (x**2 + y**2) / 4)"``: functions of position."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

#: Longest formula, in characters.
LONGEST = 500
NAMES = ("x", "y", "z", "pi")
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": np.abs, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "min": lambda *v: reduce(np.minimum, v), "max": lambda *v: reduce(np.maximum, v),
}  # fmt: skip
OPERATORS: dict[str, Callable[..., Any]] = {
    "Add": np.add, "Sub": np.subtract, "Mult": np.multiply, "Div": np.divide, "Pow": np.power,
    "USub": np.negative, "UAdd": np.positive,
}  # fmt: skip


@dataclass(frozen=True)
class Expression:
    """A formula of x, y and z out of numbers, ``+ - * / **``, parentheses, `NAMES` and `FUNCTIONS`; nothing else runs.

    Attributes
    ----------
    text : str

    Raises
    ------
    InputError
        If it is anything else.

    Examples
    --------
    >>> Expression("2 * x + max(y, 0)")(np.array([[1.0, -1.0, 0.0], [0.0, 3.0, 0.0]])).tolist()
    [2.0, 3.0]
    """

    text: str

    def __post_init__(self) -> None:
        with np.errstate(all="ignore"):
            self(np.ones((1, 3)))

    @cached_property
    def _tree(self) -> ast.expr:
        try:
            if len(self.text) > LONGEST:
                raise ValueError
            return ast.parse(self.text.strip(), mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise self._refused() from None

    def _refused(self, part: ast.AST | None = None) -> InputError:
        found = repr(self.text[:60]) if part is None else f"{ast.unparse(part)!r} in {self.text[:60]!r}"
        return InputError(
            f"A formula has numbers, + - * / **, parentheses, {', '.join(NAMES)} and {', '.join(FUNCTIONS)}, in at "
            f"most {LONGEST} characters; found {found}.",
            code="formula",
        )

    def __call__(self, points: Array) -> Array:
        """Values (n,) at points (n, 3)."""
        x, y, z = points.T
        known = {"x": x, "y": y, "z": z, "pi": np.float64(np.pi)}
        return np.array(np.broadcast_to(self._value(self._tree, known), len(points)), dtype=float)

    def _value(self, part: ast.expr, known: dict[str, Any]) -> Any:
        match part:
            case ast.Constant(value=bool()):
                pass
            case ast.Constant(value=int() | float() as number):
                return np.float64(number)
            case ast.Name(id=name) if name in known:
                return known[name]
            case ast.BinOp(left=left, op=op, right=right) if (kind := type(op).__name__) in OPERATORS:
                return OPERATORS[kind](self._value(left, known), self._value(right, known))
            case ast.UnaryOp(op=op, operand=operand) if (kind := type(op).__name__) in OPERATORS:
                return OPERATORS[kind](self._value(operand, known))
            case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
                if len(args) > 1 if name in ("min", "max") else len(args) == 1:
                    return FUNCTIONS[name](*(self._value(a, known) for a in args))
        raise self._refused(part)


@dataclass(frozen=True)
class Components:
    """Three formulas, of the components of a vector."""

    parts: tuple[Expression, Expression, Expression]

    def __call__(self, points: Array) -> Array:
        """Vectors (n, 3) at points (n, 3)."""
        return np.stack([part(points) for part in self.parts], axis=1)
