"""One load case of a scene: small motion first, finite rotation where it matters."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import partial
from typing import Any

from numpy.typing import ArrayLike

from fecontact.bodies.body import Body
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import spelled
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.common.progress import progress_line, set_part
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.candidates import KnownContact
from fecontact.contact.loads import Distribution, LoadStep
from fecontact.contact.model import SceneModel
from fecontact.results.cell_contact import is_half_space
from fecontact.results.result import ContactResult
from fecontact.scene.adaptive import Target, solve_to_accuracy
from fecontact.scene.engine import ENGINES, check_engine, on_processes
from fecontact.scene.finite_rotation import check_rest, follow, follow_from, solve_finite
from fecontact.scene.finite_strain import is_nonlinear, refuse_with_laws, solve_at_finite_strain
from fecontact.scene.linear import Settings, solved, solver_options
from fecontact.scene.local_search import solve_local
from fecontact.scene.windows import has_open_windows, solve_with_windows
from fecontact.solvers import TOLERANCE, CustomSolver
from fecontact.surfaces.facet_surface import has_cells

#: Share of the time of a solution above which what happened before its last solve is listed.
NOTICED = 0.05


@spelled
def solve_scene(
    model: SceneModel,
    forces: Mapping[object, ArrayLike] | None = None,
    *,
    moments: Mapping[Body, ArrayLike] | None = None,
    motions: Mapping[Body, Mapping[str, float]] | None = None,
    free: Mapping[Body, str] | None = None,
    pressures: Mapping[tuple[Body, str], Distribution] | None = None,
    tractions: Mapping[tuple[Body, str], Distribution] | None = None,
    displacements: Mapping[Any, Distribution] | None = None,
    temperatures: Mapping[Body, Distribution] | None = None,
    gravity: ArrayLike | Callable[[Array], ArrayLike] | None = None,
    finite_motion: bool | str = "auto",
    accuracy: float | Mapping[str, float] | None = None,
    max_dofs: int | None = None,
    max_seconds: float | None = None,
    solver: str | CustomSolver = "auto",
    tolerance: float = TOLERANCE,
    search: str = "global",
    engine: str = "own",
    ranks: int | None = None,
    progress: bool | None = None,
    max_iterations: int | None = None,
    options: Mapping[str, object] | None = None,
) -> ContactResult:
    """Solve the contact problem; with friction, one load step from the unloaded state.

    Parameters
    ----------
    model : SceneModel
        The scene; as its method `Scene.solve`, the scene itself.
    forces : mapping, optional
        Force (3,) in world axes on a body as a whole; on one of its boundaries with the key ``(body, "boundary")``,
        uniform over it; or at a point in its own axes with ``(body, (x, y, z))``: a node, or any point of the frame
        of its supports. A force on the body as a whole frees the frame along itself and holds it across; a
        component that no contact resists is refused. At a point of a rigid body a force acts as through a ball
        joint: the body may also rotate about the point.
    moments : mapping of Body to (3,), optional
        Moments about the body's reference point (its centre of mass).
    motions : mapping of Body to {component: value}, optional
        Prescribed rigid components out of x, y, z, rx, ry, rz.
    free : mapping of Body to str, optional
        Components to free although supports resist them, such as ``"rx ry"``.
    pressures : mapping of (Body, boundary) to float, callable or array, optional
        Pressures against boundaries: a number, a function of points (n, 3) in the body's axes, or values at the
        boundary's nodes, in the order of ``mesh.boundary_nodes(name)``.
    tractions : mapping of (Body, boundary) to (3,), callable or (n_nodes, 3) array, optional
        Forces per area, in world axes, given likewise; a function returns (n, 3).
    displacements : mapping, optional
        Displacement (3,) in world axes of a supported boundary with the key ``(body, "boundary")``, beside that of the
        body's frame, also as a function of points (n, 3) in the body's axes, or at the boundary's nodes; along what the
        support holds. With the key ``body`` the values (m,) of its linear conditions.
    temperatures : mapping of Body to float, callable or (n_points,) array, optional
        Change of temperature of an elastic body since it was without stress: a number, a function of points (n, 3) in
        its axes, or values at the points of its mesh. Its materials need a coefficient of expansion.
    gravity : (3,) or callable, optional
        Acceleration in world axes; bodies need densities. A function of points (n, 3) in the world gives other forces
        per mass (n, 3), such as those of a rotation.
    finite_motion : {'auto', True, False}
        Whether rigid motions are finite. True: poses are updated until they change by at most 1e-4 of the elastic
        displacements, and prescribed motions are finite (rotation vectors). False: motions are small and linearised.
        'auto': poses are updated while linearised motions change gaps or lines of action by more than 1e-3 of the
        approach (see `linearisation`).
    accuracy : float or mapping of str to float, optional
        Relative error of the contact pressure (L2), and of the tractions of friction, to reach, such as 0.02: meshes
        of elastic bodies are divided where they need it, until the estimated errors are within it. By name it is that
        of 'pressure', 'peak', 'area', 'force', 'approach' or 'tilt', such as ``{"pressure": 0.02, "force": 0.01}``;
        a warning names other figures that are worse. The fields belong to the divided bodies, `result.solved(body)`;
        `result.convergence` has the steps. Without it the meshes stay as they are.
    max_dofs, max_seconds : int and float, optional
        Limits of the way there. The result is then the best one, and says what stopped it.
    solver : str or callable
        'auto', one of `available_solvers()`, or a function ``solver(problem, **options)`` that returns the forces
        and motions (forces, q) of a `solvers.ContactProblem`; see docs/extending.md.
    tolerance : float
        Tolerance of the certificate, see `solvers.Residuals`.
    search : {'global', 'local'}
        'global' pairs whole surfaces, 'local' only the parts that may touch. The latter takes a fraction of the
        time and gives the same forces (see `contact.search_region`), without gaps elsewhere. It is the default of
        cases of a sweep.
    engine : {'own', 'petsc'}
        Where the stiffness of elastic bodies is assembled and solved: in this process, or with processes under MPI by
        PETSc, for models that one process cannot hold or is too slow for; see docs/scale.md.
    ranks : int, optional
        Number of processes of the engine 'petsc'; by default one per processor.
    progress : bool, optional
        Whether to show the stages on standard error while they last; by default where that is a terminal.
    max_iterations : int, optional
        Of the solver; it has its own limit unless given.
    options : mapping of str to object, optional
        What else the solver takes: keywords of a function, ``settings`` of a back-end, see `solvers.solve`.

    Returns
    -------
    ContactResult

    Raises
    ------
    InputError, SupportError, SolverError
        The message says what was found, what was expected and what to do.
    """
    step = LoadStep.of(
        {
            "forces": forces, "moments": moments, "motions": motions, "free": free, "pressures": pressures,
            "tractions": tractions, "displacements": displacements, "temperatures": temperatures, "gravity": gravity,
        }
    )  # fmt: skip
    settings = Settings(solver, tolerance, solver_options(max_iterations, options), search, finite_motion)
    settings.check()
    refuse_with_laws(model, search=search, finite_motion=finite_motion, engine=engine)
    elsewhere: AbstractContextManager[object] = nullcontext()
    among("engine", engine, ENGINES)
    if engine != "own" or ranks is not None:
        elsewhere = on_processes(model, check_engine(model, engine, ranks, accuracy, solver))
    if model.has_friction:
        refuse_with_friction(model, solver)
        settings = replace(settings, finite_motion=finite_motion is True, search="global")
    refuse_limits_alone(accuracy, max_dofs, max_seconds)
    started = time.perf_counter()
    with progress_line("solve", progress), elsewhere:
        if accuracy is None:
            result = _solve_known(settings, model, step, ())
        else:
            step.refuse_nodal_values()
            target = Target(accuracy, max_dofs, max_seconds)
            result = solve_to_accuracy(model, step, target, partial(_solve_known, settings))
    return _timed(result, time.perf_counter() - started)


def _timed(result: ContactResult, elapsed: float) -> ContactResult:
    """A result with the wall time of its whole solution; what its last solve does not account for comes first.

    These are earlier poses of a finite motion, earlier meshes on the way to an accuracy, and estimates.
    """
    stages = {stage: seconds for stage, seconds in result.seconds.items() if stage != "total"}
    rest = elapsed - sum(stages.values())
    before = {"before": rest} if rest > NOTICED * elapsed else {}
    return replace(result, seconds={**before, **stages, "total": elapsed})


def refuse_limits_alone(accuracy: object, max_dofs: object, max_seconds: object) -> None:
    """Refuse limits of the way to an accuracy without one.

    Raises
    ------
    InputError
    """
    if accuracy is None and (max_dofs is not None or max_seconds is not None):
        raise InputError(
            "max_dofs and max_seconds limit the way to an accuracy: give accuracy=, such as 0.02, too.",
            code="limit-without-accuracy",
        )


def refuse_with_friction(model: SceneModel, solver: str | CustomSolver) -> None:
    """Refuse what is not offered with friction.

    Raises
    ------
    InputError
    """
    if solver != "auto":
        raise InputError(f"Friction has a solver of its own: leave solver out; found solver={solver!r}.", code="solver")
    for body in {b for c in model.contacts if c.mu > 0 for b in c.bodies}:
        surface = body.surface(body.contact[0])
        if body._is_foundation or (has_cells(surface) and not is_half_space(surface)):
            raise InputError(
                f"{body.name!r} gives along its normal only, so friction on it has no slip to judge. Give an elastic "
                "body or a half-space.",
                code="friction-normal-only",
            )


def _solve_known(
    settings: Settings,
    model: SceneModel,
    step: LoadStep,
    known: Sequence[KnownContact | None],
    poses: Sequence[Pose] = (),
) -> ContactResult:
    """One solution, from contacts and final poses of a similar case."""
    if has_open_windows(model):
        return solve_with_windows(model, step, partial(_solve_known, settings))
    finite, timer = settings.finite_motion, Stopwatch()
    if is_nonlinear(model):
        return solve_at_finite_strain(model, step, settings, timer)
    set_part(f"{sum(body.n_dofs for body in model.bodies)} dofs")
    if finite is True:
        return solve_finite(model, step, settings, timer, poses)
    if finite == "auto" and poses and (found := follow_from(model, step, settings, timer, poses)) is not None:
        return check_rest(found)
    loading = step.on(model.bodies)
    if settings.search == "global":
        result = solved(model, loading, None, settings, timer, known)
    else:
        result = solve_local(model, loading, settings, timer)
    return check_rest(follow(result, step, settings, timer) if finite == "auto" else result)
