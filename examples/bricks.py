"""Bricks with gradient coordinates at large deformation and in motion: four scenes, a
picture of each.

A bar bent into a full circle; a soft block into which a rigid ball is pressed by 30 %
of its height; a strip between two rolls that squeeze it and travel along it; a brick
dropped on an edge, followed by two schemes.

Run: python examples/bricks.py
"""

import time
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.ancf import (
    AncfSolid,
    AncfSpace,
    Assembly,
    EnergyMomentum,
    GeneralisedAlpha,
    Motion,
    Stage,
    equilibrium,
    move,
    save_motion,
)
from fecontact.ancf import Path as Equilibria
from fecontact.ancf.picture import draw_side, edges, multiplier_pressure
from fecontact.common.files import save_figure

UP = np.array([0.0, 0.0, 1.0])


def circle(folder: Path, n: int = 10) -> dict[str, float]:
    """A slender bar whose end is guided round until it meets the beginning: 360
    degrees, without load on its length.
    """
    length, thickness, E = 10.0, 0.1, 1e4
    mesh = fc.shapes.block((length, thickness, thickness), (n, 1, 1), element="hex8")
    solid = AncfSolid(
        AncfSpace(mesh.translated((0.0, -thickness / 2, -thickness / 2))),
        fc.Material(E=E, nu=0.0),
    )
    a = Assembly.of([solid], [{"x_min": "xyz", "x_max": "xyz"}])
    space = solid.space
    end = np.flatnonzero(space.mesh.points[space.nodes][:, 0] > length - 1e-9)
    # position and the gradients along the end's face
    held = (space.start[end][:, None] + [0, 2, 3]).ravel()

    def stage(level: float) -> Stage:
        angle = 2 * np.pi * level
        turn = fc.rotation_about((0, 1, 0), -angle)
        centre = np.array([length * np.sinc(angle / np.pi), 0.0, 0.0])
        centre[2] = length * (1 - np.cos(angle)) / angle if level else 0.0
        motion = np.zeros((space.n_functions, 3))
        motion[held] = (
            space.affine(turn, centre - turn @ [length, 0, 0]) - a.q0
        ).reshape(-1, 3)[held]
        return Stage(a, motion=motion.ravel())

    path = _reached(equilibrium(stage, steps=16))
    levels = np.array([state.level for state in path.steps])
    figure = Figure(figsize=(8.0, 4.4), layout="constrained")
    axes = figure.subplots()
    draw_side(axes, solid, space.q0, "y_min", shaded=False, colors="0.5")
    for level in (0.125, 0.25, 0.5, 0.75, 1.0):
        state = path.steps[int(np.argmin(np.abs(levels - level)))]
        drawn = draw_side(
            axes,
            solid,
            state.q,
            "y_min",
            cmap="plasma",
            limits=(0.0, 320.0),
            linewidths=0.3,
        )
        tip = space.points_at(state.q, np.array([n - 1]), np.array([[1.0, 0.5, 0.5]]))[
            0
        ]
        away = (6, 6) if level < 1 else (-12, 10)
        axes.annotate(
            f"{360 * state.level:.0f}°",
            (tip[0], tip[2]),
            xytext=away,
            textcoords="offset points",
        )
    axes.set(xlim=(-2.8, 10.3), ylim=(-0.5, 7.4))
    figure.colorbar(drawn, ax=axes, label="equivalent stress", shrink=0.8)
    axes.set_title(f"A bar of {n} bricks bent into a full circle")
    save_figure(figure, folder / "bricks_circle.png")
    # Euler: E I k^2 L / 2
    exact = E * thickness**4 / 12 * (2 * np.pi / length) ** 2 * length / 2
    return {
        "strain energy": path.last.energy,
        "error against Euler": path.last.energy / exact - 1,
    }


