"""Newton's step of poses: the motion of a linearised problem, and what it would ask for next.

A problem of small motions keeps the lines of action m of its points. Moved on by p, so that the bodies shift by
d = u_s - u_m against each other, the lines turn by (see `contact.turning` for the derivative H of the master's normals
n by position)

    Dm = (1 - s) [t_m x n + H d] + s t_s x n,   less its part along n,

with the rotations t of slave and master and the share s of the slave's normal in the lines (`surfaces.normals`), and
gaps along them change by d.n / (m.n), as the foot of each point moves across n, and not by d.m. The forces f of the
points then balance the load no longer, by K p = sum f Dm . (v_s - v_m) for the free motions v of the bodies. Closed
points answer by the changes l of forces and the motions q

    S l + E p + B^T q = 0,   B l + K p = 0,   E p = d.n / (m.n) - d.m.

So the next problem asks for A p = q, and all of them together lead to (1 - A)^-1 p, Newton's step (Nocedal & Wright,
Numerical Optimization, 2nd ed. 2006, section 11.1). Where A is not well below one, the equilibrium may not be stable,
and steps are left as they are; so are those of compliances that are products, of which no equations are solved.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from fecontact.common.arrays import Array, IntArray
from fecontact.contact.coupling.choose import line_share
from fecontact.contact.interface import Interface
from fecontact.contact.turning import normal_gradients
from fecontact.mesh.facets import unit_vectors
from fecontact.results.contact_fields import ContactFields
from fecontact.results.result import ContactResult
from fecontact.surfaces.facet_surface import has_cells

#: Largest eigenvalue of A from which on, and up to which, it is taken into account: less leaves a hundredth at a step.
SMALLEST, LARGEST = 0.01, 0.7
#: Stiffness against a motion, relative to the largest, up to which no contact resists it.
UNRESISTED = 1e-8


def newton_step(result: ContactResult, steps: Array) -> Array:
    """Steps (n_bodies, 6) of the poses, from those by which a result without friction moves the bodies.

    Parameters
    ----------
    result : ContactResult
    steps : (n_bodies, 6) array
        Translations, and rotations about the reference points.
    """
    condensed, forces = result._condensed, result.solution.forces
    problem, closed = condensed.problem, forces > 0
    if condensed.by_products or result.friction is not None or not len(problem.B) or not closed.any():
        return steps
    bodies = [part.body for part in condensed.parts]
    K, E, start = np.zeros((len(bodies), 6, len(bodies), 6)), np.zeros((len(forces), len(bodies), 6)), 0
    for interface, contact in zip(result._interfaces, result.contacts, strict=True):
        rows = start + np.flatnonzero(closed[start : start + len(contact._candidates)])
        if len(rows):
            if has_cells(interface.slave_surface):
                return steps
            both = [next(k for k, b in enumerate(bodies) if b is body) for body in (interface.slave, interface.master)]
            points = [condensed.parts[k].frame.point for k in both]
            turn, drive, missed = _turning(interface, contact, contact._candidates[rows - start], *points)
            K[np.ix_(both, range(6), both)] += np.einsum("niaj,nibk->ajbk", drive, turn)
            E[rows[:, None], both] = missed
        start += len(contact._candidates)
    free = scipy.linalg.block_diag(*(part.free for part in condensed.parts))
    B, missed_gaps = problem.B[:, closed], E[closed].reshape(int(closed.sum()), -1)
    try:
        stiff = np.linalg.solve(np.asarray(problem.S)[np.ix_(closed, closed)], np.hstack([B.T, missed_gaps]))
    except np.linalg.LinAlgError:
        return steps
    resisted, shifted = np.split(B @ stiff, [len(B)], axis=1)
    A = np.linalg.pinv(resisted, rcond=UNRESISTED, hermitian=True) @ (free.T @ K.reshape(len(free), -1) - shifted)
    own = A @ free
    if not SMALLEST <= np.abs(np.linalg.eigvals(own)).max() <= LARGEST:
        return steps
    more = np.linalg.solve(np.eye(len(own)) - own, A @ steps.ravel())
    return np.asarray(steps + (free @ more).reshape(steps.shape))


def _turning(
    interface: Interface, contact: ContactFields, pressed: IntArray, about: Array, other: Array
) -> tuple[Array, Array, Array]:
    """Turns (n, 3, 2, 6) of the forces of points (n,) by motions of both bodies, what drives them, gaps (n, 2, 6)."""
    x, pose = contact._centres[pressed], interface.master.pose
    surface = interface.master.surface(interface.surfaces[1])
    foot = surface.project(pose.to_body(x))
    R, n = pose.rotation, foot.normals @ pose.rotation.T
    H = R @ normal_gradients(surface, foot, interface.master.size) @ R.T
    drive = np.stack([_modes(x - about), -_modes(pose.to_world(foot.points) - other)], axis=2)
    share = line_share(interface.slave, interface.master)
    turn = (1 - share) * np.einsum("nij,njak->niak", H, drive)
    across = -_modes(n)[:, :, 3:]  # t x n, of turns t
    turn[:, :, 0, 3:] += share * across
    turn[:, :, 1, 3:] += (1 - share) * across
    turn -= np.einsum("ni,nj,njak->niak", n, n, turn)
    lines = unit_vectors(contact.normals[pressed])
    slope = n / np.einsum("ni,ni->n", n, lines)[:, None] - lines
    missed = np.einsum("ni,niak->nak", slope, drive)
    return contact.forces[pressed, None, None, None] * turn, drive, missed


def _modes(arms: Array) -> Array:
    """Displacements (n, 3, 6) at arms (n, 3) by unit translations and rotations."""
    x, y, z = arms.T
    o = np.zeros_like(x)
    turns = np.array([[o, z, -y], [-z, o, x], [y, -x, o]])
    return np.concatenate([np.tile(np.eye(3), (len(arms), 1, 1)), turns.transpose(2, 0, 1)], axis=2)
