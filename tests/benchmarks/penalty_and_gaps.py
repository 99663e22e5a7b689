"""What a guessed stiffness and load increments cost: a penalty and gap elements beside the exact answer.

A ball is pressed on a plane and condensed once; all three methods then get the same small problem, so they differ in
nothing but the springs. Gap elements in load increments are how the report of 1978 had it from the MARC system
(section IV.2). Springs are spread evenly over the area; k0 is the mean stiffness of the bodies at a contact node.

Run: python tests/benchmarks/penalty_and_gaps.py; docs/baselines_page.py makes a page of it.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import fecontact as fc
from fecontact.common.files import save_figure
from fecontact.solvers.baselines import Approximation, condition_number, gap_elements, penalty

RADIUS, FORCE = 250.0, 7124.0  # mm, N
STEEL = fc.Material(E=2.0e5, nu=0.3)
HERTZ = fc.hertz.spheres(radii=(RADIUS, RADIUS), materials=(STEEL, STEEL), force=FORCE)
HARD = 1e6


def pressed_ball(level: int) -> fc.ContactResult:
    """A quarter of a ball on a rigid plane: half of two equal balls."""
    mesh = fc.shapes.quarter_sphere(RADIUS, contact_radius=HERTZ.a, level=level)
    ball = fc.ElasticBody(mesh, STEEL, contact="cap", supports={"base": "xyz", "sym_x": "x", "sym_y": "y"})
    plane = fc.RigidBody(fc.Plane())
    return fc.Scene([ball, plane], [fc.Contact(ball, plane)]).solve(forces={ball: (0, 0, -FORCE / 4)})


def node_stiffness(result: fc.ContactResult) -> NDArray[np.float64]:
    """Stiffness of the bodies at a contact node, their mean spread over the nodes by their areas."""
    contact = result.contacts[0]
    areas = contact.weights[contact._candidates]
    return areas / areas.mean() / result.problem.S.diagonal().mean()


def main(
    level: int = 1, increments: tuple[int, ...] = (4, 16, 64, 256, 1024), out: str | Path = "out"
) -> dict[str, Any]:
    result = pressed_ball(level)
    problem, exact = result.problem, result.solution
    k0 = node_stiffness(result)
    approach = -float(result.rigid_motion(result.scene.bodies[0]).translation[2])

    def row(found: Approximation) -> dict[str, Any]:
        error = float(np.abs(found.forces - exact.forces).max() / exact.forces.max())
        return {
            "error": error,
            "penetration": found.penetration / approach,
            "solves": found.solves,
            "settled": found.settled,
            "touching": int((found.gap <= 0).sum()),
        }

    springs = [{"k": k, **row(penalty(problem, k * k0))} for k in 10.0 ** np.arange(-1, 10)]
    for each in springs:
        touching = np.where(penalty(problem, each["k"] * k0).gap < 0, each["k"] * k0, 0.0)
        each["condition"] = condition_number(problem, touching)
    steps = [
        {"soft": soft, "increments": m, "cycles": n, **row(gap_elements(problem, soft * k0, HARD * k0, m, cycles=n))}
        for soft, n in ((1e-2, 1), (1e-4, 1), (1e-4, 2))
        for m in increments
    ]
    rows = {
        "penalty": springs,
        "gap elements": steps,
        "exact": {"solves": exact.nit, "touching": int(exact.active.sum()), "candidates": problem.n},
        "bodies": condition_number(problem, 0.0),
    }
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    draw(result, rows, k0, folder / "penalty_and_gaps.png")
    report(rows)
    return rows


def report(rows: dict[str, Any]) -> None:
    print(f"exact: {rows['exact']['solves']} solves, {rows['exact']['touching']} points touch")
    print(f"{'penalty k/k0':>14}{'error':>10}{'penetration':>13}{'solves':>8}{'condition':>11}")
    for r in rows["penalty"]:
        print(f"{r['k']:>14.0e}{r['error']:>10.1e}{r['penetration']:>13.1e}{r['solves']:>8}{r['condition']:>11.1e}")
    print(f"{'increments':>14}{'soft/k0':>10}{'cycles':>8}{'error':>10}{'penetration':>13}{'solves':>8}")
    for r in rows["gap elements"]:
        print(
            f"{r['increments']:>14}{r['soft']:>10.0e}{r['cycles']:>8}{r['error']:>10.1e}{r['penetration']:>13.1e}"
            f"{r['solves']:>8}"
        )


def draw(result: fc.ContactResult, rows: dict[str, Any], k0: NDArray[np.float64], path: Path) -> None:
    figure = Figure(figsize=(11.0, 8.5), layout="constrained")
    (top, beside), (below, field) = figure.subplots(2, 2)
    k = [r["k"] for r in rows["penalty"]]
    top.loglog(k, [r["error"] for r in rows["penalty"]], "o-", label="largest error of a force / largest force")
    top.loglog(k, [r["penetration"] for r in rows["penalty"]], "s-", label="penetration / approach")
    top.set(title="penalty: error falls like 1/k", xlabel="penalty stiffness k / k0")
    top.legend(fontsize=8)
    beside.loglog(k, [r["condition"] for r in rows["penalty"]], "o-", color="C3", label="with the penalty")
    beside.axhline(rows["bodies"], color="k", linestyle=":", label="bodies alone")
    for r in rows["penalty"]:
        beside.annotate(
            f"{r['solves']}", (r["k"], r["condition"]), xytext=(0, 7), textcoords="offset points", ha="center"
        )
    beside.set_ylim(top=1e12)
    beside.set(title="penalty: condition number grows like k (figures: solves)", xlabel="penalty stiffness k / k0")
    beside.legend(fontsize=8, loc="upper left", bbox_to_anchor=(0.0, 0.9))
    for soft, cycles in dict.fromkeys((r["soft"], r["cycles"]) for r in rows["gap elements"]):
        chosen = [r for r in rows["gap elements"] if (r["soft"], r["cycles"]) == (soft, cycles)]
        label = f"soft {soft:.0e} k0" + (f", {cycles} cycles" if cycles > 1 else "")
        below.loglog([r["increments"] for r in chosen], [r["error"] for r in chosen], "o-", label=label)
    below.set(title="gap elements: error against load increments", xlabel="increments")
    below.set_ylabel("largest error of a force / largest force")
    below.legend(fontsize=8)
    draw_pressures(field, result, k0)
    save_figure(figure, path)


def draw_pressures(axes: Any, result: fc.ContactResult, k0: NDArray[np.float64]) -> None:
    """How the pressure moves with the guesses."""
    contact, problem = result.contacts[0], result.problem
    found = {
        "exact": result.solution.forces,
        "penalty, k = k0": penalty(problem, k0).forces,
        "penalty, k = 10 k0": penalty(problem, 10 * k0).forces,
        "16 increments": gap_elements(problem, 1e-4 * k0, HARD * k0, 16).forces,
        "64 increments": gap_elements(problem, 1e-4 * k0, HARD * k0, 64).forces,
    }
    chosen = contact._candidates
    r = np.hypot(*contact.points[chosen, :2].T) / HERTZ.a
    order = np.argsort(r)
    for (name, forces), style in zip(found.items(), ("k.-", "C0.", "C2.", "C1x", "C3x"), strict=True):
        axes.plot(r[order], (forces / contact.weights[chosen] / HERTZ.p0)[order], style, label=name, markersize=4)
    axes.set(title="pressure over Hertz's largest", xlabel="radius / a", xlim=(0, 1.6), ylim=(-0.1, 1.6))
    axes.legend(fontsize=8)


if __name__ == "__main__":
    main()
