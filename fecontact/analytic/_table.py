"""Aligned table of quantities, used to print results."""

from __future__ import annotations

from collections.abc import Sequence


def table(title: str, rows: Sequence[tuple[str, str, float]]) -> str:
    """Return a title and one aligned line for each (quantity, symbol, value).

    Examples
    --------
    >>> print(table("Flat punch", [("contact radius", "a", 2.0), ("force", "P", 10.0)]))
    Flat punch
      contact radius  a  2
      force           P  10
    """
    wide = max(len(row[0]) for row in rows)
    narrow = max(len(row[1]) for row in rows)
    return "\n".join([title, *(f"  {name:<{wide}}  {symbol:<{narrow}}  {value:.6g}" for name, symbol, value in rows)])
