"""Stability of an equilibrium at finite strain, with the contacts that are closed.

It is stable where the tangent K of all bodies is positive definite on the motions v that keep closed gaps closed and
sticking points in place, G v = 0: where H = K + w G^T G is, with stiff springs w (Nocedal & Wright, Numerical
Optimization, 2nd ed. 2006, section 17.3). The weakest motion is the lowest v of H v = s H0 v, H0 being H of the present
shape without stress, with the moduli at rest, so that s does not tell how far a material is from incompressible.
Its stiffness s is 1 at rest and 0 at a critical point (Wriggers, Nonlinear Finite Element Methods, 2008, chapter 7).

How normals turn under the pressure of a contact is in K as in Newton's method; points that slide are free to.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from fecontact.bodies.elastic import elastic_among
from fecontact.common.arrays import ROUNDING
from fecontact.common.errors import FecontactError, place
from fecontact.fem.factor import factorise, is_definite, symmetric
from fecontact.results.result import ContactResult

#: Springs over the median stiffness of the rows that they hold.
STRENGTH = 1e4
#: Part of a unit vector along an axis from which it is told as along it.
ALONG = 0.95


@dataclass(frozen=True)
class Weakest:
    """The motion that bodies resist least: its stiffness over that at rest, the body and the motion in words."""

    stiffness: float
    body: str
    motion: str


def is_stable(result: ContactResult) -> bool:
    """Whether an equilibrium is stable."""
    tangents, springs = _tangents(result)
    return is_definite(_with(tangents, springs))


def weakest(result: ContactResult) -> Weakest | None:
    """The weakest motion at an equilibrium; None where its stiffness is below -1, far beyond a critical point."""
    tangents, springs = _tangents(result)
    H, H0 = _with(tangents, springs), _with(_tangents(result, unstressed=True)[0], springs)
    try:
        factor = factorise(sp.csr_matrix(H + H0))
    except FecontactError:
        return None
    inverse = spla.LinearOperator(H.shape, lambda x: factor.solve(x.reshape(1, -1))[0], dtype=float)
    begin = np.random.default_rng(0).uniform(-1.0, 1.0, H.shape[0])
    stiffness, found = spla.eigsh(symmetric(H), 1, symmetric(H0), -1.0, OPinv=inverse, v0=begin, tol=1e-6)
    largest, start = 0.0, 0
    for part in result._condensed.parts:
        for body in elastic_among([part.body]):
            n = len(body.model.solved_dofs)
            u = body.model.at_points(body.model.displacements(found[start : start + n, 0])) @ body.pose.rotation.T
            start += n
            length = np.linalg.norm(u, axis=1)
            if length.max() > largest:
                largest, most = float(length.max()), int(length.argmax())
                along = np.linalg.svd(u, full_matrices=False)[2][0]
                at = body.pose.to_world(body.mesh.points[most])
                at[np.abs(at) < ROUNDING * body.size] = 0.0
                axis = "xyz"[int(np.abs(along).argmax())] if np.abs(along).max() > ALONG else place(along)
                name, motion = body.name, f"a motion along {axis}, largest at {place(at)}"
    return Weakest(float(stiffness[0]), name, motion) if largest else None


def not_found_beyond(last: Weakest, share: float) -> str:
    """Why no equilibrium was found beyond a share of a load step, by the weakest motion there."""
    return (
        f"{last.body!r} is not stable beyond {share:.1%} of the load step: its stiffness against {last.motion}, has "
        f"fallen to {last.stiffness:.1%} of that at rest, and no equilibrium was found beyond. Support it against this "
        "motion, load it less, or give motions in place of forces to follow a snap."
    )


def not_stable(before: Weakest | None, now: Weakest | None, part: tuple[float, float]) -> str:
    """What an equilibrium is that is not stable, by the weakest motions at both ends of a part of a step."""
    if now is None:
        return "The bodies are not stable, by far: support them, or load them less."
    start = 1.0 if before is None else before.stiffness
    share = part[0] + (part[1] - part[0]) * start / (start - now.stiffness)
    since = f" from about {share:.1%} of the load step on" if start > 0 else ""
    return (
        f"{now.body!r} is not stable{since}: its stiffness against {now.motion}, is {now.stiffness:.1%} of that at "
        "rest. It leaves this equilibrium at the least disturbance: support it against this motion, or load it less."
    )


def _tangents(result: ContactResult, unstressed: bool = False) -> tuple[list[sp.csr_matrix], sp.csr_matrix]:
    """Tangents of the bodies with a mesh, and w G^T G over these and free motions that closed gaps resist."""
    bare, closed = result._condensed.bare, result._condensed.closed
    assert bare is not None
    assert closed is not None
    taut = (bare.own > 0) & ((result.friction or result.solution).forces > 0)
    used = np.flatnonzero(closed | taut)
    tangents, rows, compliance = [], [], np.zeros(len(used))
    for part in bare.parts:
        for body in elastic_among([part.body]):
            model = body.model.unstressed() if unstressed else body.model
            K, own = model.solved_stiffness(), sp.eye_array(len(closed), format="csc")[:, part.index]
            rows.append(sp.csr_matrix(own @ model.solved_rows(part.rows))[used])
            tangents.append(K)
            compliance += rows[-1].multiply(rows[-1]) @ (1 / np.abs(K.diagonal()))
    opening = bare.B[:, used].T
    _, singular, motions = np.linalg.svd(opening, full_matrices=False)
    opening = opening @ motions[singular > ROUNDING * singular.max(initial=0.0)].T
    G = sp.hstack([*rows, sp.csr_matrix(opening)], format="csr")
    w = np.full(len(used), STRENGTH / float(np.median(compliance)) if len(used) else 0.0)
    w[taut[used]] = 1 / bare.own[used][taut[used]]
    return tangents, sp.csr_matrix(sp.triu(G.T @ sp.diags_array(w) @ G))


def _with(tangents: list[sp.csr_matrix], springs: sp.csr_matrix) -> sp.csr_matrix:
    """Upper triangle of H."""
    free = springs.shape[0] - sum(K.shape[0] for K in tangents)
    return sp.csr_matrix(sp.block_diag([*tangents, sp.csr_matrix((free, free))]) + springs)
