"""Check that bodies are in equilibrium: motions larger than any length of their scene are refused."""

from __future__ import annotations

import numpy as np

from fecontact.common.errors import SupportError
from fecontact.results.result import ContactResult

#: Largest rotation (radians) and translation (relative to the largest body, gap and elastic displacement) of a body
#: held by contacts; a larger motion was resisted by rounding or the corners of facets only.
LARGEST_TURN, LARGEST_SHIFT = 1.0, 1e3


def check_rest(result: ContactResult) -> ContactResult:
    """The result; refused if a body moved further than any length of its scene.

    A load along a motion resisted only by rounding or the corners of facets (a ring on a round shaft with a
    non-matching mesh) has an algebraic solution: the body rotates until a slope of 1e-8 balances the load.

    Raises
    ------
    SupportError
        Describes the motion.
    """
    frames, state = result.loading.frames, result.state
    sizes = result.scene.sizes
    gaps = np.concatenate([i.gap for i in result.condensed.interfaces])
    known = max(sizes) + float(np.abs(gaps[np.isfinite(gaps)]).max(initial=0.0))
    found = [motion - frame.prescribed for frame, motion in zip(frames, state.motions, strict=True)]
    shifts, turns = np.linalg.norm(np.reshape(found, (-1, 2, 3)), axis=2).T
    if turns.max() <= LARGEST_TURN and shifts.max() <= LARGEST_SHIFT * known:
        return result
    # a load that deforms the bodies by as much has an equilibrium, if an absurd one; strains are warned of
    rest = [u - f.modes(m[:, None])[:, 0] for u, f, m in zip(state.displacements, frames, state.motions, strict=True)]
    elastic = max(float(np.abs(r).max(initial=0.0)) for r in rest)
    texts = []
    for frame, motion, turn, shift in zip(frames, found, turns, shifts, strict=True):
        if turn > LARGEST_TURN * max(1.0, elastic / max(sizes)):
            texts.append(f"{frame.describe(motion)}, by {turn:.3g} rad")
        elif shift > LARGEST_SHIFT * max(known, elastic):
            texts.append(f"{frame.describe(motion)}, by {shift:.3g}")
    if not texts:
        return result
    raise SupportError(
        "The load drives a motion that nothing resists but rounding or the corners of facets; what was found is no "
        f"rest - {'; '.join(texts)}. Support the body in that motion, prescribe it with motions=, change the load, or "
        "start nearer to the rest that finite_motion=True is to find."
    )
