"""One load case of a scene: small motion first, finite rotation where it matters."""

from __future__ import annotations

from collections.abc import Mapping

from numpy.typing import ArrayLike

from fecontact.bodies.protocol import Body
from fecontact.common.errors import InputError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.loads import make_loading
from fecontact.contact.model import SceneModel
from fecontact.results.result import ContactResult
from fecontact.scene.finite_rotation import follow, solve_finite
from fecontact.scene.linear import solved
from fecontact.scene.local_search import solve_local
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
    timer = Stopwatch()
    if finite_motion is True:
        return solve_finite(model, arguments, timer)
    loading = make_loading(model.bodies, forces, moments, motions, free, pressures, gravity)
    result = (
        solved(model, loading, None, settings, timer)
        if search == "global"
        else solve_local(model, loading, settings, timer)
    )
    return check_rest(follow(result, arguments, timer) if finite_motion == "auto" else result)
