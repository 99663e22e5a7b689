"""A wheel on a rail: its contact patches, pressed and rolled on half-spaces in their planes, until they bear the load.

Each patch has a grid of its own in its plane. The wheel is lowered until the vertical parts of normal and tangential
forces are those of the load. Pressures of a patch lift the others, as far away on one half-space; what tractions of one
do to the slip of another is left out.

References
----------
K. L. Johnson, Contact Mechanics, 1985, section 3.2 (a concentrated force);
E. A. H. Vollebregt, User guide for CONTACT, 2023, chapter 3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from scipy.spatial.distance import cdist

from fecontact.bodies import HalfSpace
from fecontact.common import checks
from fecontact.common.arguments import instance
from fecontact.common.arrays import Array, Mask
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, SolverError
from fecontact.common.files import save_figure
from fecontact.common.material import Material
from fecontact.common.path import Path
from fecontact.common.table import Column, Table
from fecontact.common.units import Units
from fecontact.halfspace import RollingContact
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.pictures import Drawn, draw_map, draw_stick_slip
from fecontact.surfaces.profile import Profile
from fecontact.surfaces.wheel_rail import Place, WheelOnRail

#: Cells along a side of the grid on which a patch is first sought, and cells beside it on its own grid.
FIRST, BESIDE = 40, 2
#: Half-lengths of the first grid over that of the overlap of two paraboloids, and how often it may be doubled.
LONGER, DOUBLINGS = 1.5, 4
#: Angles of the rail across a contact, either way from its plane, in radians, that are warned of and refused.
CURVED, CONFORMAL = math.radians(10), math.radians(30)
#: Relative tolerances of the load, and of that whose planes and grids are taken, and steps towards them.
BALANCED, NEAR, MAX_STEPS = 1e-6, 1e-3, 30


@compact_repr
@dataclass(frozen=True, eq=False)
class ContactPatch:
    """A contact of a wheel and a rail in a plane.

    Attributes
    ----------
    place : Place
        Its plane: `origin`, `angle`, `rolling_radius`.
    contact : RollingContact
        On the half-space of its plane, x along the track, y across it to the left.
    centre : (float, float)
        Middle of its grid in the plane, from the origin.
    creepage : (float, float)
    spin : float
        Of the wheel against the rail at the origin.
    angle_across : float
        Largest angle between the rail within the contact and its plane, in radians.
    """

    place: Place
    contact: RollingContact
    centre: tuple[float, float]
    creepage: tuple[float, float]
    spin: float
    angle_across: float

    @property
    def force_on_rail(self) -> Array:
        """Force (3,) on the rail along the track, to the left, and upwards."""
        return np.array([*self.contact.tangential, -self.contact.force]) @ self.place.axes

    @property
    def figures(self) -> dict[str, float]:
        """Figures by name."""
        at, rolled = self.place, self.contact
        return {
            "y": float(at.origin[1]),
            "on_rail": float(at.origin[1] - at.pair.rail_position),
            "angle": at.angle,
            "radius": at.rolling_radius,
            "force": rolled.force,
            "along": rolled.tangential[0],
            "across": rolled.tangential[1],
            "torque": rolled.torque + self.centre[0] * rolled.tangential[1] - self.centre[1] * rolled.tangential[0],
            "creepage_along": self.creepage[0],
            "creepage_across": self.creepage[1],
            "spin": self.spin,
            "max_pressure": rolled.max_pressure,
            "area": rolled.figures["area"],
            "stick_share": rolled.stick_area / rolled.figures["area"],
            "angle_across": self.angle_across,
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the contact, and of a rail that is curved too much for a plane."""
        turns = f"The rail turns by {math.degrees(self.angle_across):.1f} degrees across a contact"
        curved = f"{turns}: its plane is a model of a conformal contact there."
        return (*self.contact.warnings, *([curved] if self.angle_across > CURVED else []))


#: Columns of figures of a patch.
COLUMNS = (
    Column("y", ".3f"),
    Column("angle", ".4f"),
    Column("radius", ".3f"),
    Column("force", ".0f"),
    Column("along", ".0f"),
    Column("across", ".0f"),
    Column("creepage_along", ".2e"),
    Column("creepage_across", ".2e"),
    Column("spin", ".2e"),
    Column("max_pressure", ".0f"),
    Column("area", ".2f"),
    Column("stick_share", ".2f"),
)


