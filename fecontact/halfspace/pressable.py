"""Pressing and dragging a rigid surface on a half-space."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypedDict, Unpack, overload

from numpy.typing import ArrayLike

from fecontact.common.arguments import instance, spelled
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.checks import friction as friction_coefficient
from fecontact.common.errors import InputError
from fecontact.common.path import follow
from fecontact.common.progress import LONG, progress_line
from fecontact.halfspace.adhesion import Adhesive, AdhesiveContact, Given
from fecontact.halfspace.adhesion_curve import AdhesionCurve, ApproachSteps
from fecontact.halfspace.attraction import Dugdale
from fecontact.halfspace.cell_surface import CellSurface, Pressed, listed, refuse_others
from fecontact.halfspace.contact import HalfSpaceContact
from fecontact.halfspace.friction import CERTIFIED, Friction, PressStep
from fecontact.halfspace.hardness import hardness_field
from fecontact.halfspace.path import CurveSteps, FrictionPath, FrictionSteps, LoadCurve
from fecontact.halfspace.pressing import Load, check_settings, press
from fecontact.halfspace.rolling import RollingContact
from fecontact.halfspace.steady import MovingContact, press_moving
from fecontact.halfspace.traction_contact import FrictionContact
from fecontact.halfspace.wear import WornSteps

#: What passes through a contact, for conductivities, or a drop along x and a viscosity, of 1.
PASSES: Mapping[str, Callable[[HalfSpaceContact], float]] = {
    "conductance": lambda contact: contact.conductance(1.0, 1.0).value,
    "leakage": lambda contact: contact.leakage(1.0, 1.0).flow,
}


class Solved(TypedDict, total=False):
    """Settings of a solve."""

    tolerance: float
    symmetry: bool
    workers: int | None


class Loaded(Solved, total=False):
    """A load and settings of its solve."""

    force: float | None
    approach: float | None


class Followed(Solved, total=False):
    """Settings of the solves of a curve."""

    path: str | Path | None
    progress: bool | None


class Pressable(CellSurface):
    """Surface of cells that rigid ones are pressed on."""

    @overload
    def press(
        self, surface: Pressed, *, friction: None = None, adhesion: None = None,
        load_point: tuple[float, float] | None = None, hardness: ArrayLike | None = None, **load: Unpack[Loaded],
    ) -> HalfSpaceContact: ...  # fmt: skip

    @overload
    def press(
        self, surface: Pressed, *, velocity: tuple[float, float],
        load_point: tuple[float, float] | None = None, **load: Unpack[Loaded],
    ) -> MovingContact: ...  # fmt: skip

    @overload
    def press(self, surface: Pressed, *, adhesion: Dugdale, **load: Unpack[Loaded]) -> AdhesiveContact: ...

    @overload
    def press(
        self, surface: Pressed, *, friction: float, tangential: tuple[float, float] | None = None,
        shift: tuple[float, float] | None = None, hardness: ArrayLike | None = None, **load: Unpack[Loaded],
    ) -> FrictionContact: ...  # fmt: skip

    @spelled
    def press(
        self,
        surface: Pressed,
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
        within = (1e-8 if friction is None else CERTIFIED) if tolerance is None else tolerance
        check_settings(within, symmetry, workers)
        others: dict[str, object] = {"friction": friction, "tangential": tangential, "shift": shift}
        others["hardness"] = hardness
        if adhesion is not None:
            others |= {"load_point": load_point, "velocity": velocity}
            adhesive = self._adhesive(surface, adhesion, others, within, symmetry, workers)
            Load(force if force is None else abs(force) or 1.0, approach, None)  # a force may be a tension
            return self._between_cells(adhesive.judged(*adhesive.contact(Given(approach, force))), surface)
        if velocity is not None:
            load, why = Load(force, approach, load_point), "A contact that moves steadily is without tractions, such as"
            refuse_others(others, f"{why} those of a driven wheel, and does not yield", "velocity-alone")
            if self.compliance.memory is None:
                raise InputError(
                    "A velocity changes nothing on an elastic half-space: leave it out, or give a Viscoelastic "
                    "material.",
                    code="velocity-elastic",
                )
            moved = press_moving(self.compliance, self.heights_of(surface), load, velocity, within, workers)
            return self._between_cells(moved, surface)
        if friction is not None:
            step = PressStep(force, approach, tangential, shift, load_point=load_point)
            with progress_line("press", None, delay=LONG):
                return self.press_path(
                    surface, [step], friction, within, symmetry, workers, progress=False, hardness=hardness
                ).last
        self._refuse_memory("a press without time")
        if tangential is not None or shift is not None:
            raise InputError("A tangential force or a shift needs friction: give friction=, Coulomb's mu.")
        load = Load(force, approach, load_point)
        z, hard = self.heights_of(surface), hardness_field(hardness, self.compliance)
        with progress_line("press", None, delay=LONG):
            pressed = press(self.compliance, z, load, within, symmetry, workers, hardness=hard)
        return self._between_cells(pressed, surface)

    @overload
    def curve(
        self, surface: Pressed, forces: ArrayLike, *, also: Sequence[str] = (),
        load_point: tuple[float, float] | None = None, hardness: ArrayLike | None = None, **others: Unpack[Followed],
    ) -> LoadCurve: ...  # fmt: skip

    @overload
    def curve(
        self, surface: Pressed, *, approaches: ArrayLike, adhesion: Dugdale,
        **others: Unpack[Followed],
    ) -> AdhesionCurve: ...  # fmt: skip

    @spelled
    def curve(
        self,
        surface: Pressed,
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
        check_settings(tolerance, symmetry, workers)
        if adhesion is not None:
            refused = {"forces": forces, "load_point": load_point, "hardness": hardness, "also": also or None}
            adhesive = self._adhesive(surface, adhesion, refused, tolerance, symmetry, workers)
            points = ApproachSteps(adhesive, listed("approaches", approaches).tolist())
            return points.curve(follow(points, len(points.approaches), path, progress, "curve", "approach")[0])
        if approaches is not None:
            raise InputError("Approaches are of a curve with adhesion: give adhesion=, a Dugdale, or forces.")
        values = listed("forces", forces)
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
        self, surface: Pressed, adhesion: Dugdale, others: Mapping[str, object], tolerance: float, symmetry: bool,
        workers: int | None,
    ) -> Adhesive:  # fmt: skip
        """A surface that adheres to it; other arguments that are given are refused."""
        self._refuse_memory("adhesion")
        instance("the adhesion", adhesion, Dugdale)
        why = "With adhesion surfaces are pressed without tilt, friction and hardness, and a curve goes by approaches"
        refuse_others(others, why, "not-with-adhesion")
        return Adhesive(self.compliance, self.heights_of(surface), adhesion, tolerance, symmetry, workers)

    @spelled
    def press_path(
        self,
        surface: Pressed,
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
        track: Pressed | None = None,
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
        own = 0.0 if track is None else self.heights_of(track)
        given = setting, lambda position: self.heights_of(surface, position) - own, steps, symmetry
        if wear is not None:
            self._refuse_memory("wear")
            others = {"hardness": hardness, "start": start, "track": track, "accuracy": accuracy}
            refuse_others(others, "Wear is offered by itself", "wear-alone")
        each = WornSteps(*given, wear) if wear is not None else FrictionSteps(*given, start=start, accuracy=accuracy)
        contacts, cuts = follow(each, len(steps), path, progress)
        if wear is None and track is None:  # between the cells a worn shape and a track are not known
            contacts = tuple(self._between_cells(c, surface, c.position) for c in contacts)
        return FrictionPath(contacts, cuts)
