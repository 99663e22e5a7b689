"""Contact with Coulomb friction on candidate points: the problem, its residuals and its solution.

Every frictional point has a normal force l and a tangential force t of one or two components; w is the normal gap and
s the slip, both after the step:

    (w, s) = S (l, t) + g + B^T q,   B (l, t) = F
    0 <= l,  0 <= w,  l w = 0                                     (Signorini)
    |t| <= mu l,  s = 0 where |t| < mu l,  mu l s + |s| t = 0     (Coulomb)

Slip is the change of the tangential displacement since the last step: g has the displacement at its end, with the sign
reversed. Forces act on the slave, displacements are those of the slave against the master: friction opposes slip.
Without friction (mu = 0) it is the complementarity problem of `solvers.problem`; an infinite mu is a rough surface.

Sources: Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353; Klarbring, Ing.-Arch. 60 (1990) 529.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, field, fields
from functools import cached_property

import numpy as np

from fecontact.common.errors import InputError
from fecontact.common.one_line import one_line
from fecontact.common.renamed import renamed
from fecontact.solvers.problem import ComplementarityProblem, Solution, Status, largest, ratio


@dataclass(frozen=True)
class FrictionResiduals:
    """Violations of the conditions of contact and friction; all numbers are relative and dimensionless.

    Parameters
    ----------
    penetration, tension, complementarity, equilibrium : float
        As in `solvers.Residuals`, of the normal forces and gaps under the tangential forces found.
    cone : float
        Largest excess of |t| over mu l, over the force scale.
    slip : float
        Largest defect |t - P(t - r s)| of the natural map, over the force scale; P is the projection on the disc of
        radius mu l and r the force scale over the gap scale. It is zero if and only if Coulomb's law holds.
    dissipation : float
        Defect of maximum dissipation: sum(mu l |s| + t . s) over sum(mu l |s|); zero without slip.
    """

    penetration: float
    tension: float
    complementarity: float
    equilibrium: float
    cone: float
    slip: float
    dissipation: float

    @property
    def worst(self) -> float:
        """The largest of the numbers."""
        return max(astuple(self))

    def within(self, tolerance: float) -> bool:
        """Whether the answer is certified: penetration within ten times the tolerance, the others within it."""
        others = (getattr(self, each.name) for each in fields(self) if each.name != "penetration")
        return self.penetration <= 10 * tolerance and all(each <= tolerance for each in others)

    def __str__(self) -> str:
        return ", ".join(f"{each.name} {getattr(self, each.name):.1e}" for each in fields(self))


@one_line
@dataclass(frozen=True, eq=False)
class FrictionProblem:
    """Contact with friction on points with m rigid components in equilibrium.

    Parameters
    ----------
    rows : ComplementarityProblem
        S, g, B and F of all N rows, normal and tangential ones.
    points : ndarray of int, shape (f,)
        Normal row of each frictional point.
    tangents : ndarray of int, shape (f, k)
        Its tangential rows, k of 1 or 2, along orthogonal directions. All other rows are normal ones.
    mu : ndarray, shape (f,)
        Coefficient of friction; zero or infinite ones are allowed.

    Raises
    ------
    InputError
        For shapes or indices that do not fit, an operator for S, or a mu that is negative or not a number.

    Examples
    --------
    A point pressed down by 1 and dragged by 0.2 does not slip at mu = 0.3:

    >>> import numpy as np
    >>> from fecontact.solvers import ComplementarityProblem
    >>> rows = ComplementarityProblem(np.eye(2), np.zeros(2), np.eye(2), np.array([1.0, 0.2]))
    >>> problem = FrictionProblem(rows, points=np.array([0]), tangents=np.array([[1]]), mu=np.array([0.3]))
    >>> problem.residuals(np.array([1.0, 0.2]), np.array([-1.0, -0.2])).worst
    0.0
    """

    rows: ComplementarityProblem
    points: np.ndarray
    tangents: np.ndarray
    mu: np.ndarray

    def __post_init__(self) -> None:
        points, tangents = np.asarray(self.points, dtype=np.int64), np.asarray(self.tangents, dtype=np.int64)
        mu = np.asarray(self.mu, dtype=float)
        if not isinstance(self.rows.S, np.ndarray):
            raise InputError("Friction needs the compliance as an array; found an operator. Form the array.")
        if points.ndim != 1 or tangents.ndim != 2 or tangents.shape[1] not in (1, 2) or len(points) != len(tangents):
            raise InputError(
                f"Expected points (f,) and tangents (f, 1) or (f, 2); found shapes {points.shape} and {tangents.shape}."
            )
        if mu.shape != points.shape:
            raise InputError(f"Expected one coefficient of friction per point, {points.shape}; found {mu.shape}.")
        if not (mu >= 0).all():
            raise InputError(f"A coefficient of friction is a number from 0 on, or inf; found {mu[~(mu >= 0)][0]!r}.")
        used = np.concatenate([points, tangents.ravel()])
        if len(used) and (used.min() < 0 or used.max() >= self.rows.n or len(np.unique(used)) != len(used)):
            raise InputError(f"points and tangents must be different rows out of 0 to {self.rows.n - 1}.")
        for name, value in (("points", points), ("tangents", tangents), ("mu", mu)):
            object.__setattr__(self, name, value)

    @property
    def S(self) -> np.ndarray:
        """Compliance (N, N) of all rows."""
        assert isinstance(self.rows.S, np.ndarray)
        return self.rows.S

    @cached_property
    def normals(self) -> np.ndarray:
        """Normal rows (n,), with friction or without."""
        return np.setdiff1d(np.arange(self.rows.n), self.tangents)

    def normal_problem(self, forces: np.ndarray) -> ComplementarityProblem:
        """Problem of the normal forces, under the tangential part of given forces (N,)."""
        n, t = self.normals, self.tangents.ravel()
        rows = self.rows
        g = rows.g[n] + self.S[np.ix_(n, t)] @ forces[t]
        return ComplementarityProblem(self.S[np.ix_(n, n)], g, rows.B[:, n], rows.F - rows.B[:, t] @ forces[t])

    def slip(self, forces: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Slip of the points during the step, shape (f, k)."""
        return np.asarray(self.rows.gap(forces, q)[self.tangents])

    def limit(self, forces: np.ndarray) -> np.ndarray:
        """Largest tangential force mu l of the points, shape (f,); infinite where rough and pressed."""
        return friction_limit(self.mu, forces[self.points])

    def residuals(self, forces: np.ndarray, q: np.ndarray) -> FrictionResiduals:
        """Residuals of a solution, recomputed from the problem alone.

        Parameters
        ----------
        forces : ndarray, shape (N,)
        q : ndarray, shape (m,)

        Returns
        -------
        FrictionResiduals
            Infinite where the solution is not finite.
        """
        forces, q = np.asarray(forces, dtype=float), np.asarray(q, dtype=float)
        if forces.shape != (self.rows.n,) or q.shape != (self.rows.m,):
            raise InputError(
                f"Residuals need forces of shape {(self.rows.n,)} and q of shape {(self.rows.m,)}; "
                f"found {forces.shape} and {q.shape}."
            )
        if not (np.isfinite(forces).all() and np.isfinite(q).all()):
            return FrictionResiduals(*[np.inf] * len(fields(FrictionResiduals)))
        every = self.rows.residual_scales(forces, q)
        alone = self.normal_problem(forces)
        normal = alone.residuals(forces[self.normals], q, every)
        t, s, limit = forces[self.tangents], self.slip(forces, q), self.limit(forces)
        size, slipped = np.linalg.norm(t, axis=1), np.linalg.norm(s, axis=1)
        trial = t - every.force / every.gap * s if every.gap else t
        moved = projected(trial, limit) - t
        rough = np.isinf(limit)
        bound = np.where(rough, size, limit)
        spent = np.where(rough, 0.0, limit) * slipped
        given = np.where(rough, 0.0, np.einsum("fk,fk->f", t, s))
        # the rounding of slip counts by the limits, which exceed the forces under much friction, and by the motions
        # that cancel in it
        terms = max(largest(self.rows.g), largest(np.abs(self.rows.B).T @ np.abs(q)))
        work = max(every.gap, MOTION_FLOOR * terms) * max(every.force, float(np.where(rough, 0.0, limit).sum()))
        return FrictionResiduals(
            normal.penetration,
            normal.tension,
            normal.complementarity,
            normal.equilibrium,
            cone=largest(ratio(np.maximum(size - bound, 0.0), every.force)),
            slip=largest(ratio(moved, every.force)),
            dissipation=float(ratio(np.array([abs((spent + given).sum())]), max(spent.sum(), NO_WORK * work))[0]),
        )


