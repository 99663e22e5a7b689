"""Panels of pictures: axes given by a user or new ones, and scales of values over decades."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.files import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Largest over least value of a curve from which its axis is logarithmic.
DECADES = 100.0


def panel(ax: Axes | None, size: tuple[float, float]) -> Axes:
    """Axes of a picture that has no others: those given, or those of a new figure of a size in inches."""
    return new_figure(size).subplots() if ax is None else ax


def scale_by_decades(axes: Axes, along: ArrayLike, curves: Iterable[ArrayLike]) -> None:
    """Make the axes logarithmic whose finite values are positive and more than two decades apart.

    Examples
    --------
    >>> axes = panel(None, (3.0, 3.0))
    >>> scale_by_decades(axes, [1.0, 10.0, 1000.0], [[0.0, 1.0, 500.0]])
    >>> axes.get_xscale(), axes.get_yscale()
    ('log', 'linear')
    """
    for axis, values in (("x", [along]), ("y", list(curves))):
        every = np.concatenate([np.ravel(np.asarray(v, float)) for v in values])
        every = every[np.isfinite(every)]
        if len(every) and every.min() > 0 and every.max() > DECADES * every.min():
            axes.set(**{f"{axis}scale": "log"})
