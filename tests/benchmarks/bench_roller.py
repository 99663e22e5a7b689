"""A rubber roller pressed by 46 %: error of its force against time, beside felupe and the bricks with gradients.

    OMP_NUM_THREADS=1 python tests/benchmarks/bench_roller.py --peer-python peers/bin/python --plot roller.png

`peers/_roller.py` has the problem and its converged force, `peers/README.md` how felupe is installed; without it the
rest is run, and a line names what is absent. Printed are unknowns, processor seconds with meshing and without the
loading of packages, the force, its error, iterations of each load step and the largest penetration of a node.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.ancf import AncfSolid, AncfSpace, Assembly, Stage, equilibrium

PEERS = Path(__file__).parent / "peers"
sys.path[:0] = [str(PEERS), str(Path(__file__).parent)]

from _roller import DEPTH, FORCE, NU, OUTER, WIDTH, E, place  # noqa: E402
from compare.peers import ask, environment, find_peers  # noqa: E402

LAW = fc.NeoHookean(E=E, nu=NU)
#: Cells through the rubber; there are four times as many around.
THROUGH = (2, 4, 8, 16)
PATIENCE = 300


def section(through: int, element: str) -> dict[str, Any]:
    """Cells of the section, in one load step."""
    axes = [np.linspace(0, 1, n + 1) for n in (through, 4 * through)]
    mesh = fc.sections.rectangle((1.0, 1.0), (axes[0], axes[1]), element=element)

    def bent(x: np.ndarray) -> np.ndarray:
        across, up = place(x[:, 0], x[:, 2])
        return np.stack([across, 0 * up, up], axis=1)

    supports = {"left": "xz", "bottom": "x", "top": "x"}
    roller = fc.PlaneBody(mesh.mapped(bent), LAW, "right", supports, name="roller", thickness=WIDTH)
    floor = fc.RigidBody(fc.Plane(), name="floor").placed((0.0, 0.0, -OUTER))
    result = fc.Scene([roller, floor], [fc.Contact(roller, floor)]).solve(motions={floor: {"z": DEPTH}})
    contact = result.contacts[0]
    return {
        "dofs": mesh.points.shape[0] * 2,
        "force": 2 * abs(contact.force[2]),
        "steps": [each.iterations for each in result.finite_strain],
        "penetration": max(0.0, -float(contact.gap.min())),
    }


def solid(through: int) -> tuple[fc.Mesh, fc.RigidBody, dict[str, str]]:
    """The same as one layer of hexahedra of 20 nodes, a floor below it, and its supports."""
    axes = [np.linspace(0, 1, n + 1) for n in (through, 4 * through)]
    mesh = fc.shapes.block((1.0, WIDTH, 1.0), (axes[0], 1, axes[1]), element="hex20")

    def bent(x: np.ndarray) -> np.ndarray:
        across, up = place(x[:, 0], x[:, 2])
        return np.stack([across, x[:, 1], up], axis=1)

    floor = fc.RigidBody(fc.Plane(), name="floor").placed((0.0, WIDTH / 2, -OUTER))
    supports = {"x_min": "xyz", "y_min": "y", "y_max": "y", "bottom": "x", "top": "x"}
    return mesh.mapped(bent), floor, supports


def hexahedra(through: int) -> dict[str, Any]:
    """Hexahedra in one load step."""
    mesh, floor, supports = solid(through)
    roller = fc.ElasticBody(mesh, LAW, "x_max", supports, name="roller", geometry="plain")
    result = fc.Scene([roller, floor], [fc.Contact(roller, floor)]).solve(motions={floor: {"z": DEPTH}})
    contact = result.contacts[0]
    return {
        "dofs": roller.n_dofs,
        "force": 2 * abs(contact.force[2]),
        "steps": [each.iterations for each in result.finite_strain],
        "penetration": max(0.0, -float(contact.gap.min())),
    }


def bricks(through: int) -> dict[str, Any]:
    """Bricks with gradients, in four load steps."""
    mesh, floor, supports = solid(through)
    rubber = AncfSolid(AncfSpace(mesh), fc.NeoHookean(E=E, nu=NU), points=3)
    both = Assembly.of([rubber], [supports], [fc.Contact(rubber.side("x_max"), floor)])
    path = equilibrium(lambda share: Stage(both.with_rigid(floor.placed((0, 0, DEPTH * share)))), steps=4)
    last = path.last
    return {
        "dofs": rubber.space.n_dofs,
        "force": 2 * abs(float(last.reactions @ both.translation(np.array([0.0, 0.0, 1.0])))),
        "steps": [state.nit for state in path.steps],
        "penetration": max(0.0, -float(last.gaps[0].min())),
    }


#: Methods of this package: how they solve, and on which of `THROUGH`.
OURS: dict[str, tuple[Callable[[int], dict[str, Any]], tuple[int, ...]]] = {
    "sections, quad8": (lambda n: section(n, "quad8"), THROUGH),
    "sections, quad9": (lambda n: section(n, "quad9"), THROUGH),
    "one layer, hex20": (hexahedra, THROUGH[1:3]),
    "bricks with gradients": (bricks, THROUGH[1:3]),
}


def ours() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Name, mesh and figures of each run; the first run of each loads what is loaded late."""
    for name, (solve, meshes) in OURS.items():
        solve(meshes[0])
        for through in meshes:
            began = time.process_time()
            row = solve(through)
            yield name, f"{through} x {4 * through}", {**row, "seconds": time.process_time() - began}


def theirs(python: str) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """The same of other programs; what is absent is said."""
    peers, absent = find_peers(PEERS, python)
    for line in absent:
        if line.startswith("felupe"):
            print(f"not run: {line}; see {PEERS / 'README.md'}")
    for peer in (p for p in peers if "roller" in p.problems):
        for setting in peer.settings:
            row = ask([python, str(peer.script), "roller", str(setting)], environment(1), PATIENCE)
            if isinstance(row, str):
                print(f"not run: {peer.method} {setting}: {row}")
            else:
                yield f"{peer.method} {peer.version}", str(setting), row


def main(python: str, plot: str | None) -> None:
    """Solve, print and draw."""
    print(f"{'':52}{'mesh':>10}{'dofs':>8}{'s':>8}{'force':>9}{'error':>9}{'penetration':>13}  iterations or steps")
    curves: dict[str, list[tuple[float, float]]] = {}
    for name, mesh, row in (*ours(), *theirs(python)):
        error = row["force"] / FORCE - 1
        curves.setdefault(name, []).append((row["seconds"], abs(error)))
        print(
            f"{name:52}{mesh:>10}{row['dofs']:>8}{row['seconds']:>8.2f}{row['force']:>9.2f}{error:>9.2%}"
            f"{row['penetration']:>13.1e}  {row['steps']}"
        )
    if plot is not None:
        figure = Figure(figsize=(7.0, 5.0), layout="constrained")
        axes = figure.subplots()
        for name, points in curves.items():
            axes.loglog(*np.transpose(points), "o--" if name.startswith("felupe") else "o-", label=name)
        axes.set(xlabel="processor time, s", ylabel="error of the force", title="a roller pressed by 46 %")
        axes.legend()
        figure.savefig(plot, dpi=150)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("--peer-python", default=sys.executable, help="interpreter that has felupe")
    parser.add_argument("--plot", help="picture of error against time")
    given = parser.parse_args()
    main(given.peer_python, given.plot)
