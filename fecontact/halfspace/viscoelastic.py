"""Visco-elastic half-spaces: the memory of pressures and tractions.

At a constant Poisson's ratio displacements are those at once, of a compliance K, by forces f and what is left of them,

    u = K (f + sum s m),    theta dm/dt = f - m,

with shares s and times theta of creep. Where f changes evenly in a step of length h, x = h/theta,

    m_1 = e m_0 + (v - e) f_0 + (1 - v) f_1,    e = exp(-x),    v = (1 - e)/x,

holds exactly for any h. A step is then one of an elastic body that is 1 + sum s (1 - v) times as compliant, on a
surface displaced by K sum s (e m_0 + (v - e) f_0): one product for all terms.

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
from fecontact.halfspace.contact import FrictionContact

if TYPE_CHECKING:
    from fecontact.halfspace.friction import Friction

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
    shares, x = np.array(memory.shares), (time - before) / np.array(memory.times)
    keep = np.exp(-x)
    mean = np.divide(-np.expm1(-x), x, out=np.ones(len(x)), where=x > 0)
    weights = np.stack([keep, mean - keep, 1 - mean])
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


def softened(body: SurfaceCompliance, factor: float) -> SurfaceCompliance:
    """The same elastic body, so many times as compliant."""
    materials = [None if m is None else replace(m, E=m.E / factor) for m in (body.material, body.against)]
    return replace(body, material=materials[0], against=materials[1], memory=None)
