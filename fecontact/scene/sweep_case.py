"""One case of a sweep: its posed scene, loads, row, kept fields and fingerprints."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from fecontact.bodies.protocol import Body
from fecontact.common.errors import FecontactError, InputError
from fecontact.common.fingerprint import fingerprint
from fecontact.common.json_lines import read_rows
from fecontact.common.one_line import one_line
from fecontact.common.stopwatch import Stopwatch
from fecontact.common.version import VERSION
from fecontact.contact.loads import Loading, make_loading
from fecontact.contact.model import SceneModel
from fecontact.results.case_row import Kept, kept_of, row_of
from fecontact.results.dividing_plane import DividingPlane
from fecontact.results.result import ContactResult
from fecontact.scene.carried import KEYED
from fecontact.scene.case_files import PICTURES, files_of
from fecontact.scene.finite_rotation import follow
from fecontact.scene.local_search import SearchHistory, solve_local_case
from fecontact.scene.poses import posed_scene
from fecontact.scene.rest import check_rest
from fecontact.scene.settings import Settings
from fecontact.scene.solve import refuse_with_friction, solve_scene
from fecontact.scene.windows import has_open_windows
from fecontact.solvers import TOLERANCE

Case = Mapping[str, Any]
#: What a case has besides poses and the arguments of `Scene.solve`; its result does not depend on it.
OF_CASES = ("name", "parameters", "save", "keep")
#: Arguments of `Scene.solve` that are not loads, and those that are not settings of the solver.
_OTHER = ("search", "finite_motion", "accuracy", "max_dofs", "max_seconds")


@one_line
@dataclass(frozen=True, eq=False)
class Posed:
    """A case in its poses.

    Attributes
    ----------
    scene : SceneModel
        Scene of the moved bodies.
    arguments : dict
        Arguments of `Scene.solve` for the moved bodies.
    """

    scene: SceneModel
    arguments: dict[str, Any]

    @classmethod
    def of(cls, scene: SceneModel, case: Case) -> Posed:
        """The posed scene of a case."""
        now = posed_scene(scene, case.get("poses"))
        return cls(now.scene, now.loads({k: v for k, v in case.items() if k not in (*OF_CASES, "poses", "split")}))

    def loading(self) -> Loading:
        """Its loads, sorted and checked, and its settings checked with them."""
        rest = {k: v for k, v in self.arguments.items() if k not in (*KEYED, "gravity", *_OTHER)}
        if rest:
            Settings(rest.pop("solver", "auto"), rest.pop("tolerance", TOLERANCE), rest).check()
        return make_loading(self.scene.bodies, **{k: self.arguments.get(k) for k in (*KEYED, "gravity")})


#: Row of a case, and its fields that are kept.
Solved = tuple[dict[str, Any], Kept]


def solved_case(scene: SceneModel, case: Case, history: SearchHistory) -> Solved:
    """Row and kept fields of a case, with local search by default; writes its files."""
    result = _solved(scene, case, history)
    files = files_of(case)
    for path in files:
        if path.suffix.lower() in PICTURES:
            result.plot("pressure", path)
        else:
            result.save(path)
    split = case.get("split")
    row = row_of(result, None if split is None else DividingPlane(**split), scene.bodies)
    if files:
        row["files"] = [str(path) for path in files]
    return row, kept_of(result, case.get("keep", ()))


def _solved(scene: SceneModel, case: Case, history: SearchHistory) -> ContactResult:
    posed = Posed.of(scene, case)
    arguments = {"search": "local", **posed.arguments}
    finite = arguments.get("finite_motion", "auto")
    apart = arguments["search"] == "global" or finite is True or arguments.get("accuracy") is not None
    if apart or has_open_windows(posed.scene):
        return solve_scene(posed.scene, **arguments)
    if scene.has_friction:
        refuse_with_friction(scene, arguments.get("solver", "auto"))
    small = {k: v for k, v in arguments.items() if k not in _OTHER}
    timer = Stopwatch()
    result = solve_local_case(posed.scene, small, history, timer)
    if finite == "auto" and not scene.has_friction:
        result = follow(result, {**small, "search": "local"}, timer, history)
    return check_rest(result)


@contextmanager
def naming(name: str) -> Iterator[None]:
    """Context: prefix error messages with the name of a case."""
    try:
        yield
    except FecontactError as error:
        if len(error.args) != 1:
            raise
        raise type(error)(f"Case {name!r}: {error}") from error


def fingerprints(scene: SceneModel, cases: Mapping[str, Case]) -> dict[str, dict[str, str]]:
    """Fingerprints of each case by part: bodies, contacts, springs, and every argument."""
    bodies = scene.bodies
    model = {"fecontact": VERSION}
    for name in dict.fromkeys(b.name for b in bodies):
        model[f"body {name!r}"] = fingerprint([b for b in bodies if b.name == name])
    for what in ("contacts", "springs"):
        parts = [{f.name: getattr(part, f.name) for f in fields(part)} for part in getattr(scene, what)]
        model[what] = fingerprint(numbered(parts, bodies))
    usual = {k: p.default for k, p in inspect.signature(solve_scene).parameters.items()} | {"search": "local"}
    nothing = {fingerprint(None), fingerprint({})}
    out = {}
    for name, case in cases.items():
        try:
            given = {k: fingerprint(numbered(v, bodies)) for k, v in case.items() if k not in OF_CASES}
        except RecursionError:
            raise InputError(f"Case {name!r} has a list or mapping that holds itself; give plain values.") from None
        said = {k: v for k, v in given.items() if v not in nothing and v != fingerprint(usual.get(k))}
        out[name] = {**model, **said}
    return out


def numbered(thing: Any, bodies: Sequence[Body]) -> Any:
    """The same with bodies as numbers, which are faster to compare."""
    for k, body in enumerate(bodies):
        if thing is body:
            return ("body", k)
    if isinstance(thing, Mapping):
        return {numbered(k, bodies): numbered(v, bodies) for k, v in thing.items()}
    if isinstance(thing, (tuple, list)):
        return tuple(numbered(v, bodies) for v in thing)
    return thing


def finished(
    path: str | Path | None, prints: Mapping[str, Mapping[str, str]], what: str = "a row of a sweep"
) -> dict[str, dict[str, Any]]:
    """Rows of an earlier run of these cases.

    Parameters
    ----------
    path : str, Path or None
    prints : mapping
        `fingerprints` of the cases.
    what : str
        What a row is, for the message.

    Raises
    ------
    InputError
        If a row with the name of a case is of another model or case, or has no fingerprint.
    """
    rows = {} if path is None else read_rows(path, "name", what)
    remedy = "Give another path, or delete that line of the file to have the case solved again."
    for name, now in prints.items():
        if name not in rows:
            continue
        then = rows[name].get("fingerprint")
        if not isinstance(then, dict):
            raise InputError(
                f"The row {name!r} in {path} has no fingerprint (it was written by an earlier version or by hand), so "
                f"that it cannot be told whether it is of this model and case. {remedy}"
            )
        other = sorted(k for k in {*then, *now} if then.get(k) != now.get(k))
        if other:
            raise InputError(f"The row {name!r} in {path} is of another model or case ({', '.join(other)}). {remedy}")
    return {name: rows[name] for name in prints if name in rows}
