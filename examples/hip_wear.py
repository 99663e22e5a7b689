"""Wear of a hip cup: a metal head turns to and fro in a polyethylene cup over the poses
of a gait, for a million steps.

The cup is held in the pelvis; the femur flexes and extends under the load of walking.
What the head slips by wears the cup by Archard's law, and the contact moves with the
worn shape.

Axes: x to the middle of the body, y forwards, z upwards; mm, N, MPa.

Run: python examples/hip_wear.py              (a million gait cycles)
     python examples/hip_wear.py --cycles 3e6
"""

import argparse
from pathlib import Path

import numpy as np
from hip_joint import LOAD, dome, socket_axis, towards

import fecontact as fc

POLYETHYLENE = fc.Material(E=800.0, nu=0.45)
# radii, thickness of the cup, degrees to its rim
HEAD, CUP, THICKNESS, EDGE = 14.0, 14.1, 8.0, 85.0
FRICTION = 0.06
#: Volume per force and length of slip, mm^3/(N mm): 1e-6 mm^3/(N m), assumed: take a
#: measured one.
WEAR = 1e-9
#: Flexion (degrees) and load (its share of the peak) at six instants of a gait cycle:
#: stance, then swing.
GAIT = ((20.0, 0.5), (12.0, 1.0), (4.0, 0.8), (-4.0, 0.7), (4.0, 0.2), (12.0, 0.2))


def cup(n: int) -> fc.ElasticBody:
    """Polyethylene on its shell, which is held."""
    layer = fc.extrude(dome(CUP + THICKNESS, EDGE, n).flipped(), THICKNESS, layers=2)
    body = fc.ElasticBody(
        layer, POLYETHYLENE, contact="top", supports={"base": "xyz"}, name="cup"
    )
    return body.placed(rotation=towards(socket_axis()))


def walked(cycles: float, n: int = 1) -> fc.LoadPath:
    """The gait's poses, once without cycles at first, then each passed as often."""
    liner = cup(n)
    head = fc.RigidBody(fc.Sphere(HEAD), name="head").placed((0.0, 0.0, -HEAD))
    contact = fc.Contact(liner, head, friction=FRICTION)
    scene = fc.Scene([liner, head], [contact], units=("mm", "N", "MPa"))
    poses = [
        {
            "forces": {head: share * LOAD},
            "motions": {head: {"rx": np.radians(angle)}},
            "free": {head: "x y z"},
        }
        for angle, share in GAIT
    ]
    steps = [poses[-1], *({**pose, "cycles": cycles} for pose in poses)]
    return scene.solve_path(steps, finite_motion=True, wear={contact: WEAR})


def main() -> None:
    """Print depths and volumes, and draw the worn depth."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cycles", type=float, default=1e6)
    parser.add_argument("--out", default="out")
    args = parser.parse_args()
    folder = Path(args.out)
    folder.mkdir(parents=True, exist_ok=True)
    path = walked(args.cycles)
    found = path.last.contacts[0]
    print(path)
    print(
        f"worn after {args.cycles:g} cycles: {found.worn_volume:.3g} mm^3, "
        f"{found.worn.max():.3g} mm deep"
    )
    path.last.plot("worn", folder / "hip_wear.png")


if __name__ == "__main__":
    main()
