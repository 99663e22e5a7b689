"""Files with given texts; pictures, small as their size tells nothing of the drawing and takes most of its time."""

import pytest

from fecontact.mesh import picture
from fecontact.results.pictures import bodies


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    for module in (picture, bodies):
        monkeypatch.setattr(module, "PIXELS", (160, 120))


@pytest.fixture
def written(tmp_path):
    """Path of a file with a text."""

    def write(text, name="scene.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write
