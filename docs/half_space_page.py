"""Measure the page of half-spaces: python docs/half_space_page.py [--times] [--pictures].

The pictures in docs/images are in git; only `--pictures` draws them anew.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from generated_pages import FOLDER, write
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.app.studies.closed_forms import Wave
from fecontact.app.studies.friction import Setting, draw_tractions, run
from fecontact.app.studies.indentation import Ground, indent
from fecontact.app.studies.study import Study
from fecontact.common.units import Units
from fecontact.halfspace.pictures import draw_stick_slip
from fecontact.halfspace.pressing import Load
from fecontact.surfaces import Cone, FlatPunch, Paraboloid

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent / "examples"), str(HERE.parent / "tests" / "benchmarks")]

UNIT = Ground(fc.Material(E=1.0, nu=0.0))
PERIODIC = Ground(fc.Material(E=1.0, nu=0.0), periodic=True)
CELLS = (64, 128, 256)
HEIGHT = 0.01  # of the sinusoid of wavelength 1

Job = Callable[[int], Study]


def _free(shape: object, force: float, point: tuple[float, float] | None = None) -> Job:
    size = (3.0, 3.0) if isinstance(shape, FlatPunch) else None
    return lambda n: indent(shape, UNIT, Load(force, None, point), cells=(n, n), size=size)


def _wave(share: float) -> Job:
    load = Load(share * math.pi * HEIGHT, None, None)
    return lambda n: indent(Wave(HEIGHT, 1.0), PERIODIC, load, cells=(n, n), size=(1.0, 1.0))


CASES: dict[str, Job] = {
    "ball": _free(Paraboloid(1.0), 4 / 3),
    "ellipse 10:1": _free(Paraboloid(36.536, 1.0), 0.05),
    "cone": _free(Cone(math.atan(0.1)), 0.157),
    "flat punch": _free(FlatPunch(radius=1.0), 2.0),
    "tilted punch, e = 0.2 a": _free(FlatPunch(radius=1.0), 2.0, (0.2, 0.0)),
    **{f"sinusoid, {share:g} p*": _wave(share) for share in (0.1, 0.3, 0.6, 0.9, 0.95, 1.5)},
}


def errors() -> str:
    """Errors of each case over the number of cells, and their orders."""
    head = "| case | " + " | ".join(f"pressure L2, {n}" for n in CELLS) + " | order | "
    head += f"approach, {CELLS[-1]} | area by cells, {CELLS[-1]} | area, {CELLS[-1]} |"
    lines = [head, "|---" * (head.count("|") - 1) + "|"]
    for name, job in CASES.items():
        found = [job(n) for n in CELLS]
        l2 = [abs(f.errors["pressure, L2"]) for f in found]
        exact = l2[-1] < 1e-6  # of the tolerance, not of the cells
        order = "exact" if exact else f"{np.log(l2[0] / l2[-1]) / np.log(CELLS[-1] / CELLS[0]):.1f}"
        last = found[-1].errors
        approach = f"{last['approach']:+.0e}" if "approach" in last else ""
        by_cells = found[-1].figures["area of its cells"].found / found[-1].figures["area"].exact - 1
        lines.append(
            f"| {name} | {' | '.join(f'{e:.1e}' for e in l2)} | {order} | {approach} | {by_cells:+.1e} "
            f"| {last['area']:+.1e} |"
        )
    return "\n".join(lines)


def report() -> str:
    """The report's figures 2 and 3."""
    import report_half_space

    found = report_half_space.main(out=FOLDER / "images")
    lines = ["| cells, self term | pressure L2 | centre | area | approach |", "|---|---|---|---|---|"]
    for (cell, rule), e in found.items():
        lines.append(f"| {10 * cell:g} mm, {rule} | {' | '.join(f'{100 * v:+.2f} %' for v in e.values())} |")
    return "\n".join(lines)


def times(cells: Sequence[int] = (64, 128, 256, 512), peers: bool = True) -> str:
    """The benchmark's table, beside tamaas where it is installed."""
    import bench_halfspace

    return "```text\n" + "\n".join(bench_halfspace.table(cells, peers)) + "\n```"


def pictures() -> None:
    """Pictures of a ball on a layer, and of a rough surface's curves."""
    layer = fc.Layer(fc.Material(E=5.0, nu=0.45), 2.0)
    ball = indent(
        fc.Sphere(20.0), Ground(None, (layer,)), Load(100.0, None, None), cells=(128, 128), name="ball on a layer"
    )
    ball.plot(HERE / "images" / "half_space_layer.png", "mm", "N", "MPa")
    friction_picture()


def friction_picture() -> None:
    """Stick, slip and tractions of a ball, and tractions of a roller, for docs/friction.md."""
    options = {"radius": 10.0, "E": 210e3, "nu": 0.3, "force": 100.0, "friction": 0.3}
    ball, roller = run("mindlin", options), run("carter", {**options, "cells": 48})
    figure = Figure(figsize=(14.0, 4.4), layout="constrained")
    panels, names = figure.subplots(1, 3), Units("mm", "N", "MPa")
    setting = Setting(fc.Material(E=210e3, nu=0.3), 10.0, 100.0, 0.3, None, 48)
    draw_stick_slip(panels[0], ball.solved.last, names)
    draw_tractions(panels[1], ball.solved, setting.ball, names)
    draw_tractions(panels[2], roller.solved, setting.roller, names, rolls=True)
    for axes, title in zip(panels, ("ball: stick and slip", "ball: tractions", "roller, to the right"), strict=True):
        axes.set_title(title)
    figure.savefig(HERE / "images" / "friction_half_space.png", dpi=90)


def page(with_times: bool) -> str:
    """docs/generated/half_space.md."""
    timed = f"""## Times

Problem H1: Hertz, a box of 3a, not periodic, given force, tolerance 1e-8, one thread; processor seconds, all in one
run. The last column, in units of one forward transform of the padded grid in the same run, can be compared between
machines.

{times()}
"""
    return f"""# Half-spaces: errors and times

Generated by `python docs/half_space_page.py` (`--times`: with times, which want a quiet machine); no figure is typed.

## Errors

Relative to closed forms; cells per side of a box of three contact widths (of the period for the sinusoid).

{errors()}

## The report's half-space

Two spheres of 25 cm pressed by 454 kgf as half-spaces, with a force on every cell: the report's rule (Elangovan 1978,
figures 2 and 3), the ratio 4 ln(1 + sqrt 2) = 3.5255 of the mean over a square, and Love's rectangles.

![forces per cell and the pressure along a diagonal](images/report_half_space.png)

{report()}

{timed if with_times else ""}"""


def measure(with_times: bool = False) -> None:
    """Measure the page; times only where asked for."""
    print(f"wrote {write('half_space', page(with_times).rstrip() + chr(10))}")


if __name__ == "__main__":
    if "--pictures" in sys.argv[1:]:
        pictures()
    measure("--times" in sys.argv[1:])
