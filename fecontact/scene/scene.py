"""Scene: bodies and the contacts between them, with methods to solve and sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from fecontact.bodies.protocol import Body
from fecontact.contact.model import SceneModel
from fecontact.results.result import ContactResult
from fecontact.scene.solve import solve_scene
from fecontact.scene.sweep import run_sweep
from fecontact.solvers import TOLERANCE, CustomSolver


@dataclass(frozen=True, eq=False)
class Scene(SceneModel):
    """Bodies and the contacts between them.

    Parameters
    ----------
    bodies : sequence of Body
    contacts : sequence of Contact
    springs : sequence of Spring, optional
        Springs and ligaments.

    Raises
    ------
    InputError
        For repeated or missing bodies, or no contact.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    >>> result = scene.solve(motions={body: {"z": -0.01}})
    >>> round(float(result.contacts[0].force[2]), 12)
    0.01
    """

    def solve(
        self,
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
        """Solve the frictionless contact problem.

        Parameters
        ----------
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
        pressures : mapping of (Body, boundary) to float, optional
            Pressures against boundaries.
        gravity : (3,), optional
            Acceleration; bodies need densities.
        finite_motion : {'auto', True, False}
            Whether rigid motions are finite. True: poses are updated until they converge, and prescribed motions are
            finite (rotation vectors). False: motions are small and linearised. 'auto': poses are updated while
            linearised motions change gaps or lines of action by more than 1e-3 of the approach (see `linearisation`).
        accuracy : float, optional
            Relative error of the contact pressure (L2) to reach, such as 0.02: meshes of elastic bodies are divided
            where the pressure needs it, until the estimated error is within it. The fields belong to the divided
            bodies, `result.solved(body)`; `result.convergence` has the steps. Without it the meshes stay as they are.
        max_dofs, max_seconds : int and float, optional
            Limits of the way there. The result is then the best one, and says what stopped it.
        solver : str or callable
            'auto', one of `available_solvers()`, or a function ``solver(problem, **options)`` that returns the forces
            and motions (forces, q) of a `solvers.ComplementarityProblem`; see docs/extending.md.
        tolerance : float
            Tolerance of the certificate, see `solvers.Residuals`.
        search : {'global', 'local'}
            'global' pairs whole surfaces, 'local' only the parts that may touch. The latter takes a fraction of the
            time and gives the same forces (see `contact.search.region`), without gaps elsewhere. It is the default of
            cases of a sweep.
        **options
            Passed to the solver. The former name of ``search``, ``whole=True`` or ``False``, still works and warns.

        Returns
        -------
        ContactResult

        Raises
        ------
        InputError, SupportError, SolverError
            The message says what was found, what was expected and what to do.
        """
        return solve_scene(
            self, forces, moments=moments, motions=motions, free=free, pressures=pressures, gravity=gravity,
            finite_motion=finite_motion, accuracy=accuracy, max_dofs=max_dofs, max_seconds=max_seconds,
            solver=solver, tolerance=tolerance, search=search, **options,
        )  # fmt: skip

    def sweep(
        self,
        cases: Sequence[Mapping[str, Any]],
        path: str | Path | None = None,
        processes: int = 1,
        executor: Executor | None = None,
    ) -> list[dict[str, Any]]:
        """Solve many load cases and poses with one condensation; see `fecontact.scene.sweep.run_sweep`."""
        return run_sweep(self, cases, path, processes, executor)