@compact_repr
@dataclass(frozen=True, eq=False)
class WheelRailContact(Drawn):
    """A wheel on a rail under a load; made by `WheelRail.roll`.

    Attributes
    ----------
    pair : WheelOnRail
        Profiles and position; `pair.lift` is where the wheel stands.
    patches : tuple of ContactPatch
        From the inner one to the outer one.
    """

    pair: WheelOnRail
    patches: tuple[ContactPatch, ...]

    @property
    def force_on_rail(self) -> Array:
        """Force (3,) on the rail along the track, to the left, and upwards."""
        return np.sum([patch.force_on_rail for patch in self.patches], axis=0)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the patches, each once."""
        return tuple(dict.fromkeys(text for patch in self.patches for text in patch.warnings))

    def _drawn(self, path: str | FilePath | None, units: Units) -> Figure:
        figure = Figure(figsize=(5.4 * (1 + len(self.patches)), 9.0), layout="constrained")
        axes = figure.subplots(2, 1 + len(self.patches), squeeze=False)
        for wide, panel in zip((True, False), axes[:, 0], strict=True):
            _draw_profiles(panel, self, units, wide)
        for k, patch in enumerate(self.patches, 1):
            rolled, label = patch.contact, units.axis_label("pressure", "stress")
            draw_map(axes[0, k], rolled.grid, rolled.pressure, "magma_r", label, units)
            draw_stick_slip(axes[1, k], rolled, units)
            axes[0, k].set_title(f"at {patch.place.origin[1]:.1f}, {math.degrees(patch.place.angle):.1f} degrees")
        return save_figure(figure, path)

    def __str__(self) -> str:
        x, y, z = self.force_on_rail
        total = f"on the rail: {x:.6g} along the track, {y:.6g} to the left, {z:.6g} upwards"
        notes = [total, *(f"Warning: {text}" for text in self.warnings)]
        rows = [[patch.figures[column.name] for column in COLUMNS] for patch in self.patches]
        return str(Table(COLUMNS, rows, notes))


@compact_repr
@dataclass(frozen=True, eq=False)
class WheelRailPath(Path[WheelRailContact], Drawn):
    """A wheel on a rail at several positions; made by `WheelRail.positions`. Its table has a row for each patch."""

    def rows(self) -> list[dict[str, float]]:
        """Figures of each patch by name, after the axle's shift and yaw."""
        each = [(at.pair, patch.figures) for at in self.steps for patch in at.patches]
        return [{"shift": pair.shift, "yaw": pair.yaw, **figures} for pair, figures in each]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the positions, each once."""
        return tuple(dict.fromkeys(text for at in self.steps for text in at.warnings))

    def _drawn(self, path: str | FilePath | None, units: Units) -> Figure:
        figure = Figure(figsize=(12.0, 7.0), layout="constrained")
        shift = self.column("shift")
        panels = {
            units.axis_label("place on the rail", "length"): ("on_rail",),
            "contact angle [degrees]": ("angle",),
            units.axis_label("rolling radius", "length"): ("radius",),
            units.axis_label("force", "force"): ("force", "along", "across"),
            "creepage": ("creepage_along", "creepage_across"),
            units.axis_label("largest pressure", "stress"): ("max_pressure",),
        }
        for axes, (label, names) in zip(figure.subplots(2, 3).flat, panels.items(), strict=True):
            for name in names:
                values = self.column(name)
                values = np.degrees(values) if name == "angle" else values
                axes.plot(shift, values, "o", markersize=4, label=name.replace("_", " "))
            if len(names) > 1:
                axes.legend(fontsize="small")
            axes.set_xlabel(units.axis_label("shift", "length"))
            axes.set_ylabel(label)
            axes.grid(alpha=0.3)
        return save_figure(figure, path)

    @property
    def table(self) -> Table:
        """The columns that are printed."""
        columns = (Column("shift"), *COLUMNS)
        return Table(columns, [[row[column.name] for column in columns] for row in self.rows()])

    def __str__(self) -> str:
        return "\n".join([str(self.table), *(f"Warning: {text}" for text in self.warnings)])


@compact_repr
@dataclass(frozen=True, eq=False)
class WheelRail:
    """A wheel and a rail of given profiles, or any two bodies: one of revolution on a straight one.

    The wheel is the left one: x along the track, y to the left, away from its middle, z upwards. A right wheel is its
    mirror image: give shift, yaw and roll with the other sign; y, lateral forces and creepages, torque and spin then
    have it, too.

    Parameters
    ----------
    wheel, rail : Profile
    radius : float
        Of the wheel where its profile has y = z = 0.
    material : Material
        Of the rail, and of the wheel unless `against` is given.
    against : Material, optional
    wheel_position : float
        Distance of the wheel profile's origin from the middle of the axle: 750 mm with a distance of 1360 mm between
        the flanges' backs, which are 70 mm from the origin.
    gauge : (float, float)
        Distance of the rails' inner sides, and how far below the top it is measured.
    rail_position : float, optional
        Distance of the rail profile's origin from the middle of the track, in place of the gauge.

    Raises
    ------
    InputError
        If numbers are invalid, or the rail's profile does not reach down to where the gauge is measured.

    Examples
    --------
    A cone of 1 in 20 on a crowned rail:

    >>> import numpy as np
    >>> import fecontact as fc
    >>> steel = fc.Material(E=210e3, nu=0.28)
    >>> angle = np.linspace(-0.1, 0.1, 81)
    >>> crown = fc.surfaces.Profile(np.stack([300 * np.sin(angle), 300 * np.cos(angle) - 300], axis=1))
    >>> y = np.linspace(-30.0, 30.0, 13)
    >>> cone = fc.surfaces.Profile(np.stack([y, y / 20], axis=1))
    >>> pair = fc.WheelRail(cone, crown, 460.0, steel, rail_position=750.0)
    >>> found = pair.roll(80e3, friction=0.3, cells=32)
    >>> round(float(found.force_on_rail[2])), round(found.patches[0].place.angle, 4)
    (-80000, 0.05)
    """

    wheel: Profile
    rail: Profile
    radius: float
    material: Material
    against: Material | None = None
    wheel_position: float = 750.0
    gauge: tuple[float, float] = (1435.0, 14.0)
    rail_position: float | None = None

    def __post_init__(self) -> None:
        instance("the wheel", self.wheel, Profile)
        instance("the rail", self.rail, Profile)
        checks.lengths(radius=self.radius)
        if self.rail_position is None:
            width, below = checks.positives("the gauge and the depth where it is measured", self.gauge, 2)
            object.__setattr__(self, "rail_position", width / 2 - self.rail.gauge_face(below))
        checks.finite("the rail's position", self.rail_position or 0.0)

    def roll(
        self,
        force: float,
        *,
        friction: float = 0.3,
        shift: float = 0.0,
        yaw: float = 0.0,
        roll: float = 0.0,
        turning: float = 1.0,
        cells: int = 48,
        join: float = 0.0,
    ) -> WheelRailContact:
        """The wheel rolls steadily along the track under a vertical force.

        Parameters
        ----------
        force : float
            Of the wheel on the rail, downwards.
        friction : float
            Coulomb's mu.
        shift, yaw, roll : float
            Position of the axle: to the left, and counter-clockwise about z and then about x, in radians.
        turning : float
            Speed of the tread at the nominal radius over that along the track: above 1 the wheel drives.
        cells : int
            Cells along each side of a patch's grid.
        join : float
            Patches nearer than this share one plane, of their mean angle, as within CONTACT's D_COMB; without it each
            has its own.

        Returns
        -------
        WheelRailContact

        Raises
        ------
        InputError
            If numbers are invalid, the profiles are not above each other, or a contact is conformal.
        SolverError
            If no certified solution was found.
        """
        checks.positive("the force of a wheel", force)
        checks.whole("the cells of a patch", cells, 4)
        for name, value in {"shift": shift, "yaw": yaw, "roll": roll, "turning": turning, "join": join}.items():
            checks.finite(f"the {name}", value)
        assert self.rail_position is not None
        pair = WheelOnRail(
            self.wheel, self.rail, self.radius, self.wheel_position, self.rail_position, shift, yaw, roll
        )
        if math.isnan(pair.touching_lift):
            raise InputError(
                "The wheel's profile is not above the rail's: check the shift, and the positions of both profiles.",
                code="profiles-apart",
            )
        pair = replace(pair, lift=pair.touching_lift)
        normal = force  # what the normal forces must bear: the load without the tangential ones
        modulus = HalfSpace(self.material, (1.0, 1.0), (2, 2), against=self.against or self.material).contact_modulus
        depth = (0.75 * force / modulus / math.sqrt(self.radius)) ** (2 / 3)
        for _ in range(MAX_STEPS):
            depth, found = self._lowered(pair, normal, depth, cells, join)
            patches = tuple(patch.rolled(friction, turning) for patch in found)
            borne = -float(sum(patch.force_on_rail[2] for patch in patches))
            if abs(borne - force) <= 10 * BALANCED * force:
                return WheelRailContact(replace(pair, lift=pair.lift - depth), patches)
            normal *= force / borne
        raise SolverError(
            "The tangential forces and the load found no balance: the contact angle may be above what friction bears."
        )

    def positions(
        self,
        force: float,
        shifts: ArrayLike,
        *,
        yaws: ArrayLike = 0.0,
        rolls: ArrayLike = 0.0,
        turnings: ArrayLike = 1.0,
        **options: Any,
    ) -> WheelRailPath:
        """The wheel at several positions (n,) of the axle; others, as in `roll`, are numbers or (n,).

        Raises
        ------
        InputError, SolverError
            As in `roll`.
        """
        given = (checks.number_array("the positions", values) for values in (shifts, yaws, rolls, turnings))
        try:
            steps = np.broadcast_arrays(*map(np.atleast_1d, given))
        except ValueError as error:
            raise InputError(f"Shifts, yaws, rolls and turnings must be as many: {error}", code="wrong-shape") from None
        found = [
            self.roll(force, shift=shift, yaw=yaw, roll=roll, turning=turning, **options)
            for shift, yaw, roll, turning in np.stack(steps, axis=1).tolist()
        ]
        return WheelRailPath(tuple(found), (1,) * len(found))

    def _lowered(
        self, pair: WheelOnRail, force: float, depth: float, cells: int, join: float
    ) -> tuple[float, list[_Pressed]]:
        """Depth below where they touch at which normal forces bear a load, and the patches pressed there.

        Planes and grids are those of a depth nearby, whose load is the same but for `NEAR`: forces are smooth on them.
        """
        before, at = (0.0, 0.0), depth
        grids: list[_Grid] = []
        found: list[_Pressed | None] = []
        for _ in range(MAX_STEPS):
            lowered = replace(pair, lift=pair.lift - at)
            settled = bool(grids) and abs(before[1] - 1) < NEAR
            if not settled:
                grids = [grid for place in lowered.places(join) if (grid := self._grid(place, cells)) is not None]
            found = pressed_together(grids, lowered, found if settled else [])
            patches = [patch for patch in found if patch]
            borne = sum(patch.contact.force * math.cos(patch.place.angle) for patch in patches)
            if abs(borne - force) <= BALANCED * force:
                return at, patches
            value = (borne / force) ** (2 / 3)  # nearly linear in the depth: by secants
            slope = (value - before[1]) / (at - before[0])
            before, at = (at, value), max(at + (1 - value) / slope, 0.1 * at) if slope > 0 else 2 * at
        raise SolverError("No depth was found at which the wheel bears the load; patches come and go with the depth.")

    def _grid(self, place: Place, cells: int) -> _Grid | None:
        """A grid round the contact as far as wheel and rail overlap; None where they do not along its normal."""
        half = LONGER * math.sqrt(2 * place.overlap * place.pair.radius / math.cos(place.angle))
        for _ in range(DOUBLINGS):
            x, y = np.linspace(-half, half, FIRST), np.linspace(*place.ends, FIRST)
            inside: Mask = place.gap(x, y) < 0
            if not inside[[0, -1]].any():
                break
            half *= 2
        if not inside.any():
            return None
        pressed = self._around(place, x, y, inside, FIRST, 1).pressed(place.pair)
        if pressed is None or not pressed.contact.active.any():
            return None
        return self._around(place, *pressed.at, pressed.contact.active, cells, BESIDE)

    def _around(self, place: Place, x: Array, y: Array, inside: Mask, cells: int, beside: int) -> _Grid:
        """A grid round what is inside (nx, ny), with some of the former steps and a cell of its own beside it."""
        ends = []
        for axis, values in enumerate((x, y)):
            at = values[np.any(inside, axis=1 - axis)]
            margin = max((beside + 0.5) * (values[1] - values[0]), 1.5 * (at[-1] - at[0]) / (cells - 3))
            ends.append((float(at[0] - margin), float(at[-1] + margin)))
        (left, right), (low, high) = ends
        size = (right - left, high - low)
        half = HalfSpace(self.material, size, (cells, cells), against=self.against or self.material)
        return _Grid(place, half, ((left + right) / 2, (low + high) / 2))


@dataclass(frozen=True, eq=False)
class _Grid:
    """Cells of a half-space in the plane of a place, with their middle at `centre` of it."""

    place: Place
    half: HalfSpace
    centre: tuple[float, float]

    @property
    def at(self) -> tuple[Array, Array]:
        """Distances of the cells' middles from the place's origin, along (nx,) and across (ny,)."""
        grid = self.half.grid
        return grid.x + self.centre[0], grid.y + self.centre[1]

    def pressed(self, pair: WheelOnRail, others: Sequence[_Pressed] = ()) -> _Pressed | None:
        """The patch with the wheel at another height, beside others; None without overlap."""
        place = replace(self.place, pair=pair)
        gap, points, y = place.gap(*self.at), place.points(*self.at), self.at[1]
        if others:
            gap = gap + sum(other.lifts(points) for other in others)
            gap[:, (y < place.ends[0]) | (y > place.ends[1])] = np.inf  # may be within another patch
        approach = -float(gap.min())
        if approach <= 0:
            return None
        heights = gap + approach
        return _Pressed(place, self.half, self.centre, heights, self.half.press(heights, approach=approach))


@dataclass(frozen=True, eq=False)
class _Pressed(_Grid):
    """A patch without friction, by heights (nx, ny) of the wheel over the rail."""

    heights: Array
    contact: HalfSpaceContact

    def lifts(self, points: Array) -> Array:
        """What the pressures open gaps at points (nx, ny, 3) of other patches: as forces at the middles of cells."""
        on = self.contact.active
        lift = (1 / cdist(points.reshape(-1, 3), self.place.points(*self.at)[on])) @ self.contact.pressure[on]
        return lift.reshape(points.shape[:2]) * self.half.grid.area / (math.pi * self.half.contact_modulus)

    def rolled(self, friction: float, turning: float) -> ContactPatch:
        """The patch, rolling."""
        place, y = self.place, self.at[1][self.contact.active.any(axis=0)]
        turns = place.pair.rail.angle(place.origin[1] + y * math.cos(place.angle) - place.pair.rail_position)
        if (angle := float(np.nanmax(np.abs(turns - place.angle)))) > CONFORMAL:
            raise InputError(
                f"The rail turns by {math.degrees(angle):.1f} degrees across a contact: it is conformal, and no plane "
                f"is a model of it. Contacts up to {math.degrees(CONFORMAL):.0f} degrees are offered.",
                code="conformal",
            )
        along, across, spin = place.rigid_motion(turning)
        creepage = (along - spin * self.centre[1], across + spin * self.centre[0])
        depth = self.contact.approach
        contact = self.half.roll(self.heights, approach=depth, friction=friction, creepage=creepage, spin=spin)
        return ContactPatch(place, contact, self.centre, (along, across), spin, angle)


def pressed_together(
    grids: Sequence[_Grid], pair: WheelOnRail, found: Sequence[_Pressed | None]
) -> list[_Pressed | None]:
    """Patches on their grids, each lifted by the others, from those nearby: block by block until the forces settle."""
    if len(grids) == 1:
        return [grids[0].pressed(pair)]
    now = list(found) or [grid.pressed(pair) for grid in grids]
    for _ in range(MAX_STEPS):
        before = [at.contact.force if at else 0.0 for at in now]
        for k, grid in enumerate(grids):
            now[k] = grid.pressed(pair, [at for i, at in enumerate(now) if at and i != k])
        forces = [at.contact.force if at else 0.0 for at in now]
        if math.dist(forces, before) <= (BALANCED if found else NEAR / 10) * sum(forces):
            return now
    raise SolverError("The pressures of patches beside each other do not settle: give join= to solve them as one.")


def _draw_profiles(axes: Any, at: WheelRailContact, names: Units, whole: bool) -> None:
    """Draw the outlines of wheel and rail with the patches' normals, all of them or near the patches."""
    pair = at.pair
    rail = pair.rail.samples[0] + [pair.rail_position, 0.0]
    wheel = pair.outline[0]
    axes.plot(*rail.T, color="#555555", label="rail")
    axes.plot(wheel[:, 1], wheel[:, 2], color="#3182bd", label="wheel")
    span = float(np.ptp(rail[:, 0])) / (1 if whole else 4)
    for patch in at.patches:
        _, y, z = patch.place.origin
        _, dy, dz = 0.2 * span * patch.place.axes[2]
        axes.annotate("", (y, z), (y + dy, z + dz), arrowprops={"arrowstyle": "->", "color": "#d62728"})
    if not whole:
        places = np.array([patch.place.origin[1:] for patch in at.patches])
        reach = max(span / 2, 0.7 * float(np.ptp(places, axis=0).max()))
        (y, z) = (places.max(axis=0) + places.min(axis=0)) / 2
        axes.set_xlim(y - reach, y + reach)
        axes.set_ylim(z - reach, z + reach)
    axes.set_aspect("equal", adjustable="box")
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel(names.axis_label("y", "length"))
    axes.set_ylabel(names.axis_label("z", "length"))
    axes.legend(fontsize="small")
