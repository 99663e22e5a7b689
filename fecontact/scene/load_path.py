"""Load paths: a sequence of load steps with friction, whose answer depends on their order.

Slip of a step is counted from the end of the step before, so that what sticks keeps its displacement. A step without
certified solution is cut in halves, with loads and motions in between.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError, SolverError, SupportError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.model import SceneModel
from fecontact.results.result import ContactResult
from fecontact.scene.carried import KEYED
from fecontact.scene.linear import solved
from fecontact.scene.local_search import sorted_case
from fecontact.scene.rest import check_rest
from fecontact.solvers import TOLERANCE

#: Halvings of a step that has no certified solution.
HALVINGS = 5


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Results of the steps of a load path.

    Attributes
    ----------
    steps : tuple of ContactResult
        At the end of every step given.
    dissipated : (n_steps, n_contacts) array
        Work of friction during every step, parts of cut steps included; zero for contacts without friction.
    cuts : tuple of int
        Parts in which every step was solved.
    """

    steps: tuple[ContactResult, ...]
    dissipated: Array
    cuts: tuple[int, ...]

    def __len__(self) -> int:
        """Number of steps."""
        return len(self.steps)

    def __getitem__(self, k: int) -> ContactResult:
        """Result of a step."""
        return self.steps[k]

    @cached_property
    def forces(self) -> Array:
        """Forces (n_steps, n_contacts, 3) on the slaves, friction included."""
        return np.array([[c.force for c in result.contacts] for result in self.steps])

    def motions(self, body: Body) -> Array:
        """Rigid motions (n_steps, 6) of a body's frame: translations and rotation vectors."""
        found = [result.rigid_motion(body) for result in self.steps]
        return np.array([np.concatenate([m.translation, m.rotation]) for m in found])

    def wear_depth(self, contact: int, coefficient: float) -> Array:
        """Wear depth (n,) at the points of a contact by Archard's law, h = k int p |ds|.

        Parameters
        ----------
        contact : int
            Number of the contact in the scene.
        coefficient : float
            Archard's k: volume per force and distance, one over pressure. The work of friction by area is mu times the
            integral. Exact where steps are not cut; a cut step counts with the path between its ends.

        Returns
        -------
        (n,) array
        """
        found = [result.contacts[contact].friction for result in self.steps]
        if any(f is None or not 0 < f.mu < np.inf for f in found):
            raise InputError(f"Contact {contact} has no finite friction: Archard's law needs its work.")
        return np.asarray(sum(coefficient * f.work_density / f.mu for f in found if f is not None))

    def __str__(self) -> str:
        lines = [f"{'step':>4}  {'normal':>12}  {'friction':>12}  {'stick area':>12}  {'slip area':>12}  {'work':>12}"]
        for k, result in enumerate(self.steps):
            for c, work in zip(result.contacts, self.dissipated[k], strict=True):
                if c.friction is not None:
                    f = c.friction
                    values = (c.total_force, float(np.linalg.norm(f.force)), f.stick_area, f.slip_area, float(work))
                    lines.append(f"{k + 1:>4}  " + "  ".join(f"{v:>12.5g}" for v in values))
        return "\n".join(lines)


