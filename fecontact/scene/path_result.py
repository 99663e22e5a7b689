"""Results of a load path: forces, work and wear, a table of its steps, files.

File of a load path: a row of JSON for each step, from which an interrupted path goes on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.protocol import Body
from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array
from fecontact.common.checks import number_array, positive, whole
from fecontact.common.errors import InputError
from fecontact.common.files import append_row
from fecontact.common.fingerprint import fingerprint
from fecontact.common.one_line import one_line
from fecontact.common.renamed import renamed
from fecontact.common.table import Column, Table
from fecontact.contact.model import SceneModel
from fecontact.contact.step_end import StepEnd
from fecontact.results.case_figures import fields_to_keep, kept_of, plane_of, row_of
from fecontact.results.case_table import CaseTable
from fecontact.results.dividing_plane import DividingPlane
from fecontact.results.files import save_series
from fecontact.results.friction_fields import at_nodes
from fecontact.results.result import ContactResult
from fecontact.results.resultants import resultant
from fecontact.scene.sweep_case import fingerprints, finished


@one_line
@dataclass(frozen=True, eq=False)
class LoadPath:
    """Results of the steps of a load path.

    Attributes
    ----------
    steps : tuple of ContactResult
        At the end of every step given.
    cuts : tuple of int
        Parts in which every step was solved.
    loads : tuple of dict
        Loads at the end of every step by name, see `scene.sweep_case`.
    """

    steps: tuple[ContactResult, ...]
    cuts: tuple[int, ...]
    loads: tuple[Mapping[str, float], ...] = field(repr=False)

    dissipated = renamed("dissipated", "friction_work")

    def __len__(self) -> int:
        """Number of steps."""
        return len(self.steps)

    def __getitem__(self, k: int) -> ContactResult:
        """Result of a step."""
        return self.steps[k]

    @cached_property
    def friction_work(self) -> Array:
        """Work of friction (n_steps, n_contacts) during every step; zero for contacts without friction."""
        return np.array([[c.friction.friction_work if c.friction else 0.0 for c in r.contacts] for r in self.steps])

    @cached_property
    def forces(self) -> Array:
        """Forces (n_steps, n_contacts, 3) on the first body of each contact, friction included."""
        return np.array([[resultant(c)[0] for c in result.contacts] for result in self.steps])

    def motions(self, body: Body) -> Array:
        """Rigid motions (n_steps, 6) of a body's frame: translations and rotation vectors."""
        found = [result.rigid_motion(body) for result in self.steps]
        return np.array([np.concatenate([m.translation, m.rotation]) for m in found])

    def wear_depth(self, contact: int, coefficient: float) -> Array:
        """Wear depth (n,) at the points of a contact by Archard's law, h = k int p |ds|.

        Parameters
        ----------
        contact : int
            Number of the contact in the scene.
        coefficient : float
            Archard's k: volume per force and distance, one over pressure. The work of friction by area is mu times the
            integral. Every step, or part of a step that was cut, counts with the chord of its path.

        Returns
        -------
        (n,) array
            At the points of the last step.
        """
        positive("the coefficient of wear", coefficient)
        whole("the number of the contact", contact, 0, len(self.steps[0].contacts) - 1)
        found = [(result.contacts[contact].friction, result.interfaces[contact].pairing.nodes) for result in self.steps]
        if any(f is None or np.isinf(f.mu).any() for f, _ in found):
            raise InputError(f"Contact {contact} has no finite friction: Archard's law needs its work.")
        last = found[-1][1]
        return coefficient * np.sum([at_nodes(f.sliding_integral, own, last) for f, own in found if f], axis=0)

    def table(
        self,
        times: Sequence[float] | None = None,
        *,
        keep: str | Sequence[str] = (),
        split: DividingPlane | tuple[ArrayLike, ArrayLike] | None = None,
    ) -> CaseTable:
        """Figures of all steps, a row for each, to print, draw and save.

        Parameters
        ----------
        times : sequence of float, optional
            Time of each step, for a column.
        keep, split
            Fields for maps, and a plane that divides contacts, as in `Scene.sweep`.

        Raises
        ------
        InputError
            If there are other numbers of times than steps, or a field or a plane is none.
        """
        first = self.steps[0]
        bodies = first.unrefined or first.originals or first.scene.bodies
        fields, plane = fields_to_keep(keep, first.scene), plane_of(split, bodies)
        given: list[dict[str, float]] = [{} for _ in self.steps]
        if times is not None:
            given = [{"time": float(t)} for t in number_array("the times of the steps", times).ravel()]
            if len(given) != len(self):
                raise InputError(f"There are {len(self)} steps and {len(given)} times.", code="times-differ")
        rows = []
        for k, result in enumerate(self.steps):
            row = row_of(result, plane, bodies)
            rows.append({"name": f"step {k + 1}", **row, "parameters": given[k], "loads": dict(self.loads[k])})
        names = tuple((c.slave.name, c.master.name) for c in first.scene.contacts)
        maps = tuple(kept_of(result, fields) for result in self.steps)
        return CaseTable(tuple(rows), names, first.scene.unit_names, maps)

    def save(self, path: str | Path, times: Sequence[float] | None = None) -> Path:
        """Write the path; the suffix decides: .pvd with a .vtu for each step, or as `CaseTable.save`.

        Parameters
        ----------
        path : str or Path
        times : sequence of float, optional
            Time of each step; in a .pvd their numbers from 0 unless given.

        Raises
        ------
        InputError
            For another suffix, a file that cannot be written, or another number of times than of steps.
        """
        if file_path("the path of a load path", path).suffix.lower() != ".pvd":
            return self.table(times).save(path)
        return save_series(self.steps, path, None if times is None else number_array("the times", times).tolist())

    def __str__(self) -> str:
        names = ("normal", "friction", "stick area", "slip area", "work")
        columns = [Column("step"), *(Column(name, ".5g") for name in names)]
        rows = [
            (k, c.total_force, float(np.linalg.norm(f.force)), c.stick_area, c.slip_area, f.friction_work)
            for k, result in enumerate(self.steps, start=1)
            for c in result.contacts
            if (f := c.friction) is not None
        ]
        return str(Table(columns, rows))


