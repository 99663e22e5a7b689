"""Ligaments by the points where they are attached, and tables of them."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from numpy.typing import ArrayLike

from fecontact.bodies.body import Body
from fecontact.common.arguments import file_path, text
from fecontact.common.checks import among, positive, vector
from fecontact.common.errors import InputError
from fecontact.contact.springs import Spring
from fecontact.contact.strands import WrapCylinder

#: Strain at which the toe region of a ligament ends: twice the 0.03 of Blankevoort & Huiskes (1991).
TOE = 0.06
#: Columns of a table of ligaments; that of the toe region may be left out.
COLUMNS = ("name", "x1", "y1", "z1", "x2", "y2", "z2", "stiffness", "slack_length")


@dataclass(frozen=True)
class Ligament:
    """A ligament from the moving to the fixed bone of a `Joint`.

    Its tension grows with the square of the strain in the toe region and linearly beyond, from the slack length on:
    k e^2 / (2 toe) up to e = toe, k (e - toe/2) beyond (Blankevoort & Huiskes, Ligament-bone interaction in a
    three-dimensional model of the knee, J. Biomech. Eng. 113 (1991), 263).

    Parameters
    ----------
    name : str
    moving, fixed : (3,) points
        Where it is attached, in the axes of each bone.
    stiffness : float
        Force per strain beyond the toe region.
    slack_length : float
    toe : float
        Strain at which the toe region ends; 0 for none.
    via : sequence of ('moving' or 'fixed', (3,) point)
        Points of either bone through which it is led, from the moving bone on.
    around : ('moving' or 'fixed', WrapCylinder), optional
        A cylinder on either bone round which it is led where the straight way would pass through it.

    Raises
    ------
    InputError

    Examples
    --------
    >>> Ligament("ACL", (0.0, 0.0, 30.0), (0.0, 0.0, 0.0), stiffness=5000.0, slack_length=29.0).toe
    0.06
    """

    name: str
    moving: tuple[float, float, float]
    fixed: tuple[float, float, float]
    stiffness: float
    slack_length: float
    toe: float = TOE
    via: Sequence[tuple[str, ArrayLike]] = ()
    around: tuple[str, WrapCylinder] | None = None

    def __post_init__(self) -> None:
        text("the name of a ligament", self.name)
        for bone, _ in (*self.via, *(() if self.around is None else (self.around,))):
            among(f"the bone that leads {self.name!r}:", bone, ("moving", "fixed"))
        for what in ("moving", "fixed"):
            vector(f"the {what} end of {self.name!r}", getattr(self, what))
        for what in ("stiffness", "slack_length"):
            positive(f"the {what.replace('_', ' ')} of {self.name!r}", getattr(self, what))

    def spring(self, moving: Body) -> Spring:
        """The ligament between a body and the ground."""
        per_length, bones = self.stiffness / self.slack_length, {"moving": moving, "fixed": None}
        return Spring(
            per_length, (moving, self.moving), (None, self.fixed), self.slack_length, "tension", self.name, self.toe,
            via=[(bones[bone], point) for bone, point in self.via],
            around=None if self.around is None else (bones[self.around[0]], self.around[1]),
        )  # fmt: skip


def read_ligaments(path: str | Path) -> list[Ligament]:
    r"""Read a table of ligaments (.csv).

    Its columns are name, x1, y1, z1 (on the moving bone), x2, y2, z2 (on the fixed bone), stiffness (force per strain),
    slack_length and, if it differs from 0.06, toe, in any order; lengths and forces in the joint's units.

    Parameters
    ----------
    path : str or Path

    Raises
    ------
    InputError
        If the file cannot be read, or lacks a column; the message names the line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> rows = "name,x1,y1,z1,x2,y2,z2,stiffness,slack_length", "LCL,35,0,2,40,-8,-30,2400,31"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "knee.csv"
    ...     _ = path.write_text("\n".join(rows))
    ...     read_ligaments(path)[0].slack_length
    31.0
    """
    path = file_path("the table of ligaments", path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"The table {path} cannot be read: {error}.", code="unreadable") from error
    reader = csv.DictReader(lines, skipinitialspace=True)
    found = tuple(reader.fieldnames or ())
    if wrong := sorted(set(COLUMNS) ^ set(found) - {"toe"}):
        raise InputError(
            f"{path.name}: expected the columns {', '.join(COLUMNS)}, and toe; there are {', '.join(found) or 'none'} "
            f"(missing or not known: {', '.join(wrong)}).",
            code="columns",
        )
    out = []
    for row in reader:
        try:
            v = {name: float(row[name]) for name in found if name != "name"}
        except (TypeError, ValueError):
            raise InputError(
                f"{path.name}, line {reader.line_num}: expected {len(found) - 1} numbers after the name.",
                code="numbers",
            ) from None
        ends = ((v["x1"], v["y1"], v["z1"]), (v["x2"], v["y2"], v["z2"]))
        out.append(Ligament(row["name"].strip(), *ends, v["stiffness"], v["slack_length"], v.get("toe", TOE)))
    return out
