"""Error of linearised motions: change of gaps and lines of action when the same motions are finite.

At finite strain, equilibrium as Newton's method found it, and as forces at the nodes tell it.

The problem of a scene is linear in the displacements of its surfaces. A tangential motion d of a surface of curvature k
changes the gap by a further k d^2 / 2 or so, and a rotation changes the direction of the forces. Both are measured at
the pairs in contact, without a further solve: the surfaces are projected on each other again after the bodies' rigid
motions and the mean of their deflections in the contact (a sphere on a bending arm moves with it).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from fecontact.bodies.body import Body
from fecontact.bodies.elastic import elastic_among
from fecontact.bodies.pose import Pose, turned
from fecontact.common.arrays import Array, IntArray, Mask, cross
from fecontact.contact.condensed_problem import BodyBlock
from fecontact.contact.interface import Interface
from fecontact.contact.springs import SpringState
from fecontact.fem.rigid import COMPONENTS
from fecontact.results.contact_fields import ContactFields
from fecontact.surfaces.facet_surface import Projection, Surface, with_nodes

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult


@dataclass(frozen=True)
class LinearisationError:
    """Errors of a result due to linearised motions.

    Attributes
    ----------
    gap : float
        Largest change of a gap or of a spring's length; infinite where contact is lost or missed.
    approach : float
        Largest elastic approach of two surfaces or elongation of a spring, the scale of `gap`.
    direction : float
        Change (radians) of the direction of a contact's resultant or of a spring.
    stretch : float
        Largest stretch of a body by a linearised rotation t: t^2 / 2.
    friction : float
        Change of tractions of friction (L2), relative, as normals turn.
    deflected : float
        Shift of a contact by what its bodies deflect, which poses do not take up, over its whole shift.
    """

    gap: float
    approach: float
    direction: float
    stretch: float = 0.0
    friction: float = 0.0
    deflected: float = 0.0

    @property
    def worst(self) -> float:
        """The largest of the change of gap over the approach, of direction, and of the stretch."""
        return max(self.gap / self.approach, self.direction, self.stretch)


@dataclass(frozen=True)
class CarriedMotion:
    """What carrying the poses along has changed, against the answer to linearised motions.

    Attributes
    ----------
    motion : float
        Largest change of a rigid motion, relative to the largest motion; rotations by the size of their body.
    force : float
        Largest change of a contact's force, relative to the largest.
    rest : float
        The motion by which the poses would go on, relative to the largest: what is still linearised.
    """

    motion: float
    force: float
    rest: float


#: Tolerated error of linearised motions, relative to the approach.
BEARABLE = 1e-3
#: Largest number of points examined in contact, and of the nearest others.
MAX_POINTS = 400
#: Opening by a unit of a rigid motion, relative to the largest, below which the motion changes no gap.
NEUTRAL = 1e-7
#: Largest weight of inner nodes in a closest point on the rim.
ON_RIM = 1e-9
#: Share of the force up to which a point does not make a contact wider.
ALONE = 1e-6
#: Least approach, relative to the smallest body, used as a scale: less is rounding.
MIN_APPROACH = 1e-9


def linearisation_error(result: ContactResult) -> LinearisationError:
    """Errors of a result due to linearised rigid motions.

    Parameters
    ----------
    result : ContactResult

    Returns
    -------
    LinearisationError
        The one that the result already has, if it was judged before.
    """
    if result._linearisation is not None:
        return result._linearisation
    least = MIN_APPROACH * float(result.scene.sizes.min())
    found = [LinearisationError(0.0, least, 0.0)]
    motions = driven_motions(result)
    after = {
        id(f.body): _Motion(f.body, f.point, m, _driven(result, k, m))
        for k, (f, m) in enumerate(zip(result._loading.frames, motions, strict=True))
    }
    contacts = zip(result._interfaces, result.contacts, strict=True)
    if np.any(motions):
        found += [_of_contact(i, c, after) for i, c in contacts]
        found += [_of_spring(s, after) for s in result.springs]
    else:
        found += [_of_contact(i, c, after) for i, c in contacts if _turn_by_deflection(i, c, after) > BEARABLE]
    return LinearisationError(
        gap=max(e.gap for e in found),
        approach=max(e.approach for e in found),
        direction=max(e.direction for e in found),
        stretch=max(float(m[3:] @ m[3:]) / 2 for m in motions),
        friction=max(e.friction for e in found),
        deflected=max(e.deflected for e in found),
    )


def driven_motions(result: ContactResult) -> Array:
    """Rigid motions (n_bodies, 6) of a result, without those that change no gap: undetermined ones, and twists."""
    motions = result._motions
    if result.scene.twists:
        motions = motions * (np.arange(6) != COMPONENTS.index("rz"))
    B = result._condensed.problem.B
    if not len(B):
        return motions
    squares, directions = np.linalg.eigh(B @ B.T)
    neutral = directions[:, squares <= NEUTRAL**2 * squares[-1]]
    scale = np.where(np.arange(6) < 3, 1.0, result.scene.sizes[:, None])
    count = np.cumsum([0] + [p.free.shape[1] for p in result._condensed.parts])
    fields = [p.frame.free @ neutral[a:b] for p, a, b in zip(result._condensed.parts, count, count[1:], strict=False)]
    basis, _ = np.linalg.qr(scale.reshape(-1, 1) * np.concatenate(fields))
    flat = (scale * motions).ravel()
    return np.asarray((flat - basis @ (basis.T @ flat)).reshape(motions.shape) / scale)


def _driven(result: ContactResult, k: int, motion: Array) -> Array | None:
    """Displacements (n_points, 3) of an elastic body, in the world, less its neutral motion; None for others."""
    body, frame = result.scene.bodies[k], result._loading.frames[k]
    u = body._at_points(result._state.displacements[k] - frame.modes((result._motions[k] - motion)[:, None])[:, 0])
    return None if u is None else u @ body.pose.rotation.T


@dataclass(frozen=True, eq=False)
class _Motion:
    """A small rigid motion (6,) of a body about a world point, linearised and finite.

    `displacements` (n_points, 3) of an elastic body's points include its deflection.
    """

    body: Body
    point: Array
    motion: Array
    displacements: Array | None = None

    def in_contact(self, weights: sp.csr_matrix | None, places: Array, forces: Array) -> _Motion:
        """The motion with the mean translation of contact points (n, 3), weighted by their forces (n,).

        `weights` (n, n_points) interpolate the contact points from the body's points. Rotations are those of the body:
        the slope of an indentation on half a contact (with a plane of symmetry) is not a rotation.
        """
        if self.displacements is None or weights is None or not forces.any():
            return self
        if weights.shape[1] != len(self.displacements):  # a surface with its own points
            return self
        deflection = weights @ self.displacements - self.linear(places)
        shift = forces @ deflection / forces.sum()
        return _Motion(self.body, self.point, self.motion + np.concatenate([shift, np.zeros(3)]))

    def linear(self, points: Array) -> Array:
        """Displacements (n, 3) of world points (n, 3)."""
        return np.asarray(self.motion[:3] + cross(self.motion[3:], points - self.point))

    @property
    def pose(self) -> Pose:
        """The pose after the finite motion."""
        return turned(self.body.pose, self.motion, self.point)


def _turn_by_deflection(interface: Interface, fields: ContactFields, after: dict[int, _Motion]) -> float:
    """Bound (radians) of how far normals turn as bodies deflect: the curvature of the contact times the deflections."""
    if not fields.active.any():
        return 0.0
    # sizes that no turn of the scene changes
    pressed = (v[fields.active] for v in (fields.points, fields.normals))
    width, spread = (float(np.linalg.norm(v - v.mean(axis=0))) for v in pressed)
    deflected = (after[id(body)].displacements for body in (interface.slave, interface.master))
    size = sum(float(np.linalg.norm(u, axis=1).max()) for u in deflected if u is not None)
    return size * spread / width if width > 0 else 0.0


def _of_contact(interface: Interface, fields: ContactFields, after: dict[int, _Motion]) -> LinearisationError:
    chosen = _looked_at(fields)
    active = fields.forces[chosen] > 0
    surface = interface.master.surface(interface.surfaces[1])
    x = fields.points[chosen]
    own = interface.slave.pose.to_body(x)
    before = surface.project(interface.master.pose.to_body(x))
    lines = before.normals @ interface.master.pose.rotation.T
    foot = interface.master.pose.to_world(before.points)

    def closing(one: _Motion, other: _Motion) -> Array:
        return np.asarray(before.gap + np.einsum("ni,ni->n", lines, one.linear(x) - other.linear(foot)))

    rigid_motions = slave, master = after[id(interface.slave)], after[id(interface.master)]
    rigid = closing(slave, master)
    slave = slave.in_contact(_nodes_of(interface, chosen), x, fields.forces[chosen])
    master = master.in_contact(before.weights, foot, fields.forces[chosen])
    there = master.pose
    projection = surface.project(there.to_body(slave.pose.to_world(own)))
    linear = closing(slave, master)
    seen = ~(before.outside | projection.outside)
    inside = seen & ~(_at_rim(surface, before) | _at_rim(surface, projection))
    # a closest point on the rim does not show how the surface continues
    seen = inside if (active & inside).any() else seen
    if not active.any():
        overlooked = bool((projection.gap[seen] < -MIN_APPROACH * interface.slave.size).any())
        return LinearisationError(np.inf if overlooked else 0.0, 1.0, 0.0)
    if not (active & seen).any():
        return LinearisationError(np.inf, 1.0, 0.0)
    change = projection.gap - linear
    approach = min(max(float(-rigid[active].min()), 0.0), _indentation(fields))
    # others count where the change would bring them into contact
    counted = seen & (active | (fields.gap[chosen] + change < -BEARABLE * approach))
    forces = np.where(active & seen, fields.forces[chosen], 0.0)
    turn = _smooth(surface, projection) @ there.rotation.T - _smooth(surface, before) @ interface.master.pose.rotation.T
    direction = float(np.linalg.norm(forces @ turn) / forces.sum())
    friction = _of_friction(fields, chosen, forces, turn)
    shifts = [forces @ (a.linear(x) - b.linear(foot)) / forces.sum() for a, b in ((slave, master), rigid_motions)]
    along = forces @ lines / forces.sum()
    whole, left = (np.linalg.norm(np.cross(along, s)) for s in (shifts[0], shifts[0] - shifts[1]))
    deflected = float(left / whole) if whole > 0 else np.inf
    return LinearisationError(float(np.abs(change[counted]).max()), approach, direction, 0.0, friction, deflected)


def _of_friction(fields: ContactFields, chosen: IntArray, forces: Array, turn: Array) -> float:
    """Change of friction as normals turn by `turn` (n, 3) under `forces` (n,), relative (L2); none below `BEARABLE`.

    A pressure p that turns by an angle has the part p times the angle across: where points stick it is friction, as
    they are held in place, and where they slip it turns the resultant.
    """
    if fields.friction is None:
        return 0.0
    root = np.sqrt(fields.weights[chosen, None])
    added, pressed, tangential = (
        float(np.linalg.norm(f / root))
        for f in (forces[:, None] * turn, forces[:, None], fields.friction.forces[chosen])
    )
    return added / tangential if tangential and added > BEARABLE * pressed else 0.0


def _nodes_of(interface: Interface, chosen: IntArray) -> sp.csr_matrix:
    """Weights (n_chosen, n_nodes) that select nodal values of the chosen points."""
    n, nodes = len(chosen), interface.pairing.nodes[chosen]
    return sp.csr_matrix((np.ones(n), nodes, np.arange(n + 1)), shape=(n, len(interface.slave_nodes)))


def _indentation(fields: ContactFields) -> float:
    """Scale of the indentation: p b / E*, b three times the radius of gyration of the forces; infinite for one point.

    For a sphere about 0.8 of the approach.
    """
    softness = 1 / fields.slave.contact_modulus + 1 / fields.master.contact_modulus
    total = fields.total_force
    # by what carries, and not by a distance of rounding: a point alone has none from itself
    if np.count_nonzero(fields.forces > ALONE * total) < 2:
        return np.inf
    arm = fields._centres - fields.forces @ fields._centres / total
    width = 3 * float(np.sqrt(fields.forces @ (arm**2).sum(axis=1) / total))
    return total / fields.point_area * width * softness


def _looked_at(fields: ContactFields) -> IntArray:
    """Points in contact and the nearest others, at most `MAX_POINTS` each; all pairs without contact."""
    active = np.flatnonzero(fields.active)
    others = fields._candidates[fields.forces[fields._candidates] <= 0] if len(active) else np.arange(len(fields.gap))
    nearest = others[np.argsort(fields.gap[others], kind="stable")[:MAX_POINTS]]
    return np.concatenate([active[:: 1 + len(active) // MAX_POINTS], nearest])


def _at_rim(surface: Surface, projection: Projection) -> Mask:
    """Mask of closest points (n,) on the rim: interpolated from rim nodes only."""
    if projection.weights is None:
        return np.zeros(len(projection.gap), bool)
    inner = abs(projection.weights) @ ~with_nodes(surface).rim_nodes
    return np.asarray(inner <= ON_RIM)


def _smooth(surface: Surface, projection: Projection) -> Array:
    """Normals (n, 3) at closest points, continuous between facets."""
    return projection.normals if projection.weights is None else with_nodes(surface).smooth_normals(projection)


def _of_spring(state: SpringState, after: dict[int, _Motion]) -> LinearisationError:
    """The same for a spring that carries, or would carry, a force."""
    spring = state.spring
    motions = [None if body is None else after[id(body)] for body in spring.carriers]
    finite, arc = spring.way([None if motion is None else motion.pose for motion in motions])
    length, linear = arc + sum(strand.length for strand in finite), spring.length
    for strand in spring.strands:
        for which, place, sign in zip(strand.carriers, strand.ends, (-1.0, 1.0), strict=True):
            if (motion := motions[which]) is not None:
                linear += sign * float(strand.direction @ motion.linear(place[None])[0])
    assert spring.slack_length is not None
    if state.tension == 0 and length <= spring.slack_length:
        return LinearisationError(0.0, 0.0, 0.0)
    turn = np.inf
    if all(strand.length > 0 for strand in finite):  # those at its ends, as others may touch a cylinder or leave it
        both = ((finite[k].direction, spring.strands[k].direction) for k in (0, -1))
        turn = max(float(np.linalg.norm(now - before)) for now, before in both)
    return LinearisationError(abs(length - linear), abs(state.elongation), turn if state.tension else 0.0)


#: Largest force inside a body that counts as none, over its size and its largest stiffness: rounding, 2e-16 of these,
#: is then below the tolerance of 1e-8.
REST = 1e-7


@dataclass(frozen=True)
class Equilibrium:
    """How a load step at finite strain ended.

    Attributes
    ----------
    iterations : int
    change : float
        Largest displacement of the last iteration, relative to the size of the bodies.
    residual : float
        Largest force on a node that is not balanced, relative to the largest force inside.
    unstable : str
        Of an equilibrium that is not stable: the body and the motion, in words.
    """

    iterations: int
    change: float
    residual: float
    unstable: str = ""


def unbalanced(part: BodyBlock, forces: Array, inner: Array | None) -> float:
    """Largest force on a node that is not balanced, relative to the largest inside; zero of bodies without nodes.

    Parameters
    ----------
    part : BodyBlock
    forces : (n,) array
        Of the problem.
    inner : (n_dofs,) array, optional
        Forces inside the body.
    """
    if inner is None:
        return 0.0
    (body,) = elastic_among([part.body])
    given = part.rows.T @ forces[part.index] + part.external
    rest = body.model.solved_forces((given if part.hold is None else part.hold.balanced(given)) - inner)
    unstrained = REST * body.size * float(body.model.stiffness.diagonal().max())
    return float(np.abs(rest).max(initial=0.0)) / max(float(np.abs(inner).max()), unstrained)
