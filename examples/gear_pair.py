"""A gear pair over a mesh cycle: load sharing, transmission error, pressures, from
involutes to sections in contact.

Teeth are sections of finite elements from the data of the gears; the rim below them is
held at its bore. The pinion turns about its shaft under a torque, the wheel is held;
kinematics takes both from one place of the cycle to the next.

Run: python examples/gear_pair.py
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.mesh.gear_section import Gear, centre_distance

STEEL = fc.Material(E=206e3, nu=0.3)  # mm, N, MPa
PINION, WHEEL = Gear(module=4.0, teeth=20), Gear(module=4.0, teeth=30)
WIDTH, TORQUE = 20.0, 200e3  # mm, N mm


def pair(pinion=PINION, wheel=WHEEL, flank=80):
    """Sections of five teeth of the pinion and six of the wheel, a gap upwards; three
    of them come into contact.
    """
    held = {"bore": "xz", "cut": "xz"}
    return tuple(
        fc.PlaneBody(
            gear.section(count, flank=flank),
            STEEL,
            [f"right {k}" for k in (1, 2, 3)],
            held,
            thickness=WIDTH,
            name=name,
        )
        for gear, count, name in ((pinion, 5, "pinion"), (wheel, 6, "wheel"))
    )


def meshed(bodies, turn, torque=TORQUE, pinion=PINION, wheel=WHEEL, accuracy=None):
    """The pair under a torque after a turn of the pinion (radians), 0 where its middle
    tooth is on the line of axes.
    """
    one = bodies[0].placed(rotation=fc.rotation_about((0, 1, 0), turn))
    back = np.pi - turn * pinion.teeth / wheel.teeth
    other = bodies[1].placed(
        (0, 0, centre_distance(pinion, wheel)), fc.rotation_about((0, 1, 0), back)
    )
    contacts = [
        fc.Contact(one, other, (f"right {k}", f"right {4 - k}")) for k in (1, 2, 3)
    ]
    shaft = [
        fc.Spring(1e8, (one, (0, 0, 0)), (None, 100 * way), kind="linear")
        for way in np.eye(3)[::2]
    ]
    scene = fc.Scene([one, other], contacts, springs=shaft, units=("mm", "N", "MPa"))
    return scene.solve(
        moments={one: (0, torque, 0)},
        free={one: "x z ry"},
        finite_motion=False,
        accuracy=accuracy,
    )


def cycle(n=17, flank=40, torque=TORQUE):
    """Over one pitch about the middle tooth's pitch point: turns (n,), forces (3, n) of
    the teeth, error (n,) in mm.

    The transmission error is by how much the pinion runs ahead of the wheel, along the
    line of action.
    """
    bodies = pair(flank=flank)
    turns = (np.linspace(-0.5, 0.5, n) - 0.25) * 2 * np.pi / PINION.teeth
    forces, error = np.zeros((3, n)), np.zeros(n)
    for k, turn in enumerate(turns):
        result = meshed(bodies, turn, torque)
        forces[:, k] = [np.linalg.norm(contact.force) for contact in result.contacts]
        error[k] = (
            PINION.base_radius * result.rigid_motion(result.scene.bodies[0]).rotation[1]
        )
    return turns, forces, error


def at_pitch_point(flank=60, accuracy=0.05):
    """The pair with one contact, at the pitch point, divided until its pressure is
    accurate; and Hertz.
    """
    result = meshed(pair(flank=flank), -np.pi / 2 / PINION.teeth, accuracy=accuracy)
    radii = [
        gear.pitch_radius * np.sin(gear.pressure_angle) for gear in (PINION, WHEEL)
    ]
    return result, fc.hertz.line(
        radii, (STEEL, STEEL), force=TORQUE / PINION.base_radius / WIDTH
    )


def draw(path, turns, forces, error):
    """Shares of the teeth and transmission error over the cycle."""
    figure = Figure(figsize=(7.0, 5.2), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    degrees = np.degrees(turns)
    for force, name in zip(
        forces, ("the next pair", "the middle pair", "the pair before"), strict=True
    ):
        above.plot(degrees, force / 1e3, ".-", label=name)
    above.set(
        ylabel="force of a pair of teeth [kN]",
        title=f"{TORQUE / 1e3:g} N m on the pinion",
        ylim=(0, None),
    )
    above.legend(fontsize="small")
    below.plot(degrees, 1e3 * error, ".-", color="tab:red")
    below.set(
        xlabel="turn of the pinion [degrees]",
        ylabel="transmission error [um]",
        ylim=(0, None),
    )
    for axes in (above, below):
        axes.grid(color="0.9")
    figure.savefig(path, dpi=150)


def main(n=17, flank=40, out="out"):
    """Print the cycle and the pressure at the pitch point, and draw them."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    turns, forces, error = cycle(n, flank)
    print("turn, degrees; forces of three pairs of teeth, N; transmission error, um")
    for turn, three, e in zip(turns, forces.T, error, strict=True):
        print(
            f"{np.degrees(turn):8.2f}"
            + "".join(f"{f:9.0f}" for f in three)
            + f"{1e3 * e:9.2f}"
        )
    print(f"transmission error, peak to peak: {1e3 * np.ptp(error):.2f} um")
    draw(folder / "gear_pair.png", turns, forces, error)
    result, hertz = at_pitch_point()
    (contact,) = (c for c in result.contacts if c.max_pressure > 0)
    print(
        f"pitch point: {contact.max_pressure:.0f} MPa, {contact.error_estimate}; "
        f"Hertz {hertz.p0:.0f} MPa"
    )
    result.plot(
        "von_mises",
        folder / "gear_pair_stress.png",
        title="One pair in contact, at the pitch point",
    )
    return turns, forces, error, contact.max_pressure / hertz.p0


if __name__ == "__main__":
    main()
