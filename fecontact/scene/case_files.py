"""Files of the cases of a sweep: named for each, or by a template for all."""

from __future__ import annotations

import string
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from fecontact.common.arguments import file_path, items
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable
from fecontact.results.files import WRITERS

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
                    f"The cases {taken[path]!r} and {name!r} would both write {path}: put {{name}} into save=."
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
                "all cases solved again, or delete that line of the file."
            )
