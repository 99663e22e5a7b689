"""Examples out of the package: listed, copied with what they name, never over other files."""

import runpy

import pytest

from fecontact.app.cli import main
from fecontact.app.examples import copy_example, example_folder, examples


def test_every_script_and_scene_is_listed_with_a_line(capsys):
    assert main(["examples", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    files = {path.stem for path in example_folder().iterdir() if path.suffix in (".py", ".toml")}
    assert {line.split()[0] for line in lines} == files == set(examples())
    assert all(len(line.split(maxsplit=1)[1]) > 20 for line in lines)


def test_a_copy_has_what_it_needs(tmp_path, capsys):
    assert main(["examples", "copy", "bracket", "--to", str(tmp_path / "new")]) == 0
    assert "wrote" in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "new").iterdir()} == {"bracket.py", "bracket.step"}
    assert runpy.run_path(str(tmp_path / "new" / "bracket.py"))["STEP"].exists()
    assert {path.name for path in copy_example("scene_file", tmp_path)} == {"scene_file.py", "ball_on_block.toml"}


def test_all_of_them_at_once(tmp_path):
    assert {path.stem for path in copy_example("all", tmp_path)} >= set(examples())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["copy"], "Which one"),
        (["copy", "kneee"], "no example 'kneee'; there are: ball_on_block"),
    ],
)
def test_what_is_missing_is_told(arguments, message, capsys):
    assert main(["examples", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_nothing_is_overwritten(tmp_path, capsys):
    (tmp_path / "knee.py").write_text("mine")
    assert main(["examples", "copy", "knee", "--to", str(tmp_path)]) == 2
    assert "knee.py would be overwritten" in capsys.readouterr().err
    assert (tmp_path / "knee.py").read_text() == "mine"
