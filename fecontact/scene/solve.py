"""One load case of a scene: small motion first, finite rotation where it matters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from fecontact.bodies.protocol import Body
from fecontact.common.errors import InputError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.first_candidates import KnownContact
from fecontact.contact.model import SceneModel
from fecontact.results.result import ContactResult
from fecontact.scene.adaptive import Target, solve_to_accuracy
from fecontact.scene.finite_rotation import follow, solve_finite
from fecontact.scene.linear import solved
from fecontact.scene.local_search import solve_local, sorted_case
from fecontact.scene.rest import check_rest
from fecontact.scene.settings import Settings, renamed
from fecontact.solvers import TOLERANCE, CustomSolver


def solve_scene(
    model: SceneModel,
    forces: Mapping[object, ArrayLike] | None = None,
    *,
    moments: Mapping[Body, ArrayLike] | None = None,
    motions: Mapping[Body, Mapping[str, float]] | None = None,
    free: Mapping[Body, str] | None = None,
    pressures: Mapping[tuple[Body, str], float] | None = None,
    gravity: ArrayLike | None = None,
    finite_motion: bool | str = "auto",
    accuracy: float | None = None,
    max_dofs: int | None = None,
    max_seconds: float | None = None,
    solver: str | CustomSolver = "auto",
    tolerance: float = TOLERANCE,
    search: str = "global",
    **options: object,
) -> ContactResult:
    """Solve the frictionless contact problem; arguments and errors are those of `Scene.solve`."""
    options = renamed(options if search == "global" else {**options, "search": search})
    search = str(options.pop("search", search))
    settings = Settings(solver, tolerance, options)
    settings.check()
    if finite_motion not in (True, False, "auto"):
        raise InputError(f"finite_motion must be 'auto', True or False; found {finite_motion!r}.")
    loads = {"forces": forces, "moments": moments, "motions": motions, "free": free, "pressures": pressures}
    arguments = {
        **loads, "gravity": gravity, "solver": solver, "tolerance": tolerance, "search": search, **options,
    }  # fmt: skip
    if accuracy is not None:
        given = {**arguments, "finite_motion": finite_motion}
        return solve_to_accuracy(model, given, Target(accuracy, max_dofs, max_seconds), _solve_known)
    if max_dofs is not None or max_seconds is not None:
        raise InputError("max_dofs and max_seconds limit the way to an accuracy: give accuracy=, such as 0.02, too.")
    return _solve_known(model, {**arguments, "finite_motion": finite_motion}, ())


def _solve_known(model: SceneModel, given: Mapping[str, Any], known: Sequence[KnownContact | None]) -> ContactResult:
    """One solution from checked arguments of `Scene.solve`, and what a similar case tells of its contacts."""
    arguments = dict(given)
    finite_motion, search = arguments.pop("finite_motion"), arguments["search"]
    timer = Stopwatch()
    if finite_motion is True:
        return solve_finite(model, arguments, timer)
    loading, settings = sorted_case(model, {name: v for name, v in arguments.items() if name != "search"})
    if search == "global":
        result = solved(model, loading, None, settings, timer, known)
    else:
        result = solve_local(model, loading, settings, timer)
    return check_rest(follow(result, arguments, timer) if finite_motion == "auto" else result)
