"""Decks of all formats as scenes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fecontact.app.decks.abaqus import read_deck
from fecontact.app.decks.assemble import make_scene
from fecontact.app.decks.content import DeckContent
from fecontact.app.decks.febio import read_feb
from fecontact.app.options import FINITE
from fecontact.app.scene_file.contents import SceneFile
from fecontact.common.errors import InputError

DECKS: dict[str, Callable[[Path, str], DeckContent]] = {".inp": read_deck, ".feb": read_feb}


def read_deck_scene(path: Path, laws: str = FINITE, divide: int = 0) -> SceneFile:
    """Scene of a deck, checked, its cells divided so many times, see `divided`.

    Raises
    ------
    InputError, MeshError
        If there is no such file, it has no scene with a contact of two bodies, or its cells cannot be divided.
    """
    if not path.is_file():
        raise InputError(f"There is no file {path}.", code="no-file")
    if divide and path.suffix.lower() != ".inp":
        raise InputError(
            f"The cells of decks of Abaqus and CalculiX are divided; found {path.name}.", code="not-divided"
        )
    deck = read_deck(path, laws, divide) if divide else DECKS[path.suffix.lower()](path, laws)
    return make_scene(deck, path)
