"""Contact and Coulomb friction at points: the law, and how far forces and displacements are from obeying it.

With a normal force l, a tangential force t, the gap w and the slip s of a step:

    0 <= l,  0 <= w,  l w = 0                                     (Signorini)
    |t| <= mu l,  s = 0 where |t| < mu l,  mu l s + |s| t = 0     (Coulomb)

Forces act on the slave, displacements are those of the slave against the master: friction opposes slip. mu = 0 is no
friction. An infinite mu is a rough surface, the limit of a growing one: what is pressed sticks, and a closed point that
is bare of pressure may slide against a tangential force, to which mu l tends. Without bare points there need not be a
state; with a finite mu there always is one where bodies are held (Klarbring), of forces that are bounded whatever mu.
The components of vectors are along the first axis of their arrays, (k, ...).

Sources: Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353; Klarbring, Ing.-Arch. 60 (1990) 529.

Examples
--------
Of two points pressed by 1 at mu = 0.5 the first sticks, the second slides:

>>> t, s = np.array([[0.25, -0.5]]), np.array([[0.0, 2.0]])
>>> limit = friction_limit(0.5, np.ones(2))
>>> sticks(t, limit).tolist()
[True, False]
>>> Residuals(0.0, 0.0, 0.0, 0.0).with_friction(t, s, limit, ResidualScales(force=2.0, gap=1.0, point=1.0)).worst
0.0
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask

RIM_TOLERANCE = 1e-9
"""Relative distance from the rim of a cone at which a point counts as sliding."""

WORK_FLOOR, MOTION_FLOOR = 1e-3, 0.1
"""Share of force scale times gap scale below which the work of friction is rounding, and share of the largest motions,
whose sum slip is, that counts as such a scale: slips of 45 units in the last place, 1e-14 of these motions, reach the
tolerance of 1e-10."""


def friction_limit(mu: Array | float, normal: Array) -> Array:
    """Radius mu l of the cones of normal forces (...); zero where they are not positive, also for an infinite mu."""
    return np.multiply(mu, normal, out=np.zeros(normal.shape), where=normal > 0)


def sizes(vectors: Array) -> Array:
    """Lengths (...) of vectors (k, ...), k of 1 or 2."""
    return np.asarray(np.hypot(*vectors) if len(vectors) == 2 else np.abs(vectors[0]))


def projected(t: Array, limit: Array) -> Array:
    """Vectors (k, ...) moved to the closest point of discs of radii `limit` (...)."""
    size = sizes(t)
    return np.asarray(t * np.divide(limit, size, out=np.ones(size.shape), where=size > limit))


def sticks(t: Array, limit: Array) -> Mask:
    """Whether tangential forces (k, ...) are within their cones; those on the rim slide."""
    return np.asarray(sizes(t) < (1 - RIM_TOLERANCE) * limit)


def natural_map(t: Array, s: Array, limit: Array, stiffness: float) -> Array:
    """P(t - r s) - t (k, ...) with a stiffness r and the projection P on the cones.

    It is zero if and only if Coulomb's law holds.
    """
    return projected(t - stiffness * s, limit) - t


NEARLY_HELD, TILT = 1e-9, 1e-2
"""Compliance of a point in one direction, over that in others, that is rounding of its mesh; the largest part of that
direction along the normal."""


def with_held_directions(S: Array, tangents: IntArray, B: Array | None = None, points: IntArray | None = None) -> Array:
    """A copy of a compliance (N, N) with its mean diagonal entry where a tangential row is held on both sides.

    As on a plane of symmetry: such a direction has no compliance and no motion by the rows of B, and no force as long
    as nothing drags along it. Tangents (n, k) at normals of a mesh with few digits are not quite along it: the rows of
    a point, with `points` (n,) of their normals, then depend on each other, and forces on them are not unique.
    """
    S, rows = np.array(S), np.ravel(tangents)
    held = S[rows, rows] == 0
    if B is not None:
        held &= ~B[:, rows].any(axis=0)
    mean = S.diagonal().mean()
    S[rows[held], rows[held]] = mean
    if points is not None and len(points):
        own = np.concatenate([points[:, None], tangents], axis=1)
        size, axes = np.linalg.eigh(S[own[:, :, None], own[:, None, :]])
        along = axes[:, 1:, 0]
        near = (size[:, 0] < NEARLY_HELD * size[:, -1]) & (np.abs(axes[:, 0, 0]) < TILT)
        if B is not None:
            moved = np.abs(np.einsum("mnk,nk->mn", B[:, tangents], along)).max(axis=0, initial=0.0)
            near &= moved <= TILT * np.abs(B).max(initial=0.0)
        t, along = tangents[near], along[near]
        S[t[:, :, None], t[:, None, :]] += mean * along[:, :, None] * along[:, None, :]
    return S


@dataclass(frozen=True, eq=False)
class ResidualScales:
    """Sizes by which residuals are divided, see the notes of `Residuals`.

    Attributes
    ----------
    force : float
        Of all forces together.
    gap : float
    point : float
        Largest force at a point.
    motion : float
        Largest of the motions whose sum a slip is; rounding of them must not count.
    row : (m,) array
        Of equilibrium.
    """

    force: float
    gap: float
    point: float
    motion: float = 0.0
    row: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Residuals:
    """Violation of the conditions of contact and friction; all numbers are relative and dimensionless.

    Parameters
    ----------
    penetration : float
        Largest penetration over the gap scale.
    tension : float
        Largest negative force over the force scale.
    complementarity : float
        Largest, over the points, of the smaller of |force| / force scale and |gap| / gap scale.
    equilibrium : float
        Largest |B l - F| of a row over the row scale.
    cone : float
        Largest excess of |t| over mu l, over the largest force at a point.
    slip : float
        Largest `natural_map` over the largest force at a point, with that force over the gap scale as stiffness.
    dissipation : float
        Defect of maximum dissipation: sum(mu l |s| + t . s) over sum(mu l |s|); zero without slip.

    Notes
    -----
    The last three are None without friction. Force scale of a `ContactProblem`: the sum of |l|, or, if larger, the
    load, each F_j over the largest entry of its row of B. Gap scale: the largest elastic deflection |S l|, but not less
    than 1e-3 of the largest |g + B^T q| (rigid bodies have no deflection) or 1e-4 of the largest |g| or |B|^T |q|
    (rounding). Row scale: the row's largest entry times the force scale, plus |F_j|. The scales follow a change of
    units. A residual that is exactly zero stays zero for any scale.
    """

    penetration: float
    tension: float
    complementarity: float
    equilibrium: float
    cone: float | None = None
    slip: float | None = None
    dissipation: float | None = None

    def as_dict(self) -> dict[str, float]:
        """The numbers by name, those of friction where there is any."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    @property
    def worst(self) -> float:
        """The largest of the numbers."""
        return max(self.as_dict().values())

    def within(self, tolerance: float) -> bool:
        """Whether the answer is certified: penetration within ten times the tolerance, the others within it."""
        allowed = {"penetration": 10 * tolerance}
        # one by one: a number that is not one is not below the tolerance, but may be hidden by `max`
        return all(value <= allowed.get(name, tolerance) for name, value in self.as_dict().items())

    def with_friction(self, t: Array, s: Array, limit: Array, scales: ResidualScales) -> Residuals:
        """The same with the residuals of Coulomb's law.

        Parameters
        ----------
        t, s : (k, ...) arrays
            Tangential forces, and slips of the step.
        limit : (...) array
            Of friction, see `friction_limit`.
        scales : ResidualScales
        """
        rough = np.isinf(limit)
        finite = np.where(rough, 0.0, limit)
        excess = np.where(rough, 0.0, sizes(t) - finite)
        spent, given = finite * sizes(s), np.where(rough, 0.0, (t * s).sum(axis=0))
        stiffness = scales.point / scales.gap if scales.gap else 0.0
        # the rounding of slip counts by the limits, which exceed the forces under much friction
        work = max(scales.gap, MOTION_FLOOR * scales.motion) * max(scales.force, float(finite.sum()))
        return replace(
            self,
            cone=largest(ratio(np.maximum(excess, 0.0), scales.point)),
            slip=largest(ratio(natural_map(t, s, limit, stiffness), scales.point)),
            dissipation=largest(ratio((spent + given).sum(), max(float(spent.sum()), WORK_FLOOR * work))),
        )

    def __str__(self) -> str:
        return ", ".join(f"{name} {value:.1e}" for name, value in self.as_dict().items())


def largest(values: Array) -> float:
    """Largest size of an entry; zero if there is none."""
    return max(float(values.max(initial=0.0)), -float(values.min(initial=0.0)))


def ratio(values: Array, scales: Array | float) -> Array:
    """Return values / scales, where 0 / 0 is 0 and anything else over 0 is infinite."""
    scales = np.broadcast_to(scales, values.shape)
    return np.divide(values, scales, out=np.where(values == 0, 0.0, np.inf), where=scales > 0)
