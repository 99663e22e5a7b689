"""A ball that begins to roll, from Cattaneo to Carter as of CONTACT's example, then
rolls over a bump; an animation.

Run: python examples/rolling.py
"""

from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.halfspace.path import FrictionPath
from fecontact.halfspace.traction_contact import FrictionContact

#: Modulus of rigidity 1 (forces are over it), mm; the ball's contact is 7 mm wide.
NU, MU, CURVATURE, FORCE, SHARE, WIDTH = 0.28, 0.4013, 2 * 0.002963, 0.4705, 0.657, 7.0
BODY = fc.Material(E=2 * (1 + NU), nu=NU)
BALL = fc.surfaces.Paraboloid(1 / CURVATURE)
PULL = (SHARE * MU * FORCE, 0.0)


def main(n: int = 28, out: str | Path = "out") -> dict[str, float]:
    cell, across = WIDTH / n, n + 5
    half = fc.HalfSpace(
        BODY,
        ((across + 2 * n) * cell, across * cell),
        (across + 2 * n, across),
        against=BODY,
    )

    def at(x: float) -> fc.PressStep:
        return fc.PressStep(force=FORCE, tangential=PULL, position=(x, 0.0))

    # dragged, then rolled cell by cell over twice its width
    begins = half.press_path(
        BALL, [at(-n * cell), *(at((k - n) * cell) for k in range(1, 2 * n + 1))], MU
    )
    creep = np.diff(begins.shift[:, 0]) / cell
    steady = half.roll(BALL, force=FORCE, friction=MU, tangential=PULL, rule="contact")

    # on from the steady state of cells half as large, over a ridge across the way; half
    # steps halve the teeth of cells that the edge reaches late in a step
    cell, fine = cell / 2, 2 * n
    cells = (4 * fine + 5, fine + 5)
    half = fc.HalfSpace(BODY, (cells[0] * cell, cells[1] * cell), cells, against=BODY)
    first = half.roll(BALL, force=FORCE, friction=MU, tangential=PULL, rule="contact")
    ridge = 0.004 * np.exp(-((half.grid.x - 0.85 * WIDTH) ** 2))
    track = np.repeat(ridge[:, None], fine + 5, axis=1)
    step = cell / 2
    bumped = half.press_path(
        BALL,
        [at(k * step) for k in range(1, 5 * fine // 2 + 1)],
        MU,
        start=first,
        track=track,
    )
    over = np.diff(bumped.shift[1::2, 0], prepend=0.0) / cell

    figures = {
        "shift of the drag": float(begins.shift[0, 0]),
        "creepage of the first cell": float(creep[0]),
        "creepage after two widths": float(creep[-1]),
        "of steady rolling, one solve": steady.creepage[0],
        "and on cells half as large": first.creepage[0],
        "creepage over the bump, least": float(over.min()),
        "creepage over the bump, most": float(over.max()),
        "pressure over the bump, most": max(
            contact.max_pressure for contact in bumped.steps
        ),
        "and without it": steady.max_pressure,
    }
    for name, value in figures.items():
        print(f"{name:<32}{value:.4g}")

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    draw(
        begins,
        bumped,
        creep / steady.creepage[0],
        over / first.creepage[0],
        folder / "rolling.png",
    )
    animate([*begins.steps, *bumped.steps[::4]], folder / "rolling.gif")
    return figures


def line(contact: FrictionContact) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Along the middle: places from the ball's, tractions, the limit of friction."""
    middle = contact.grid.shape[1] // 2
    return (
        contact.grid.x - contact.position[0],
        contact.traction[0][:, middle],
        MU * contact.pressure[:, middle],
    )


def draw(
    begins: FrictionPath,
    bumped: FrictionPath,
    creep: np.ndarray,
    over: np.ndarray,
    file: Path,
) -> None:
    """Tractions at some distances, creepages over the distance, and tractions over the
    bump.
    """
    figure = Figure(figsize=(12.0, 4.2), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    for axes, path, ways in (
        (left, begins, (0, 0.25, 0.5, 2)),
        (right, bumped, (0.4, 0.6, 0.85, 1.25)),
    ):
        cell = path[1].position[0] - path[0].position[0]
        for way in ways:
            k = round(way * WIDTH / cell) - (path is bumped)
            x, q, _ = line(path[k])
            axes.plot(x, 1e3 * q, label=f"after {way * WIDTH:.2g} mm")
        x, _, limit = line(path[0])
        axes.plot(x, 1e3 * limit, "--", color="0.6", label="limit of friction")
        axes.set_xlim(-0.7 * WIDTH, 0.7 * WIDTH)
        axes.set_xlabel("along the rolling, from the ball [mm]")
        axes.set_ylabel("traction over the modulus, thousandths")
        axes.legend(fontsize="small", loc="lower center", bbox_to_anchor=(0.46, 0.0))
    left.set_title("dragged, then rolling")
    right.set_title("over a bump")
    middle.plot(
        np.linspace(0, 2 * WIDTH, len(creep) + 1)[1:], creep, label="begins to roll"
    )
    middle.plot(
        np.linspace(0, 1.25 * WIDTH, len(over) + 1)[1:],
        over,
        label="over a bump, from the steady state",
    )
    middle.axhline(1.0, color="0.6", linestyle="--", label="steady, one solve")
    middle.set_xlabel("distance [mm]")
    middle.set_ylabel("creepage over the steady one")
    middle.legend(fontsize="small")
    figure.savefig(file, dpi=150)


def animate(contacts: list[FrictionContact], file: Path) -> None:
    """Tractions along the middle under the limit of friction, for each step."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.set_xlim(-0.7 * WIDTH, 0.7 * WIDTH)
    axes.set_ylim(0, 1.3e3 * MU * contacts[0].max_pressure)
    axes.set_xlabel("along the rolling, from the ball [mm]")
    axes.set_ylabel("traction over the modulus, thousandths")
    (limit,) = axes.plot([], [], "--", color="0.6")
    (traction,) = axes.plot([], [], color="C0")

    def show(k: int) -> None:
        x, q, most = line(contacts[k])
        limit.set_data(x, 1e3 * most)
        traction.set_data(x, 1e3 * q)

    FuncAnimation(figure, show, frames=len(contacts)).save(
        file, writer=PillowWriter(fps=8)
    )


if __name__ == "__main__":
    main()
