"""Engines: where the stiffness of elastic bodies is assembled and solved.

'own' is this process, by the back-end of each body. 'petsc' shares it between processes under MPI (`fem.petsc`): all
else, pairing, active sets and the certificate, stays here and is the same.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from typing import Any

from fecontact.bodies.elastic import elastic_among
from fecontact.common.checks import among, whole
from fecontact.common.errors import InputError, named
from fecontact.contact.model import SceneModel
from fecontact.fem.condensation import memory_budget
from fecontact.fem.multigrid import Multigrid
from fecontact.fem.petsc.job import Job, SharedFactor, SharedSystem
from fecontact.fem.support import mirrors

ENGINES = ("own", "petsc")
#: Unknowns above which several processes pay off (docs/scale.md).
WORTHWHILE = 300_000


def check_engine(model: SceneModel, engine: str, ranks: int | None, accuracy: object, solver: object) -> int:
    """Number of processes of an engine other than this process.

    Raises
    ------
    InputError
        For a number of processes without one, or what the engine does not offer.
    """
    if engine == "own":
        raise InputError(
            f"ranks={ranks!r} is a number of processes of the engine 'petsc': give engine='petsc', too.",
            code="ranks-without-petsc",
        )
    if ranks is not None:
        whole("the number of ranks", ranks)
    if accuracy is not None:
        raise InputError("The engine 'petsc' does not divide meshes: leave accuracy out and refine the mesh.")
    if why := _refusal(model):
        raise InputError(
            f"The engine 'petsc' is for rigid and elastic bodies without friction: {why}. Leave engine out.",
            code="petsc-cannot",
        )
    if solver != "auto":
        raise InputError(f"The engine 'petsc' has a solver of its own: leave solver out; found {solver!r}.")
    return ranks or os.cpu_count() or 1


def of_cases(model: SceneModel, cases: Mapping[str, Mapping[str, Any]]) -> int | None:
    """Number of processes of the engine of all cases of a sweep; None for this process.

    Raises
    ------
    InputError
        If they have different engines, or for what `check_engine` refuses.
    """
    found = {(case.get("engine", "own"), case.get("ranks")) for case in cases.values()}
    if found <= {("own", None)}:
        return None
    if len(found) > 1:
        raise InputError(
            f"The cases of a sweep share one engine; found {', '.join(sorted(map(str, found)))}. Give all of them the "
            "same engine and ranks.",
            code="engines-differ",
        )
    for name, case in cases.items():
        with named(f"Case {name!r}"):
            among("engine", case.get("engine", "own"), ENGINES)
            asked = (case.get("accuracy"), case.get("solver", "auto"))
            ranks = check_engine(model, case.get("engine", "own"), case.get("ranks"), *asked)
    return ranks


def own_engine(case: Mapping[str, Any]) -> dict[str, Any]:
    """A case whose engine runs already."""
    return {name: value for name, value in case.items() if name not in ("engine", "ranks")}


@contextmanager
def on_processes(model: SceneModel, ranks: int) -> Iterator[Job]:
    """The stiffness of all elastic bodies with `ranks` processes; they end when no result refers to them any more."""
    models = [body.model for body in elastic_among(model.bodies)]
    job = Job(models, ranks)
    before = {id(each): each.condensation for each in models}
    for each in {id(each): each for each in models}.values():
        numbers = [k for k, other in enumerate(models) if other is each]
        why = f"multigrid of PETSc on {ranks} processes has products only"
        planes = mirrors(each.mesh, each.supports)
        each.condensation = Multigrid(SharedFactor(job, numbers), each.solved_positions, planes, SharedSystem, why=why)
    try:
        yield job
    finally:
        for each in models:
            each.condensation = before[id(each)]


@contextmanager
def for_cases(model: SceneModel, ranks: int | None) -> Iterator[None]:
    """Processes of all cases of a sweep, which end with it; none without a number of them."""
    if ranks is None:
        yield
        return
    with on_processes(model, ranks) as job, closing(job):
        yield


def _refusal(model: SceneModel) -> str:
    """Why the engine 'petsc' does not solve a scene; empty if it does."""
    if model.has_friction:
        return "a contact has friction"
    if model.has_overclosure:
        return "a contact is soft"
    by_cells = {id(body) for body in elastic_among(model.bodies) if body.model.by_cells}
    for body in model.bodies:
        if not body.is_rigid and id(body) not in by_cells:
            return f"{body.name!r} is a {type(body).__name__} that is not assembled from a mesh of solids"
    return "" if elastic_among(model.bodies) else "no body is elastic"


def advice(model: SceneModel, n_dofs: int, memory: float) -> str:
    """What to solve a large model with; empty for others.

    Parameters
    ----------
    model : SceneModel
    n_dofs : int
        Unknowns of all elastic bodies.
    memory : float
        MB that their factors need.
    """
    if n_dofs < WORTHWHILE and memory < memory_budget() / 1e6:
        return ""
    if why := _refusal(model):
        return f"own: {why}"
    return "backend='amg' of the bodies needs less memory than a factor; engine='petsc' shares it between processes"
