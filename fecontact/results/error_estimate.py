"""Estimate of a contact's discretisation error from one solution, by two other reconstructions of its pressure.

The error of a finite element contact is largest at the edge, where the pressure falls to zero as a square root within a
face. Two reconstructions bracket it, and per face the larger difference counts:

- the root of the interpolated squares of the nodal pressures, exact for a square root that begins at a node,
with an error as large as that of the pressure itself elsewhere;
- the recovered pressure (`results.recovery`), which also shows the roughness of pressures inside the contact
  (Zienkiewicz & Zhu 1992).

Nothing is fitted to problems with a known solution; docs/error_estimates.md compares the estimate with true errors.
All count what the master covers of a face. Where its rim lies within faces, nodal coupling has the forces of what is
covered act at the nodes inside: by their second moments the error of the pressure inside is added (`AT_RIM`).

Neither shows faces that deviate from a smooth shape; the error of these (`results.geometry_error`) is independent and
its square is added. Where a contact fills few faces, both see little of how the pressure varies: the error of the
stresses in the cells below counts too (`FILLED`). The estimate covers the mesh only, not errors of the model, its loads
or its materials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fecontact.common.arrays import Array, IntArray, Mask
from fecontact.common.error_estimate import NO_CONTACT, NO_FIELD, ErrorEstimate
from fecontact.fem.energy_error import NO_CELLS, EnergyError
from fecontact.mesh.facets import triangular
from fecontact.results.contact_outline import planes_of_symmetry
from fecontact.results.facet_samples import facet_samples, hats, past_rim, without
from fecontact.results.geometry_error import geometry_error
from fecontact.results.recovery import NodalPressure, nodal_pressure, recovered_on

if TYPE_CHECKING:
    from fecontact.results.contact_fields import ContactFields

#: Least and largest number of samples along each side of a face, and the total above which it is reduced.
SAMPLES, MAX_SAMPLES = (3, 6), 40_000
#: Facets per block, which bounds the memory.
BLOCK = 4096
#: Least error of the largest pressure as a share of the mean error: force in excess at the edge is missing inside.
MIN_SHARE = 0.25
#: That share over the mean error, where this is larger: with pressures off by 30 % peaks are off by up to as much.
COARSE_SHARE = 1.6
#: Depth in faces, and as a share of the faces across, up to which the largest pressure lies at the edge, as below flat
#: tips, and is as much in error as the pressure there.
AT_EDGE, AT_EDGE_OF_WIDTH = 2.0, 0.25
#: Error of the area, with its edge located within the faces, as a share of the mean error; on triangles, whose edge is
#: located in fewer places.
AREA_SHARE, AREA_SHARE_OF_TRIANGLES = 0.35, 0.6
#: Pressure at a kink between faces over the root mean square of what kinks bring in; it grows with the logarithm of the
#: faces' size and is 1.5 where faces have a kink at every side, 3.4 with eight faces from kink to kink.
AT_KINKS = 2.0
#: Error of the pressure over that of the compliance: 1 for a modulus that is off everywhere, up to 2 in thin layers of
#: linear elements, whose recovered strains are too smooth.
STIFFNESS = 1.5
#: Relative change of the pressure inside over that of the second moment of the forces, where these act at the nodes
#: inside of faces at the master's rim: the area under a punch that seems smaller is pressed more.
AT_RIM = 2.0
#: Samples along each side of these faces.
RIM_SAMPLES = 12
#: Faces across a contact down to whose width elements below it are looked at.
NARROWEST = 2.0
#: Faces across a contact that fills them, up to which pressures err as the stresses below do. Over n of these widths
#: the error is an n-th: the mean pressure on a region errs by the product of the energy norms of two errors, that of
#: the solution and that of the answer to a mean displacement of the region, which is a face's part of it (Babuska &
#: Miller 1984, *The post-processing approach in the finite element method*).
FILLED = 2.0
#: Share of a contact's force above which a region counts.
MIN_REGION = 0.05


@dataclass(frozen=True, eq=False)
class PressureReadings:
    """Three reconstructions of a contact's pressure on the facets that carry force.

    Attributes
    ----------
    facets : (n,) int array
        Numbers of these facets.
    points, areas : (n, n_q, 3) and (n, n_q) arrays
        Samples on them, see `results.facet_samples`; beyond the master's rim they have no area.
    whole : (n,) array
        Areas of the facets.
    interpolated, root, smooth : (n, n_q) arrays
        The pressure of the coupling, the root of its interpolated squares, and the recovered one.
    bounded : (n,) bool array
        Facets off edges where the pressure has no bound; only these count.
    peak : float
        Largest pressure at a node.
    peak_offset : float
        Its difference from the recovered pressure there; infinite where the pressure has no bound.
    peak_depth : float
        Distance in faces of its node from the nearest one without pressure.
    across : float
        Faces across the narrowest region, see `faces_across`.
    spanned : float
        The same with faces that the master covers in part counted as whole ones: those on which an edge is looked for.
    samples : int
        Samples along each side of a facet.
    """

    facets: IntArray
    points: Array
    areas: Array
    whole: Array
    interpolated: Array
    root: Array
    smooth: Array
    bounded: Mask
    peak: float
    peak_offset: float
    peak_depth: float
    across: float
    spanned: float
    samples: int
    rim: Array

    @cached_property
    def misfit(self) -> Array:
        """Integral (n,) over each facet of the squared difference, the larger of the two, and what the rim adds."""
        found = larger_misfit(self.areas, self.interpolated, (self.root, self.smooth))
        return np.where(self.bounded, found, 0.0) + self.rim * self.norm

    @cached_property
    def error(self) -> float:
        """Relative L2 norm of the misfit; one where no facet counts, or none that counts has pressure."""
        return float(np.sqrt(self.misfit.sum() / self.norm)) if self.norm > 0 else 1.0

    @cached_property
    def norm(self) -> float:
        """Integral of the squared pressure."""
        return float((self.areas * self.interpolated**2)[self.bounded].sum())

    @cached_property
    def in_contact(self) -> Array:
        """Area (n,) of each facet on which the recovered pressure is positive."""
        return np.asarray(np.where(self.smooth > 0, self.areas, 0.0).sum(axis=1))


def larger_misfit(areas: Array, field: Array, others: Sequence[Array]) -> Array:
    """Largest of the squared differences of a field (n, n_q) from others, integrated over each facet (n,)."""
    return np.asarray(np.max([(areas * (other - field) ** 2).sum(axis=1) for other in others], axis=0))


def readings_of(contact: ContactFields, samples: int | None = None) -> PressureReadings | None:
    """Three reconstructions of a contact's pressure, at so many samples a side of a face; None without pressure.

    Nor have nodes alone any, whose forces are no field.
    """
    if contact._surface.of_nodes:
        return None
    field = nodal_pressure(contact)
    if field is None:
        return None
    chosen = np.flatnonzero(field.loaded)
    n = samples or int(np.clip(np.sqrt(MAX_SAMPLES / len(chosen)), *SAMPLES))
    highest = int(np.argmax(np.nan_to_num(field.known)))
    past = _past_rim(contact, chosen)
    blocks = [_read(contact, field, past, chosen[k : k + BLOCK], n, highest) for k in range(0, len(chosen), BLOCK)]
    *read, at_peak = (np.concatenate(part) for part in zip(*blocks, strict=True))
    peak, offset = float(field.pressure.max()), np.inf
    if contact._singular_edge is None:
        peak = float(field.pressure[highest])
        offset = float(abs(peak - at_peak.mean()))
    bounded = field.bounded[chosen]
    outside = contact.facets[chosen].ravel()
    outside = outside[field.pressure[outside] == 0]
    points, covered, whole, interpolated, root, smooth = read
    # a contact so small that no sample sees it counts as if it filled its facets
    areas = np.where(covered, whole, 0.0) if covered.any() else whole
    size = np.sqrt(whole.sum(axis=1).mean()) if contact.facets.shape[1] > 3 else _lengths(contact, chosen).mean()
    depth = np.linalg.norm(contact.nodes[outside] - contact.nodes[highest], axis=1).min(initial=np.inf) / size
    found = PressureReadings(
        chosen, points, areas, whole.sum(axis=1), interpolated, root, smooth,
        bounded, peak, offset, float(depth), np.nan, np.nan, n, _rim_error(contact, field, past, chosen),
    )  # fmt: skip
    across = faces_across(contact, found)
    spanned = across if covered.all() else faces_across(contact, replace(found, areas=whole))
    return replace(found, across=across, spanned=spanned)


def _lengths(contact: ContactFields, facets: IntArray) -> Array:
    """Length (n,) of the first side of facets."""
    ends = contact.nodes[contact.facets[facets, :2]]
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def _past_rim(contact: ContactFields, chosen: IntArray) -> Mask:
    """Nodes (m,) of chosen facets that lie beyond the master's rim.

    With nodal coupling they have no value; in a mortar coupling those of facets at the rim do.
    """
    mine, past = np.zeros((2, len(contact.nodes)), bool)
    mine[contact.facets[chosen]] = True
    if contact.coupling != "mortar":
        mine &= np.diff(contact._at_nodes.indptr) == 0
    past[mine] = past_rim(contact, contact.nodes[mine])
    return past


def _read(
    contact: ContactFields, field: NodalPressure, past: Mask, chosen: IntArray, n: int, highest: int
) -> tuple[Array, ...]:
    """Samples on some facets, n along each side, with the three pressures, and the smooth at a node.

    Points, whether the master covers them, areas, and the pressures: that of a node is force over covered area, and on
    facets at the master's rim that of the nodes inside goes on up to the rim.
    """
    facets, mortar = contact.facets[chosen], contact.coupling == "mortar"
    samples = facet_samples(contact.nodes, facets, mortar, contact._extent, n)
    shapes, straight = samples.shapes, hats(facets, samples.local, mortar)
    covered = np.ones(samples.areas.shape, bool)
    rim = past[facets].any(axis=1)
    if rim.any():
        covered[rim] = ~past_rim(contact, samples.points[rim])
        if not mortar:
            shapes, straight = shapes.copy(), straight.copy()
            shapes[rim] = straight[rim] = without(straight[rim], past[facets[rim]])
    squares = np.einsum("fqa,fa->fq", straight, field.pressure[facets] ** 2)
    interpolated = np.einsum("fqa,fa->fq", shapes, field.pressure[facets])
    smooth, some, at_node = interpolated.copy(), field.bounded[chosen], np.zeros((0, 1))
    if some.any():
        recovery = recovered_on(contact, field, chosen[some])
        smooth[some] = recovery.at(samples.points[some])
        there = (facets[some] == highest).any(axis=1)
        at_node = recovery.at(np.broadcast_to(contact.nodes[highest], (len(there), 1, 3)))[there]
    root = np.sqrt(np.maximum(squares, 0.0))
    return samples.points, covered, samples.areas, interpolated, root, smooth, at_node


def _rim_error(contact: ContactFields, field: NodalPressure, past: Mask, chosen: IntArray) -> Array:
    """Squared relative error (n,) of the pressure due to chosen facets at the master's rim.

    With nodal coupling the force on what is covered of them acts at nodes inside. So its second moment about the middle
    of a region is too small, and the pressure, which goes as its inverse at a given force, is too large.
    """
    out = np.zeros(len(chosen))
    rim = np.flatnonzero(past[contact.facets[chosen]].any(axis=1))
    if contact.coupling == "mortar" or not len(rim):
        return out
    facets = contact.facets[chosen[rim]]
    samples = facet_samples(contact.nodes, facets, False, contact._extent, RIM_SAMPLES)
    straight = hats(facets, samples.local, False)
    shares = np.einsum("fq,fqa->fa", samples.areas, straight) * ~past[facets]
    at = np.einsum("fa,fai->fi", shares, contact.nodes[facets]) / shares.sum(axis=1, keepdims=True)
    pressure = np.einsum("fqa,fa->fq", without(straight, past[facets]), field.pressure[facets])
    forces = np.where(past_rim(contact, samples.points), 0.0, samples.areas * pressure)
    region, off, moment = contact._facet_region[chosen[rim]], np.zeros(len(rim)), 0.0
    for k in np.unique(region):  # of many contacts few
        points, middle = contact.region == k, _middle(contact, k)
        moment += contact.forces[points] @ ((contact.points[points] - middle) ** 2).sum(axis=1)
        own = region == k
        far = ((samples.points[own] - middle) ** 2).sum(axis=2) - ((at[own] - middle) ** 2).sum(axis=1)[:, None]
        off[own] = np.abs((forces[own] * far).sum(axis=1))
    share = float(contact.forces[np.isin(contact.region, region)].sum() / contact.forces.sum())
    out[rim] = off * off.sum() * share * (AT_RIM / moment) ** 2 if moment > 0 else 0.0
    return out


def _middle(contact: ContactFields, region: int) -> Array:
    """Mean position (3,) of the forces of a region and their mirror images."""
    mine, pose = contact.region == region, contact.slave.pose
    force = contact.forces[mine] / contact.forces[mine].sum()
    middle = force @ contact.points[mine]
    nodes = contact._node_numbers[contact._at_nodes @ mine.astype(float) > 0]
    for mirror in planes_of_symmetry(contact._surface, pose, nodes):
        middle = middle - ((middle - mirror.point) @ mirror.normal) * mirror.normal
    if contact._surface.revolved and _reaches_axis(radius := pose.to_body(contact.points[mine])[:, 0]):
        middle = middle - (radius @ force) * pose.rotation[:, 0]
    return np.asarray(middle)


def _reaches_axis(radius: Array) -> bool:
    """Whether a ring of such radii (n,) reaches the axis and continues beyond it."""
    return bool(radius.min() < np.ptp(radius) / 6)


def error_estimate(contact: ContactFields, readings: PressureReadings | None) -> ErrorEstimate:
    """Errors of a contact estimated from its reconstructed pressures and the kinks between its faces."""
    if readings is None:
        return ErrorEstimate.none(NO_FIELD if contact._surface.of_nodes else NO_CONTACT)
    area = float(readings.in_contact.sum())
    counted = float(contact.weights[contact.active].sum())
    # pressures that would pull part instead, so that they are never off by more than all of them
    norm = readings.norm
    geometry = min(1.0, float(geometry_error(contact) * np.sqrt(max(area, counted) / norm))) if norm > 0 else 0.0
    edge = contact._singular_edge
    unseen = unseen_profile(contact, readings)
    interior = interior_error(contact._energy_errors, unseen)
    pressure = float(np.sqrt(readings.error**2 + geometry**2 + interior**2))
    cornered = contact.facets.shape[1] > 3 and triangular(contact.facets).any()
    of_area = AREA_SHARE_OF_TRIANGLES if cornered else AREA_SHARE
    share = min(1.0, max(MIN_SHARE, unseen, COARSE_SHARE * pressure))
    if readings.peak_depth <= min(AT_EDGE, AT_EDGE_OF_WIDTH * readings.across):
        share = 1.0
    found = ErrorEstimate(
        pressure=pressure,
        geometry=geometry,
        interior=interior,
        peak=max(
            readings.peak_offset / readings.peak, share * pressure, AT_KINKS * geometry, interior if unseen else 0.0
        ),
        area=of_area * pressure if area > 0 else 1.0,
        faces_across=readings.across,
        unbounded=None if edge is None else edge.peak,
    )
    # a contact that fills its faces is as wide as they are
    return found if contact.active.all() else found.within_resolution()


def unseen_profile(contact: ContactFields, readings: PressureReadings) -> float:
    """What the readings of a contact do not tell of its profile: 1 up to `FILLED` faces across, then the less the more.

    Zero where a contact ends within its faces, since its edge shows a profile.
    """
    return min(1.0, FILLED / readings.across) if contact.active.all() else 0.0


def interior_error(errors: Sequence[EnergyError], unseen: float = 0.0) -> float:
    """Relative error of the pressure due to that of the compliance of the elements below a contact.

    The compliance is too small by the error's square over the energy (`fem.energy_error`), as with a modulus that is
    too large. Of a profile that is unseen also by that of their stresses, its root.
    """
    error, energy = sum(float(e.error.sum()) for e in errors), sum(float(e.energy.sum()) for e in errors)
    share = error / energy if energy > 0 else 0.0
    return min(1.0, max(STIFFNESS * share, unseen * float(np.sqrt(share))))


def energy_errors(contact: ContactFields, readings: PressureReadings | None) -> tuple[EnergyError, EnergyError]:
    """Errors in the cells of slave and master below a contact, as deep as it is wide."""
    if readings is None:
        return NO_CELLS, NO_CELLS
    width = max(readings.across, NARROWEST) * float(_lengths(contact, readings.facets).mean())
    points, (ours, theirs), heated = contact.points[contact.active], contact._displacements, contact._heated
    return (
        contact.slave._energy_error(ours, contact.slave.pose.to_body(points), width, heated[0]),
        contact.master._energy_error(theirs, contact.master.pose.to_body(points), width, heated[1]),
    )


def faces_across(contact: ContactFields, readings: PressureReadings) -> float:
    """Faces across the narrowest region of a contact that carries a twentieth of its force.

    The number on the shorter diameter of an ellipse with the same number of faces, including mirror images.
    """
    share = readings.in_contact / readings.whole
    at_nodes = contact._at_nodes.copy()
    at_nodes.data = contact.region[at_nodes.indices].astype(float)
    region = at_nodes.max(axis=1).toarray().ravel().astype(np.int64)
    of_facet = contact._facet_region[readings.facets]
    load = np.bincount(contact.region, contact.forces)
    least = min(MIN_REGION * load.sum(), load.max())  # of many regions none may carry so much
    chosen = [k for k in np.flatnonzero(load >= least) if k > 0]
    return min(_across(contact, readings, of_facet == k, share, contact._node_numbers[region == k]) for k in chosen)


def _across(contact: ContactFields, readings: PressureReadings, chosen: Mask, share: Array, numbers: IntArray) -> float:
    """Faces across one region, from its facets (n,), their shares (n,) in contact, and its node numbers."""
    n = share[chosen].sum() * 2 ** contact.slave._planes_through(numbers)
    points, weights = readings.points[chosen].reshape(-1, 3), readings.areas[chosen]
    if contact.facets.shape[1] == 3:
        radius = contact.slave.pose.to_body(points)[:, 0]
        return float(2 * n if contact._surface.revolved and _reaches_axis(radius) else n)
    weights = np.where(readings.smooth[chosen] > 0, weights, 0.0).ravel()
    if not weights.any():
        return float(n)
    offset = points - weights @ points / weights.sum()
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh((offset * weights[:, None]).T @ offset), 0.0))
    slender = spread[1] / spread[2]
    return float(np.sqrt(4 * n * slender / np.pi))
