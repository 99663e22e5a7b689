"""Elastic half-space."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar, Protocol, TypedDict, TypeVar, Unpack, cast, overload

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.body import Reduced
from fecontact.bodies.pose import Pose
from fecontact.bodies.surface_body import SurfaceBody
from fecontact.common.arguments import flag, instance, items, spelled, text
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, number_array, positive
from fecontact.common.checks import friction as friction_coefficient
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.path import follow
from fecontact.common.progress import LONG, progress_line
from fecontact.common.renamed import renamed_argument
from fecontact.common.stopwatch import Stopwatch
from fecontact.common.viscoelastic import Viscoelastic
from fecontact.halfspace import kernels
from fecontact.halfspace.adhesion import AdhesionCurve, Adhesive, AdhesiveContact, ApproachSteps, Dugdale, Given
from fecontact.halfspace.compliance import SurfaceCompliance
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.creep import CreepCoefficients, CreepCurve, CreepSteps, creep_coefficients
from fecontact.halfspace.friction import CERTIFIED, Friction, PressStep
from fecontact.halfspace.friction_law import FrictionLaw, FrictionOfRolling
from fecontact.halfspace.gradient import PressGradient, friction_gradient, press_gradient
from fecontact.halfspace.grid import Grid, GridSurface, grid_surface
from fecontact.halfspace.hardness import hardness_field
from fecontact.halfspace.layered import Layer
from fecontact.halfspace.operator import CellModel, Part, coarse_pressure
from fecontact.halfspace.path import CurveSteps, FrictionPath, FrictionSteps, LoadCurve
from fecontact.halfspace.pressing import Load, check_settings, press
from fecontact.halfspace.rolling import Pair, RollingContact, RollingFriction, RollingStep, roll
from fecontact.halfspace.steady import MovingContact, press_moving
from fecontact.halfspace.traction_contact import FrictionContact
from fecontact.halfspace.validity import overlap_between_cells
from fecontact.halfspace.viscoelastic import elastic, memory_of
from fecontact.halfspace.wear import WornSteps
from fecontact.solvers import ContactProblem
from fecontact.surfaces.rigid.heightmap import HeightMap
from fecontact.surfaces.rigid.shapes import heights_of

C = TypeVar("C", bound=HalfSpaceContact)

#: What passes through a contact, for conductivities, or a drop along x and a viscosity, of 1.
PASSES: Mapping[str, Callable[[HalfSpaceContact], float]] = {
    "conductance": lambda contact: contact.conductance(1.0, 1.0).value,
    "leakage": lambda contact: contact.leakage(1.0, 1.0).flow,
}


class HeightSurface(Protocol):
    """A rigid surface over the plane z = 0, with its lowest point on it."""

    def heights(self, x: Array, y: Array) -> Array:
        """Heights at coordinates that broadcast together; infinite where there is no surface."""


class Solved(TypedDict, total=False):
    """Settings of a solve."""

    tolerance: float
    symmetry: bool
    workers: int | None


class Pressed(Solved, total=False):
    """A load and settings of its solve."""

    force: float | None
    approach: float | None


class Followed(Solved, total=False):
    """Settings of the solves of a curve."""

    path: str | Path | None
    progress: bool | None


@spelled
@compact_repr
@dataclass(frozen=True, eq=False, init=False)
class HalfSpace(SurfaceBody):
    """An elastic half-space z <= 0 with a grid of cells on its surface, centred on the origin.

    Parameters
    ----------
    material : Material, Viscoelastic or None
        None with layers: a rigid base. A visco-elastic one is served by `press_path`, whose steps have times, and
        by `press` with a velocity; the attribute is its material at once.
    size : (float, float)
        Sides of the grid along x and y.
    cells : (int, int)
        Numbers of cells along x and y.
    periodic : bool
        Whether the surface repeats beyond the grid. Its approach is then relative to the mean plane of the surface.
    layers : sequence of Layer
        Layers from the surface downwards.
    against : Material or Viscoelastic, optional
        Material of a counter-body that is elastic too: its compliance as a half-space is added, which is exact for two
        smooth frictionless half-spaces. Without it the counter-body is rigid.
    pressure : {'uniform', 'bilinear', 'point'}
        Pressure over a cell; 'point' is the report's version, a force at its centre (Elangovan 1978 after Conry &
        Seireg 1971).
    self_ratio : float
        With 'point': displacement under the force over that at the nearest neighbour.
    name : str, optional

    Attributes
    ----------
    grid : Grid
        Cells of the surface.
    compliance : SurfaceCompliance
        Compliance of the surface.

    Raises
    ------
    InputError
        If sizes, numbers of cells or options are invalid.

    Examples
    --------
    A steel sphere of radius 10 mm against a steel plane:

    >>> import fecontact as fc
    >>> steel = fc.Material(E=210e3, nu=0.3)
    >>> half = fc.HalfSpace(steel, size=(0.6, 0.6), cells=(64, 64), against=steel)
    >>> contact = half.press(fc.Sphere(10.0), force=100.0)
    >>> hertz = fc.hertz.spheres((10.0, float("inf")), (steel, steel), force=100.0)
    >>> abs(contact.approach / hertz.approach - 1) < 2e-4, abs(contact.max_pressure / hertz.p0 - 1) < 2e-3
    (True, True)
    """

    required: ClassVar = ("facets",)

    material: Material | None
    grid: Grid
    periodic: bool
    layers: tuple[Layer, ...]
    against: Material | None
    pressure: str
    self_ratio: float
    name: str
    pose: Pose
    compliance: SurfaceCompliance = field(repr=False)

    def __init__(
        self,
        material: Material | Viscoelastic | None,
        size: tuple[float, float] = (4.0, 4.0),
        cells: tuple[int, int] = (256, 256),
        periodic: bool = False,
        *,
        layers: Sequence[Layer] = (),
        against: Material | Viscoelastic | None = None,
        pressure: str = "uniform",
        self_ratio: float = kernels.SELF_TERM_RATIO,
        name: str = "half-space",
        shape: tuple[int, int] | None = None,
    ) -> None:
        for what, given in (("material", material), ("counter-body's material", against)):
            instance(f"the {what} of a half-space", elastic(given), (Material, type(None)))
        memory = memory_of((material, against))
        if memory and layers:
            raise InputError(
                "Layers on or under a visco-elastic half-space are not offered: its displacements would not creep as "
                "one. Leave out the layers, or take Materials.",
                code="viscoelastic",
            )
        for layer in items("the layers of a half-space", layers, "Layer objects"):
            instance("each of the layers of a half-space", layer, Layer)
        fields = {
            "material": elastic(material),
            "grid": Grid(size, renamed_argument("HalfSpace", "shape", "cells", shape, cells)),
            "periodic": flag("periodic", periodic),
            "layers": tuple(layers),
            "against": elastic(against),
            "pressure": pressure,
            "self_ratio": positive("self_ratio", self_ratio),
            "name": text("the name of a half-space", name),
            "pose": Pose(),
        }
        for key, value in fields.items():
            object.__setattr__(self, key, value)
        object.__setattr__(
            self,
            "compliance",
            SurfaceCompliance(
                self.grid,
                self.material,
                self.layers,
                self.against,
                pressure,
                self_ratio,
                self.periodic,
                memory=memory,
            ),
        )

    @overload
    def press(
        self, surface: HeightSurface | ArrayLike, *, friction: None = None, adhesion: None = None,
        load_point: tuple[float, float] | None = None, hardness: ArrayLike | None = None, **load: Unpack[Pressed],
    ) -> HalfSpaceContact: ...  # fmt: skip

    @overload
    def press(
        self, surface: HeightSurface | ArrayLike, *, velocity: tuple[float, float],
        load_point: tuple[float, float] | None = None, **load: Unpack[Pressed],
    ) -> MovingContact: ...  # fmt: skip

    @overload
    def press(
        self, surface: HeightSurface | ArrayLike, *, adhesion: Dugdale, **load: Unpack[Pressed]
    ) -> AdhesiveContact: ...

    @overload
    def press(
        self, surface: HeightSurface | ArrayLike, *, friction: float, tangential: tuple[float, float] | None = None,
        shift: tuple[float, float] | None = None, hardness: ArrayLike | None = None, **load: Unpack[Pressed],
    ) -> FrictionContact: ...  # fmt: skip

    @spelled
    def press(
        self,
        surface: HeightSurface | ArrayLike,
        *,
        force: float | None = None,
        approach: float | None = None,
        load_point: tuple[float, float] | None = None,
        friction: float | None = None,
        tangential: tuple[float, float] | None = None,
        shift: tuple[float, float] | None = None,
        hardness: ArrayLike | None = None,
        adhesion: Dugdale | None = None,
        velocity: tuple[float, float] | None = None,
        tolerance: float | None = None,
        symmetry: bool = True,
        workers: int | None = None,
    ) -> HalfSpaceContact:
        """Press a rigid surface down on the half-space, without friction or with it.

        With friction it is one step from the unloaded state, in which all loads grow together; for others see
        `press_path`.

        Parameters
        ----------
        surface : shape with `heights`, or (nx, ny) array_like
            Heights above the plane z = 0 at the cell centres; infinite where there is no surface.
        force : float, optional
            Total force (on the grid, or on one period), positive but with adhesion.
        approach : float, optional
            Downward displacement of the surface from the given heights. Exactly one of the two.
        load_point : (float, float), optional
            Point of action of the force; the surface is then free to tilt. Without it there is no tilt.
        friction : float, optional
            Coulomb's mu, zero or positive; infinite: what touches sticks. Without it the surface is frictionless.
        tangential : (float, float), optional
            With friction: force on the surface along x and y; zero unless this or the shift is given.
        shift : (float, float), optional
            With friction: displacement of the surface along x and y.
        hardness : float or (nx, ny) array_like, optional
            Largest pressure, at which the surface yields and keeps a `dent`, see `halfspace.hardness`; at least 1e-4
            of the contact modulus. Without it the half-space is elastic.
        adhesion : Dugdale, optional
            The surfaces, separated before, attract each other; under a force, negative for a tension, they have just
            touched. For coming off see `curve`.
        velocity : (float, float), optional
            Of the contact over a visco-elastic half-space, along an axis of a free grid: it rolls, or slides without
            friction, and has done so for long. A visco-elastic counter-body rolls; for one that slides, give what it is
            after a long time (`.relaxed`).
        tolerance : float
            Relative tolerance of the certificate, see `solvers.Residuals`; 1e-8 unless given, with friction 1e-10.
        symmetry : bool
            Whether to solve on a half or quarter of a surface that is symmetric about the axes of the grid.
        workers : int, optional
            Threads of the transforms.

        Returns
        -------
        HalfSpaceContact
            A `FrictionContact` with friction, an `AdhesiveContact` with adhesion, a `MovingContact` with a velocity.

        Raises
        ------
        InputError
            If loads or heights are invalid, or the grid is smaller than the contact; the message gives the size needed.
        SolverError
            If no certified solution was found.

        Examples
        --------
        >>> import numpy as np
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(1.0, 1.0), cells=(32, 32), periodic=True)
        >>> waves = 0.01 * np.cos(2 * np.pi * half.grid.x)[:, None] * np.ones(32)
        >>> contact = half.press(waves, force=0.1)
        >>> contact.area_fraction, round(contact.force, 12)
        (1.0, 0.1)

        A ball dragged by 0.6 of what friction holds sticks within a radius of 0.74 of the contact's:

        >>> plain = fc.Material(E=1.0, nu=0.0)
        >>> half = fc.HalfSpace(plain, size=(3.0, 3.0), cells=(64, 64), against=plain)
        >>> dragged = half.press(fc.surfaces.Paraboloid(1.0), force=2 / 3, friction=0.5, tangential=(0.2, 0.0))
        >>> round((dragged.stick_area / dragged.area) ** 0.5, 2), round(dragged.tangential[0], 9)
        (0.74, 0.2)

        A ball that rolls over rubber, whose loss holds it back by a few hundredths of its load:

        >>> rubber = fc.Viscoelastic(fc.Material(E=1.0, nu=0.3), prony=[(0.5, 1.0)])
        >>> half = fc.HalfSpace(rubber, size=(3.0, 3.0), cells=(32, 32))
        >>> rolls = half.press(fc.surfaces.Paraboloid(1.0), force=0.1, velocity=(1.0, 0.0))
        >>> round(rolls.drag / rolls.force, 2)
        0.04
        """
        if adhesion is not None:
            others: dict[str, object] = {"load_point": load_point, "friction": friction, "tangential": tangential}
            others |= {"shift": shift, "hardness": hardness, "velocity": velocity}
            within = 1e-8 if tolerance is None else tolerance
            adhesive = self._adhesive(surface, adhesion, others, within, symmetry, workers)
            Load(force if force is None else abs(force) or 1.0, approach, None)  # a force may be a tension
            found = adhesive.judged(*adhesive.contact(Given(approach, force)))
            return self._between_cells(found, surface)
        if velocity is not None:
            refused = {"friction": friction, "tangential": tangential, "shift": shift, "hardness": hardness}
            return self._moving(
                surface, Load(force, approach, load_point), velocity, refused, tolerance or 1e-8, workers
            )
        if friction is not None:
            step = PressStep(force, approach, tangential, shift, load_point=load_point)
            within = CERTIFIED if tolerance is None else tolerance
            with progress_line("press", None, delay=LONG):
                return self.press_path(
                    surface, [step], friction, within, symmetry, workers, progress=False, hardness=hardness
                ).last
        self._refuse_memory("a press without time")
        if tangential is not None or shift is not None:
            raise InputError("A tangential force or a shift needs friction: give friction=, Coulomb's mu.")
        tolerance = 1e-8 if tolerance is None else tolerance
        check_settings(tolerance, symmetry, workers)
        load = Load(force, approach, load_point)
        z, hard = self.heights_of(surface), hardness_field(hardness, self.compliance)
        with progress_line("press", None, delay=LONG):
            pressed = press(self.compliance, z, load, tolerance, symmetry, workers, hardness=hard)
        return self._between_cells(pressed, surface)

    def _moving(
        self,
        surface: HeightSurface | ArrayLike,
        load: Load,
        velocity: tuple[float, float],
        others: Mapping[str, object],
        tolerance: float,
        workers: int | None,
    ) -> MovingContact:
        """A contact that moves steadily; other arguments that are given are refused."""
        why = "A contact that moves steadily is without tractions, such as those of a driven wheel, and does not yield"
        _refuse_others(others, why, "velocity-alone")
        if self.compliance.memory is None:
            raise InputError(
                "A velocity changes nothing on an elastic half-space: leave it out, or give a Viscoelastic material.",
                code="velocity-elastic",
            )
        check_settings(tolerance, True, workers)
        moved = press_moving(self.compliance, self.heights_of(surface), load, velocity, tolerance, workers)
        return self._between_cells(moved, surface)

    def _between_cells(
        self, contact: C, surface: HeightSurface | ArrayLike, position: tuple[float, float] = (0.0, 0.0)
    ) -> C:
        """The contact, with a warning where a shape reaches below the surface between its cells."""
        # of a map nothing is known between its points
        if (heights := heights_of(surface)) is None or isinstance(surface, HeightMap):
            return contact
        x, y = position
        warning = overlap_between_cells(contact, lambda s, t: heights(s - x, t - y), self.compliance.modulus)
        return replace(contact, between=warning) if warning else contact

    @overload
    def curve(
        self, surface: HeightSurface | ArrayLike, forces: ArrayLike, *, also: Sequence[str] = (),
        load_point: tuple[float, float] | None = None, hardness: ArrayLike | None = None, **others: Unpack[Followed],
    ) -> LoadCurve: ...  # fmt: skip

    @overload
    def curve(
        self, surface: HeightSurface | ArrayLike, *, approaches: ArrayLike, adhesion: Dugdale,
        **others: Unpack[Followed],
    ) -> AdhesionCurve: ...  # fmt: skip

    @spelled
    def curve(
        self,
        surface: HeightSurface | ArrayLike,
        forces: ArrayLike | None = None,
        *,
        approaches: ArrayLike | None = None,
        adhesion: Dugdale | None = None,
        also: Sequence[str] = (),
        load_point: tuple[float, float] | None = None,
        hardness: ArrayLike | None = None,
        tolerance: float = 1e-8,
        symmetry: bool = True,
        workers: int | None = None,
        path: str | Path | None = None,
        progress: bool | None = None,
    ) -> LoadCurve | AdhesionCurve:
        """Press a rigid surface with several forces: approach, area and pressures over the force.

        With adhesion it goes through approaches, from separated surfaces, each state from the one before: coming on,
        off, or both.

        Every load starts from coarser grids, which give its error estimate too: half the time of a start from the
        neighbouring load at 128 x 128 cells goes into them, at 384 x 384 nothing. Pressures are not kept.

        Parameters
        ----------
        surface : shape with `heights`, or (nx, ny) array_like
            As in `press`.
        forces : (n,) array_like
            Positive, in any order.
        approaches : (n,) array_like
            With adhesion: in the order of the path, negative while surfaces are apart.
        adhesion : Dugdale, optional
        also : sequence of {'stiffness', 'conductance', 'leakage'}
            More columns: the slope of force over approach, `conductance` for conductivities of 1, and `leakage` along x
            for a drop and a viscosity of 1; the first two take about the time of a load each.
        load_point, hardness, tolerance, symmetry, workers
            As in `press`. With a hardness each load meets the dents of those before: forces that grow and fall again
            are loading and unloading, and `steps` have the dents.
        path : str or Path, optional
            File of JSON lines, a row per load, written as loads are done; an interrupted curve goes on from there. A
            row of another half-space, surface or load, or after other loads, is refused.
        progress : bool, optional
            Whether to show the loads on standard error; by default where that is a terminal.

        Raises
        ------
        InputError, SolverError
            As from `press`.

        Examples
        --------
        A paraboloid of radius 1, as Hertz's sphere: the approach grows with the power 2/3 of the force.

        >>> import numpy as np
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(64, 64))
        >>> curve = half.curve(fc.surfaces.Paraboloid(1.0), np.array([0.25, 0.5, 1.0]))
        >>> bool(np.abs(np.diff(np.log(curve.approach)) / np.diff(np.log(curve.force)) - 2 / 3).max() < 2e-3)
        True

        A ball that adheres, on and off; its pull-off is between 3/2 and 2 pi times work and radius:

        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(0.12, 0.12), cells=(32, 32))
        >>> on = np.linspace(-1e-3, 2e-4, 7)
        >>> sticky = fc.Dugdale(work=1e-5, range=4e-4)
        >>> curve = half.curve(fc.surfaces.Paraboloid(1.0), approaches=np.r_[on, on[::-1]], adhesion=sticky)
        >>> round(curve.pull_off / (np.pi * 1e-5), 2), curve.hysteresis > 0
        (1.56, True)
        """
        self._refuse_memory("a curve over the force")
        if adhesion is not None:
            refused = {"forces": forces, "load_point": load_point, "hardness": hardness, "also": also or None}
            adhesive = self._adhesive(surface, adhesion, refused, tolerance, symmetry, workers)
            points = ApproachSteps(adhesive, _listed("approaches", approaches).tolist())
            return points.curve(follow(points, len(points.approaches), path, progress, "curve", "approach")[0])
        if approaches is not None:
            raise InputError("Approaches are of a curve with adhesion: give adhesion=, a Dugdale, or forces.")
        values = _listed("forces", forces)
        check_settings(tolerance, symmetry, workers)
        z, hard = self.heights_of(surface), hardness_field(hardness, self.compliance)
        loads = [Load(float(force), None, load_point) for force in values]

        def pressed(heights: Array, load: Load) -> HalfSpaceContact:
            return press(self.compliance, heights, load, tolerance, symmetry, workers, hardness=hard)

        columns: Mapping[str, Callable[[HalfSpaceContact], float]] = {"stiffness": self.stiffness, **PASSES}
        for name in also:
            among("also", name, columns)
        steps = CurveSteps(self.compliance, z, loads, pressed, tolerance, hard, {n: columns[n] for n in also})
        return LoadCurve(*follow(steps, len(loads), path, progress, "curve", "load"))

    def _adhesive(
        self,
        surface: HeightSurface | ArrayLike,
        adhesion: Dugdale,
        others: Mapping[str, object],
        tolerance: float,
        symmetry: bool,
        workers: int | None,
    ) -> Adhesive:
        """A surface that adheres to it; other arguments that are given are refused."""
        self._refuse_memory("adhesion")
        instance("the adhesion", adhesion, Dugdale)
        why = "With adhesion surfaces are pressed without tilt, friction and hardness, and a curve goes by approaches"
        _refuse_others(others, why, "not-with-adhesion")
        check_settings(tolerance, symmetry, workers)
        return Adhesive(self.compliance, self.heights_of(surface), adhesion, tolerance, symmetry, workers)

    @spelled
    def press_path(
        self,
        surface: HeightSurface | ArrayLike,
        steps: Sequence[PressStep],
        friction: float,
        tolerance: float = CERTIFIED,
        symmetry: bool = True,
        workers: int | None = None,
        path: str | Path | None = None,
        progress: bool | None = None,
        *,
        hardness: ArrayLike | None = None,
        wear: float | None = None,
        start: FrictionContact | RollingContact | None = None,
        track: HeightSurface | ArrayLike | None = None,
        accuracy: float | None = None,
    ) -> FrictionPath:
        """Press and drag a rigid surface with friction along a path of loads, from the unloaded state or a known one.

        With friction the answer depends on the order of the loads, on a visco-elastic half-space also on their times.
        In a step they change together; slip is counted
        from the end of the step before. A step without certified solution is cut in halves, unless its position
        changes; `FrictionPath.cuts` has the number of parts.

        Parameters
        ----------
        surface : shape with `heights`, or (nx, ny) array_like
            As in `press`; steps at other positions need a shape.
        steps : sequence of PressStep
            Loads at the ends of the steps.
        friction : float
            Coulomb's mu, zero or positive; infinite: what touches sticks.
        tolerance, symmetry, workers
            As in `press`; symmetry concerns the pressures.
        path : str or Path, optional
            File of JSON lines, a row per step, written as steps are done, with 30 to 60 bytes per cell: steps already
            in it are certified, not solved, so that an interrupted path goes on where it stopped. A row of another
            half-space, surface, step or history is refused.
        progress : bool, optional
            Whether to show the steps on standard error; by default where that is a terminal.
        hardness : float or (nx, ny) array_like, optional
            As in `press`. Dents stay from step to step, where they are on the half-space.
        wear : float, optional
            Archard's coefficient k, volume per force and length of slip: what slips wears by k p |ds|, the contact
            changes with it, and the next step begins with the worn shape, see `halfspace.wear`. Depths stay where the
            contact is: on both bodies where they slip a little, on the surface that slides along where it slides far.
            Steps are cut until the error of the worn depth is 1 %. A file has twice as many bytes; of steps in it the
            contact on the worn shape is certified.
        start : FrictionContact or RollingContact, optional
            State on the same grid that the path begins with, with the same friction; of steady rolling, shift and twist
            count from it. Steps of one cell along the rolling go on as it does by CONTACT's rule.
        track : shape with `heights`, or (nx, ny) array_like, optional
            Heights of the half-space's own surface, upwards, which stay where they are while steps have other
            positions: a bump, corrugation.
        accuracy : float, optional
            Of a visco-elastic half-space: steps are cut, to a 32nd part, until their `time_error` is below.

        Returns
        -------
        FrictionPath

        Raises
        ------
        InputError
            If steps, friction or heights are invalid, layers are not bonded, or the loads exceed what friction holds;
            the message names the step and the friction needed.
        SolverError
            If no certified solution was found.

        Examples
        --------
        >>> import fecontact as fc
        >>> plain = fc.Material(E=1.0, nu=0.0)
        >>> half = fc.HalfSpace(plain, size=(3.0, 3.0), cells=(32, 32), against=plain)
        >>> pull = [fc.PressStep(force=2 / 3, tangential=(q, 0.0)) for q in (0.0, 0.2, -0.2, 0.2)]
        >>> path = half.press_path(fc.surfaces.Paraboloid(1.0), pull, friction=0.5)
        >>> path.shift[:, 0].round(3)
        array([ 0.   ,  0.229, -0.229,  0.229])

        A ball that slides by 2 under a force of 0.1, without friction, wears:

        >>> slides = [fc.PressStep(force=0.1, shift=(x, 0.0)) for x in (0.0, 2.0)]
        >>> path = half.press_path(fc.surfaces.Paraboloid(1.0), slides, friction=0.0, wear=0.5)
        >>> path.worn_volume.round(9), path.last.max_pressure < path[0].max_pressure
        (array([0. , 0.1]), True)
        """
        check_settings(tolerance, symmetry, workers)
        mu, hard = friction_coefficient(friction, infinite=True), hardness_field(hardness, self.compliance)
        setting = Friction(self.compliance, mu, tolerance, workers, hard)
        if isinstance(start, RollingContact):
            start = start.at_rest()
        given = setting, self._heights_at(surface, track), steps, symmetry
        if wear is not None:
            self._refuse_memory("wear")
            others = {"hardness": hardness, "start": start, "track": track, "accuracy": accuracy}
            _refuse_others(others, "Wear is offered by itself", "wear-alone")
        each = WornSteps(*given, wear) if wear is not None else FrictionSteps(*given, start=start, accuracy=accuracy)
        contacts, cuts = follow(each, len(steps), path, progress)
        if wear is None and track is None:  # between the cells a worn shape and a track are not known
            contacts = tuple(self._between_cells(c, surface, c.position) for c in contacts)
        return FrictionPath(contacts, cuts)

    @spelled
    def roll(
        self,
        surface: HeightSurface | ArrayLike,
        *,
        force: float | None = None,
        approach: float | None = None,
        friction: FrictionOfRolling,
        creepage: Pair = (None, None),
        tangential: Pair = (None, None),
        spin: float = 0.0,
        towards: tuple[float, float] = (1.0, 0.0),
        rule: str = "blended",
        start: RollingContact | None = None,
        tolerance: float = 1e-8,
        symmetry: bool = True,
        workers: int | None = None,
    ) -> RollingContact:
        """Steady rolling of a surface on the half-space, Kalker's problem, in one solve.

        Creepage is the velocity of the surface against the half-space over that of rolling; forces are those on the
        surface, as in `press`. Both are along the direction of rolling and to its left. Where neither is given, the
        surface rolls freely. Bodies are half-spaces; unlike ones couple pressures and tractions.

        Parameters
        ----------
        surface, force, approach, symmetry, workers
            As in `press`.
        friction : float, (float, float), FallingFriction or callable
            Coulomb's mu, zero or positive; infinite: what touches sticks. Two: along the rolling and to its left. A
            function: of the velocities of slip over that of rolling, an array; where it falls there may be several
            solutions: of this one, reached from the friction without slip, `also` and a warning tell.
        creepage : (float or None, float or None)
        tangential : (float or None, float or None)
            For each direction a creepage, a force or none of both.
        spin : float
            Rotation of the surface against the half-space about the normal through the origin, counter-clockwise seen
            from above, per length rolled.
        towards : (float, float)
            Direction of rolling, in which the contact moves over the half-space.
        rule : {'blended', 'contact'}
            Difference along the direction of rolling: the default, or that of the program CONTACT, for comparison.
        start : RollingContact, optional
            A solution nearby on the same grid, to start from.
        tolerance : float
            Relative tolerance of the certificate.

        Returns
        -------
        RollingContact

        Raises
        ------
        InputError
            If loads or heights are invalid, the half-space is periodic, layers are not bonded, or the forces exceed
            what friction holds.
        SolverError
            If no certified solution was found; where friction falls steeply there may be none.

        Notes
        -----
        Between these figures and those of CONTACT, whose surface is its body 1 and whose x and y are the direction of
        rolling and to its left:

        ============================  ===================
        here                          CONTACT
        ============================  ===================
        ``creepage``                  (CKSI, CETA)
        ``spin``                      CPHI
        ``tangential``                -(FX, FY)
        ``torque``                    -MZ
        ``traction``                  -(PX, PY)
        ``slip``                      -(SX, SY)
        ``friction_work``             -FRIC.POWER
        ============================  ===================

        References
        ----------
        J. J. Kalker, Three-dimensional elastic bodies in rolling contact, 1990.

        Examples
        --------
        A braked wheel, at six tenths of the force that friction holds:

        >>> import fecontact as fc
        >>> steel = fc.Material(E=210e3, nu=0.28)
        >>> half = fc.HalfSpace(steel, size=(14.0, 14.0), cells=(32, 32), against=steel)
        >>> wheel = fc.surfaces.Paraboloid(460.0)
        >>> rolling = half.roll(wheel, force=80e3, friction=0.3, tangential=(0.6 * 24e3, 0.0))
        >>> round(1e3 * rolling.creepage[0], 2), round(rolling.stick_area / rolling.area, 2)
        (1.37, 0.6)
        """
        step = RollingStep(force, approach, creepage, tangential, spin, towards, rule)
        setting = self._rolling(step, friction, tolerance, symmetry, workers)
        found = roll(setting, self.heights_of(surface), step, _rolling_start(start), symmetry)
        return self._between_cells(found, surface)

    @spelled
    def creep_curve(
        self,
        surface: HeightSurface | ArrayLike,
        creepages: ArrayLike,
        *,
        spins: ArrayLike = 0.0,
        friction: FrictionOfRolling,
        start: RollingContact | None = None,
        tolerance: float = 1e-8,
        symmetry: bool = True,
        workers: int | None = None,
        path: str | Path | None = None,
        progress: bool | None = None,
        force: float | None = None,
        approach: float | None = None,
        towards: tuple[float, float] = (1.0, 0.0),
        rule: str = "blended",
    ) -> CreepCurve:
        """Steady rolling at several creepages and spins: a creep curve, or a family of them.

        Each point starts from the one before; pressures without tractions are solved for once.

        Parameters
        ----------
        surface
            As in `roll`.
        creepages : (n,) or (n, 2) array_like
            Along the direction of rolling, or along it and to its left.
        spins : (m,) array_like or float
            For each of them all creepages.
        friction, start, tolerance, symmetry, workers
            As in `roll`.
        path, progress
            As in `press_path`: a file of points, from which an interrupted curve goes on.
        force, approach, towards, rule
            As in `roll`.

        Examples
        --------
        >>> import fecontact as fc
        >>> steel = fc.Material(E=210e3, nu=0.28)
        >>> half = fc.HalfSpace(steel, size=(14.0, 14.0), cells=(24, 24), against=steel)
        >>> curve = half.creep_curve(fc.surfaces.Paraboloid(460.0), [5e-4, 1e-3, 1e-2], force=80e3, friction=0.3)
        >>> (curve.tangential[:, 0] / (0.3 * 80e3)).round(2)
        array([0.26, 0.47, 1.  ])
        """
        values = number_array("the creepages of a curve", creepages)
        values = np.stack([values, np.zeros(values.shape)], axis=1) if values.ndim == 1 else values
        if values.ndim != 2 or values.shape[1:] != (2,) or not values.size:
            raise InputError(
                f"The creepages of a curve must be numbers (n,) or (n, 2); found shape {values.shape}.",
                code="wrong-shape",
            )
        turns = np.atleast_1d(number_array("the spins of a curve", spins))
        if turns.ndim != 1 or not turns.size:
            raise InputError(
                f"The spins of a curve must be a number or numbers (m,); found shape {turns.shape}.", code="wrong-shape"
            )
        steps = [
            RollingStep(force, approach, (x, y), spin=spin, towards=towards, rule=rule)
            for spin in turns.tolist()
            for x, y in values.tolist()
        ]
        setting = self._rolling(steps[0], friction, tolerance, symmetry, workers)
        each = CreepSteps(setting, self.heights_of(surface), steps, _rolling_start(start), symmetry)
        contacts, cuts = follow(each, len(steps), path, progress, "creep curve", "point")
        return CreepCurve(tuple(self._between_cells(c, surface) for c in contacts), cuts)

    @spelled
    def creep_coefficients(
        self,
        surface: HeightSurface | ArrayLike,
        *,
        force: float | None = None,
        approach: float | None = None,
        towards: tuple[float, float] = (1.0, 0.0),
        rule: str = "blended",
        tolerance: float = 1e-8,
        symmetry: bool = True,
        workers: int | None = None,
    ) -> CreepCoefficients:
        """Kalker's coefficients C11, C22, C23 and C33 of the contact of a surface, of any outline and nu.

        Other parameters are as in `roll`. The coefficients are of first order in the cells: 1 % at 64 across.

        Examples
        --------
        Kalker's table has 4.12, 3.67 and 1.47 for a disc and nu = 0.25.

        >>> import fecontact as fc
        >>> plain = fc.Material(E=1.0, nu=0.25)
        >>> half = fc.HalfSpace(plain, size=(0.2, 0.2), cells=(48, 48), against=plain)
        >>> found = half.creep_coefficients(fc.surfaces.Paraboloid(1.0), force=4e-4)
        >>> round(found.c11, 1), round(found.c22, 1), round(found.c23, 1)
        (4.1, 3.7, 1.5)
        """
        step = RollingStep(force, approach, towards=towards, rule=rule)
        setting = self._rolling(step, math.inf, tolerance, symmetry, workers)
        z = self.heights_of(surface)
        normal = press(self.compliance, z, Load(force, approach, None), tolerance, symmetry, workers)
        return creep_coefficients(setting, normal, step)

    def _rolling(
        self, step: RollingStep, mu: FrictionOfRolling, tolerance: float, symmetry: bool, workers: int | None
    ) -> RollingFriction:
        """Friction of rolling on it."""
        check_settings(tolerance, symmetry, workers)
        self._refuse_memory("rolling with friction")
        if self.periodic:
            raise InputError(
                "A periodic half-space does not roll: the slip of a period would be that of a train of surfaces. Use "
                "periodic=False and a grid round the contact.",
                code="rolling-periodic",
            )
        law = FrictionLaw.of(mu)
        own = law if law.unlike or law.of_slip else None
        return RollingFriction(self.compliance, law.mu, tolerance, workers, axes=step.axes, rule=step.rule, law=own)

    def _refuse_memory(self, what: str) -> None:
        """Refuse what does not know of time, if the half-space is visco-elastic."""
        if self.compliance.memory:
            raise InputError(
                f"A visco-elastic half-space does not serve {what}: use press_path with PressStep(time=), press with "
                "velocity= for a contact that moves steadily, or an elastic half-space of its material at once "
                "(`.material`) or after a long time (`.relaxed`).",
                code="viscoelastic",
            )

    def _heights_at(
        self, surface: HeightSurface | ArrayLike, track: HeightSurface | ArrayLike | None = None
    ) -> Callable[[tuple[float, float]], Array]:
        """Heights (nx, ny) of a surface by its position, above those of the half-space's own surface."""
        shape, grid = heights_of(surface), self.grid
        own = 0.0 if track is None else self.heights_of(track)

        def heights(position: tuple[float, float]) -> Array:
            if tuple(position) == (0.0, 0.0):
                return self.heights_of(surface) - own
            if not shape:
                raise InputError(
                    "Heights given as an array cannot be moved to a position: give a shape with `heights`.",
                    code="heights-fixed",
                )
            z = shape(grid.x[:, None] - position[0], grid.y[None, :] - position[1])
            return np.broadcast_to(np.asarray(z, dtype=float), grid.shape) - own

        return heights

    def stiffness(self, contact: HalfSpaceContact) -> float:
        """Slope of force over approach at a contact with this half-space, without tilt.

        An increment of approach displaces all cells in contact equally: the slope is the force per approach of a flat
        punch with the contact's outline (Barber, Proc. R. Soc. A 459 (2003) 53). Infinite for a periodic surface in
        full contact, whose mean plane is not displaced.

        Examples
        --------
        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(64, 64))
        >>> ball = half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3)  # radius 1: 2 E* a
        >>> abs(half.stiffness(ball) / 2.0 - 1) < 0.01
        True
        """
        instance("the contact", contact, HalfSpaceContact)
        if not contact.has_stiffness:
            raise InputError(
                "The stiffness with adhesion, and in motion over a visco-elastic half-space, is not that of the "
                "outline: take the slope of a curve with adhesion, or of several contacts.",
                code="not-with-adhesion",
            )
        if not contact.active.any():
            return 0.0
        if self.periodic and self.compliance.mean_is_stiff and contact.active.all():
            return math.inf
        outline = np.where(contact.active, 0.0, np.inf)
        load = Load(contact.force, None, None)
        return contact.force / press(self.compliance, outline, load, 1e-8, True, None, boxed=False).approach

    def gradient(
        self,
        contact: HalfSpaceContact,
        what: str | ArrayLike = "max_pressure",
        *,
        load_point: tuple[float, float] | None = None,
        by_shift: bool = False,
    ) -> PressGradient:
        """Derivatives of a figure of a contact with this half-space, by one solution with the cells in contact.

        Parameters
        ----------
        contact : HalfSpaceContact
            Of `press`, elastic, without adhesion, hardness or velocity. With friction of up to 1500 cells in contact.
        what : {'max_pressure', 'force', 'area', 'approach'} or (nx, ny) array_like
            A figure, or the weights of a linear functional of the pressures, with friction (3, nx, ny) of pressures and
            tractions. The gradient of a function of them is that with its derivatives as weights. With friction there
            is no area.
        load_point : (float, float), optional
            As in `press`.
        by_shift : bool
            With friction: whether the shift was prescribed, not the tangential force.

        Returns
        -------
        PressGradient

        Raises
        ------
        InputError
            For another figure or contact, or weights of another shape.

        Examples
        --------
        The largest pressure under a ball grows with the cube root of the force, and with E^(2/3):

        >>> import fecontact as fc
        >>> half = fc.HalfSpace(fc.Material(E=1.0, nu=0.0), size=(3.0, 3.0), cells=(32, 32))
        >>> ball = half.press(fc.surfaces.Paraboloid(1.0), force=4 / 3)
        >>> slope = half.gradient(ball)
        >>> round(slope.load * ball.force / slope.value, 2), round(slope.E / slope.value, 2)
        (0.33, 0.67)
        """
        if type(contact) is FrictionContact and contact.dent is None and contact.retarded is None:
            return friction_gradient(self.compliance, self._modulus, contact, what, by_shift)
        elastic_contact = type(contact) is HalfSpaceContact and contact.dent is None
        if not elastic_contact or (any(contact.tilt) and load_point is None):
            raise InputError(
                "A gradient is of an elastic contact of `press`, and of one free to tilt with its "
                f"load_point; found {contact!r}.",
                code="no-gradient",
            )
        soft, other = (0.0 if m is None else 1 / m.plane_strain_modulus for m in (self.material, self.against))
        share = soft / (soft + other) if soft else 0.0
        return press_gradient(self.compliance, self.material, contact, what, load_point, share)

    def heights_of(self, surface: HeightSurface | ArrayLike) -> Array:
        """Heights (nx, ny) of a surface at the cell centres."""
        if heights := heights_of(surface):
            z = heights(self.grid.x[:, None], self.grid.y[None, :])
            return np.broadcast_to(np.asarray(z, dtype=float), self.grid.shape)
        return number_array("the heights", surface)

    @property
    def _modulus(self) -> float | None:
        """That of a homogeneous half-space below a rigid partner."""
        alone = not self.layers and self.against is None
        return self.material.E if alone and isinstance(self.material, Material) else None

    def _met_by(self, partner: object) -> HalfSpace:
        """The half-space with cells opposite those of a local body; itself for other partners."""
        faced = getattr(partner, "half_space_opposite", None)
        return self if faced is None else cast(HalfSpace, faced(self))

    @property
    def _matrix_free(self) -> bool:
        """Its compliance is applied by Fourier transforms."""
        return True

    def _size_lines(self, twin: str = "") -> list[str]:
        """Report lines."""
        return [f"{self.name}: a half-space, of which only the surface is cut"]

    @property
    def size(self) -> float:
        """Diagonal of the grid."""
        return math.hypot(*self.grid.size)

    @property
    def reference_point(self) -> Array:
        """The origin of its axes."""
        return np.zeros(3)

    @property
    def contact_modulus(self) -> float:
        """E* of the bodies that it represents."""
        return self.compliance.modulus

    @cached_property
    def _cells(self) -> CellModel:
        return CellModel(self.compliance)

    @cached_property
    def facets(self) -> GridSurface:  # type: ignore[override]
        """Its surface: cell centres and quadrilaterals between them."""
        self._refuse_memory("a scene")
        return grid_surface(self.grid, "surface", self.periodic, self.compliance.pressure == "point")

    def reduce(self, rows: sp.csr_matrix, loads: Array | None, timer: Stopwatch) -> Reduced:
        """Compliance along rows: a matrix, or an operator for many rows of one cell each."""
        with timer("condense"):
            with_friction = _along_surface(rows)
            compliance = (
                self._cells.in_space(rows) if with_friction else self._cells.along(_along(rows, self.facets.normal))
            )
            return Reduced(compliance, np.zeros(rows.shape[0]))

    def coarse_pressure(self, cells: IntArray, problem: ContactProblem) -> tuple[Array | None, Part]:
        """Pressure on cells twice as large by a problem whose rows are cells (n,); see `halfspace.operator`."""
        return coarse_pressure(self._cells, cells, problem)

    def displacement(self, rows: sp.csr_matrix, forces: Array, loads: Array | None) -> Array:
        """Elastic displacements (n_dofs,) under forces along rows."""
        cells, normal = self._cells, self.facets.normal
        if _along_surface(rows):
            return cells.displaced(np.asarray(rows.T @ forces).reshape(-1, 3)).ravel()
        outward = np.asarray(_along(rows, normal).T @ forces).reshape(cells.shape)
        if not outward.any():
            return np.zeros(self.n_dofs)
        u = cells.product.apply(outward / self.grid.area)
        return np.asarray((u.reshape(-1, 1) * normal).ravel())

    def describe(self) -> str:
        """One-line description of the model."""
        kind = "periodic" if self.periodic else "free"
        stack = f", {len(self.layers)} layer(s)" if self.layers else ""
        return f"{self.name}: {kind} half-space, {self.grid.shape[0]} x {self.grid.shape[1]} cells{stack}"