def ball(folder: Path, n: int = 4, steps: int = 6) -> dict[str, float]:
    """A rigid ball (R = 1) pressed 0.3 deep into a soft block of 2 x 2 x 1 held below;
    a quarter is modelled.
    """
    mesh = fc.shapes.block((1.0, 1.0, 1.0), (n, n, n), element="hex8").translated(
        (0.0, 0.0, -1.0)
    )
    solid = AncfSolid(AncfSpace(mesh), fc.NeoHookean(E=1.0, nu=0.3))
    sphere, deepest = fc.RigidBody(fc.Sphere(1.0)), 0.3
    a = Assembly.of(
        [solid],
        [{"bottom": "xyz", "x_min": "x", "y_min": "y"}],
        [fc.Contact(solid.side("top"), sphere)],
    )
    path = _reached(
        equilibrium(
            lambda s: Stage(a.with_rigid(sphere.placed((0, 0, -deepest * s)))),
            steps=steps,
        )
    )
    depth = np.array([0.0] + [deepest * s.level for s in path.steps])
    force = np.array(
        [0.0] + [4 * float(s.reactions @ a.translation(UP)) for s in path.steps]
    )

    figure = Figure(figsize=(13.0, 4.2), layout="constrained")
    curve, section, above = figure.subplots(1, 3)
    small = np.linspace(0.0, deepest, 61)
    # half-space, small strains: E* = E/(1 - nu^2), R = 1
    hertz = 4 / 3 / (1 - 0.3**2) * small**1.5
    curve.plot(depth, force, "o-", label="block of bricks")
    curve.plot(small, hertz, "--", color="0.5", label="Hertz, small strains")
    curve.set(xlabel="depth / height", ylabel="force", title="Force")
    curve.legend(frameon=False)
    drawn = draw_side(section, solid, path.last.q, "y_min")
    figure.colorbar(drawn, ax=section, label="equivalent stress", shrink=0.8)
    points, triangles, pressure = multiplier_pressure(
        a.constraints[0].slave, path.last.q, path.last.forces[0], averaged=True
    )
    row = np.flatnonzero(np.abs(points[:, 1]) < 1e-9)
    row = row[np.argsort(points[row, 0])]
    _draw_ball(section, (0.0, 1.0 - deepest), 1.0)
    section.plot(points[row, 0], 0.1 + 0.4 * pressure[row] / pressure.max(), "C3.-")
    section.fill_between(
        points[row, 0],
        0.1 + 0.4 * pressure[row] / pressure.max(),
        0.1,
        color="C3",
        alpha=0.3,
    )
    section.text(0.42, 0.42, "pressure", color="C3")
    section.set(
        xlim=(-0.05, 1.15), ylim=(-1.05, 0.6), title="Section through the middle"
    )
    patches = above.tripcolor(
        points[:, 0],
        points[:, 1],
        triangles,
        pressure,
        shading="gouraud",
        cmap="inferno_r",
    )
    for line in edges(solid.space, path.last.q, "top"):
        above.plot(line[:, 0], line[:, 1], color="0.6", linewidth=0.5)
    figure.colorbar(patches, ax=above, label="pressure", shrink=0.8)
    above.set(aspect="equal", title="From above, averaged to the corners (a quarter)")
    save_figure(figure, folder / "bricks_ball.png")
    return {
        "force": force[-1],
        "largest pressure": float(pressure.max()),
        "force out of balance": path.last.residuals.equilibrium,
        "penetration": path.last.residuals.penetration,
    }


def strip(folder: Path) -> dict[str, float]:
    """Two frictionless rolls squeeze a strip by a fifth of its height, then travel
    along it.
    """
    mesh = fc.shapes.block((8.0, 0.5, 1.0), (16, 1, 2), element="hex8").translated(
        (0.0, -0.25, -0.5)
    )
    middle = np.flatnonzero(
        (mesh.points[:, 0] < 1e-9) & (np.abs(mesh.points[:, 2]) < 1e-9)
    )
    mesh = replace(mesh, node_sets={"height": middle})
    solid = AncfSolid(AncfSpace(mesh), fc.NeoHookean(E=1.0, nu=0.3), points=3)
    upper = fc.RigidBody(fc.surfaces.Cylinder(2.0), name="upper roll")
    lower = upper.placed(
        rotation=fc.rotation_about((0, 1, 0), np.pi), name="lower roll"
    )
    held = {"x_min": "x", "y_min": "y", "y_max": "y", "height": "z"}
    a = Assembly.of(
        [solid],
        [held],
        [fc.Contact(solid.side("top"), upper), fc.Contact(solid.side("bottom"), lower)],
    )

    def where(level: float) -> tuple[float, float]:
        """Place of the rolls and half the height between them: the first half squeezes,
        the second travels.
        """
        return 3.0 + 2.0 * max(0.0, level - 0.5), 0.5 - 0.1 * min(1.0, 2 * level)

    def stage(level: float) -> Stage:
        x, half = where(level)
        return Stage(
            a.with_rigid(upper.placed((x, 0, half)), lower.placed((x, 0, -half)))
        )

    path = _reached(equilibrium(stage, steps=8))
    travel = [s for s in path.steps if s.level > 0.5 - 1e-9]
    forces = []
    for state in travel:
        part = stage(state.level).assembly.conditions(state.q).parts[0]
        push = part.G.T @ state.forces[0]
        forces.append(
            [float(push @ a.translation(e)) for e in (np.array([1.0, 0.0, 0.0]), -UP)]
        )
    along, down = np.array(forces).T

    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    pictures = figure.subplots(2, 1)
    for axes, state in zip(pictures, (travel[0], travel[-1]), strict=True):
        drawn = draw_side(axes, solid, state.q, "y_min", limits=(0.0, 0.25))
        x, half = where(state.level)
        for side in (1, -1):
            _draw_ball(axes, (x, side * (half + 2.0)), 2.0)
        axes.set(xlim=(-0.3, 8.5), ylim=(-1.2, 1.2), title=f"Rolls at x = {x:.1f}")
    figure.colorbar(drawn, ax=pictures, label="equivalent stress", shrink=0.8)
    save_figure(figure, folder / "bricks_strip.png")
    return {
        "force of a roll": float(down.mean()),
        "spread while it travels": float(np.ptp(down) / down.mean()),
        "force along / force": float(np.abs(along).max() / down.mean()),
    }


