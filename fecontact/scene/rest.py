"""Whether bodies have found rest: motions larger than their scene knows of are refused by name."""

from __future__ import annotations

import numpy as np

from fecontact.common.errors import SupportError
from fecontact.results.result import ContactResult

#: Rotation (radians) and translation (of the largest body, gap and elastic displacement) by which a body that contacts
#: hold at rest can have moved; beyond, nothing but rounding or the corners of facets has stopped it.
LARGEST_TURN, LARGEST_SHIFT = 1.0, 1e3


def check_rest(result: ContactResult) -> ContactResult:
    """The result, unless a body has found no rest within any distance that its scene knows of.

    A load that drives a motion which only rounding or the corners of facets resist (a ring on a round shaft that does
    not match it) has an answer by the algebra: the body turns until a slope of 1e-8 has given way.

    Raises
    ------
    SupportError
        Names the motion in words.
    """
    bodies, frames, state = result.scene.bodies, result.loading.frames, result.state
    sizes = [b.size for b in bodies if not b.is_rigid] or [b.size for b in bodies]
    gaps = np.concatenate([i.gap for i in result.condensed.interfaces])
    known = max(sizes) + float(np.abs(gaps[np.isfinite(gaps)]).max(initial=0.0))
    found = [motion - frame.prescribed for frame, motion in zip(frames, state.motions, strict=True)]
    shifts, turns = np.linalg.norm(np.reshape(found, (-1, 2, 3)), axis=2).T
    if turns.max() <= LARGEST_TURN and shifts.max() <= LARGEST_SHIFT * known:
        return result
    # under a load that deforms the bodies by as much there is a rest, though an absurd one; strains tell of that
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
