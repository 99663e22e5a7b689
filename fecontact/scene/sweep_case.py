"""One case of a sweep: its posed scene, loads, row, kept fields and fingerprints.

Files of the cases of a sweep: named for each, or by a template for all.

Numbers by name that a case of a sweep is given: parameters of the user, loads and poses.
"""

from __future__ import annotations

import inspect
import string
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.bodies.body import Body
from fecontact.common.arguments import file_path, items, known_names, mapping, text
from fecontact.common.arrays import Array
from fecontact.common.checks import among, finite
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable
from fecontact.common.fingerprint import fingerprint
from fecontact.common.stopwatch import Stopwatch
from fecontact.common.version import VERSION
from fecontact.contact.loads import LOADS, Loading, LoadStep
from fecontact.contact.model import SceneModel
from fecontact.fem.rigid import COMPONENTS
from fecontact.results.case_table import FIGURES, GIVEN, WHOLE, Kept, kept_of, row_of
from fecontact.results.files import WRITERS
from fecontact.results.result import ContactResult
from fecontact.results.resultants import DividingPlane
from fecontact.scene.carried import posed_scene
from fecontact.scene.finite_rotation import check_rest, follow
from fecontact.scene.finite_strain import OFFERED, is_nonlinear, refuse_with_laws
from fecontact.scene.linear import Settings, solver_options
from fecontact.scene.local_search import SearchHistory, solve_local
from fecontact.scene.solve import refuse_with_friction, solve_scene
from fecontact.scene.windows import has_open_windows

#: Suffixes of pictures among the files of a case, and of the collection that lists a file of each case.
PICTURES, COLLECTION = (".png", ".pdf", ".svg"), ".pvd"


def files_of(case: Mapping[str, Any]) -> list[Path]:
    """Files that a case is to write.

    Raises
    ------
    InputError
        If one of them cannot be written, or has an unknown suffix.
    """
    files = [check_writable(path) for path in _own(case)]
    for path in files:
        among("the suffix of a case's file", path.suffix.lower(), (*WRITERS, *PICTURES))
    return files


def collection_of(save: Any) -> Path | None:
    """The collection (.pvd) that a sweep is to write, if `save` is the path of one."""
    if isinstance(save, str | PathLike) and Path(save).suffix.lower() == COLLECTION:
        return check_writable(Path(save))
    return None


def with_files(cases: Mapping[str, Mapping[str, Any]], save: Any) -> dict[str, Mapping[str, Any]]:
    """Cases with the files of a template added to their own.

    Parameters
    ----------
    cases : mapping of str to case
    save : str or Path, several of them, or None
        Paths with ``{name}`` in place of the name of the case; of a collection, run.pvd, the cases write
        run_{name}.vtu.

    Raises
    ------
    InputError
        If a path has another field, or two cases have the same file.

    Examples
    --------
    >>> with_files({"a": {}, "b": {}}, "pose_{name}.vtu")["b"]["save"]
    [PosixPath('pose_b.vtu')]
    """
    if save is None:
        return dict(cases)
    given = (save,) if isinstance(save, str | PathLike) else items("the files of a sweep", save, "paths")
    if (collection := collection_of(save)) is not None:
        given = (collection.with_name(f"{_quoted(collection.stem)}_{{name}}.vtu"),)
    templates = [str(file_path("the path of a file of each case", path)) for path in given]
    out: dict[str, Mapping[str, Any]] = {}
    taken: dict[Path, str] = {}
    for name, case in cases.items():
        own = [_filled(template, name) for template in templates]
        for path in own:
            if path in taken:
                raise InputError(
                    f"The cases {taken[path]!r} and {name!r} would both write {path}: put {{name}} into save=.",
                    code="same-file",
                )
            taken[path] = name
        out[name] = {**case, "save": [*_own(case), *own]}
    return out


def _own(case: Mapping[str, Any]) -> tuple[Any, ...]:
    given = case.get("save")
    return () if given is None else items("the files of a case", given, "paths")


def _filled(template: str, name: str) -> Path:
    """A path with the name of a case in it."""
    try:
        fields = {field for _, field, _, _ in string.Formatter().parse(template) if field is not None}
    except ValueError as error:
        raise InputError(f"save={template!r} cannot be read: {error}. Write {{name}} for the name of a case.") from None
    if fields - {"name"}:
        raise InputError(f"save={template!r} has the field {sorted(fields)[0]!r}; expected {{name}} only.")
    if fields and Path(name).name != name:
        raise InputError(f"The name {name!r} cannot be part of the name of a file: give the case another one.")
    return Path(template.format(name=name))


def _quoted(text: str) -> str:
    return text.replace("{", "{{").replace("}", "}}")


def check_finished(done: Mapping[str, Mapping[str, Any]], cases: Mapping[str, Mapping[str, Any]], rows: Any) -> None:
    """Refuse a collection of files of which those of finished cases are missing.

    Raises
    ------
    InputError
        The message names the first of them.
    """
    for name in done:
        path = Path(cases[name]["save"][-1])
        if not path.is_file():
            raise InputError(
                f"Case {name!r} is finished in {rows}, but its file {path} is not there. Give another path= to have "
                "all cases solved again, or delete that line of the file.",
                code="file-of-case-missing",
            )


Case = Mapping[str, Any]
#: What a case has besides poses and the arguments of `Scene.solve`; its result does not depend on it.
OF_CASES = ("name", "parameters", "save", "keep")
#: Arguments of `Scene.solve` that are neither loads nor settings of one solution.
OF_ACCURACY = ("accuracy", "max_dofs", "max_seconds", "engine")


