"""A rotor blade that is spun up: how far its tip lags behind, and how far it is
stretched in the end.

The blade's root turns by a given angle, up to 6 rad/s after 15 s. It bends back while
it is accelerated, swings a little after, and stays longer by rho A w^2 L^3 / (3 E A).
Source: J. C. Simo & L. Vu-Quoc, J. Appl. Mech. 53 (1986), 849-863, whose tip lags by
0.57 to 0.58 at most; the drive is that of T. R. Kane, R. R. Ryan & A. K. Banerjee, J.
Guidance 10 (1987), 139-151.

Run: python examples/spin_up.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from fecontact import ancf
from fecontact.ancf.slender import Joints, line, straight

LENGTH, EA, EI, MASS, SPEED, TIME = 10.0, 2.8e7, 1.4e4, 1.2, 6.0, 15.0


def angle(t: float) -> float:
    """Of the root, in radians."""
    if t > TIME:
        return SPEED * (t - TIME / 2)
    w = 2 * np.pi / TIME
    return SPEED / TIME * (t**2 / 2 + (np.cos(w * t) - 1) / w**2)


def main(
    n: int = 6, until: float = 20.0, step: float = 0.025, out: Path | None = None
) -> dict[str, float]:
    """Move n elements, draw and print."""
    folder = Path("out") if out is None else out
    folder.mkdir(exist_ok=True)
    blade = line(straight((0, 0, 0), (LENGTH, 0, 0), n), EA=EA, EI=EI, mass=MASS)
    joints = Joints([blade])
    a = ancf.Assembly(
        [blade], [joints.flat(), joints.pinned((0, 0)), joints.guided((0, 0), 1)]
    )

    def stage(t: float) -> ancf.Stage:
        root = np.zeros(blade.vectors.shape)
        root[0, 1] = np.cos(angle(t)) - 1, np.sin(angle(t)), 0
        return ancf.Stage(a, motion=root.ravel())

    motion = ancf.move(
        stage, until=until, step=step, scheme=ancf.GeneralisedAlpha(0.6), every=1
    )
    t = motion.frame_times
    turn = np.array([angle(x) for x in t])
    tip = np.array([blade.positions(q)[-1] for q in motion.frames])
    along = tip[:, 0] * np.cos(turn) + tip[:, 1] * np.sin(turn) - LENGTH
    lag = tip[:, 0] * np.sin(turn) - tip[:, 1] * np.cos(turn)
    late = t > TIME + 1
    found = {
        "largest lag": lag.max(),
        "at the time": t[lag.argmax()],
        "stretched by": along[late].mean() if late.any() else np.nan,
        "closed form": MASS * SPEED**2 * LENGTH**3 / (3 * EA),
        "success": float(motion.success),
    }

    figure = Figure(figsize=(12.0, 3.4), layout="constrained")
    shapes, behind, longer = figure.subplots(1, 3)
    for i in np.linspace(0, np.searchsorted(turn, 2 * np.pi), 9).astype(int):
        x = blade.points(motion.frames[i]).reshape(-1, 3)
        shapes.plot(x[:, 0], x[:, 1], color="C0", linewidth=1)
        shapes.plot(
            [0, LENGTH * np.cos(turn[i])],
            [0, LENGTH * np.sin(turn[i])],
            ":",
            color="0.6",
            linewidth=0.8,
        )
    shapes.set(title="first turn, beside a rigid blade", aspect="equal")
    behind.plot(t, lag)
    behind.set(xlabel="time in s", title="lag of the tip in m")
    longer.plot(t, 1e3 * along)
    longer.axhline(1e3 * found["closed form"], color="0.6", linestyle=":")
    longer.set(
        xlabel="time in s", title="tip along the root's direction, in mm", ylim=(-20, 3)
    )
    figure.savefig(folder / "spin_up.png", dpi=150)
    print(
        "\n".join(f"{name:13} {value:.5g}" for name, value in found.items()),
        motion,
        sep="\n",
    )
    return found


if __name__ == "__main__":
    main()