#: Share of force scale times gap scale below which dissipated work is rounding, and share of the largest motions, whose
#: sum slip is, that counts as such a scale: slips of 45 units in the last place, 1e-14 of these motions, reach the
#: tolerance of 1e-10.
NO_WORK, MOTION_FLOOR = 1e-3, 0.1


@one_line
@dataclass(frozen=True, eq=False)
class FrictionSolution:
    """Solution of a contact problem with friction. Its residuals are recomputed from the problem.

    Parameters
    ----------
    problem : FrictionProblem
    forces : ndarray, shape (N,)
        Normal forces, compression positive, and tangential ones, at their rows.
    q : ndarray, shape (m,)
        Multiplier of the equilibrium rows, the rigid motion.
    status : Status
    message : str
    nit : int
        Newton steps, or sweeps.
    solver : str
    seconds : float
    history : tuple of float
        Residual of each iteration.
    orientation : int
        Sign of the determinant of Newton's matrix at the end, +1 as without friction; -1: the solution is not the only
        one, or not stable (Klarbring 1990); 0: singular, forces are not unique.
    """

    problem: FrictionProblem = field(repr=False)
    forces: np.ndarray
    q: np.ndarray
    status: Status
    message: str
    nit: int
    solver: str
    seconds: float = 0.0
    history: tuple[float, ...] = ()
    orientation: int = 1

    @property
    def success(self) -> bool:
        """Whether the solution is certified."""
        return self.status in (Status.SOLVED, Status.NO_CONTACT)

    @cached_property
    def residuals(self) -> FrictionResiduals:
        """Residuals of forces and motion, recomputed from the problem."""
        return self.problem.residuals(self.forces, self.q)

    @cached_property
    def normal(self) -> Solution:
        """Solution of the normal forces alone, under the tangential forces found."""
        problem = self.problem
        return Solution(
            problem.normal_problem(self.forces), self.forces[problem.normals], self.q, self.status, self.message,
            self.nit, self.solver, self.seconds, self.history, problem.rows.residual_scales(self.forces, self.q),
        )  # fmt: skip

    @property
    def tangential(self) -> np.ndarray:
        """Tangential forces of the frictional points, shape (f, k)."""
        return self.forces[self.problem.tangents]

    @cached_property
    def slip(self) -> np.ndarray:
        """Slip of the frictional points during the step, shape (f, k)."""
        return self.problem.slip(self.forces, self.q)

    @property
    def touching(self) -> np.ndarray:
        """Frictional points with a normal force, shape (f,), bool."""
        return np.asarray(self.forces[self.problem.points] > 0)

    @cached_property
    def sliding(self) -> np.ndarray:
        """Touching points on the rim of their cone, shape (f,), bool; the other touching ones stick."""
        size = np.linalg.norm(self.tangential, axis=1)
        return self.touching & (size >= (1 - ON_CONE) * self.problem.limit(self.forces))

    @property
    def friction_work(self) -> float:
        """Work of friction during the step, - sum t . s."""
        return -float((self.tangential * self.slip).sum())

    dissipated = renamed("dissipated", "friction_work")


#: Relative distance from the rim of a cone at which a point counts as sliding.
ON_CONE = 1e-9


def friction_limit(mu: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Radius mu l of the cones of normal forces (f,); zero where they are not positive, also for an infinite mu."""
    return np.multiply(mu, normal, out=np.zeros(len(mu)), where=normal > 0)


def projected(t: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Vectors (f, k) moved to the closest point of discs of radii `limit` (f,)."""
    size = np.linalg.norm(t, axis=1)
    outside = size > limit
    share = np.divide(limit, size, out=np.ones(len(t)), where=outside)
    return np.asarray(t * share[:, None])
