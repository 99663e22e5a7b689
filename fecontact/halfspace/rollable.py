"""Steady rolling on a half-space."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import instance, spelled
from fecontact.common.checks import number_array
from fecontact.common.errors import InputError
from fecontact.common.path import follow
from fecontact.halfspace.cell_surface import CellSurface, Pressed, listed
from fecontact.halfspace.creep import CreepCoefficients, CreepCurve, CreepSteps, creep_coefficients
from fecontact.halfspace.friction_law import FrictionLaw, FrictionOfRolling
from fecontact.halfspace.pressing import Load, check_settings, press
from fecontact.halfspace.rolling import Pair, RollingContact, RollingFriction, RollingStep, roll


class Rollable(CellSurface):
    """Surface of cells that rigid ones roll on."""

    @spelled
    def roll(
        self,
        surface: Pressed,
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
        surface: Pressed,
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
        turns = listed("spins", np.atleast_1d(spins))
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
        surface: Pressed,
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


def _rolling_start(start: RollingContact | None) -> RollingContact | None:
    """A start of rolling, or a refusal of anything else."""
    return start if start is None else instance("the start of rolling", start, RollingContact)
