"""Checks whether contact forces can balance the loads, before condensation, and error messages."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.optimize
import scipy.sparse as sp

from fecontact.common.arrays import Array
from fecontact.common.errors import SupportError
from fecontact.contact.interface import UnilateralConstraints
from fecontact.contact.loads import Loading

#: Share of the largest opening by a unit motion up to which contacts do not resist a motion (flat facets from files
#: have seven digits), and share of a load allowed in such a motion.
UNRESISTED, SWALLOWED = 1e-6, 1e-5


def opening_by_motions(rows: sp.csr_matrix, modes: Array, rounding: float) -> Array:
    """Opening (n, k) by rigid motions with fields (n_dofs, k), with rounding set to zero, see `Loading.rounding`.

    A motion without opening is usually a combination of components, such as sliding along an oblique plane. Singular
    vectors find it in any axes, so that the result does not change with a rotation of the scene.
    """
    opening = np.asarray(rows @ modes)
    if not opening.any():
        return opening
    largest = abs(rows).sum(axis=1).max() * np.abs(modes).max(axis=0)
    largest[largest == 0] = 1.0
    n, m = opening.shape
    _, singular, Vt = np.linalg.svd(np.linalg.qr(opening / largest, mode="r"))
    none = np.concatenate([singular, np.zeros(m - len(singular))]) < rounding * np.sqrt(n)
    if none.any():
        opening -= ((opening / largest) @ Vt[none].T) @ Vt[none] * largest
    opening[np.abs(opening) < rounding * largest] = 0.0
    return opening


def check_balance(interfaces: Sequence[UnilateralConstraints], loading: Loading) -> None:
    """Refuse loads that no contact forces can balance, before anything is condensed.

    By Farkas' lemma either B l = F has a solution l >= 0, or the load does work along a rigid motion that closes no
    gap; non-negative least squares finds one or the other.

    Raises
    ------
    SupportError
        Describes the motion.
    """
    blocks, load = [], []
    _check_across(interfaces, loading)
    for k, frame in enumerate(loading.frames):
        if frame.free.shape[1] == 0:
            continue
        modes = frame.modes(frame.free)
        parts = [i.rows(frame.body) for i in interfaces]
        columns = [
            np.zeros((len(i.gap), modes.shape[1])) if r is None else opening_by_motions(r, modes, loading.rounding)
            for i, r in zip(interfaces, parts, strict=True)
        ]
        columns += [-c for i, c in zip(interfaces, columns, strict=True) if i.two_sided]
        blocks.append(np.concatenate(columns).T)
        load.append(-loading.driving(k, frame.free))
    if not blocks:
        return
    B, F = np.concatenate(blocks), np.concatenate(load)
    scale = np.abs(B).max(axis=1, initial=0.0)
    # a zero row is compared with the others, in their units
    scale[scale == 0] = scale.max() or 1.0
    if not F.any():
        return
    B, F = B / scale[:, None], F / scale
    forces, rest = scipy.optimize.nnls(B, F, maxiter=50 * sum(B.shape))
    if rest <= 1e-8 * np.linalg.norm(F):
        return
    raise unbalanced(motion_texts((B @ forces - F) / scale, loading), interfaces)


def motion_texts(direction: Array, loading: Loading) -> list[str]:
    """A motion (m,) of the free rigid components, body by body in words."""
    texts, start = [], 0
    for frame in loading.frames:
        part = direction[start : start + frame.free.shape[1]]
        start += len(part)
        arm = np.array([1.0] * 3 + [frame.body.size] * 3)
        motion = frame.free @ part
        if np.linalg.norm(arm * motion) > 1e-6 * np.linalg.norm(direction):
            texts.append(frame.describe(motion))
    return texts


def unbalanced(texts: Sequence[str], interfaces: Sequence[UnilateralConstraints]) -> SupportError:
    """Error that describes the motions without resistance."""
    return SupportError(
        "No contact forces can balance the load; it drives a motion that nothing resists - "
        + "; ".join(texts)
        + ". "
        + "".join(i.infeasibility_hint for i in interfaces if i.infeasibility_hint)
        + "Support the body in that motion, prescribe it with motions=, or change the load."
    )


def _check_across(interfaces: Sequence[UnilateralConstraints], loading: Loading) -> None:
    """Refuse a load on a body as a whole with a component in which no contact resists the body.

    The body moves along the load only and is held across it. On a frictionless floor, a load of 10 sideways and 1
    downwards would thus act like a wedge with a contact force of 101. Resistance is judged by the contacts' lines of
    action, so that the result does not change with a rotation of the scene.

    Raises
    ------
    SupportError
        Describes the component as a motion.
    """
    texts = []
    for frame in loading.frames:
        if not frame.load.any():
            continue
        rows = [r for i in interfaces if (r := i.rows(frame.body)) is not None]
        modes = frame.modes(np.eye(6))
        opening = np.concatenate([np.zeros((0, 6)), *(r @ modes for r in rows)])
        for kind in (range(3), range(3, 6)):
            left = [c for c in kind if c not in frame.prescribed_components]
            if not frame.load[left].any():
                continue
            _, singular, Vt = np.linalg.svd(np.linalg.qr(opening[:, left], mode="r"))
            resisting = int((singular > UNRESISTED * singular.max(initial=0.0)).sum())
            swallowed = Vt[resisting:].T @ (Vt[resisting:] @ frame.load[left])
            # directions of faces are known to `UNRESISTED`, and turn what is free by as much over the least resistance
            slope = singular[resisting - 1] / singular[0] if resisting else 1.0
            share = SWALLOWED + UNRESISTED * (1 / slope - 1)
            if np.linalg.norm(swallowed) > share * np.linalg.norm(frame.load[left]):
                motion = np.zeros(6)
                motion[left] = swallowed
                texts.append(frame.describe(motion))
    if texts:
        raise unbalanced(texts, interfaces)
