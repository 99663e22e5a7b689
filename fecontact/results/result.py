"""Result of a scene: its fields, resultants, displacements, stresses and residuals; report, pictures and files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import ElasticBody, elastic_among
from fecontact.bodies.inner_fields import InnerFields
from fecontact.common.arguments import file_path, known_options, text
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import point_array
from fecontact.common.error_estimate import ResponseError
from fecontact.common.errors import InputError, optional, shown
from fecontact.common.files import check_writable
from fecontact.common.renamed import FormerNames
from fecontact.common.stopwatch import Stopwatch
from fecontact.common.units import UnitNames, Units
from fecontact.contact.condensed_problem import CondensedProblem, DisplacementState
from fecontact.contact.interface import Interface, UnilateralConstraints
from fecontact.contact.loads import Loading, mass_weighted
from fecontact.contact.model import SceneModel
from fecontact.contact.springs import SpringState
from fecontact.contact.step_end import StepEnd
from fecontact.results.cell_contact import is_half_space
from fecontact.results.contact_fields import ContactFields, contact_fields
from fecontact.results.convergence import Convergence
from fecontact.results.edge_pressure import EdgePressure, edge_pressure
from fecontact.results.friction_fields import FrictionFields
from fecontact.results.gradient import Gradient, result_gradient
from fecontact.results.linearisation import CarriedMotion, Equilibrium, LinearisationError, unbalanced
from fecontact.results.report import model_size, peak_memory, report
from fecontact.results.response_error import AtRest, ResponseErrors
from fecontact.results.resultants import hold_of_body, hold_of_boundary, resultant
from fecontact.results.warnings import notes_of, warnings_of
from fecontact.solvers import ContactProblem, Residuals, Solution, Status

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """Small rigid motion of a body: `translation` (3,) of `point` (3,) and `rotation` vector (3,), world axes."""

    translation: Array
    rotation: Array
    point: Array

    @property
    def components(self) -> list[float]:
        """Translation and rotation vector, six numbers."""
        return [*self.translation.tolist(), *self.rotation.tolist()]


@dataclass(frozen=True, eq=False)
class ContactResult(FormerNames):
    """Certified solution of a scene, with methods to print, draw and save it.

    Attributes
    ----------
    contacts : tuple of ContactFields
    springs : tuple of SpringState
    solution : Solution
        Solution of the condensed problem.
    seconds : dict
        Wall time by stage of the last solve, 'before' it (earlier poses or meshes, estimates), and 'total'.
    memory : dict
        Peak resident memory of the process in MB, 'before' and by the end of each stage (`Stopwatch.memory`).
    rounds : int
        Number of choices of candidates.
    condensation : dict
        Route to the compliance of each elastic body and its reason, by name; models in several poses once.
    convergence : Convergence, optional
        Solved to an accuracy: the steps on the way to it.
    friction : Solution, optional
        Solution of the condensed problem with friction; `solution` then is that of its normal forces alone, under the
        tangential forces found.
    finite_strain : tuple of Equilibrium
        With laws of finite strain: how Newton's method ended in each load step; else ().
    """

    scene: SceneModel
    contacts: tuple[ContactFields, ...]
    springs: tuple[SpringState, ...]
    solution: Solution
    seconds: dict[str, float]
    memory: dict[str, float]
    rounds: int
    condensation: dict[str, str]
    _loading: Loading = field(repr=False)
    _condensed: CondensedProblem = field(repr=False)
    _state: DisplacementState = field(repr=False)
    #: After a finite motion: the bodies as given; `scene` has them in their final poses.
    _originals: Sequence[Body] = ()
    #: Solved to an accuracy: the bodies before their meshes were divided; `scene` holds those of the last division.
    _unrefined: Sequence[Body] = ()
    convergence: Convergence | None = None
    #: Error of linearised motions, where it decided whether poses are updated (``finite_motion="auto"``).
    _linearisation: LinearisationError | None = field(default=None, repr=False)
    #: After a finite motion from the poses given: what carrying them along has changed.
    _carried: CarriedMotion | None = field(default=None, repr=False)
    friction: Solution | None = field(default=None, repr=False)
    #: With friction: what the next load step goes on from.
    _step_end: StepEnd | None = field(default=None, repr=False)
    #: Whether it belongs to a load path.
    _follows_step: bool = False
    finite_strain: tuple[Equilibrium, ...] = field(default=(), repr=False)

    @property
    def success(self) -> bool:
        """Whether the certificate holds; always true for a result that was returned."""
        return self.solution.success

    @property
    def status(self) -> str:
        """'solved' or 'no-contact'."""
        return str(self.solution.status)

    @property
    def message(self) -> str:
        """The status in a sentence."""
        if self.status == Status.NO_CONTACT and any(c._between_nodes.overlap for c in self.contacts):
            return "no contact point touches, but bodies overlap between the nodes: see the warnings"
        return self.solution.message

    @property
    def nit(self) -> int:
        """Iterations of the solver in the last round."""
        return self.solution.nit

    @property
    def problem(self) -> ContactProblem:
        """The condensed problem on the candidate points: S, g, B, F.

        The forces `solution.forces` (n,) minimise 1/2 l^T S l + g^T l over l >= 0 with B l = F; the gaps are
        S l + g + B^T q with q = `solution.q`. Rows are the candidates of one contact after the other, then springs.
        """
        return self.solution.problem

    @property
    def n_dofs(self) -> int:
        """Degrees of freedom of all elastic bodies."""
        return sum(b.n_unknowns for b in self._elastic_bodies)

    @property
    def _n_dofs_factorised(self) -> int:
        """The same, with a model in several poses counted once."""
        return sum({id(b.model): b.n_unknowns for b in self._elastic_bodies}.values())

    @property
    def _interfaces(self) -> tuple[Interface, ...]:
        """The paired contacts, one for each of `contacts`."""
        return tuple(c for i in self._condensed.interfaces if (c := i.as_contact) is not None)

    @property
    def _elastic_bodies(self) -> tuple[ElasticBody, ...]:
        """The scene's elastic bodies."""
        return elastic_among(self.scene.bodies)

    @property
    def _meshed_bodies(self) -> tuple[ElasticBody, ...]:
        """The scene's bodies with a mesh: elastic ones, and local ones."""
        pairs = zip(self.scene.bodies, self._state.displacements, strict=True)
        return tuple(cast(ElasticBody, b) for b, u in pairs if b._at_points(u) is not None)

    @property
    def n_candidates(self) -> int:
        """Candidate points of all contacts."""
        return 0 if self._only_tied else self.solution.problem.n

    @property
    def _only_tied(self) -> bool:
        """Whether nothing may touch: parts of bodies are tied to each other only."""
        return not (self.contacts or self.springs)

    @property
    def n_active(self) -> int:
        """Points that carry force."""
        return int((self.solution.forces > 0).sum())

    def _number(self, body: Body) -> int:
        for bodies in (self.scene.bodies, self._originals, self._unrefined):
            for k, b in enumerate(bodies):
                if b is body:
                    return k
        raise InputError(f"{getattr(body, 'name', None) or shown(body)!r} is not a body of this result's scene.")

    def _elastic(self, body: Body) -> tuple[int, ElasticBody]:
        k = self._number(body)
        for posed in elastic_among([self.scene.bodies[k]]):
            return k, posed
        raise _no_field(body)

    def solved(self, body: Body) -> Body:
        """The body as it was solved, in its final pose and on its last mesh, to which its fields belong."""
        return self.scene.bodies[self._number(body)]

    def _given(self, body: Body) -> Body:
        """The body in its given pose; `scene` has it in its final pose after a finite motion."""
        return self._originals[self._number(body)] if self._originals else body

    def _given_points(self, body: Body) -> Array:
        """World positions (n_points, 3) of the nodes of a body with a mesh before the loads."""
        given = cast(ElasticBody, self._given(body))
        return given.pose.to_world(given.mesh.points)

    def _moved_with_pose(self, k: int, points: Array) -> Array:
        """World displacements (n, 3) of points (n, 3) of body k due to the change of its pose in a finite motion."""
        now = self.scene.bodies[k]
        return now.pose.to_world(points) - self._given(now).pose.to_world(points)

    def displacement(self, body: Body) -> Array:
        """Total displacement (n_points, 3) of the body's nodes from their given positions, in world axes."""
        k = self._number(body)
        posed = self.scene.bodies[k]
        own = posed._at_points(self._state.displacements[k])
        if own is None:
            why = "is rigid" if body.is_rigid else "has no mesh"
            raise InputError(f"{body.name!r} {why}: it has no displacement field; see rigid_motion.", code="rigid")
        mesh = cast(ElasticBody, posed).mesh
        return self._moved(k, own, mesh.points) + self._deformed(k)

    def _deformed(self, k: int) -> Array:
        """World displacements (n_points, 3) of the mesh's points by the state of a body at finite strain; else zero."""
        now = self.scene.bodies[k]
        return np.zeros(3) if now._deformation is None else now._deformation @ self._given(now).pose.rotation.T

    def _moved(self, k: int, own: Array, points: Array) -> Array:
        """World displacements (n, 3) of points (n, 3) of body k from their given positions; `own` in its axes."""
        own = own @ self.scene.bodies[k].pose.rotation.T
        return own + self._moved_with_pose(k, points) if self._originals else own

    def strain(self, body: Body) -> Array:
        """Strain (n_points, 6) at the nodes, components as in `common.material.VOIGT`, in the body's own axes."""
        return self._inner(body).strain()

    def stress(self, body: Body, group: str | None = None) -> Array:
        """Stress (n_points, 6) at the nodes, tension positive, in the body's own axes.

        Evaluated at the Gauss points, extrapolated and averaged; components xx, yy, zz, xy, yz, xz. Of a local body
        that is the smooth part, to which the half-space's field below its window is added.

        Parameters
        ----------
        body : Body
        group : str, optional
            An element set of its mesh, such as the cells of one material: only these are averaged, since stress jumps
            where two materials meet, and all other nodes get NaN.
        """
        inner = self._inner(body)
        groups = inner.model.mesh.groups
        if group is not None and text("the name of an element set", group) not in groups:
            known = ", ".join(map(repr, groups)) or "none"
            raise InputError(f"The mesh of {body.name!r} has no element set {group!r}. Its sets are: {known}.")
        return inner.stress(None if group is None else groups[group])

    def gradient(
        self,
        what: str | ArrayLike | Mapping[Body, ArrayLike] = "max_pressure",
        contact: int = 0,
        of: Sequence[str] = ("gaps", "loads", "E"),
    ) -> Gradient:
        """Derivatives of a figure of a contact by gaps, loads and moduli, by one back substitution (the adjoint).

        Parameters
        ----------
        what : {'max_pressure', 'force'}, (n,) array_like or mapping of Body to (6,) array_like
            A figure, or the weights of a linear functional of the pressures at the contact's points, or of the rigid
            motions of bodies, as in `rigid_motion`. The gradient of a function of pressures or motions is that with its
            derivatives as weights.
        contact : int
            Its number in the scene; of motions there is no need for it.
        of : sequence of {'gaps', 'loads', 'E'}
            By what; moduli take a solution of each body.

        Raises
        ------
        InputError
            For another figure or contact, or a result whose poses were carried along, of finite strain, or of a path.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
        >>> floor = fc.RigidBody(fc.Plane())
        >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
        >>> slope = result.gradient("force")  # 0.01 E, and -E by gaps that widen together
        >>> round(slope.E[body], 9), round(float(slope.gaps[0].sum()), 9)
        (0.01, -1.0)
        """
        return result_gradient(self, what, contact, of)

    def strain_energy(self, body: Body) -> float:
        """Elastic energy of a body; of a section by its thickness or over the whole circle, as its forces are.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
        >>> floor = fc.RigidBody(fc.Plane())
        >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
        >>> round(result.strain_energy(body), 12)
        5e-05
        """
        k, elastic = self._elastic(body)
        rigid = self._loading.frames[k].modes(self._state.motions[k][:, None])[:, 0]
        if self._condensed.parts[k].frame.heated is not None:
            return float(self._response_errors.primal[k].energy.sum()) / 2
        return elastic.model.strain_energy(self._state.displacements[k] - rigid)

    def fields_at(self, body: Body, points: ArrayLike) -> tuple[Array, Array]:
        """Total displacement (n, 3) in world axes and stress (n, 6) in the body's own axes at points of a body.

        Parameters
        ----------
        body : Body
            An elastic body in space or a local body. Below the window of a local body they are as fine as its cells;
            elsewhere the nodal fields of the mesh are interpolated in its cells.
        points : (n, 3) array_like
            In the body's own axes, within it as it was given; at finite strain, too, before its deformation.

        Returns
        -------
        displacement : (n, 3) array
            From the given positions, as `displacement`.
        stress : (n, 6) array
            As `stress`, components xx, yy, zz, xy, yz, xz, tension positive.

        Raises
        ------
        InputError
            If a point is outside the body, or the body has no mesh inside or is a section.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
        >>> floor = fc.RigidBody(fc.Plane())
        >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
        >>> u, stress = result.fields_at(body, [[0.5, 0.3, 0.1]])
        >>> round(float(u[0, 2]), 9), round(float(stress[0, 2]), 9)
        (-0.001, -0.01)
        """
        where = point_array("points", points, 3).reshape(-1, 3)
        inner = self._inner(body)
        if inner.model.mesh.is_flat:
            raise InputError(f"{body.name!r} is a section; fields at points are offered for bodies in space.")
        u, stress, found = inner.at(where)
        if not found.all():
            corners = (
                np.array2string(f(inner.model.mesh_at_rest.points, axis=0), precision=6) for f in (np.min, np.max)
            )
            raise InputError(
                f"{(~found).sum()} of {len(found)} points are not in {body.name!r}, the first: "
                f"{np.array2string(where[np.argmin(found)], precision=6)}. Points are given in the body's own axes"
                f"{', before its deformation' if self.finite_strain else ''}; its mesh reaches from "
                f"{' to '.join(corners)}.",
                code="points-outside-body",
            )
        k = self._number(body)
        now = self.scene.bodies[k]
        if now._deformation is not None:
            return now.pose.to_world(where + u) - self._given(now).pose.to_world(where), stress
        return self._moved(k, u, where), stress

    def _inner(self, body: Body) -> InnerFields:
        k = self._number(body)
        part = self._condensed.parts[k]
        forces = (self.friction or self.solution).forces[part.index]
        inner = self.scene.bodies[k]._inner_fields(self._state.displacements[k], part.rows, forces)
        if inner is None:
            raise _no_field(body)
        return replace(inner, heated=part.frame.heated)

    @cached_property
    def _motions(self) -> Array:
        """Rigid motions (n_bodies, 6) in the present problem, as in `rigid_motion`, in the order of the scene."""
        return np.stack([self._motion(k) for k in range(len(self.scene.bodies))])

    def _motion(self, k: int) -> Array:
        body, frame, motion = self.scene.bodies[k], self._loading.frames[k], self._state.motions[k]
        if body.free_motions.shape[1] == 0:
            return motion
        elastic = self._state.displacements[k] - frame.modes(motion[:, None])[:, 0]
        found = motion + self._drift(k, elastic)
        part = self._condensed.parts[k]
        if part.hold is not None:
            f = part.rows.T @ (self.friction or self.solution).forces[part.index]
            mean = part.hold.of_elastic(f if part.loads is None else f + part.loads)
            found = found + frame.mean_held @ (mean - part.hold.mean @ elastic)
        return np.asarray(found)

    def _drift(self, k: int, displacement: Array) -> Array:
        """Mean motion (6,) of body k by displacements (n_dofs,), weighted by mass, where no support resists it."""
        body, frame = self.scene.bodies[k], self._loading.frames[k]
        Q = body.pose.rotation
        floating = np.concatenate([Q @ body.free_motions[:3], Q @ body.free_motions[3:]])
        modes = frame.modes(floating)
        weighted = mass_weighted(frame, floating)
        return np.asarray(floating @ np.linalg.solve(modes.T @ weighted, weighted.T @ displacement))

    def rigid_motion(self, body: Body) -> RigidMotion:
        """Rigid motion of a body about its reference point.

        That of the frame for supported components; that of the mean position weighted by mass (Elangovan 1978, eq.
        A-17) for others. After a finite motion: from the original pose, with a rotation vector.
        """
        k = self._number(body)
        state, motion = self.scene.bodies[k]._deformation, self._motions[k]
        return self._since_given(k, motion if state is None else motion + self._drift(k, state.ravel()))

    def _since_given(self, k: int, motion: Array) -> RigidMotion:
        """The motion of body k from its given pose, with a last part (6,)."""
        body, frame = self.scene.bodies[k], self._loading.frames[k]
        if not self._originals:
            return RigidMotion(motion[:3], motion[3:], frame.point)
        start = self._originals[k].pose
        point = start.to_world(body.reference_point)
        turn = Rotation.from_matrix(body.pose.rotation @ start.rotation.T).as_rotvec()
        return RigidMotion(frame.point - point + motion[:3], turn + motion[3:], point)

    @cached_property
    def _response_errors(self) -> ResponseErrors:
        """Parts of the bodies' cells in the errors of forces and motions."""
        return ResponseErrors(
            self._condensed,
            self.solution,
            self._state,
            self.contacts,
            self.friction,
            lambda b: self.rigid_motion(b).rotation,
            self._at_rest if self.finite_strain else None,
        )

    @property
    def _at_rest(self) -> AtRest:
        """Gaps of the candidates before bodies at finite strain deformed and moved, along the present normals."""
        n, driven = self._condensed.problem.n, False
        gaps, closing = np.zeros(n), np.zeros(n)
        now = np.concatenate([np.zeros(0), *(c.gap[c._candidates] for c in self.contacts)])
        gaps[: len(now)] = now
        for k, part in enumerate(self._condensed.parts):
            motion, frame = self._since_given(k, self._state.motions[k]), self._loading.frames[k]
            whole = frame.modes(np.concatenate([motion.translation, motion.rotation])[:, None])[:, 0]
            deformed = self._state.displacements[k] - frame.modes(self._state.motions[k][:, None])[:, 0]
            if (state := part.body._deformation) is not None:
                deformed = deformed + state.ravel()
            closing[part.index] -= part.rows @ whole
            gaps[part.index] -= part.rows @ (whole + deformed)
            driven |= bool(self._loading.driving(k, part.free).any())
        return AtRest(gaps, closing, driven)

    @property
    def response_error(self) -> ResponseError:
        """Estimated errors of forces, where motions are given, and of motions, by the elements of whole bodies.

        Examples
        --------
        Cells of eight nodes, two across, bend too stiffly:

        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((8.0, 1.0, 1.0), (16, 2, 2), element="hex8").translated((0.0, -0.5, 0.0))
        >>> beam = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="top", supports={"x_min": "xyz"})
        >>> ball = fc.RigidBody(fc.Sphere(5.0)).placed((6.4, 0.0, 1.0))
        >>> result = fc.Scene([beam, ball], [fc.Contact(beam, ball)]).solve(motions={ball: {"z": -0.1}})
        >>> print(result.response_error)
        force about 23 %
        """
        if any(
            contact.worn is not None for contact in self.contacts
        ):  # motions have the worn depth, which no body gives
            return ResponseError()
        return self._response_errors.estimate

    def boundary_motion(self, body: Body, name: str) -> Array:
        """Mean displacement (3,) of a boundary in world axes, weighted by nodal areas."""
        k, elastic = self._elastic(body)
        along_z = elastic.model.traction(name, lambda x, n: np.broadcast_to([0.0, 0.0, 1.0], x.shape))
        weights = along_z.reshape(-1, 3)[:, 2]
        area = along_z @ elastic.model.rigid_modes[:, 2]
        total = elastic.pose.rotation @ (weights @ self._state.displacements[k].reshape(-1, 3)) / area
        if self.finite_strain:
            return np.asarray(weights @ self.displacement(body) / area)
        if not self._originals:
            return total
        # the rotational modes, x -> e x (x - c), give the boundary's centre
        turns = np.tensordot(weights, elastic.model.rigid_modes.reshape(-1, 3, 6), 1)[:, 3:] / area
        centre = elastic.reference_point + np.array([-turns[2, 1], turns[2, 0], -turns[1, 0]])
        return total + self._moved_with_pose(k, centre[None])[0]

    def reaction(self, body: Body, boundary: str | None = None) -> Array:
        """Reaction (6,) on a body: force and moment about its reference point, in world axes.

        Parameters
        ----------
        body : Body
        boundary : str, optional
            A supported boundary of an elastic body.

        Returns
        -------
        (6,) array
            Without a boundary: the reaction on the body's frame, from the equilibrium of the body under its loads,
            contacts and springs; zero in free components. With one: the force of the frame on that boundary, from the
            nodal forces there. The latter, summed over all supports, equal the former plus the load on the body as a
            whole.

        Examples
        --------
        >>> import fecontact as fc
        >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
        >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
        >>> floor = fc.RigidBody(fc.Plane())
        >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
        >>> round(float(result.reaction(body)[2]), 12), round(float(result.reaction(floor)[2]), 12)
        (-0.01, 0.01)
        """
        k = self._number(body)
        part, forces = self._condensed.parts[k], (self.friction or self.solution).forces
        if boundary is None:
            return hold_of_body(part, self._loading, k, forces)
        return hold_of_boundary(self._elastic(body)[1], part, boundary, self._state.displacements[k], forces)

    def residuals(self) -> Residuals:
        """Violations of the conditions of contact and friction, recomputed from the problem; all relative.

        Penetration covers the points outside the candidates too. Equilibrium is the larger of the condensed problem's
        and of the balance of forces and moments of every pair of bodies in contact and on every free frame; at finite
        strain also of the forces on every node of every body.
        """
        r = (self.friction or self.solution).residuals
        gaps = (c.gap if c.overclosure is None else c.gap + c.overclosure for c in self.contacts)
        outside = max((float(-gap.min(initial=0.0)) for gap in gaps), default=0.0)
        scale = self._state.scale if self._state.scale > 0 else 1.0
        equilibrium = max([r.equilibrium, self._unbalanced, *map(self._imbalance, self._interfaces, self.contacts)])
        return replace(r, penetration=max(r.penetration, outside / scale), equilibrium=equilibrium)

    def _forces_inside(self, body: Body) -> Array:
        """Forces (n_points, 3) that the elements of an elastic body take up at its nodes, in its axes."""
        k, elastic = self._elastic(body)
        rigid = self._condensed.parts[k].frame.modes(self._state.motions[k][:, None])[:, 0]
        forces = elastic.model.internal_forces(self._state.displacements[k] - rigid)
        heated = self._condensed.parts[k].frame.heated
        return (forces if heated is None else forces - heated.forces).reshape(-1, 3)

    @cached_property
    def _unbalanced(self) -> float:
        """Largest unbalanced force on a node, see `results.finite_strain`; zero of contacts without laws."""
        worst, forces = 0.0, (self.friction or self.solution).forces
        for part in self._condensed.parts if self.finite_strain or self._only_tied else ():
            for body in elastic_among([part.body]):
                worst = max(worst, unbalanced(part, forces, self._forces_inside(body).ravel()))
        return worst

    def _imbalance(self, interface: Interface, fields: ContactFields) -> float:
        """Resultant of the forces on slave and master together (six components), relative to the forces."""
        if fields.total_force == 0:
            return 0.0
        # the forces are equal and opposite by construction; their lines of action must coincide
        couple = fields.forces @ interface.pairing.couple_residual(interface.slave_nodes)
        return float(np.linalg.norm(couple) / (fields.total_force * interface.slave.size))

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
        start = np.cumsum([0] + [len(c._candidates) for c in self.contacts])
        forces = self.solution.forces
        pairs = zip(self.contacts, start[:-1].tolist(), strict=True)
        return tuple(edge_pressure(c, self.problem, first, forces) for c, first in pairs)

    @property
    def unit_names(self) -> Units:
        """Units of the scene's numbers."""
        return self.scene.unit_names

    def plot(
        self, what: str = "pressure", path: str | Path | None = None, *, units: UnitNames = (), **options: Any
    ) -> Figure:
        """Picture of a field, see `fecontact.results.pictures.draw`; written to `path` if given.

        Names of `units`, ``("mm", "N", "MPa")`` or that of the field alone, are those of the scene unless given.
        """
        from fecontact.results.pictures.draw import plot_result

        return plot_result(self, what, path, units=units, **options)

    def show(
        self, field: str = "von_mises", path: str | Path | None = None, *, units: UnitNames = (), **options: Any
    ) -> None:
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

        show_result(self, field, path, units=units, **options)

    def report(self, path: str | Path, *, units: UnitNames = (), **options: Any) -> Path:
        """Write a page of tables, pictures, warnings and the certificate, see `fecontact.results.page.write_page`.

        Parameters
        ----------
        path : str or Path
            A file ``.html``; it needs no other file.
        units : (length, force) or (length, force, stress)
            Names of units; those of the scene unless given.
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
        return write_page(self, check_writable(path), units=units, **options)

    def _repr_html_(self) -> str:
        from fecontact.results.page import notebook_cell

        return notebook_cell(self)

    def save(self, path: str | Path, *, units: UnitNames = ()) -> Path:
        """Write the result; the suffix decides: .vtu (ParaView), .json (summary), .csv (contact points), .npz (arrays).

        An .npz file has the condensed problem (S where it is an array, g, B, F; with friction points, tangents, mu),
        forces and motions q, and of each contact k points_k, normals_k, pressure_k and gap_k. With names of `units`
        heads of a .csv have them, and .json and .npz an entry ``units``; a .vtu has no place for them.
        """
        from fecontact.results.files import save_result

        return save_result(self, path, units)

    def to_pyvista(self) -> Any:
        """The bodies with their fields as a pyvista UnstructuredGrid, as the .vtu file has them.

        Raises
        ------
        MissingPackageError
            If pyvista is not installed.
        InputError
            If no body has a mesh.
        """
        read = optional("pyvista", "A grid of the bodies", "'fecontact[view]'").read
        with TemporaryDirectory() as folder:
            return read(self.save(Path(folder) / "result.vtu"))

    def summary(self) -> dict[str, Any]:
        """Figures for scripts, ready for JSON."""
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
            "bodies": [
                {"name": b.name, "reaction": self.reaction(b).tolist(), "motion": m.components}
                for b, m in ((b, self.rigid_motion(b)) for b in self.scene.bodies)
            ],
            "warnings": list(self.warnings),
            "notes": list(self.notes),
            "springs": [
                {"name": s.spring.name, "tension": s.tension, "elongation": s.elongation} for s in self.springs
            ],
            "residuals": self.residuals().as_dict(),
            "seconds": dict(self.seconds),
            "memory_mb": dict(self.memory),
            "peak_rss_mb": peak_memory(),
            "saved": model_size(self),
            **({} if self.convergence is None else {"convergence": self.convergence.as_dict()}),
            **({"finite_strain": [asdict(each) for each in self.finite_strain]} if self.finite_strain else {}),
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
        return report(self)


def _no_field(body: Body) -> InputError:
    if body.is_rigid:
        return InputError(f"{body.name!r} is rigid: it has no displacement field; see rigid_motion.", code="rigid")
    return InputError(f"{body.name!r} has no field of finite elements by itself; see displacement and contacts.")


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
            places = [number[id(body)] for body in (contact.slave, contact.master)]
            own, other = (state.displacements[place] for place in places)
            one, two = (loading.frames[place].heated for place in places)
            k = len(contacts)
            swapped = contact.slave is not scene.contacts[k].slave
            fields = contact_fields(contact, candidates, forces, gap, (own, other), swapped)
            tangential = None if k not in friction else replace(friction[k], sign=fields._sign)
            alone = contact.master.is_rigid and solution.problem.n == len(candidates)
            problem = solution.problem if alone and is_half_space(fields._surface) else None
            fields = replace(fields, friction=tangential, directions=scene.directions, worn=contact.worn)
            fields = replace(fields, _heated=(one, two))
            if contact.overclosure is not None:
                overlap = np.where(forces > 0, contact.starts, 0.0) + contact.own_compliance * forces
                softness = float(contact.overclosure.lines[0].max())
                fields = replace(fields, gap=gap - contact.starts, overclosure=overlap, _softness=softness)
            contacts.append(replace(fields, _cell_problem=problem))
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