def bounce(folder: Path, until: float = 0.75, step: float = 0.01) -> dict[str, float]:
    """A brick that falls on its edge and tumbles: trajectory, and energies of two
    schemes.
    """
    mesh = fc.shapes.block((1.0, 0.5, 0.5), (2, 1, 1), element="hex8").translated(
        (-0.5, -0.25, -0.25)
    )
    turn = fc.rotation_about((0, 1, 0), 0.35)
    mesh = mesh.mapped(lambda x: x @ turn.T + [0.0, 0.0, 0.9])
    solid = AncfSolid(
        AncfSpace(mesh), fc.NeoHookean(E=400.0, nu=0.3, density=1.0), points=3
    )
    floor = fc.RigidBody(fc.Plane(), name="floor")
    a = Assembly.of(
        [solid],
        None,
        [fc.Contact(solid.side(name), floor) for name in ("bottom", "x_max")],
    )
    schemes = {
        "energy-momentum": EnergyMomentum(),
        "generalised-alpha": GeneralisedAlpha(0.8),
    }
    motions = {
        name: _reached(
            move(
                a,
                until=until,
                step=step,
                scheme=scheme,
                velocity=(6.0, 0, 0),
                gravity=(0, 0, -10.0),
                every=5,
            )
        )
        for name, scheme in schemes.items()
    }

    figure = Figure(figsize=(11.0, 6.6), layout="constrained")
    axes = figure.subplot_mosaic(
        [["path", "path"], ["energy-momentum", "generalised-alpha"]]
    )
    kept = motions["energy-momentum"]
    for q in kept.frames[::3]:
        drawn = draw_side(
            axes["path"], solid, q, "y_min", limits=(0.0, 80.0), linewidths=0.4
        )
    axes["path"].axhline(0.0, color="black")
    axes["path"].set_title("Every 15 steps, energy-momentum scheme")
    figure.colorbar(drawn, ax=axes["path"], label="equivalent stress", shrink=0.9)
    for name, motion in motions.items():
        for kind in ("kinetic", "strain", "potential"):
            axes[name].plot(motion.time, getattr(motion, kind), label=kind)
        axes[name].plot(motion.time, motion.energy, "k", label="total")
        axes[name].set(
            xlabel="time",
            ylabel="energy",
            title=f"{name}: total changes by {np.ptp(motion.energy):.1e}",
        )
    figure.legend(
        *axes["energy-momentum"].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=4,
    )
    save_figure(figure, folder / "bricks_bounce.png")
    save_motion(a, kept.frames, folder / "bricks_bounce.pvd", kept.frame_times)
    return {f"energy drift, {name}": m.drift for name, m in motions.items()} | {
        f"penetration, {name}": float(m.penetration.max())
        for name, m in motions.items()
    }


Found = TypeVar("Found", Equilibria, Motion)


def _reached(found: Found) -> Found:
    """What was found; stop with its message if it did not reach its end."""
    if not found.success:
        raise SystemExit(found.message)
    return found


def _draw_ball(axes: Axes, centre: tuple[float, float], radius: float) -> None:
    """The outline of a ball or a roll."""
    t = np.linspace(0.0, 2 * np.pi, 361)
    axes.fill(
        centre[0] + radius * np.cos(t),
        centre[1] + radius * np.sin(t),
        facecolor="0.9",
        edgecolor="0.4",
    )


def main(small: bool = False, out: str | Path = "out") -> dict[str, dict[str, float]]:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    scenes = {
        "bar into a circle": (circle, {"n": 8}),
        "ball into a block": (ball, {"n": 2, "steps": 4}),
        "strip between rolls": (strip, {}),
        "brick on the floor": (bounce, {"until": 0.5, "step": 0.02}),
    }
    figures = {}
    for title, (scene, less) in scenes.items():
        start = time.process_time()
        figures[title] = scene(folder, **(less if small else {}))
        print(f"{title} ({time.process_time() - start:.1f} s of processor time)")
        for what, value in figures[title].items():
            print(f"  {what:34}{value:12.4g}")
    return figures


if __name__ == "__main__":
    main()
