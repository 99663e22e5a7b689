"""Visco-elastic half-spaces: the memory of pressures and tractions.

At a constant Poisson's ratio displacements are those at once, of a compliance K, by forces f and what is left of them,

    u = K (f + sum s m),    theta dm/dt = f - m,

with shares s and times theta of creep. Where f changes evenly in a step of length h, x = h/theta,

    m_1 = e m_0 + (v - e) f_0 + (1 - v) f_1,    e = exp(-x),    v = (1 - e)/x,

holds exactly for any h. A step is then one of an elastic body that is 1 + sum s (1 - v) times as compliant, on a
surface displaced by K sum s (e m_0 + (v - e) f_0): one product for all terms.

Pressures that do not change evenly make the error. In the middle of each step they are solved for, roughly: what they
are more than the mean of both ends, b, changes m_1 by 4 b int_0^x exp(-y) y/x (1 - y/x) dy, as of a parabola. In a
contact of the same outline pressures change by d, (1 + sum s (1 - v)) d_1 = -sum s (that + e dm_0 + (v - e) d_0), less
their mean where the force is given.

References
----------
E. H. Lee & J. R. M. Radok, J. Appl. Mech. 27 (1960) 438; T. C. T. Ting, J. Appl. Mech. 33 (1966) 845; R. L. Taylor, K.
S. Pister & G. L. Goudreau, Int. J. Numer. Methods Eng. 2 (1970) 45 (exact exponentials).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.viscoelastic import Viscoelastic
from fecontact.halfspace.compliance import Memory, SurfaceCompliance
from fecontact.halfspace.hardness import dented
from fecontact.halfspace.pressing import press
from fecontact.halfspace.traction_contact import FrictionContact

if TYPE_CHECKING:
    from fecontact.halfspace.friction import Friction, PressStep

#: Tolerance of the pressures in the middle of a step.
MIDDLE_TOLERANCE = 1e-4
#: Time over that of creep below which pressures of a parabola are remembered as of short steps.
EVEN = 1e-3

Bodies = tuple[Material | Viscoelastic | None, Material | Viscoelastic | None]


def memory_of(bodies: Bodies) -> Memory | None:
    """Memory of a half-space and a counter-body; None if both are elastic.

    Examples
    --------
    >>> rubber = Viscoelastic(Material(E=10.0, nu=0.49), prony=[(0.5, 1.0)])
    >>> memory_of((rubber, None))
    Memory(shares=(1.0,), times=(2.0,), alike=True)
    """
    softness = [0.0 if (m := elastic(body)) is None else 1 / m.plane_strain_modulus for body in bodies]
    shares, times = [], []
    for body, own in zip(bodies, softness, strict=True):
        if isinstance(body, Viscoelastic):
            shares += (body.creep[0] * own / sum(softness)).tolist()
            times += body.creep[1].tolist()
    return Memory(tuple(shares), tuple(times), bodies[1] in (None, bodies[0])) if times else None


def elastic(body: Material | Viscoelastic | None) -> Material | None:
    """The material, of a visco-elastic one that at once."""
    return body.material if isinstance(body, Viscoelastic) else body


@dataclass(frozen=True, eq=False)
class Creep:
    """What a step on a half-space remembers; nothing if that is elastic.

    Attributes
    ----------
    friction : Friction
        With a body as compliant as in the step.
    body : SurfaceCompliance
        As it is at once.
    time : float
        At its end.
    weights : (3, n) array
        Of m_0, f_0 and f_1 in m_1, see the module.
    forces : (3, nx, ny) array or None
        Tractions and pressures before the step; None from the unloaded state.
    retarded : (n, 3, nx, ny) array or None
        m_0 of each term.
    rest : (3, nx, ny) array or None
        Displacements along x and y and into the body at its end, by what was before.
    slip : (2, nx, ny) array or None
        `rest` along x and y, less the displacements at its beginning.
    """

    friction: Friction
    body: SurfaceCompliance
    time: float
    weights: Array | None = None
    forces: Array | None = None
    retarded: Array | None = None
    rest: Array | None = None
    slip: Array | None = None

    def below(self, heights: Array) -> Array:
        """Heights (nx, ny) over the surface that is displaced by what was before."""
        return heights if self.rest is None else heights + self.rest[2]

    def memorised(self, contact: FrictionContact) -> FrictionContact:
        """A contact at the end of the step, with what it leaves behind."""
        if self.weights is None:
            return replace(contact, time=self.time)
        now = np.stack([*contact.traction, contact.pressure])
        keep, first, second = (w[:, None, None, None] for w in self.weights)
        retarded = second * now
        if self.forces is not None:
            retarded += keep * self.retarded + first * self.forces
        return replace(contact, time=self.time, retarded=retarded)

    def remembered(self, contact: FrictionContact) -> FrictionContact:
        """The same of a contact on the body of the step, whose displacements are without `rest`."""
        displacement = contact.displacement if self.rest is None else contact.displacement + self.rest[2]
        return self.memorised(replace(contact, material=self.body.material, displacement=displacement))


def creep_of(friction: Friction, time: float | None, last: FrictionContact | None) -> Creep:
    """What a step that ends at a time remembers.

    Raises
    ------
    InputError
        On a visco-elastic half-space: without a time, for one before that of the last step, and for friction between
        bodies that creep differently.
    """
    memory, before = friction.body.memory, 0.0 if last is None else last.time
    if memory is None:
        return Creep(friction, friction.body, before if time is None else time)
    if time is None:
        raise InputError(
            "A visco-elastic half-space answers by the time that loads take: give PressStep(time=), the time at the "
            "end of each step.",
            code="time-missing",
        )
    if time < before:
        raise InputError(
            f"A step ends at the time {time:g}, before that of the step before it, {before:g}: times must not fall.",
            code="time-backwards",
        )
    if friction.mu > 0 and not memory.alike:
        raise InputError(
            "Friction between bodies that creep differently is not offered. Press without friction, or take a rigid "
            "counter-body (against=None) or one of the same visco-elastic material.",
            code="creep-unlike",
        )
    shares, weights = np.array(memory.shares), _weights(memory, time - before)[:3]
    keep = weights[0]
    softer = replace(friction, body=softened(friction.body, 1 + float(shares @ weights[2])), _made={})
    if last is None:
        return Creep(softer, friction.body, time, weights)
    assert last.retarded is not None
    forces = np.stack([*last.traction, last.pressure])
    was = np.tensordot(shares, last.retarded, 1) + forces
    will = np.tensordot(shares * keep, last.retarded, 1) + float(shares @ weights[1]) * forces
    along = friction.compliance(0, friction.body.grid.shape) if friction.mu > 0 or friction.coupled else None
    rest, moved = np.zeros(forces.shape), np.zeros((2, *friction.body.grid.shape))
    rest[2] = friction.body.product().apply(will[2])
    if along is not None:
        rest[:2] = along.apply(will[:2]) + along.of_pressure(will[2])
        rest[2] += along.normal_displacement(will[:2])
        moved = along.apply(was[:2]) + along.of_pressure(was[2])
    return Creep(softer, friction.body, time, weights, forces, last.retarded, rest, rest[:2] - moved)


def _weights(memory: Memory, span: float) -> Array:
    """Weights (4, n) of m_0, f_0, f_1 and b in m_1 after a time, see the module."""
    x = span / np.array(memory.times)
    keep = np.exp(-x)
    mean = np.divide(-np.expm1(-x), x, out=np.ones(len(x)), where=x > 0)
    y = np.maximum(x, EVEN)
    bow = 4 * ((1 - np.exp(-y) * (1 + y)) / y - (2 - np.exp(-y) * (y**2 + 2 * y + 2)) / y**2) * x / y
    return np.stack([keep, mean - keep, 1 - mean, bow])


def with_time_change(
    friction: Friction, heights: Array, middle: PressStep, last: FrictionContact | None, found: FrictionContact,
    symmetry: bool,
) -> FrictionContact:  # fmt: skip
    """The contact at the end of a step with its change by small steps, from the pressures in the middle of the step."""
    memory, creep, begin = friction.body.memory, creep_of(friction, middle.time, last), 0.0
    assert memory is not None
    pressure, traction = found.pressure / 2, found.traction / 2
    change = np.zeros((1 + len(memory.times), *pressure.shape))
    if last is not None:
        begin, pressure, traction = last.time, pressure + last.pressure / 2, traction + last.traction / 2
        change = change if last.time_change is None else last.time_change
    keep, first, second, bow = _weights(memory, found.time - begin)[..., None, None]
    late = keep * change[1:] + first * change[0]
    if found.time > begin and pressure.any():
        lift, z = creep.friction.lift, dented(creep.below(heights), last)
        now = press(
            creep.friction.body, z if lift is None else z + lift.apply(traction)[0],
            middle.normal_load, MIDDLE_TOLERANCE, symmetry, friction.workers,
            boxed=False, start=replace(found, pressure=pressure), hardness=friction.hardness,
        )  # fmt: skip
        late = late + bow * (now.pressure - pressure)
    shares = np.array(memory.shares)[:, None, None]
    own = np.where(found.active, -(shares * late).sum(axis=0), 0.0) / (1 + float((shares * second).sum()))
    if found.given == "force":
        own -= np.where(found.active, own.sum() / max(int(found.active.sum()), 1), 0.0)
    return replace(found, time_change=np.stack([own, *(late + second * own)]))


def softened(body: SurfaceCompliance, factor: float) -> SurfaceCompliance:
    """The same elastic body, so many times as compliant."""
    materials = [None if m is None else replace(m, E=m.E / factor) for m in (body.material, body.against)]
    return replace(body, material=materials[0], against=materials[1], memory=None)
