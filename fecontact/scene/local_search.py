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
from fecontact.contact.search.radius import SearchRadius
from fecontact.contact.search.region import STILL
from fecontact.results.result import ContactResult
from fecontact.scene.carried import KEYED
from fecontact.scene.linear import solved
from fecontact.scene.search_radius import check_search_region, first_radius, predict_radius
from fecontact.scene.settings import Settings
from fecontact.solvers import TOLERANCE

#: Number of reaches that are tried before whole surfaces are paired.
MOST_REACHES = 4


@dataclass
class SearchHistory:
    """What the last of a row of similar cases asked for, contact by contact; `solve_local` keeps it up to date."""

    search_radii: Sequence[SearchRadius | None] = ()

    def settle(self) -> None:
        """Take the drift as done: the poses have followed it."""
        self.search_radii = [None if r is None else replace(r, increment=STILL) for r in self.search_radii]


def solve_local_case(
    scene: SceneModel, arguments: Mapping[str, Any], history: SearchHistory, timer: Stopwatch
) -> ContactResult:
    """`Scene.solve` of near parts for one of a row of similar cases; small motions.

    Parameters
    ----------
    scene : SceneModel
    arguments : mapping
        Of `Scene.solve`, except `finite_motion` and `search`.
    history : SearchHistory
    """
    return solve_local(scene, *sorted_case(scene, arguments), timer, history)


def sorted_case(scene: SceneModel, arguments: Mapping[str, Any]) -> tuple[Loading, Settings]:
    """Loads and settings of a case, from the arguments of `Scene.solve` but `finite_motion` and `search`."""
    rest = dict(arguments)
    loads = {name: rest.pop(name, None) for name in (*KEYED, "gravity")}
    settings = Settings(rest.pop("solver", "auto"), rest.pop("tolerance", TOLERANCE), rest)
    settings.check()
    return make_loading(scene.bodies, **loads), settings


def solve_local(
    scene: SceneModel, loading: Loading, settings: Settings, timer: Stopwatch, history: SearchHistory | None = None
) -> ContactResult:
    """Solution with only near parts paired, or all where these do not do.

    Parameters
    ----------
    scene : SceneModel
    loading : Loading
    settings : Settings
    timer : Stopwatch
    history : SearchHistory, optional
        What is known of a similar case; replaced by what is known of this one.
    """
    search_radii = [first_radius(c, loading) for c in scene.contacts]
    if history is not None and history.search_radii:
        search_radii = [
            predict_radius(known, first) for known, first in zip(history.search_radii, search_radii, strict=True)
        ]
    tries = 0 if all(r is None for r in search_radii) else MOST_REACHES
    for _ in range(tries):
        try:
            result = solved(scene, loading, search_radii, settings, timer)
        except FecontactError:
            # what was left out may be what carries the load; if not, the whole surfaces say so again
            break
        enough, search_radii = check_search_region(result)
        if enough:
            if history is not None:
                history.search_radii = search_radii
            return result
    return solved(scene, loading, None, settings, timer)