@compact_repr
@dataclass(frozen=True, eq=False)
class Posed:
    """A case in its poses.

    Attributes
    ----------
    scene : SceneModel
        Scene of the moved bodies.
    step : LoadStep
        Loads on the moved bodies.
    others : dict
        Other arguments of `Scene.solve`.
    """

    scene: SceneModel
    step: LoadStep
    others: dict[str, Any]

    @classmethod
    def of(cls, scene: SceneModel, case: Case) -> Posed:
        """The posed scene of a case."""
        now = posed_scene(scene, case.get("poses"))
        others = {k: v for k, v in case.items() if k not in (*OF_CASES, "poses", "split", *LOADS)}
        search = "global" if is_nonlinear(scene) else "local"
        return cls(now.scene, now.step(LoadStep.of(case)), {"search": search, **others})

    @property
    def settings(self) -> Settings:
        """Settings of its solution."""
        names = ("solver", "tolerance", "search", "finite_motion")
        known_names(
            "A case", self.others, (*names, *OF_ACCURACY, "max_iterations", "options", *LOADS, *OF_CASES, "poses")
        )
        options = solver_options(self.others.get("max_iterations"), self.others.get("options"))
        return Settings(**{n: self.others[n] for n in names if n in self.others}, options=options)

    def loading(self) -> Loading:
        """Its loads, sorted and checked, and its settings checked with them."""
        self.settings.check()
        refuse_with_laws(self.scene, **{name: v for name, v in self.others.items() if name in OFFERED})
        return self.step.on(self.scene.bodies)


#: Row of a case, and its fields that are kept.
Solved = tuple[dict[str, Any], Kept]


def solved_case(scene: SceneModel, case: Case, history: SearchHistory) -> Solved:
    """Row and kept fields of a case, with local search by default; writes its files."""
    result = _solved(scene, case, history)
    files = files_of(case)
    split = None if (given := case.get("split")) is None else DividingPlane(**given)
    for path in files:
        if path.suffix.lower() in PICTURES:
            result.plot("pressure", path, split=split)
        else:
            result.save(path)
    row = row_of(result, split, scene.bodies)
    if files:
        row["files"] = [str(path) for path in files]
    return row, kept_of(result, case.get("keep", ()))


def _solved(scene: SceneModel, case: Case, history: SearchHistory) -> ContactResult:
    posed = Posed.of(scene, case)
    settings = posed.settings
    apart = (
        settings.search == "global"
        or is_nonlinear(scene)
        or settings.finite_motion is True
        or case.get("accuracy") is not None
    )
    if apart or has_open_windows(posed.scene):
        return solve_scene(posed.scene, **vars(posed.step), **posed.others)
    if scene.has_friction:
        refuse_with_friction(scene, settings.solver)
    timer = Stopwatch()
    result = solve_local(posed.scene, posed.loading(), settings, timer, history)
    if settings.finite_motion == "auto" and not scene.has_friction:
        result = follow(result, posed.step, settings, timer, history)
    return check_rest(result)


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


AXES = ("x", "y", "z")


def parameters_of(case: Mapping[str, Any]) -> dict[str, float]:
    """Numbers that belong to a case, by name.

    Raises
    ------
    InputError
        If one is no finite number, or has the name of a column of the table.

    Examples
    --------
    >>> parameters_of({"parameters": {"angle": 30}})
    {'angle': 30.0}
    """
    return {
        _free_name(name): float(finite(f"the parameter {name!r}", value))
        for name, value in mapping("parameters", case.get("parameters")).items()
    }


def loads_of(case: Mapping[str, Any]) -> dict[str, float]:
    """Loads and poses of a valid case by kind, body and component.

    ``forces ball z``, ``poses ball rx`` (a component of the rotation vector, radians), ``pressures pad.top``. Loads
    that vary over a boundary are no numbers and left out.

    Examples
    --------
    >>> loads_of({"gravity": (0.0, 0.0, -9.81)})
    {'gravity x': 0.0, 'gravity y': 0.0, 'gravity z': -9.81}
    """
    return {" ".join(words): float(value) for *words, value in _numbers(case)}


def _free_name(name: object) -> str:
    word = text("the name of a parameter", name)
    if (
        word in (*FIGURES, *WHOLE)
        or word.partition(" ")[0] in (*GIVEN, "tractions", "temperatures", "gravity")
        or ": " in word
    ):
        raise InputError(f"The parameter {word!r} has the name of a column of the table; give it another name.")
    return word


def _numbers(case: Mapping[str, Any]) -> Iterator[tuple[Any, ...]]:
    """Kind, body and component, and the number."""
    if case.get("gravity") is not None and not callable(case["gravity"]):
        yield from (("gravity", axis, v) for axis, v in zip(AXES, case["gravity"], strict=True))
    for kind in ("forces", "moments", "tractions"):
        for key, value in (case.get(kind) or {}).items():
            if not callable(value) and np.ndim(value) == 1:
                yield from ((kind, _target(key), axis, v) for axis, v in zip(AXES, value, strict=True))
    for kind in ("pressures", "temperatures"):
        for key, value in (case.get(kind) or {}).items():
            if not callable(value) and np.ndim(value) == 0:
                yield kind, _target(key), value
    for body, motion in (case.get("motions") or {}).items():
        yield from (("motions", body.name, component, value) for component, value in motion.items())
    for body, pose in (case.get("poses") or {}).items():
        yield from (("poses", body.name, c, v) for c, v in zip(COMPONENTS, _six(pose), strict=True))


def _target(key: Any) -> str:
    """Body, with its boundary if there is one."""
    body, where = key if isinstance(key, tuple) else (key, None)
    return f"{body.name}.{where}" if isinstance(where, str) else str(body.name)


def _six(pose: Any) -> Array:
    """Translation and rotation vector (6,)."""
    return np.concatenate([pose.translation, Rotation.from_matrix(pose.rotation).as_rotvec()])
