"""Pictures of the verification manual, each computed when it is drawn."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fecontact as fc

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "verification"))
from references import layer_on_rigid_plane, pin_in_hole
from test_hard_cases import along_edge, pressed_pin, receding_layer
from test_sections import STEEL, press_cylinders, press_spheres

PIN = fc.Material(210e3, 0.3)
LINE, FOUND = {"color": "0.35", "lw": 1.2}, {"color": "tab:red", "ls": "", "marker": "o", "ms": 3.5, "mfc": "none"}


def hertz_line(path: Path) -> None:
    """Line contact at two levels against Hertz."""
    figure, axes = plt.subplots(1, 2, figsize=(8, 3.1), sharey=True, layout="constrained")
    for axis, level in zip(axes, (1, 3), strict=True):
        exact, result = press_cylinders(level, True)
        contact = result.contacts[0]
        x = contact.points[:, 0] / exact.a
        near, line = x < 1.6, np.linspace(0, 1.6, 400)
        axis.plot(line, np.sqrt(np.maximum(1 - line**2, 0)), **LINE, label="Hertz")
        axis.plot(x[near], contact.pressure[near] / exact.p0, **FOUND, label=f"level {level}, {result.n_dofs:,} dofs")
        axis.set(xlabel="x / a", xlim=(0, 1.6), ylim=(0, 1.1))
        axis.legend(frameon=False)
    axes[0].set_ylabel("pressure / p0")
    _save(figure, path)


def pin_and_layer(path: Path) -> None:
    """A pin in a hole and a layer that recedes, against solutions without finite elements."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.1), layout="constrained")
    for clearance, approach, mark in ((0.01, 0.02, "o"), (0.01, 0.03, "s")):
        angle, exact = pin_in_hole(10.0, clearance, approach, (4.0, PIN), (30.0, PIN))
        at, found = along_edge(
            pressed_pin(clearance, approach).contacts[0], lambda x: np.arctan2(np.abs(x[:, 1]), x[:, 0])
        )
        left.plot(np.degrees(angle), exact, **LINE, label="series" if mark == "o" else None)
        left.plot(np.degrees(at), found, **{**FOUND, "marker": mark}, label=f"approach {approach}")
    left.set(xlabel="angle [degrees]", ylabel="pressure", xlim=(0, 110), ylim=(0, None), title="pin, clearance 0.01")
    x, exact = layer_on_rigid_plane(1.0, 1.0, 0.25, 1.0, n=200)
    at, found = along_edge(receding_layer()[0].contacts[0], lambda points: points[:, 0])
    right.plot(x, exact, **LINE, label="transforms")
    right.plot(at[at < 2], found[at < 2], **FOUND, label="finite elements")
    right.set(xlabel="x / thickness", ylabel="pressure x thickness / load", title="receding layer")
    right.set(xlim=(0, 2), ylim=(0, None))
    for axis in (left, right):
        axis.legend(frameon=False)
    _save(figure, path)


def shear_below(path: Path) -> None:
    """Shear stress on the axis below a sphere, against Johnson 1985, equations 3.45 and 3.46."""
    _, result, body = press_spheres(5, two=False, element="quad9")
    mesh, nu = body.mesh, STEEL.nu
    sphere = fc.hertz.spheres((25.0, np.inf), (STEEL, None), force=726.4)
    axis = np.flatnonzero(np.abs(mesh.points[:, 0]) < 1e-12)
    s = mesh.points[axis, 2] / sphere.a
    stress = result.stress(body)[axis]
    order = np.argsort(s)[s[np.argsort(s)] < 3]
    z = np.linspace(1e-3, 3, 300)
    radial = (1 + nu) * (1 - z * np.arctan(1 / z)) - 0.5 / (1 + z**2)
    figure, axes = plt.subplots(figsize=(5, 3.1), layout="constrained")
    axes.plot(z, np.abs(1 / (1 + z**2) - radial) / 2, **LINE, label="closed form")
    found = np.abs(stress[:, 2] - stress[:, 0]) / 2 / sphere.p0
    axes.plot(s[order], found[order], **FOUND, label=f"finite elements, {result.n_dofs:,} dofs")
    axes.set(xlabel="depth / a", ylabel="shear stress / p0", xlim=(0, 3), ylim=(0, None))
    axes.legend(frameon=False)
    _save(figure, path)


def _save(figure: plt.Figure, path: Path) -> None:
    figure.savefig(path, dpi=130)
    plt.close(figure)