def step_prints(
    model: SceneModel, steps: Sequence[Mapping[str, Any]], settings: Mapping[str, Any]
) -> list[dict[str, str]]:
    """Fingerprints of each step: of the model, the settings, its loads, and those of all steps before it."""
    named = {str(k): {**step, **settings} for k, step in enumerate(steps, start=1)}
    out: list[dict[str, str]] = []
    for found in fingerprints(model, named).values():
        out.append({**found, "the steps before": fingerprint(out[-1] if out else None)})
    return out


def rows_before(path: str | Path, prints: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Rows of an earlier run, from the first step to the last one without a gap.

    Raises
    ------
    InputError
        If a row is of another model, step or settings.
    """
    named = {str(k): each for k, each in enumerate(prints, start=1)}
    found = finished(path, named, "a step of a load path")
    rows: list[dict[str, Any]] = []
    for name in named:
        if name not in found:
            break
        if not {"end", "since", "parts", "cuts"} <= set(found[name]):
            raise InputError(f"The row {name!r} in {path} is not a step of a load path; choose another file.")
        rows.append(found[name])
    return rows


def append_step(
    path: str | Path,
    name: str,
    prints: Mapping[str, str],
    result: ContactResult,
    cuts: int,
    since: StepEnd | None,
) -> None:
    """Add the row of a step: its summary, what the next one goes on from, and what its last part followed."""
    assert result.step_end is not None
    row = {
        "name": name,
        **result.summary(),
        "parts": [parts and parts.as_dict() for parts in (c.friction and c.friction.earlier for c in result.contacts)],
        "cuts": cuts,
        "end": result.step_end.as_dict(),
        "since": None if since is None else since.as_dict(),
        "fingerprint": prints,
    }
    append_row(path, row)
