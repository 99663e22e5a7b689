"""Local search: pair the parts that may touch, solve, check that no other part can have touched, else pair more.

The parts are predicted from a similar case, by its rigid motion and the size of its elastic displacements. The
prediction affects the time but not the solution, by the check of `fecontact.contact.search.region`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fecontact.common.errors import FecontactError
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.loads import Loading, make_loading
from fecontact.contact.model import SceneModel
from fecontact.contact.search.region import STILL, SearchRadius
from fecontact.results.result import ContactResult
from fecontact.scene.carried import KEYED
from fecontact.scene.linear import solved
from fecontact.scene.search_radius import check_search_region, first_radius, predict_radius
from fecontact.scene.settings import Settings
from fecontact.solvers import TOLERANCE

#: Number of search radii tried before whole surfaces are paired.
MOST_REACHES = 4


@dataclass
class SearchHistory:
    """Search radii needed by the last of a series of similar cases, by contact; updated by `solve_local`."""

    search_radii: Sequence[SearchRadius | None] = ()

    def settle(self) -> None:
        """Reset the predicted motion."""
        self.search_radii = [None if r is None else replace(r, increment=STILL) for r in self.search_radii]


def solve_local_case(
    scene: SceneModel, arguments: Mapping[str, Any], history: SearchHistory, timer: Stopwatch
) -> ContactResult:
    """`Scene.solve` with local search for one of a series of similar cases; small motions.

    Parameters
    ----------
    scene : SceneModel
    arguments : mapping
        Arguments of `Scene.solve`, except `finite_motion` and `search`.
    history : SearchHistory
    """
    return solve_local(scene, *sorted_case(scene, arguments), timer, history)


def sorted_case(scene: SceneModel, arguments: Mapping[str, Any]) -> tuple[Loading, Settings]:
    """Loads and settings of a case, from the arguments of `Scene.solve` except `finite_motion` and `search`."""
    rest = dict(arguments)
    loads = {name: rest.pop(name, None) for name in (*KEYED, "gravity")}
    settings = Settings(rest.pop("solver", "auto"), rest.pop("tolerance", TOLERANCE), rest)
    settings.check()
    return make_loading(scene.bodies, **loads), settings


def solve_local(
    scene: SceneModel, loading: Loading, settings: Settings, timer: Stopwatch, history: SearchHistory | None = None
) -> ContactResult:
    """Solution with the near parts paired, or with all parts if these do not suffice.

    Parameters
    ----------
    scene : SceneModel
    loading : Loading
    settings : Settings
    timer : Stopwatch
    history : SearchHistory, optional
        History of a similar case; updated by this one.
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
            # omitted parts may carry the load; if not, whole surfaces give the error again
            break
        enough, search_radii = check_search_region(result)
        if enough:
            if history is not None:
                history.search_radii = search_radii
            return result
    return solved(scene, loading, None, settings, timer)
