"""Solutions on near parts of surfaces: pair what may touch, solve, prove that nothing else can have, or pair more.

What is known of a similar case, the rigid motion and the size of the elastic displacements, tells which parts those
are. It decides the time and never the answer: the proof is that of `fecontact.contact.search.region`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fecontact.common.errors import FecontactError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.loads import Loading, make_loading
from fecontact.contact.model import SceneModel
from fecontact.contact.search.radius import Reach
from fecontact.contact.search.region import STILL
from fecontact.results.result import ContactResult
from fecontact.scene.linear import solved
from fecontact.scene.poses import KEYED
from fecontact.scene.search_radius import first_reach, following, judged
from fecontact.scene.settings import Settings
from fecontact.solvers import TOLERANCE

#: Number of reaches that are tried before whole surfaces are paired.
MOST_REACHES = 4


@dataclass
class Guide:
    """What the last of a row of similar cases asked for, contact by contact; `solve_partly` keeps it up to date."""

    reaches: Sequence[Reach | None] = ()

    def settle(self) -> None:
        """Take the drift as done: the poses have followed it."""
        self.reaches = [None if r is None else replace(r, drift=STILL) for r in self.reaches]


def solve_guided(scene: SceneModel, arguments: Mapping[str, Any], guide: Guide, watch: Stopwatch) -> ContactResult:
    """`Scene.solve` of near parts for one of a row of similar cases; small motions.

    Parameters
    ----------
    scene : SceneModel
    arguments : mapping
        Of `Scene.solve`, except `finite_motion` and `search`.
    guide : Guide
    """
    return solve_partly(scene, *sorted_case(scene, arguments), watch, guide)


def sorted_case(scene: SceneModel, arguments: Mapping[str, Any]) -> tuple[Loading, Settings]:
    """Loads and settings of a case, from the arguments of `Scene.solve` but `finite_motion` and `search`."""
    rest = dict(arguments)
    loads = {name: rest.pop(name, None) for name in (*KEYED, "gravity")}
    settings = Settings(rest.pop("solver", "auto"), rest.pop("tolerance", TOLERANCE), rest)
    settings.check()
    return make_loading(scene.bodies, **loads), settings


def solve_partly(
    scene: SceneModel, loading: Loading, settings: Settings, watch: Stopwatch, guide: Guide | None = None
) -> ContactResult:
    """Solution with only near parts paired, or all where these do not do.

    Parameters
    ----------
    scene : SceneModel
    loading : Loading
    settings : Settings
    watch : Stopwatch
    guide : Guide, optional
        What is known of a similar case; replaced by what is known of this one.
    """
    reaches = [first_reach(c, loading) for c in scene.contacts]
    if guide is not None and guide.reaches:
        reaches = [following(known, first) for known, first in zip(guide.reaches, reaches, strict=True)]
    tries = 0 if all(r is None for r in reaches) else MOST_REACHES
    for _ in range(tries):
        try:
            result = solved(scene, loading, reaches, settings, watch)
        except FecontactError:
            # what was left out may be what carries the load; if not, the whole surfaces say so again
            break
        enough, reaches = judged(result)
        if enough:
            if guide is not None:
                guide.reaches = reaches
            return result
    return solved(scene, loading, None, settings, watch)
