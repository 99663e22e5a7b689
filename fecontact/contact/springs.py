"""Springs and ligaments as complementarity conditions in the contact problem.

A ligament of stiffness k and slack length L pulls with T >= 0. With the elongation e = length - L its law reads

    w = T / k - e >= 0,   T >= 0,   T w = 0

which is a contact condition whose gap is -e and whose own compliance is 1/k. A linear spring is two such rows, one for
each sign. Small motions change the length along the line between its ends, or along all lines between the points
through which a ligament is led and where it touches a cylinder, see `contact.strands`.

A ligament with a toe region, k s^2 / (2 toe) up to the strain s = toe and k (s - toe/2) beyond (Blankevoort & Huiskes
1991, k per strain), is a bundle of n equal fibres that tighten one after the other, at s = toe (j - 1/2)/n: its tension
is exact beyond the toe and off by k toe / (8 n^2) at most within.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body, check_body
from fecontact.bodies.pose import Pose
from fecontact.common.arguments import instance, items, spelled, text
from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.checks import among, check_magnitude, number, positive, vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.contact.rigid_motion import RigidMotionConstraints, after_prescribed
from fecontact.contact.strands import Strand, WrapCylinder

KINDS = ("tension", "linear")
#: Fibres of a ligament with a toe region: their tension is off by 1/400 of that at the end of the toe.
FIBRES = 10
#: Largest strain at which a toe region may end.
LONGEST_TOE = 1.0


def _as_given(body: Body | None, point: ArrayLike) -> Array:
    return np.asarray(point, dtype=float)


def _present(body: Body | None, point: ArrayLike) -> Array:
    """Place (3,) of a point of a body that has deformed, in its axes."""
    given = _as_given(body, point)
    return given if body is None else body._present(given)


def _in_world(pose: Pose | None, point: Array) -> Array:
    return point if pose is None else pose.to_world(point[None])[0]


@spelled
@compact_repr
@dataclass(frozen=True, eq=False)
class Spring:
    """A spring between points of two bodies, or of a body and the ground.

    Parameters
    ----------
    stiffness : float
        Force per length, positive.
    start, end : (Body or None, (3,) point)
        A body with a point in its own axes, or None with a point of the world (the ground).
    slack_length : float, optional
        Length at which the force vanishes; the length in the given poses by default.
    kind : {'tension', 'linear'}
        'tension': a ligament, slack when shorter; 'linear': pulls and pushes.
    name : str
    toe : float
        Strain up to which the tension of a ligament grows with its square, from 0 to `stiffness` per length; with it
        the linear part begins (Blankevoort & Huiskes, J. Biomech. Eng. 113 (1991), 263: 0.06). None by default.
    via : sequence of (Body or None, (3,) point)
        Points through which a ligament is led, without friction, from its start to its end.
    around : (Body or None, WrapCylinder), optional
        A cylinder round which it is led the shorter way where the straight one would pass through it; without `via`.

    Raises
    ------
    InputError

    Examples
    --------
    >>> import fecontact as fc
    >>> ball = fc.RigidBody(fc.Sphere(1.0))
    >>> fc.Spring(10.0, (ball, (0, 0, 2)), (None, (0, 0, 5))).slack_length
    3.0
    """

    stiffness: float
    start: tuple[Body | None, ArrayLike]
    end: tuple[Body | None, ArrayLike]
    slack_length: float | None = None
    kind: str = "tension"
    name: str = "spring"
    toe: float = 0.0
    via: Sequence[tuple[Body | None, ArrayLike]] = ()
    around: tuple[Body | None, WrapCylinder] | None = None

    def __post_init__(self) -> None:
        text("the name of a spring", self.name)
        check_magnitude(f"the stiffness of {self.name!r}", positive(f"the stiffness of {self.name!r}", self.stiffness))
        among(f"kind of the spring {self.name!r}:", self.kind, KINDS)
        if not 0 <= number(self.toe) <= LONGEST_TOE or (self.toe and not self.only_pulls):
            raise InputError(
                f"The toe of {self.name!r} is a strain from 0 to {LONGEST_TOE:g}, of a ligament (kind='tension'); "
                f"found {shown(self.toe)}.",
                code="toe",
            )
        for end in (self.start, *items(f"via of {self.name!r}", self.via, "points"), self.end):
            if not (isinstance(end, tuple | list) and len(end) == 2):
                raise InputError(f"An end of {self.name!r} must be (body or None, (x, y, z)); found {shown(end)}.")
            if end[0] is not None:
                check_body(end[0])
            vector(f"an end of {self.name!r}", end[1])
        if self.around is not None:
            instance(f"what {self.name!r} is led around", self.around[-1], WrapCylinder)
        if (self.via and self.around is not None) or ((self.via or self.around) and not self.only_pulls):
            raise InputError(
                f"{self.name!r} is led through points or around a cylinder, one of both, and only a ligament is "
                "(kind='tension').",
                code="led",
            )
        if self.start[0] is self.end[0]:
            raise InputError(f"{self.name!r} ties {'the ground' if self.start[0] is None else 'a body'} to itself.")
        if min(strand.length for strand in self.strands) == 0:
            raise InputError(f"The ends of {self.name!r} coincide, so it has no direction; move one of them.")
        if self.slack_length is None:
            object.__setattr__(self, "slack_length", self.length)
        elif not 0 <= number(self.slack_length) < np.inf:
            found = shown(self.slack_length)
            raise InputError(f"The slack length of {self.name!r} must not be negative or infinite; found {found}.")
        else:
            check_magnitude(f"the slack length of {self.name!r}", self.slack_length)

    @property
    def only_pulls(self) -> bool:
        """Whether it is slack when it is shorter than its slack length."""
        return self.kind == "tension"

    @property
    def tightening(self) -> Array:
        """Elongations (n_fibres,) at which its fibres tighten; each has the same share of the stiffness."""
        assert self.slack_length is not None
        n = FIBRES if self.toe else 1
        return self.toe * self.slack_length * (np.arange(n) + (0.5 if self.toe else 0.0)) / n

    @property
    def carriers(self) -> tuple[Body | None, ...]:
        """The bodies, or None for the ground, of its start, of `via` or `around`, and of its end."""
        between = self.via if self.around is None else (self.around,)
        return (self.start[0], *(body for body, _ in between), self.end[0])

    @cached_property
    def _way(self) -> tuple[tuple[Strand, ...], float]:
        return self.way([None if body is None else body.pose for body in self.carriers], _present)

    def way(
        self, poses: Sequence[Pose | None], given: Callable[[Body | None, ArrayLike], Array] = _as_given
    ) -> tuple[tuple[Strand, ...], float]:
        """Its straight strands, and the length of its arc, where its carriers are in poses, None for the ground.

        `given` tells the places of its points in the axes of their bodies.
        """
        through = (self.start, *self.via, self.end)
        numbers: Sequence[int] = range(len(through)) if self.around is None else (0, 2)
        own = [_as_given(*each) for each in through]
        places = [_in_world(poses[k], given(*each)) for k, each in zip(numbers, through, strict=True)]
        parts, arc = list(pairwise(range(len(own)))), 0.0
        if self.around is not None:
            carrier = poses[1] or Pose()
            met = self.around[1].touched(*(carrier.to_body(p[None])[0] for p in places))
            if met is not None:
                touching, arc = met
                own, numbers, parts = [own[0], *touching, own[1]], (0, 1, 1, 2), [(0, 1), (2, 3)]
                places = [places[0], *carrier.to_world(touching), places[1]]
        made = (Strand((numbers[i], numbers[j]), (own[i], own[j]), np.stack([places[i], places[j]])) for i, j in parts)
        return tuple(made), arc

    @property
    def strands(self) -> tuple[Strand, ...]:
        """Its straight parts, in the given poses."""
        return self._way[0]

    @property
    def length(self) -> float:
        """Length of its way, in the given poses."""
        return sum(strand.length for strand in self.strands) + self._way[1]

    @property
    def elongation(self) -> float:
        """Length beyond the slack length, in the given poses."""
        assert self.slack_length is not None
        return self.length - self.slack_length


@dataclass(frozen=True)
class SpringState:
    """Force and length of a spring in a solution.

    Attributes
    ----------
    spring : Spring
    tension : float
        Tension, positive.
    elongation : float
        Elongation beyond the slack length; tension / stiffness unless slack or with a toe.
    """

    spring: Spring
    tension: float
    elongation: float


@dataclass(frozen=True, eq=False)
class SpringRows:
    """The springs of a scene as unilateral constraints.

    Attributes
    ----------
    springs : tuple of Spring
    number : (n,) int array
        Spring of each row.
    sign : (n,) array
        +1 for a tensile row, -1 for a compressive one.
    tightening : (n,) array
        Elongation at which the row's fibre tightens.
    """

    springs: tuple[Spring, ...]
    number: IntArray
    sign: Array
    tightening: Array

    @property
    def gap(self) -> Array:
        """Minus the elongations (n,), with the row's sign."""
        return -self.sign * (np.array([s.elongation for s in self.springs])[self.number] - self.tightening)

    @property
    def own_compliance(self) -> Array:
        """Inverse stiffnesses (n,)."""
        return np.array([len(s.tightening) / s.stiffness for s in self.springs])[self.number]

    @property
    def infeasibility_hint(self) -> str:
        """Hint that ligaments carry tension only; empty without ligaments."""
        names = ", ".join(repr(s.name) for s in self.springs if s.only_pulls)
        return f"Of the springs {names} only pull, and this motion tightens none of them. " if names else ""

    @property
    def as_contact(self) -> None:
        """None: springs are no contact."""
        return

    @property
    def two_sided(self) -> bool:
        """No: a linear spring is two rows."""
        return False

    def spring_states(self, forces: Array, gaps: Array) -> tuple[SpringState, ...]:
        """States from the forces (n,) of the rows and their gaps (n,) by the bodies' displacements only, minus e."""
        out = []
        elongation = -self.sign * gaps + self.tightening
        for k, spring in enumerate(self.springs):
            mine = self.number == k
            out.append(SpringState(spring, float(self.sign[mine] @ forces[mine]), float(elongation[mine][0])))
        return tuple(out)

    def rows(self, body: Body) -> sp.csr_matrix | None:
        """Rows (n, n_dofs): shortening of the springs by the displacements of a body; None if none ends on it."""
        per_spring = sp.lil_matrix((len(self.springs), body.n_dofs))
        tied = False
        for k, spring in enumerate(self.springs):
            for strand in spring.strands:
                for which, point, sign in zip(strand.carriers, strand.own, (1.0, -1.0), strict=True):
                    if spring.carriers[which] is body:
                        tied = True
                        direction = sign * strand.direction @ body.pose.rotation
                        per_spring[k] = per_spring[k] + body.attachment(point, direction)
        return sp.diags(self.sign) @ per_spring.tocsr()[self.number] if tied else None

    def held(self, rows: IntArray, closed: IntArray, stuck: Sequence[IntArray]) -> Mask:
        """Which of its rows are held as contacts are: none."""
        return np.zeros(len(rows), bool)

    def opening_by(self, frames: Sequence[RigidMotionConstraints]) -> Array:
        """Gaps (n,) after the prescribed rigid motions."""
        return after_prescribed(self.gap, self.rows, frames)


def spring_rows(springs: Sequence[Spring]) -> SpringRows:
    """One row for each ligament or each of its fibres, two for each linear spring."""
    signs = {True: (1.0,), False: (1.0, -1.0)}
    rows = [(k, sign, e) for k, s in enumerate(springs) for sign in signs[s.only_pulls] for e in s.tightening]
    number, sign, tightening = zip(*rows, strict=True) if rows else ((), (), ())
    return SpringRows(tuple(springs), np.array(number, dtype=np.int64), np.array(sign), np.array(tightening))
