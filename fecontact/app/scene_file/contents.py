"""A checked scene with its loads, options and outputs, as scene files and decks describe it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, groupby
from pathlib import Path
from typing import Any

from fecontact.app.scene_file.bodies import AnyBody
from fecontact.app.scene_file.outputs import Output, write_output
from fecontact.common.errors import InputError
from fecontact.contact.loads import LOADS
from fecontact.results.case_table import CaseTable
from fecontact.results.result import ContactResult
from fecontact.scene.load_path import LoadPath
from fecontact.scene.scene import Scene
from fecontact.scene.tension import Tension, Tightened, tightened


@dataclass(frozen=True, eq=False)
class SceneFile:
    """A checked scene file or deck.

    Attributes
    ----------
    path : Path
    title : str
    scene : Scene
    bodies : mapping of str to Body
    loads : dict
        Arguments of `Scene.solve`.
    options : dict
        Solver, tolerance, finite_motion, engine, accuracy and its limits, where given.
    outputs : tuple of Output
    cases : tuple of dict
        Cases of a sweep: arguments of `Scene.solve` with ``name`` and ``poses``; empty for a single case.
    steps : tuple of dict
        Steps of a load path with friction: arguments of `Scene.solve_path`; empty unless given.
    notes : tuple of str
        Of a deck: what was changed and what is not used; what may change the answer is among the scene's warnings.
    scenes : sequence of Scene
        Those of the cases, where supports differ between them; the first is `scene`. Empty unless given.
    tensions : tuple of Tension
        Forces in cuts, of bolts that are tightened in the first case or step.
    """

    path: Path
    title: str
    scene: Scene
    bodies: Mapping[str, AnyBody]
    loads: dict[str, Any]
    options: dict[str, Any]
    outputs: tuple[Output, ...]
    cases: tuple[dict[str, Any], ...] = ()
    steps: tuple[dict[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    scenes: Sequence[Scene] = ()
    tensions: tuple[Tension, ...] = ()

    @property
    def _verb(self) -> str:
        """Method that solves it."""
        return "sweep" if self.cases else "solve_path" if self.steps else "solve"

    def solve(self) -> ContactResult:
        """Solve the scene under its loads, see `Scene.solve`.

        Raises
        ------
        InputError
            If it has several cases or steps: see `sweep` and `solve_path`.
        """
        if given := self.cases or self.steps:
            what = "cases" if self.cases else "steps of a load path"
            raise InputError(f"{self.path.name} has {len(given)} {what}: call {self._verb}() instead of solve().")
        if (found := self.tightened) is not None:
            notes = (*found.result.scene.notes, found.note)
            return replace(found.result, scene=replace(found.result.scene, notes=notes))
        return self.scene.solve(**self.loads, **self.options)

    @cached_property
    def tightened(self) -> Tightened | None:
        """How far bolts are shortened by their forces in the first case or step; None without any."""
        if not self.tensions:
            return None
        first = [*self.cases, *self.steps, self.loads][0]
        loads = {kind: load for kind, load in first.items() if kind in LOADS}
        return tightened(self.scene, self.tensions, loads, self.options)

    def solve_path(self) -> LoadPath:
        """Solve the steps of a load path, see `Scene.solve_path`.

        Raises
        ------
        InputError
            If it has none.
        """
        if not self.steps:
            raise InputError(
                f"{self.path.name} has no steps of a load path: call {self._verb}() instead of solve_path().",
                code="no-steps",
            )
        if (found := self.tightened) is None:
            return self.scene.solve_path(self.steps, **self.options)
        scene = replace(self.scene, notes=(*self.scene.notes, found.note))
        return scene.solve_path([found.loads(k, step) for k, step in enumerate(self.steps)], **self.options)

    def sweep(self, keep: Sequence[str] = ()) -> CaseTable:
        """Solve all cases and write their files; `keep` as in `Scene.sweep`.

        Raises
        ------
        InputError
            If it has none.
        """
        if not self.cases:
            raise InputError(f"{self.path.name} has no cases: call {self._verb}() instead of sweep().", code="no-cases")
        scenes = self.scenes or [self.scene] * len(self.cases)
        each = [(scene, {**self.options, **case}) for scene, case in zip(scenes, self._cases, strict=True)]
        runs = groupby(each, key=lambda one: id(one[0]))
        tables = [run[0][0].sweep([case for _, case in run], keep=keep) for run in (list(run) for _, run in runs)]
        rows, maps = (tuple(chain.from_iterable(getattr(t, name) for t in tables)) for name in ("rows", "maps"))
        table = replace(tables[0], rows=rows, maps=maps)
        for output in self.outputs:
            table.save(output.path)
        return table

    @property
    def _cases(self) -> Sequence[dict[str, Any]]:
        """The cases, with the shortenings of bolts."""
        if (found := self.tightened) is None:
            return self.cases
        return [found.loads(k, case) for k, case in enumerate(self.cases)]

    def last_case(self) -> tuple[str, ContactResult]:
        """Name and result of the last of its cases."""
        case = {**self.options, **self._cases[-1]}
        return case.pop("name"), (self.scenes or [self.scene])[-1].solve(**case)

    def write(self, result: ContactResult) -> list[Path]:
        """Write all outputs; returns their paths."""
        return [write_output(output, result, self.summary(result)) for output in self.outputs]

    def summary(self, result: ContactResult) -> dict[str, Any]:
        """Figures of the result for scripts, with the title."""
        return {"title": self.title, **result.summary()}

    def describe(self) -> str:
        """Summary of the file in a few lines."""
        lines = [f"{self.path}: {self.title or 'a scene'}"]
        lines += [f"  body     {b.describe()}" for b in self.scene.bodies]
        lines += [
            f"  contact  {c.slave.name}.{c.surfaces[0]} on {c.master.name}.{c.surfaces[1]}"
            for c in self.scene.contacts
            if c.surfaces is not None
        ]
        lines += [f"  spring   {s.name}" for s in self.scene.springs]
        lines += [f"  load     {kind}: {_targets(value)}" for kind, value in self.loads.items()]
        lines += [f"  case     {case['name']}" for case in self.cases]
        lines += [f"  step     {k}: {', '.join(step)}" for k, step in enumerate(self.steps, start=1)]
        lines += [f"  output   {o.kind}: {o.path}" for o in self.outputs]
        lines += [f"  warning  {warning}" for warning in self.scene.warnings]
        lines += [f"  note     {note}" for note in self.notes]
        return "\n".join(lines)


def _targets(value: Any) -> str:
    """Bodies and boundaries under a kind of load, with its values."""
    if not isinstance(value, Mapping):
        return str(value)
    names = [f"{k[0].name}.{k[1]}" if isinstance(k, tuple) else k.name for k in value]
    return "; ".join(f"{name} {v}" for name, v in zip(names, value.values(), strict=True))
