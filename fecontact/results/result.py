"""Result of a scene: fields, resultants, residuals, report, pictures and files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fecontact.bodies.elastic import elastic_among
from fecontact.common.arguments import file_path, known_options
from fecontact.common.arrays import IntArray
from fecontact.common.errors import InputError
from fecontact.common.files import check_writable
from fecontact.common.stopwatch import Stopwatch
from fecontact.contact.condensed_problem import CondensedProblem, DisplacementState
from fecontact.contact.interface import UnilateralConstraints
from fecontact.contact.loads import Loading
from fecontact.contact.model import SceneModel
from fecontact.contact.springs import SpringState
from fecontact.results.contact_fields import ContactFields
from fecontact.results.edge_pressure import EdgePressure, edge_pressure
from fecontact.results.friction_fields import FrictionFields
from fecontact.results.paired_fields import contact_fields
from fecontact.results.report import model_size, peak_memory, report
from fecontact.results.resultants import resultant
from fecontact.results.solved_scene import SolvedScene
from fecontact.results.warnings import notes_of, warnings_of
from fecontact.solvers import Solution


@dataclass(frozen=True, eq=False)
class ContactResult(SolvedScene):
    """Certified solution of a scene, with methods to print, draw and save it."""

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of modelling and discretisation errors; see `results.warnings`."""
        return warnings_of(self)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Notes about the model."""
        return notes_of(self)

    @cached_property
    def edge_pressures(self) -> tuple[EdgePressure, ...]:
        """Pressure of each contact with its square root at the edge; see `results.edge_pressure`.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.quarter_sphere(25.0, contact_radius=0.5, level=1)
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), "cap", {"base": "xyz", "sym_x": "x", "sym_y": "y"})
        >>> hertz = fc.hertz.spheres((25.0, float("inf")), (body.material, None), force=0.0073)
        >>> scene = fc.Scene([body, floor := fc.RigidBody(fc.Plane())], [fc.Contact(body, floor)])
        >>> (edge,) = scene.solve(forces={body: (0, 0, -hertz.force / 4)}).edge_pressures
        >>> edge.accepted, abs(edge.outlines[0].semi_axes[0] / hertz.a - 1) < 2e-3
        (True, True)
        """
        start = np.cumsum([0] + [len(c.candidates) for c in self.contacts])
        forces = self.solution.forces
        pairs = zip(self.contacts, start[:-1].tolist(), strict=True)
        return tuple(edge_pressure(c, self.problem, first, forces) for c, first in pairs)

    def plot(self, what: str = "pressure", path: str | Path | None = None, **options: Any) -> Any:
        """Picture of a field, see `fecontact.results.pictures.draw`; written to `path` if given."""
        from fecontact.results.pictures.draw import plot_result

        return plot_result(self, what, path, **options)

    def show(self, field: str = "von_mises", path: str | Path | None = None, **options: Any) -> None:
        """Show the bodies in a window, or below a cell of a notebook; see `results.pictures.bodies.show`.

        With `path` the window's picture is written instead.

        Raises
        ------
        MissingPackageError
            If pyvista is not installed.
        InputError
            For an unknown field, body, option or direction.
        """
        from fecontact.results.pictures.bodies import show_result

        show_result(self, field, path, **options)

    def report(self, path: str | Path, **options: Any) -> Path:
        """Write a page of tables, pictures, warnings and the certificate, see `fecontact.results.page.write_page`.

        Parameters
        ----------
        path : str or Path
            A file ``.html``; it needs no other file.
        **options
            ``title``.

        Raises
        ------
        InputError
            For an unknown option, a suffix other than .html, or a file that cannot be written.
        """
        from fecontact.results.page import write_page

        known_options(write_page, options)
        if (suffix := Path(file_path("the path of a page", path)).suffix.lower()) not in (".html", ".htm"):
            raise InputError(f"A report is a page; found the suffix {suffix!r}, expected .html.", code="no-html")
        return write_page(self, self.warnings, self.notes, check_writable(path), **options)

    def _repr_html_(self) -> str:
        from fecontact.results.page import notebook_cell

        return notebook_cell(self, self.warnings, self.notes)

    def save(self, path: str | Path) -> Path:
        """Write the result; the suffix decides: .vtu (ParaView), .json (summary), .csv (contact points)."""
        from fecontact.results.files import save_result

        return save_result(self, path, self.summary)

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
        r = self.residuals()
        return {
            "units": asdict(self.scene.unit_names),
            "status": self.status,
            "solver": self.solution.solver,
            "iterations": self.nit,
            "rounds": self.rounds,
            "n_dofs": self.n_dofs,
            "n_candidates": self.n_candidates,
            "n_active": self.n_active,
            "condensation": self.condensation,
            "contacts": [c.summary() for c in self.contacts],
            "response_error": self.response_error.summary(),
            "bodies": [{"name": b.name, "reaction": self.reaction(b).tolist()} for b in self.scene.bodies],
            "warnings": list(self.warnings),
            "notes": list(self.notes),
            "springs": [
                {"name": s.spring.name, "tension": s.tension, "elongation": s.elongation} for s in self.springs
            ],
            "residuals": {
                "penetration": r.penetration,
                "tension": r.tension,
                "complementarity": r.complementarity,
                "equilibrium": r.equilibrium,
                **({} if self.friction is None else {"friction": asdict(self.friction.residuals)}),
            },
            "seconds": dict(self.seconds),
            "memory_mb": dict(self.memory),
            "peak_rss_mb": peak_memory(),
            "saved": model_size(self),
            **({} if self.convergence is None else {"convergence": self.convergence.as_dict()}),
        }

    def __repr__(self) -> str:
        pairs = ", ".join(
            f"{' on '.join(body.name for body in c.bodies)}: "
            f"force {np.linalg.norm(resultant(c)[0]):.4g}, peak {c.max_pressure:.4g}"
            for c in self.contacts[:2]
        )
        more = "" if len(self.contacts) <= 2 else f", and {len(self.contacts) - 2} more"
        return f"ContactResult({self.status}, {self.n_active} of {self.n_candidates} in contact; {pairs}{more})"

    def __str__(self) -> str:
        return report(self, self.warnings, self.notes)


def make_result(
    scene: SceneModel,
    interfaces: Sequence[UnilateralConstraints],
    chosen: Sequence[IntArray],
    loading: Loading,
    condensed: CondensedProblem,
    solution: Solution,
    state: DisplacementState,
    timer: Stopwatch,
    rounds: int,
    friction: Mapping[int, FrictionFields],
) -> ContactResult:
    """`ContactResult` of a solution of the condensed problem; `friction` by numbers of contacts."""
    contacts: list[ContactFields] = []
    springs: tuple[SpringState, ...] = ()
    number = {id(body): k for k, body in enumerate(scene.bodies)}
    start = 0
    for interface, candidates, gap in zip(interfaces, chosen, state.gaps, strict=False):
        forces = np.zeros(len(gap))
        forces[candidates] = solution.forces[start : start + len(candidates)]
        start += len(candidates)
        springs += interface.spring_states(forces, gap)
        if (contact := interface.as_contact) is not None:
            own, other = (state.displacements[number[id(body)]] for body in (contact.slave, contact.master))
            k = len(contacts)
            swapped = contact.slave is not scene.contacts[k].slave
            fields = contact_fields(contact, candidates, forces, gap, (own, other), swapped)
            rubbing = None if k not in friction else replace(friction[k], sign=fields.sign)
            contacts.append(replace(fields, friction=rubbing, directions=scene.directions))
    seconds = dict(timer.seconds)
    seconds["total"] = sum(seconds.values())
    memory = {"before": timer.before, **timer.memory}
    return ContactResult(
        scene, tuple(contacts), springs, solution, seconds, memory, rounds, _routes(scene), loading, condensed, state
    )


def _routes(scene: SceneModel) -> dict[str, str]:
    """Route to the compliance of each elastic body and its reason; models in several poses once."""
    models = {id(b.model): b for b in reversed(elastic_among(scene.bodies))}
    out = {}
    for b in reversed(models.values()):
        if (found := b.model.condensation) is not None:
            out[b.name] = f"{found.route}: {found.why}"
    return out
