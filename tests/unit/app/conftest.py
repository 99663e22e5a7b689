"""Scenes of the texts of decks."""

import pytest

import fecontact as fc


@pytest.fixture
def read(written):
    """Scene of the text of a deck."""

    def scene(text, **options):
        return fc.read_scene(written(text, "deck.inp"), **options)

    return scene
