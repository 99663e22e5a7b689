"""Export of a contact problem to a neutral file for other engines: stiffnesses, couplings, gaps, rigid modes.

The file is NumPy's .npz: a zip archive of plain arrays. `docs/neutral-file.md` defines them, and
`examples/petsc/solve.py` is an engine that needs nothing else.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable, replacing
from fecontact.contact.condensed_problem import check_balance, uncondensed
from fecontact.contact.loads import LoadStep
from fecontact.contact.model import SceneModel
from fecontact.scene.linear import prepared

#: Version of the file format.
VERSION = 1


def export_problem(
    scene: SceneModel,
    path: str | Path,
    forces: Any = None,
    *,
    moments: Any = None,
    motions: Any = None,
    free: Any = None,
    pressures: Any = None,
    tractions: Any = None,
    displacements: Any = None,
    temperatures: Any = None,
    gravity: Any = None,
    likely: bool = False,
) -> Path:
    """Write the problem that `Scene.solve` would solve, without factorisation.

    Parameters
    ----------
    scene : SceneModel
        Scene of elastic and rigid bodies.
    path : str or Path
        Ends in ``.npz``.
    forces, moments, motions, free, pressures, tractions, displacements, temperatures, gravity
        As in `Scene.solve`.
    likely : bool
        Whether to write only pairs that are likely to touch; the others must then be checked afterwards.

    Raises
    ------
    InputError
        For other kinds of bodies, a body held by its mean position, another suffix, or a path that cannot be written.
    SupportError
        If no contact forces can balance the load.

    Examples
    --------
    >>> import tempfile, fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = export_problem(scene, f"{folder}/block.npz", motions={body: {"z": -0.01}})
    ...     int(np.load(path)["n_bodies"])
    1
    """
    path = check_writable(path)
    if path.suffix.lower() != ".npz":
        raise InputError(f"A problem is written to a .npz file; found {path.name!r}.", code="not-npz")
    if scene.has_friction:
        raise InputError("The file has no place for friction: leave it out of the contacts, or use Scene.solve.")
    for body in scene.bodies:
        if not (body.is_rigid or elastic_among([body])):
            raise InputError(f"{body.name!r} is a {type(body).__name__}, which has no stiffness matrix to write.")
    loads = {
        "forces": forces, "moments": moments, "motions": motions, "free": free, "pressures": pressures,
        "tractions": tractions, "displacements": displacements, "temperatures": temperatures, "gravity": gravity,
    }  # fmt: skip
    loading = LoadStep.of(loads).on(scene.bodies)
    conditions, opening, chosen = prepared(scene, loading)
    check_balance(conditions, loading)
    if not likely:
        chosen = [np.arange(len(gap)) for gap in opening]
    bare = uncondensed(scene.bodies, conditions, chosen, loading)
    ends = np.cumsum([0] + [len(c) for c in chosen])
    arrays: dict[str, NDArray[Any]] = {
        "version": np.array(VERSION),
        "gap": bare.g,
        "own_compliance": bare.own,
        "equilibrium": bare.B,
        "load": bare.F,
        "condition": np.repeat(np.arange(len(chosen)), np.diff(ends)),
        "pair": np.concatenate(chosen),
    }
    count = 0
    for part in bare.parts:
        if part.hold is not None:
            raise InputError(
                f"{part.body.name!r} floats and is held by its mean position, which the file has no place for; "
                "support it, or leave the motion free."
            )
        for body in elastic_among([part.body]):
            arrays |= {f"body{count}_{key}": value for key, value in _elastic(body, part).items()}
            count += 1
    arrays["n_bodies"] = np.array(count)
    with replacing(path) as partial, partial.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)
    return path


def _elastic(body: ElasticBody, part: Any) -> dict[str, NDArray[Any]]:
    """Arrays of one elastic body over its solved degrees of freedom."""
    model = body.model
    upper = model.solved_stiffness()
    K = sp.csr_matrix(upper + sp.triu(upper, 1).T)
    K.sort_indices()
    rows = model.solved_rows(part.rows)
    loads = np.zeros(model.n_dofs) if part.loads is None else part.loads
    return {
        "name": np.array(body.name),
        "dofs": model.solved_dofs,
        "points": model.mesh.points,
        "stiffness_data": K.data,
        "stiffness_indices": K.indices.astype(np.int64),
        "stiffness_indptr": K.indptr.astype(np.int64),
        "coupling_data": rows.data,
        "coupling_indices": rows.indices.astype(np.int64),
        "coupling_indptr": rows.indptr.astype(np.int64),
        "coupling_rows": part.index,
        "loads": model.solved_forces(loads),
        "rigid_modes": model.nodal_modes[model.solved_dofs],
    }
