"""Rigid motions that supports leave free, which friction holds or nothing does."""

from __future__ import annotations

import numpy as np

from fecontact.ancf.system.assembly import Assembly
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError

#: Share of a rigid motion that supports resist, below which it is free.
FREE = 1e-8
#: Motion of a combination of rigid motions, relative to each of them, that is rounding.
STILL = 1e-12


def free_motions(a: Assembly, q: Array) -> Array:
    """Rigid motions of the solids at coordinates q that are free.

    Parameters
    ----------
    a : Assembly
    q : (n_dofs,) array

    Returns
    -------
    (n_free, k) array
        Independent, of about unit length, in the free directions of the assembly.
    """
    out = [np.zeros((a.free.shape[1], 0))]
    for k in _held_by_friction(a):
        rows = slice(a.starts[k], a.starts[k + 1])
        modes, block = _modes(a, q, k), a.free[rows]
        _, singular, V = np.linalg.svd(_resisted(a, modes, k), full_matrices=False)
        out.append(block.T @ (modes @ V[singular < FREE].T))
    return np.concatenate(out, axis=1)


def _modes(a: Assembly, q: Array, k: int) -> Array:
    """Translations of a solid and its turns about the mean of its present coordinates, columns of unit size.

    The coordinates of what can touch are vectors that turn with it.
    """
    solid, own = a.solids[k], a.part(q, k)
    shifts = np.stack([solid.translation(e) for e in np.eye(3)], axis=1)
    middle = (own @ shifts) / (shifts**2).sum(axis=0)
    arms = (own - shifts @ middle).reshape(-1, 3)
    modes = np.concatenate([shifts, np.stack([np.cross(e, arms).ravel() for e in np.eye(3)], axis=1)], axis=1)
    return _sized(a, modes, k)


def _sized(a: Assembly, modes: Array, k: int) -> Array:
    """Independent combinations of modes (n_dofs, 6) of a solid, of unit length, without what does not move it."""
    lengths = a.lengths[a.starts[k] : a.starts[k + 1], None]
    size = np.linalg.norm(lengths * modes, axis=0)
    # a straight line does not turn about itself, whichever way it lies
    modes = modes[:, size > STILL * size.max()] / size[size > STILL * size.max()]
    _, singular, V = np.linalg.svd(lengths * modes, full_matrices=False)
    moving = singular > STILL
    return np.asarray(modes @ V[moving].T / singular[moving])


def _resisted(a: Assembly, modes: Array, k: int) -> Array:
    """The part of a solid's modes that supports resist, as lengths."""
    rows = slice(a.starts[k], a.starts[k + 1])
    block = a.free[rows]
    return np.asarray(a.lengths[rows, None] * (modes - block @ (block.T @ modes)))


def _held_by_friction(a: Assembly) -> list[int]:
    """Numbers of the solids in contacts with friction."""
    starts = {start for t in a.constraints if t.friction for start in (t.slave_start, t.master_start)}
    return [k for k, start in enumerate(a.starts[:-1]) if start in starts]


def check_supports(a: Assembly) -> bool:
    """Whether supports leave a rigid motion free, for friction to hold it.

    Raises
    ------
    InputError
        If a solid without friction is free, or any with friction beside rigid hubs; names the solid and its number of
        free rigid motions.
    """
    free, rubbing = False, _held_by_friction(a)
    for k, solid in enumerate(a.solids):
        modes = _sized(a, solid.rigid_modes, k)
        loose = int((np.linalg.svd(_resisted(a, modes, k), compute_uv=False) < FREE).sum())
        if loose and k not in rubbing:
            raise InputError(
                f"Solid {k + 1} is free in {loose} rigid motions; statics needs supports against all six, or friction. "
                "Hold more of its boundaries, or follow the motion in time (dynamics).",
                code="free-rigid-motion",
            )
        free = free or loose > 0
    if free and a.hubs is not None:
        raise InputError(
            "Statics with rigid hubs needs supports against all rigid motions of each solid; friction alone holds some "
            "here. Hold more boundaries, or leave the hub as stiff as its material (rigid=()).",
            code="free-rigid-motion",
        )
    return free
