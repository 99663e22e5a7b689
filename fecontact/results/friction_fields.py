"""Fields of friction in a contact: tractions, slip, what sticks and what slides, and the work of friction.

What sticks is a contact of its own. The reserve of friction, d = mu p - |t|, is positive where points stick and zero
where they slide. It is the pressure of a contact, the slip outside being its gap: exactly so for similar bodies (Jaeger
1998, *A new principle in contact mechanics*; Ciavarella 1998, *The generalized Cattaneo partial slip plane contact
problem*), and near its edge for others, since both fall to zero as the square root of the distance and slip grows as
its power 3/2. So what locates the edge of a contact within the faces locates the edge of stick too, and the
reconstructions of both pressures give those of the tractions, mu p - d, whose difference is the estimated error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fecontact.common.arrays import ROUNDING, Array, IntArray, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.renamed import renamed
from fecontact.contact.condensed_problem import DisplacementState
from fecontact.contact.friction_rows import TangentialRows
from fecontact.contact.step_end import at_nodes
from fecontact.results.error_estimate import PressureReadings, larger_misfit
from fecontact.solvers import Solution


@dataclass(frozen=True, eq=False)
class EarlierParts:
    """What the parts of a cut load step before the last have done.

    Attributes
    ----------
    friction_work : float
    work_density, sliding_integral : (n,) arrays
        At the points of the last part; zero at those that faced nothing.
    """

    friction_work: float
    work_density: Array
    sliding_integral: Array


@compact_repr
@dataclass(frozen=True, eq=False)
class FrictionFields:
    """Friction at the n points of a contact. Vectors are in world axes and act on the slave; see `force`.

    Attributes
    ----------
    mu : float or (float, float)
        Coefficient of friction, or those along and across the axis of orthotropic friction.
    forces : (n, 3) array
        Tangential forces.
    weights : (n,) array
        Areas of the points.
    slip : (n, 3) array
        Displacement of the slave against the master during the load step, of a cut one during its last part, in the
        tangent planes; where points touch, slip.
    touching, sliding : (n,) bool arrays
        Points that are pressed, and those of them whose force is on the rim of its cone; the others stick.
    moved : (n, 3) array
        Displacement of the slave against the master since the unloaded state, in the master's axes, without that of
        the poses; the next load step counts slip from it. What sticks has kept it along the surface.
    resultants : (n, 3) array
        As `forces`; of a body of revolution, sums over rings.
    couples : (n, 3) array
        Moments about the axis of a body of revolution in torsion, sums over rings; else zero.
    mu_along_slip : (n,) array
        Coefficient in the direction of a point's slip: the work of friction over pressure and length of the slip.
    detour : float
        Largest share by which a point's path during the step exceeds the chord, which its slip is.
    sign : float
        Factor from forces on the slave to those on the first body of the contact.
    earlier : EarlierParts, optional
        Of a step that was cut: its other parts, which work and sliding include.
    """

    mu: float | tuple[float, float]
    forces: Array
    weights: Array
    slip: Array
    touching: Mask
    sliding: Mask
    moved: Array = field(repr=False)
    resultants: Array = field(repr=False)
    couples: Array = field(repr=False)
    mu_along_slip: Array = field(repr=False)
    detour: float = 0.0
    sign: float = 1.0
    earlier: EarlierParts | None = field(default=None, repr=False)

    @property
    def traction(self) -> Array:
        """Tangential tractions (n, 3): force over area."""
        return self.forces / self.weights[:, None]

    @property
    def sticking(self) -> Mask:
        """Points (n,) that are pressed and do not slip."""
        return self.touching & ~self.sliding

    @property
    def state(self) -> list[str]:
        """State of each of the n points: "open", "stick" or "slip"."""
        return [("open", "stick", "slip")[k] for k in self.touching + 1 * self.sliding]

    @property
    def force(self) -> Array:
        """Resultant (3,) of friction on the first body of the contact."""
        return np.asarray(self.sign * self.resultants.sum(axis=0))

    def moments(self, levers: Array) -> Array:
        """Moments (n, 3) of the resultants at levers (n, 3), with their couples."""
        return np.asarray(np.cross(levers, self.resultants) + self.couples)

    @property
    def point_stick_area(self) -> float:
        """Area of the points that stick; `ContactFields.stick_area` has its edge located within the faces."""
        return float(self.weights[self.sticking].sum())

    @property
    def point_slip_area(self) -> float:
        """Area of the points that slide."""
        return float(self.weights[self.sliding].sum())

    @property
    def friction_work(self) -> float:
        """Work of friction during the load step, - sum t . s; never negative."""
        work = -float((self.forces * self.slip).sum())
        return work if self.earlier is None else work + self.earlier.friction_work

    @property
    def work_density(self) -> Array:
        """The same by area (n,)."""
        density = self._own_density
        return density if self.earlier is None else density + self.earlier.work_density

    @property
    def sliding_integral(self) -> Array:
        """Integral of the pressure over the length of slip (n,); times Archard's coefficient the wear depth.

        Not a number without friction, whose slip does no work.
        """
        mu = self.mu_along_slip
        integral = np.divide(self._own_density, mu, out=np.full(len(mu), np.nan), where=mu > 0)
        return integral if self.earlier is None else integral + self.earlier.sliding_integral

    @property
    def _own_density(self) -> Array:
        return -np.einsum("ni,ni->n", self.traction, self.slip)

    dissipated, rubbed = renamed("dissipated", "friction_work"), renamed("rubbed", "sliding_integral")
    stick_area, slip_area = renamed("stick_area", "point_stick_area"), renamed("slip_area", "point_slip_area")


def with_parts(
    friction: FrictionFields, nodes: IntArray, parts: Sequence[tuple[FrictionFields, IntArray]]
) -> FrictionFields:
    """Friction of the last part of a cut step with that of the others; each at its slave nodes, which may be others."""
    return replace(
        friction,
        earlier=EarlierParts(
            sum(f.friction_work for f, _ in parts),
            np.sum([at_nodes(f.work_density, own, nodes) for f, own in parts], axis=0),
            np.sum([at_nodes(f.sliding_integral, own, nodes) for f, own in parts], axis=0),
        ),
    )


def friction_fields(
    friction: Sequence[TangentialRows],
    chosen: Sequence[IntArray],
    solution: Solution | None,
    state: DisplacementState,
) -> dict[int, FrictionFields]:
    """Fields of every contact with friction, by its number; none without a solution."""
    if solution is None:
        return {}
    out, start = {}, 0
    for each, slip in zip(friction, state.gaps[len(chosen) :], strict=True):
        points = chosen[each.place]
        n, k, here = each.n_points, len(each.tangents), slice(start, start + len(points))
        start += len(points)
        force, moved = np.zeros((n, k)), slip.reshape(k, n)
        force[points] = solution.tangential[here]
        touching, sliding = np.zeros(n, bool), np.zeros(n, bool)
        touching[points], sliding[points] = solution.touching[here], solution.sliding[here]
        forces, slips = np.einsum("nk,kni->ni", force, each.tangents), each.slip_vectors(moved)
        # what sticks, or slides by rounding, is where it was: the solver's tolerance does not add up over steps, and
        # slip that is held so counts in the next one
        held = touching & ~(sliding & (np.linalg.norm(slips, axis=1) > ROUNDING * state.scale))
        slid = np.where(held, 0.0, moved)
        displaced = each.displaced(slid, state.gaps[each.place] - each.interface.gap)
        detour = each.detour(touching, state.scale)
        pairing, extent = each.interface.pairing, each.interface.slave_surface.out_of_plane
        couples = np.zeros_like(forces) if extent is None else extent.couples(each.points, forces)
        forces = pairing.of_points(forces)
        # what acts with another point at a rim sticks if that does, unless its own force slides
        held = pairing.of_points((touching & ~sliding).astype(float)) > 0
        touching, sliding = pairing.of_points(touching.astype(float)) > 0, np.where(touching, sliding, ~held)
        out[each.place] = FrictionFields(
            mu=each.mu if each.lay is None else (float(each.lay.mu[0]), float(each.lay.mu[1])),
            forces=forces,
            weights=pairing.weights,
            slip=pairing.unmixed(slips),
            touching=touching,
            sliding=sliding & touching,
            moved=pairing.unmixed(displaced),
            resultants=forces if extent is None else extent.mean(forces),
            couples=pairing.of_points(couples),
            mu_along_slip=each.mu_along(moved),
            detour=detour,
        )
    return out


#: Tractions, as a share of what friction could bear (both in L2), below which their error is relative to this share.
MIN_TRACTION = 0.1


def has_reserve(friction: FrictionFields) -> bool:
    """Whether a contact has a reserve of friction: one finite coefficient for all directions."""
    return isinstance(friction.mu, float) and 0 < friction.mu < np.inf


def reserve(friction: FrictionFields, pressure: Array) -> tuple[Array, Array]:
    """Reserve of friction (n,) as a force, and slip (n,), its gap."""
    assert isinstance(friction.mu, float)
    left = friction.mu * pressure * friction.weights - np.linalg.norm(friction.forces, axis=1)
    return np.where(friction.sticking, np.maximum(left, 0.0), 0.0), np.linalg.norm(friction.slip, axis=1)


def traction_misfit(
    pressed: PressureReadings, held: PressureReadings | None, friction: FrictionFields
) -> tuple[Array, float]:
    """Error of the tractions on the facets of a contact, as `PressureReadings.misfit`, and over all tractions.

    Parameters
    ----------
    pressed, held : PressureReadings
        Reconstructions of the pressure and of the reserve at the same samples of the facets; None where all slides.
    friction : FrictionFields
        With a single finite coefficient.

    Returns
    -------
    misfit : (n,) array
        Integral over each facet of `pressed` of the squared difference, the larger of the two.
    error : float
        Relative L2 norm, see `MIN_TRACTION`; one where no facet counts, or none of them is pressed.
    """
    mu = friction.mu
    assert isinstance(mu, float)
    fields = {name: mu * getattr(pressed, name) for name in ("interpolated", "root", "smooth")}
    counted = pressed.bounded.copy()
    if held is not None:
        _, at, own = np.intersect1d(pressed.facets, held.facets, return_indices=True)
        counted[at] &= held.bounded[own]
        for name, field in fields.items():
            field[at] -= getattr(held, name)[own]
    found = fields.pop("interpolated")
    misfit = larger_misfit(pressed.areas, found, list(fields.values())) * counted
    norm = (pressed.areas * found**2)[counted].sum()
    norm = max(norm, (MIN_TRACTION * mu) ** 2 * pressed.norm)
    return misfit, float(np.sqrt(misfit.sum() / norm)) if counted.any() and norm > 0 else 1.0