def _refuse_others(others: Mapping[str, object], why: str, code: str) -> None:
    """Refuse other arguments that are given."""
    if given := [f"{name}=" for name, value in others.items() if value is not None]:
        raise InputError(f"{why}: leave out {', '.join(given)}.", code=code)


def _listed(name: str, values: ArrayLike | None) -> Array:
    """Loads (n,) of a curve."""
    found = number_array(f"the {name} of a curve", values)
    if found.ndim != 1 or not found.size:
        raise InputError(f"The {name} of a curve must be numbers (n,), one or more; found shape {found.shape}.")
    return found


def _rolling_start(start: RollingContact | None) -> RollingContact | None:
    """A start of rolling, or a refusal of anything else."""
    return start if start is None else instance("the start of rolling", start, RollingContact)


def _along_surface(rows: sp.csr_matrix) -> bool:
    """Whether some of rows (n, 3 n_cells) are of friction: more along the surface than across it."""
    squares = rows.multiply(rows).tocsr()
    across = squares[:, 2::3].sum(axis=1)
    return bool((squares.sum(axis=1) > 2 * across).any())


def _along(rows: sp.csr_matrix, normal: Array) -> sp.csr_matrix:
    """Parts (n, n_cells) of rows (n, 3 n_cells) for displacements along a normal (3,)."""
    part = sp.csr_matrix(rows @ sp.kron(sp.eye_array(rows.shape[1] // 3), normal[:, None], format="csr"))
    part.eliminate_zeros()
    return part
