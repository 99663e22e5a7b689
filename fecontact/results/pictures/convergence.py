"""Picture of the convergence of an adaptive solution: estimated error against unknowns and against time."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from fecontact.common.errors import InputError
from fecontact.results.convergence import Convergence, asked


def draw_convergence(convergence: Convergence | None) -> Figure:
    """Estimated errors of the pressure and of its peak over unknowns, and over seconds; logarithmic.

    Raises
    ------
    InputError
        Without steps to draw.
    """
    if convergence is None:
        raise InputError("Only a result solved to an accuracy has steps to draw: scene.solve(..., accuracy=0.02).")
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    steps = convergence.steps
    for axes, label, x in zip(
        figure.subplots(1, 2, sharey=True),
        ("unknowns", "seconds from the start"),
        ([s.n_dofs for s in steps], [s.seconds for s in steps]),
        strict=True,
    ):
        axes.loglog(x, [100 * s.pressure for s in steps], "o-", label="pressure, L2")
        axes.loglog(x, [100 * s.peak for s in steps], "s--", label="peak pressure")
        for name in ("force", "approach", "tilt"):
            if any(name in s.errors for s in steps):
                axes.loglog(x, [100 * s.errors.get(name, math.nan) for s in steps], "^:", label=name)
        for name, value in asked(convergence.accuracy).items():
            axes.axhline(100 * value, color="0.5", linewidth=1.0, label=f"asked of the {name}")
        axes.set_xlabel(label)
        axes.grid(True, which="both", alpha=0.25)
    figure.axes[0].set_ylabel("estimated error, %")
    figure.axes[0].legend()
    return figure
