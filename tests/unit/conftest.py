"""Pictures of unit tests are small: their size tells nothing of the drawing, and takes most of its time."""

import pytest

from fecontact.mesh import picture
from fecontact.results.pictures import bodies


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    for module in (picture, bodies):
        monkeypatch.setattr(module, "PIXELS", (160, 120))
