"""Studies of friction: figures beside closed forms, files, pictures, refusals, the command."""

import json

import numpy as np
import pytest
from refusals import refused

from fecontact import InputError
from fecontact.app.cli import main
from fecontact.app.studies.friction import run
from fecontact.halfspace.pictures import plot_dragged

PLAIN = {"radius": 10.0, "E": 2.0, "nu": 0.0, "force": 1e-3, "friction": 0.3}


@pytest.mark.by_day("mindlin-48-most0", "carter-12-most2", "fretting-32-most1")
@pytest.mark.parametrize(
    ("name", "cells", "most"),
    # first order in the cells, of which the edge of stick and of contact is one
    [
        (
            "mindlin",
            48,
            {"shift": 1e-3, "stick radius": 0.03, "work of friction": 0.01, "tractions, L2 difference": 0.03},
        ),
        ("fretting", 32, {"energy per cycle": 0.01, "shift at the ends": 1e-3, "shift without force": 0.01}),
        ("carter", 12, {"creepage": 0.06, "half-width of contact": 0.03, "tractions, L2 difference": 0.06}),
        # statics, to round-off; what is left of the elastic slide in its last step
        (
            "block",
            2,
            {
                "friction under the pull": 1e-12,
                "slip in 10,000 steps of this load": 1e-15,
                "friction when all slides": 1e-8,
                "work of friction of a slide": 1e-6,
            },
        ),
    ],
)
def test_studies_find_their_closed_form(name, cells, most):
    found = run(name, {**PLAIN, "cells": cells})
    for figure, within in most.items():
        assert abs(found.errors[figure]) < within, figure
    assert found.source.split(",")[0] in str(found)
    assert "worst residual" in str(found)


@pytest.mark.by_day("mindlin-12", "fretting-12")
@pytest.mark.parametrize(("name", "cells"), [("mindlin", "12"), ("fretting", "12"), ("carter", "12"), ("block", "2")])
def test_files_and_pictures(name, cells, tmp_path, capsys):
    files = {kind: tmp_path / f"out.{kind}" for kind in ("json", "png", "csv")}
    where = ["--json", str(files["json"]), "--plot", str(files["png"]), "--csv", str(files["csv"])]
    assert main(["friction", name, "--cells", cells, "--units", "mm", "N", "MPa", *where]) == 0
    assert "beside" in capsys.readouterr().out
    told = json.loads(files["json"].read_text(encoding="utf-8"))
    assert set(told["exact"]) <= set(told["figures"])
    rows = files["csv"].read_text(encoding="utf-8").splitlines()
    assert len(rows) == 1 + len(told["steps"])
    assert files["png"].stat().st_size > 10_000


def test_picture_of_a_contact(tmp_path):
    contact = run("mindlin", {**PLAIN, "cells": 16}).solved.last
    figure = plot_dragged(contact, tmp_path / "contact.png")
    shown = figure.axes[0].images[0].get_array()
    # a cell of each kind
    assert set(np.unique(shown)) == {0, 1, 2}
    assert (shown.T == 2).sum() == contact.slipping.sum()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"friction": -0.1}, ("not-positive", "friction")),
        ({"friction": float("nan")}, ("not-positive", "friction")),
        ({"force": 0.0}, ("not-positive", "force")),
        ({"tangential": 1.0}, ("slides-as-a-whole", "tangential")),
        ({"tangential": -1e-4}, ("not-positive", "tangential")),
        ({"cells": 4}, ("too-few-cells", "4")),
    ],
)
def test_refusals(change, told):
    with refused(InputError, *told):
        run("mindlin", {**PLAIN, "cells": 16, **change})


@pytest.mark.full  # a block of solids, solved twice
def test_a_block_is_refused_what_friction_cannot_hold():
    found = run("block", {**PLAIN, "cells": 2})
    assert "at least mu = 0.315" in found.data["refusal"]
    assert "along (" in str(found)
    with refused(InputError, "slides-as-a-whole"):
        run("block", {**PLAIN, "cells": 2, "tangential": 1.0})
    with refused(InputError, "not-whole", "The number of cells"):
        run("block", {**PLAIN, "cells": 1})


def test_unknown_studies_are_named():
    with refused(InputError, "unknown-name", "'mindlin', 'fretting', 'carter', 'block'"):
        run("belt", PLAIN)


def test_the_command_tells_what_is_wrong(capsys):
    assert main(["friction", "mindlin", "--cells", "16", "--tangential", "1000"]) == 2
    assert "slides as a whole" in capsys.readouterr().err
