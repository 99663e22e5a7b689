"""Example scripts and scene files with their data, which the package carries: listed and copied."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

from fecontact.common.errors import InputError
from fecontact.common.files import make_folder

KINDS = (".py", ".toml")


def example_folder() -> Path:
    """Folder of the examples: in an installed package its own, in a checkout that beside it.

    Raises
    ------
    InputError
        If there is neither.
    """
    package = Path(__file__).parents[1]
    for folder in (package / "examples", package.parent / "examples"):
        if folder.is_dir():
            return folder
    raise InputError(f"No examples beside {package}: they are in the wheel and in the checkout of the source.")


def examples() -> dict[str, str]:
    """First sentence about each example, by its name.

    Examples
    --------
    >>> examples()["block_on_plane"]
    'Any two bodies: a rubber block pressed and tilted on a rigid plane until one edge lifts.'
    """
    return {path.stem: _about(path) for path in sorted(example_folder().iterdir()) if path.suffix in KINDS}


def copy_example(name: str, to: str | Path = ".") -> list[Path]:
    """Copy an example and the files that it names, meshes too, into a folder, which is made if missing.

    Parameters
    ----------
    name : str
        As in `examples`; ``all`` for every one.
    to : path

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If there is no such example, or a file of that name is there already.
    """
    folder = example_folder()
    found = [path for path in sorted(folder.iterdir()) if path.suffix in KINDS and name in (path.stem, "all")]
    if not found:
        raise InputError(f"There is no example {name!r}; there are: {', '.join(examples())}. Or all of them: all.")
    texts = "\n".join(path.read_text(encoding="utf-8") for path in found)
    data = [path for place in (folder, folder.parent / "meshes") for path in sorted(place.iterdir())]
    named = [path for path in data if path.is_file() and path.name in texts]
    target = Path(to)
    wanted = {path: target / path.name for path in (*found, *named)}
    if there := [place.name for place in wanted.values() if place.exists()]:
        raise InputError(f"{', '.join(there)} would be overwritten in {target.resolve()}. Choose another folder.")
    make_folder(target)
    return [Path(shutil.copyfile(path, place)) for path, place in wanted.items()]


def _about(path: Path) -> str:
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return " ".join((ast.get_docstring(ast.parse(text)) or "").partition("\n\n")[0].split())
    return text.removeprefix("#").partition("\n")[0].partition(":  ")[0].strip() + "."
