"""A rubber O-ring squeezed in its groove, then pressed against the groove's wall by the
fluid that it holds back.

The upper half of the section of a face seal: a lid comes down, the fluid acts from the
side of the axis. The rubber is neo-Hookean and nearly incompressible (nu = 0.4999), the
wall a linear ring of steel. Each state is one solution from rest. Beside the finite
elements stand Lindley's rule for the force of a squeezed ring without a wall, and
Hertz's width and peak for the force found (P. B. Lindley, J. Inst. Rubber Ind. 1 (1967)
209); for the sealing the rule that rubber passes the fluid's pressure on: the peak
rises by nu / (1 - nu) of it (A. Karaszkiewicz, Ind. Eng. Chem. Res. 29 (1990) 2134).

Run: python examples/o_ring.py
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

import fecontact as fc
from fecontact.mesh.section_mesh import merge_sections
from fecontact.mesh.section_shapes import grid

CORD, RING = 3.53, 50.0  # diameter of the cord and radius of its middle: mm, N, MPa
RUBBER = fc.NeoHookean(E=5.5, nu=0.4999)  # about 70 Shore A
STEEL = fc.Material(E=2.1e5, nu=0.3)
SLIT = 0.02  # between the ring and the groove's outer wall, before the squeeze


def half_cord(n: int) -> fc.SectionMesh:
    """Upper half of the cord's section: a core of squares with three bows around it."""
    r, c = CORD / 2, 0.5 * CORD / 2

    def arc(degrees: np.ndarray) -> np.ndarray:
        return r * np.stack(
            [np.cos(np.radians(degrees)), np.sin(np.radians(degrees))], axis=1
        )

    def bow(s: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
        return (1 - s[:, None]) * inner + s[:, None] * outer

    def core(k: np.ndarray) -> np.ndarray:
        return c * np.stack([k[:, 0] / n - 1, k[:, 1] / n], axis=1)

    def right(k: np.ndarray) -> np.ndarray:
        t = k[:, 1] / n
        return bow(k[:, 0] / n, np.stack([0 * t + c, c * t], axis=1), arc(45 * t))

    def left(k: np.ndarray) -> np.ndarray:
        t = k[:, 1] / n
        return bow(
            1 - k[:, 0] / n, np.stack([0 * t - c, c * t], axis=1), arc(180 - 45 * t)
        )

    def top(k: np.ndarray) -> np.ndarray:
        t = k[:, 0] / n
        return bow(
            k[:, 1] / n, np.stack([c * (t - 1), 0 * t + c], axis=1), arc(135 - 45 * t)
        )

    parts = [
        grid((2 * n, n), ("middle", None, None, None), core),
        grid((n, n), ("middle", "arc", None, None), right),
        grid((n, n), ("middle", None, None, "arc"), left),
        grid((2 * n, n), (None, None, "arc", None), top),
    ]
    cord = merge_sections(parts, 1e-6)
    for name, (low, high) in {"outer": (-1, 60), "upper": (50, 150)}.items():
        cord = cord.with_boundary(name, between(low, high))
    return cord


def between(low: float, high: float) -> Callable[[np.ndarray], np.ndarray]:
    """Points of the cord's outline between two angles from outside, degrees."""

    def chosen(x: np.ndarray) -> np.ndarray:
        angle = np.degrees(np.arctan2(x[:, 2], x[:, 0]))
        return (
            (np.hypot(x[:, 0], x[:, 2]) > 0.499 * CORD) & (low < angle) & (angle < high)
        )

    return chosen


def squeezed(
    squeeze: float,
    n: int,
    fluid: float = 0.0,
    wetted: float = 150.0,
    slit: float = SLIT,
) -> fc.ContactResult:
    """The O-ring under a lid, and under the fluid's pressure from an angle of its
    outline on.
    """
    mesh = (
        half_cord(n)
        .with_boundary("wetted", between(wetted, 181))
        .translated((RING, 0.0, 0.0))
    )
    ring = fc.AxisymmetricBody(
        mesh, RUBBER, ("upper", "outer"), {"middle": "z"}, name="ring"
    )
    height = (1 - squeeze) * CORD / 2
    block = fc.sections.rectangle(
        (2.0, height - SLIT), (2, 4 * n), start=RING + CORD / 2 + slit
    )
    wall = fc.AxisymmetricBody(
        block, STEEL, "left", {"right": "xz", "bottom": "z"}, name="wall"
    )
    lid = fc.RigidBody(fc.Plane(), name="lid").placed(
        (0, 0, CORD / 2), rotation=np.diag([1.0, -1, -1])
    )
    contacts = [
        fc.Contact(ring, lid, ("upper", lid.contact[0])),
        fc.Contact(ring, wall, ("outer", "left")),
    ]
    scene = fc.Scene([ring, wall, lid], contacts, units=("mm", "N", "MPa"))
    pressures = {(ring, "wetted"): fluid} if fluid else {}
    return scene.solve(motions={lid: {"z": height - CORD / 2}}, pressures=pressures)


def edge_of(result: fc.ContactResult, n: int) -> float:
    """Angle of the last point towards the fluid that touches the lid, on the outline of
    the ring at rest.
    """
    ring, cord = result.scene.bodies[0], half_cord(n)
    nodes = cord.boundary_nodes("upper")
    height = (cord.points + result.displacement(ring))[nodes, 2]
    closed = cord.points[nodes[height > height.max() - 1e-3 * CORD]]
    return float(np.degrees(np.arctan2(closed[:, 2], closed[:, 0])).max())


def main(
    n: int = 8, squeezes: tuple[float, ...] = (0.1, 0.2, 0.25), out: str | Path = "out"
) -> list[dict[str, float]]:
    """Squeeze, then let the fluid in; print and draw."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    length, rows = 2 * np.pi * RING, []
    print(
        "force / (E d length), width / d and peak / E under the lid; Lindley's force, "
        "Hertz's width and peak for it"
    )
    print(
        f"{'squeeze':>8}{'groove':>8}{'force':>9}{'Lindley':>9}{'width':>8}"
        f"{'Hertz':>8}{'peak':>8}{'Hertz':>8}{'s':>6}"
    )
    for squeeze in squeezes:
        for groove, slit in (("none", 8.0), ("wall", SLIT)):
            result = squeezed(squeeze, n, slit=slit)
            lid = result.contacts[0]
            force = abs(lid.force[2]) / (length * RUBBER.E * CORD)
            row = {
                "squeeze": squeeze,
                "slit": slit,
                "force": force,
                "lindley": 1.25 * squeeze**1.5 + 50 * squeeze**6,
            }
            row |= {
                "width": lid.area / length / CORD,
                "peak": lid.max_pressure / RUBBER.E,
            }
            rows.append(row)
            print(
                f"{squeeze:>8.0%}{groove:>8}{force:>9.4f}{row['lindley']:>9.4f}"
                f"{row['width']:>8.3f}"
                f"{np.sqrt(6 * force / np.pi):>8.3f}{row['peak']:>8.3f}"
                f"{np.sqrt(8 * force / 3 / np.pi):>8.3f}"
                f"{result.seconds['total']:>6.1f}"
            )
    dry = squeezed(0.2, n)
    wetted, peak = edge_of(dry, n) - 1e-6, dry.contacts[0].max_pressure
    results = {0.0: dry}
    print(
        f"\nsqueezed by 20 %, then under a fluid (MPa)\n{'fluid':>8}{'peak':>8}"
        f"{'passed on':>11}{'seals':>7}{'s':>6}"
    )
    for fluid in (0.5, 1.0):
        results[fluid] = wet = squeezed(0.2, n, fluid, wetted)
        found, expected = (
            wet.contacts[0].max_pressure,
            peak + RUBBER.nu / (1 - RUBBER.nu) * fluid,
        )
        rows.append({"fluid": fluid, "peak": found, "passed on": expected})
        seals = "yes" if found > fluid else "no"
        print(
            f"{fluid:>8.1f}{found:>8.2f}{expected:>11.2f}{seals:>7}"
            f"{wet.seconds['total']:>6.1f}"
        )
    draw(results, n).savefig(folder / "o_ring.png", dpi=150)
    return rows


def draw(results: dict[float, fc.ContactResult], n: int) -> Figure:
    """The deformed section in its groove, coloured by the pressure inside, and the
    contact pressure under the lid.
    """
    figure = Figure(figsize=(4.2 * len(results), 3.6), layout="constrained")
    axes = figure.subplots(1, len(results))
    cord = half_cord(n)
    corners = cord.cells[:, :4]
    triangles = np.concatenate([corners[:, :3], corners[:, [0, 2, 3]]])
    pressures = {
        fluid: -result.stress(result.scene.bodies[0])[:, :3].mean(axis=1)
        for fluid, result in results.items()
    }
    levels = MaxNLocator(21).tick_values(0.0, max(p.max() for p in pressures.values()))
    for at, (fluid, result) in zip(axes, results.items(), strict=True):
        x, _, z = (cord.points + result.displacement(result.scene.bodies[0])).T
        drawn = at.tricontourf(
            x,
            z,
            triangles,
            np.clip(pressures[fluid], 0, levels[-1]),
            levels,
            cmap="YlOrRd",
        )
        outline = cord.outer_sides
        for begin, end, middle in cord.face_nodes(outline):
            at.plot(x[[begin, middle, end]], z[[begin, middle, end]], "k", lw=0.8)
        contact = result.contacts[0]
        order = np.argsort(contact.points[:, 0])
        top = z.max()
        at.plot(
            contact.points[order, 0] - RING,
            top + 0.25 * contact.pressure[order] / levels[-1] * CORD,
            "C0",
        )
        at.axhline(top, color="0.4", lw=1.5)
        at.plot([CORD / 2 + SLIT] * 2, [0.0, top], color="0.4", lw=1.5)
        at.set(
            aspect="equal", xlim=(-0.65 * CORD, 0.6 * CORD), ylim=(-0.05, 0.72 * CORD)
        )
        at.set(
            xlabel="radius less that of the ring [mm]",
            title=f"fluid at {fluid:g} MPa from the left"
            if fluid
            else "squeezed by 20 %",
        )
    axes[0].set_ylabel("height [mm]")
    figure.colorbar(drawn, ax=axes, label="pressure [MPa]")
    figure.suptitle(
        "blue: pressure under the lid, 1 mm stands for "
        f"{levels[-1] / 0.25 / CORD:.2g} MPa",
        fontsize="medium",
    )
    return figure


if __name__ == "__main__":
    main()
