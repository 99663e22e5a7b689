"""Rolling bearings: who carries the load, how hard, and how stiff that is; rings rigid,
or as finite elements.

Rigid rings first: each ball or crowned roller is a spring between the races, by Hertz's
ellipses or by rollers pressed on half-spaces, and the five motions of the inner ring
balance the load (A. B. Jones, J. Basic Eng. 82 (1960) 309). Then the section of a
roller bearing whose outer ring is held below only and bends: rings and rollers are
meshes.

Run: python examples/rolling_bearing.py
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator
from scipy.optimize import root

import fecontact as fc
from fecontact.mesh.section_mesh import merge_sections
from fecontact.mesh.section_shapes import grid

STEEL = fc.Material(E=206e3, nu=0.3)  # mm, N, MPa


@dataclass(frozen=True)
class Bearing:
    """Rolling bodies between rigid races.

    `law` gives force and slope by compression, `pressure` the largest at the inner race
    by force; `groove` is the distance of the grooves' centres of curvature, far for the
    flat races of rollers; `angle` that of contact, radians.
    """

    count: int
    pitch: float  # diameter of the circle of their centres
    law: Callable
    pressure: Callable
    groove: float = 1e6
    angle: float = 0.0

    def compressed(self, motion, clearance):
        """Compressions (n,), directions of contact (2, n), and first and second
        derivatives by the five motions.
        """
        place = 2 * np.pi * np.arange(self.count) / self.count
        c, s, none, arm = np.cos(place), np.sin(place), 0 * place, self.pitch / 2
        # radial, axial
        moves = np.array(
            [[c, s, none, none, none], [none, none, none + 1, arm * s, -arm * c]]
        )
        start = self.groove * np.array([[np.cos(self.angle)], [np.sin(self.angle)]])
        span = start + np.einsum("aij,i->aj", moves, motion)
        size = np.hypot(*span)
        along = span / size
        by, beside = (
            np.einsum("aj,aij->ij", d, moves)
            for d in (along, np.array([-along[1], along[0]]))
        )
        return (
            size - self.groove - clearance / 2,
            along,
            by,
            np.einsum("ij,kj,j->jik", beside, beside, 1 / size),
        )

    def carry(self, load, clearance=0.0, free=range(5)):
        """Motion, forces, and stiffness (5, 5) under forces along x, y, z and moments
        about x, y of the inner ring.
        """
        motion, free = np.zeros(5), list(free)

        def balance(unknowns):
            motion[free] = unknowns
            depth, _, by, second = self.compressed(motion, clearance)
            force, slope = self.law(np.maximum(depth, 0.0))
            stiffness = (by * slope) @ by.T + np.einsum("j,jik->ik", force, second)
            return (
                (by @ force - load)[free],
                stiffness[np.ix_(free, free)],
                force,
                stiffness,
            )

        # in contact, so that springs resist
        guess = (clearance + 0.02) * np.asarray(load)[free] / np.linalg.norm(load)
        found = root(
            lambda u: balance(u)[:2],
            guess,
            jac=True,
            method="lm",
            options={"xtol": 1e-14, "ftol": 1e-14},
        )
        off, _, force, stiffness = balance(found.x)
        assert np.abs(off).max() < 1e-6 * np.abs(load).max(), (
            "no balance: does the load turn what nothing holds?"
        )
        return motion, force, stiffness


def ball_bearing(count=9, ball=9.525, pitch=46.0, grooves=(0.515, 0.52), angle=0.0):
    """A ball bearing; grooves by their radius over the ball's diameter, inner and
    outer.
    """
    r, cosine = ball / 2, np.cos(angle)
    # radii along the ball's path, the outer one hollow
    races = (pitch / 2 / cosine - r, -pitch / 2 / cosine - r)
    ends = [
        ((r, r), (race, -groove * ball))
        for race, groove in zip(races, grooves, strict=True)
    ]
    unit = [fc.hertz.ellipse(radii, (STEEL, STEEL), force=1.0) for radii in ends]
    # an approach grows with force^(2/3), a pressure with 1/3
    k = sum(contact.approach for contact in unit) ** -1.5

    def law(depth):
        return k * depth**1.5, 1.5 * k * depth**0.5

    return Bearing(
        count,
        pitch,
        law,
        lambda q: unit[0].p0 * np.cbrt(q),
        (sum(grooves) - 1) * ball,
        angle,
    )


def roller_bearing(
    count=13, roller=7.5, length=9.0, pitch=46.0, drop=0.004, cells=(24, 96)
):
    """A cylindrical roller bearing; the rollers' crown falls off by `drop` at their
    ends, with the third power.
    """
    forces, curves = np.geomspace(3.0, 3e4, 16), []
    for race in (pitch - roller, -pitch - roller):  # diameters
        half = fc.HalfSpace(STEEL, (0.15 * roller, 1.05 * length), cells, against=STEEL)
        x, y = half.grid.x[:, None], np.abs(half.grid.y[None, :]) * 2 / length
        crowned = np.where(y <= 1, x**2 * (1 / roller + 1 / race) + drop * y**3, np.inf)
        curves.append(half.curve(crowned, forces=forces))
    law = PchipInterpolator(
        np.append(0, curves[0].approach + curves[1].approach), np.append(0, forces)
    )
    pressure = PchipInterpolator(
        np.append(0, forces), np.append(0, curves[0].figures["max_pressure"])
    )
    return Bearing(count, pitch, lambda d: (law(d), law(d, 1)), pressure)


def on_arc(mesh, name, radius, at, reach):
    """Name the outline at a radius about the origin, within `reach` of an angle from
    below.
    """

    def there(x):
        off = (np.arctan2(x[:, 0], -x[:, 2]) - at + np.pi) % (2 * np.pi) - np.pi
        return (np.abs(off) < reach) & (
            np.abs(np.hypot(x[:, 0], x[:, 2]) - radius) < 1e-6 * radius
        )

    return mesh.with_boundary(name, there)


def mirrored(mesh, axis):
    """A section turned over: its cells run the other way round, their second and fourth
    sides change places.
    """
    sides = {
        name: np.stack([s[:, 0], s[:, 1] ^ (2 * (s[:, 1] % 2))], axis=1)
        for name, s in mesh.boundaries.items()
    }
    turn = np.where(np.arange(3) == axis, -1.0, 1.0)
    return fc.SectionMesh(
        mesh.points * turn, mesh.cells[:, [1, 0, 3, 2, 4, 7, 6, 5]], sides
    )


def roller_section(radius, whole):
    """Section of a roller, or its right half, fine at its lowest and highest points:
    boundaries low and high.
    """
    quarter = fc.sections.half_disc(
        radius, contact_radius=0.024 * radius, level=1
    ).translated((0, 0, -radius))
    mesh = merge_sections([quarter, mirrored(quarter, 2)], 1e-6)
    mesh = merge_sections([mesh, mirrored(mesh, 0)], 1e-6) if whole else mesh
    return on_arc(on_arc(mesh, "low", radius, 0, 0.2), "high", radius, np.pi, 0.2)


def ring_section(radius, thickness, places, width):
    """Right half of a ring, fine along its race under the rollers; a negative thickness
    is inwards.

    Boundaries: "race 0", "race 1" ... of the rollers at `places` (angles from below),
    "back", and "sym_x".
    """
    gap = (places[1] - places[0]) / 2
    near = (
        width
        / radius
        * np.append(np.linspace(0, 1.5, 13)[1:], 1.5 * 1.4 ** np.arange(1, 30))
    )
    near = [0, *near[near < 0.8 * gap], gap]
    around = np.unique(
        np.clip(
            np.add.outer(np.append(near, np.negative(near)), places), 0, np.pi
        ).round(9)
    )
    depth = width * 0.15 * np.cumsum(1.6 ** np.arange(30))
    depth = [0, *depth[depth < 0.7 * abs(thickness)], abs(thickness)]

    def bent(index):
        angle = np.interp(index[:, 0], np.arange(len(around)), around)
        r = radius + np.sign(thickness) * np.interp(
            index[:, 1], np.arange(len(depth)), depth
        )
        return np.stack(
            [
                np.where((angle > 0) & (angle < np.pi), r * np.sin(angle), 0),
                -r * np.cos(angle),
            ],
            axis=1,
        )

    mesh = grid(
        (len(around) - 1, len(depth) - 1), ("race", "sym_x", "back", "sym_x"), bent
    )
    for k, place in enumerate(places):
        mesh = on_arc(mesh, f"race {k}", radius, place, 0.6 * gap)
    return mesh


def flexible(
    force,
    clearance=0.01,
    held=np.pi / 3,
    count=13,
    roller=7.5,
    length=9.0,
    pitch=46.0,
    thick=4.25,
):
    """Roller bearing between meshed rings: the inner one on a stiff shaft, the outer
    one held below over +-`held`.

    Forces (n,) and largest pressures of the rollers from the lowest one on, and the
    result; half of it is meshed.
    """
    places = 2 * np.pi * np.arange(count // 2 + 1) / count
    # half of a contact's; half the room between the rings
    width, r = 0.012 * roller, roller / 2 + clearance / 4
    races = tuple(f"race {k}" for k in range(len(places)))
    around = on_arc(
        ring_section(pitch / 2 + r, thick, places, width),
        "seat",
        pitch / 2 + r + thick,
        0,
        held,
    )
    within = ring_section(pitch / 2 - r, -thick, places, width)
    outer = fc.PlaneBody(
        around,
        STEEL,
        races,
        {"seat": "xz", "sym_x": "x"},
        thickness=length,
        name="outer",
    )
    inner = fc.PlaneBody(
        within,
        STEEL,
        races,
        {"back": "xz", "sym_x": "x"},
        thickness=length,
        name="inner",
    )
    kinds = [
        fc.PlaneBody(
            roller_section(roller / 2, whole),
            STEEL,
            ("low", "high"),
            supports,
            thickness=length,
        )
        for whole, supports in ((False, {"sym_x": "x"}), (True, {}))
    ]
    bodies, contacts, cage = [outer, inner], [], []
    for k, angle in enumerate(places):
        out, along = (
            np.array([np.sin(angle), 0, -np.cos(angle)]),
            np.array([np.cos(angle), 0, np.sin(angle)]),
        )
        turned = fc.rotation_about((0, 1, 0), -angle)
        body = kinds[min(k, 1)].placed(
            pitch / 2 * out, rotation=turned, name=f"roller {k}"
        )
        bodies.append(body)
        contacts += [
            fc.Contact(body, outer, ("low", races[k])),
            fc.Contact(body, inner, ("high", races[k])),
        ]
        # a cage: nothing else keeps a frictionless roller from leaving sideways, or one
        # without load where it is
        for stiffness, way, up in (
            ((1e3, along, 1), (1e3, along, -1), (20, out, 0)) if k else ()
        ):
            z = up * roller / 2
            ends = (body, (0, 0, z)), (None, (pitch / 2 - z) * out + 10 * way)
            cage.append(
                fc.Spring(stiffness, *ends, kind="linear", name=f"cage {len(cage)}")
            )
    scene = fc.Scene(bodies, contacts, springs=cage, units=("mm", "N", "MPa"))
    result = scene.solve(
        forces={inner: (0, 0, -force / 2)}, free={inner: "z"}, finite_motion=False
    )
    at_inner = result.contacts[1::2]
    shares = np.array(
        [np.linalg.norm(contact.force) for contact in at_inner]
    ) * np.where(places > 0, 1, 2)
    return shares, np.array([contact.max_pressure for contact in at_inner]), result


def draw(path, rigid, pressures, rings):
    """Forces round a ball bearing under combined load, and the shares of rollers by how
    the outer ring is held.
    """
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.2))
    degrees = 360 * np.arange(len(rigid)) / len(rigid)
    left.bar(degrees, rigid, width=24, color="tab:blue")
    for at, force, pressure in zip(degrees, rigid, pressures, strict=True):
        left.text(
            at, force, f"{pressure:.0f}", ha="center", va="bottom", fontsize="x-small"
        )
    left.set(
        xlabel="degrees from the radial load",
        ylabel="force of a ball [N]",
        ylim=(0, 1.12 * max(rigid)),
    )
    left.set_title("balls: 4 kN radial, 1.5 kN axial; MPa", fontsize="medium")
    for k, (name, shares) in enumerate(rings.items()):
        right.bar(np.arange(4) + 0.27 * (k - 1), shares[:4], width=0.25, label=name)
    right.set(
        xticks=range(4),
        xticklabels=[f"{360 * k / 13:.0f}°" for k in range(4)],
        ylabel="force of a roller [N]",
    )
    right.legend(fontsize="small")
    right.set_title("rollers: 5 kN radial, by the outer ring", fontsize="medium")
    figure.savefig(path, dpi=150)


def main(held=(np.pi / 3, 0.6), out="out"):
    """Print both, and draw them."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    np.set_printoptions(precision=3, suppress=True, linewidth=120)
    grooves, ball, clearance = (0.515, 0.52), 9.525, 0.01
    # clearance lets a ball touch at this angle
    angle = np.arccos(1 - clearance / 2 / (sum(grooves) - 1) / ball)
    deep = ball_bearing(angle=angle, grooves=grooves, ball=ball)
    motion, balls, stiffness = deep.carry([4000, 0, 1500, 0, 0])
    print(
        "balls, 4 kN radial and 1.5 kN axial, angle without load "
        f"{np.degrees(angle):.2f} degrees"
    )
    print("N  ", balls.round(0), "\nMPa", deep.pressure(balls).round(0))
    print(
        f"motion {1e3 * motion[:3]} um, {1e3 * motion[3:]} mrad; stiffness, N and "
        f"mm:\n{stiffness.round(0)}"
    )
    crowned = roller_bearing()
    rigid = crowned.carry([5000, 0, 0, 0, 0], clearance, free=[0, 1])[1][:7]
    print(
        "rollers, 5 kN radial: N by rigid rings ",
        rigid.round(0),
        "\n  MPa",
        crowned.pressure(rigid).round(0),
    )
    rings = {"rigid rings": rigid}
    for reach in held:
        forces, pressures, result = flexible(5000.0, clearance, held=reach)
        rings[f"held below, ±{np.degrees(reach):.0f}°"] = forces
        print(
            f"  outer ring held over +-{np.degrees(reach):.0f} degrees",
            forces.round(0),
            "\n  MPa",
            pressures.round(0),
        )
    title = f"Outer ring held below over ±{np.degrees(reach):.0f} degrees"
    result.plot("von_mises", folder / "rolling_bearing_section.png", title=title)
    draw(folder / "rolling_bearing.png", balls, deep.pressure(balls), rings)
    return rings


if __name__ == "__main__":
    main()