def solve_path(model: SceneModel, steps: Sequence[Mapping[str, Any]], *, tolerance: float = TOLERANCE) -> LoadPath:
    """Solve load steps one after the other, with the slip and stick of each carried to the next.

    Parameters
    ----------
    model : SceneModel
        The scene; as its method `Scene.solve_path`, the scene itself.
    steps : sequence of mappings
        Loads at the end of each step, as arguments of `Scene.solve`: ``forces``, ``moments``, ``motions``, ``free``,
        ``pressures``, ``tractions``, ``gravity``. They are totals, not increments: what a step leaves out is zero
        at its end. A body is free, loaded or moved in the same components in all steps, or its change from one to the
        other is part of the step.
    tolerance : float
        Of the certificate of every step, see `solvers.friction_problem.FrictionResiduals`.

    Returns
    -------
    LoadPath

    Raises
    ------
    InputError, SupportError, SolverError
        The message has the number of the step.

    Examples
    --------
    A block on a floor is pressed, then dragged and released:

    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> block = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([block, floor], [fc.Contact(block, floor, friction=0.3)])
    >>> path = scene.solve_path([{"motions": {block: {"z": -0.01, "x": x}}} for x in (0.0, 0.02, 0.0)])
    >>> path.forces[:, 0, 0].round(9).tolist()
    [0.0, -0.003, 0.003]
    """
    if not steps:
        raise InputError("A load path needs at least one step.")
    for k, step in enumerate(steps):
        if unknown := sorted(set(step) - {*KEYED, "gravity"}):
            raise InputError(f"Step {k + 1} has {', '.join(map(repr, unknown))}; expected {', '.join(KEYED)}, gravity.")
    if not model.has_friction:
        raise InputError("No contact has friction: the order of loads does not matter; use Scene.solve or Scene.sweep.")
    results, works, cuts = [], [], []
    before: ContactResult | None = None
    given: Mapping[str, Any] = {}
    for k, step in enumerate(steps):
        try:
            parts = list(_solved_step(model, given, step, before, tolerance, 0))
        except (InputError, SupportError, SolverError) as error:
            raise type(error)(f"Step {k + 1} of {len(steps)}: {error}", *error.args[1:]) from error
        results.append(parts[-1])
        works.append(np.sum([[work_of(part, c) for c in range(len(part.contacts))] for part in parts], axis=0))
        cuts.append(len(parts))
        before, given = parts[-1], step
    return LoadPath(tuple(results), np.array(works), tuple(cuts))


def work_of(result: ContactResult, contact: int) -> float:
    """Work that friction dissipated in a contact during its last step."""
    found = result.contacts[contact].friction
    return 0.0 if found is None else found.dissipated


def _solved_step(
    model: SceneModel,
    given: Mapping[str, Any],
    step: Mapping[str, Any],
    before: ContactResult | None,
    tolerance: float,
    depth: int,
) -> Iterator[ContactResult]:
    """Results of a step: one, or those of its halves."""
    loading, settings = sorted_case(model, {**step, "tolerance": tolerance})
    try:
        found = check_rest(solved(model, loading, None, settings, Stopwatch(), (), before))
    except SolverError as error:
        if isinstance(error, SupportError) or depth == HALVINGS:
            raise
    else:
        yield replace(found, follows_step=True)
        return
    middle = between(given, step)
    for start, end in ((given, middle), (middle, step)):
        for part in _solved_step(model, start, end, before, tolerance, depth + 1):
            before = part
            yield part


def between(start: Mapping[str, Any], end: Mapping[str, Any]) -> dict[str, Any]:
    """Loads and motions half way between those of two steps; what one of them leaves out is zero there.

    Components are free as at the end.
    """
    out: dict[str, Any] = {}
    for name in {*start, *end}:
        one, other = start.get(name), end.get(name)
        if name == "free":
            out[name] = other
        elif name == "gravity":
            out[name] = _mean(one, other)
        elif name == "motions":
            keys = {**(one or {}), **(other or {})}
            out[name] = {body: _mean_motion((one or {}).get(body), (other or {}).get(body)) for body in keys}
        else:
            keys = {**(one or {}), **(other or {})}
            out[name] = {key: _mean((one or {}).get(key), (other or {}).get(key)) for key in keys}
    return {name: value for name, value in out.items() if value is not None}


def _mean(one: Any, other: Any) -> Any:
    if one is None and other is None:
        return None
    return (np.zeros(np.shape(other)) if one is None else np.asarray(one, float)) / 2 + (
        np.zeros(np.shape(one)) if other is None else np.asarray(other, float)
    ) / 2


def _mean_motion(one: Mapping[str, float] | None, other: Mapping[str, float] | None) -> dict[str, float]:
    every = {**(one or {}), **(other or {})}
    return {c: ((one or {}).get(c, 0.0) + (other or {}).get(c, 0.0)) / 2 for c in every}
