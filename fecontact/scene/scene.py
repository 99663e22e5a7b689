"""Scene: bodies and the contacts between them, with methods to solve, follow a load path and sweep."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from fecontact.common.arguments import spelled
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError
from fecontact.common.html import cell
from fecontact.common.units import UnitNames
from fecontact.contact.model import SceneModel
from fecontact.scene.cost import explain
from fecontact.scene.load_path import solve_path
from fecontact.scene.solve import solve_scene
from fecontact.scene.sweep import run_sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@spelled
@compact_repr
@dataclass(frozen=True, eq=False)
class Scene(SceneModel):
    """Bodies and the contacts between them.

    Parameters
    ----------
    bodies : sequence of Body
    contacts : sequence of Contact
    springs : sequence of Spring, optional
        Springs and ligaments.
    units : (length, force) or (length, force, stress), optional
        Names of the units in which bodies and loads are given, for tables and pictures: ``("mm", "N", "MPa")``. Nothing
        is converted.
    axes : mapping of str to (3,) array, optional
        Names of two or three directions at right angles, in world axes, along which maps are drawn instead of x, y and
        z: ``{"medial": (-1, 0, 0), "anterior": (0, 1, 0)}``. Coordinates elsewhere stay those of the world.
    notes, warnings : sequence of str, optional
        Sentences that every result repeats, such as what the deck that the scene was read from says otherwise.

    Raises
    ------
    InputError
        For repeated or missing bodies, no contact, units that are no names, or axes that are not at right angles.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    >>> result = scene.solve(motions={body: {"z": -0.01}})
    >>> round(float(result.contacts[0].force[2]), 12)
    0.01
    """

    solve = solve_scene
    solve_path = solve_path
    sweep = run_sweep
    explain = explain

    def plot(self, path: str | Path | None = None, *, units: UnitNames = (), **options: Any) -> Figure:
        """Draw the bodies as they are given, see `results.pictures.bodies.plot_scene`.

        Parameters
        ----------
        path : str or Path, optional
            File to write; the suffix decides the format.
        units : (length, ...) or str
            Names of units, of which the ruler shows that of length; those of the scene unless given.
        **options
            ``view``, ``edges``.

        Raises
        ------
        InputError
            For an unknown option or view, a scene without meshes, or a file that cannot be written.
        """
        from fecontact.results.pictures.bodies import plot_scene

        return plot_scene(self, path, units=units, **options)

    def _repr_html_(self) -> str:
        from fecontact.results.pictures.solids import meshed_among

        draw = self.plot if meshed_among(self.bodies) else None
        return cell("\n".join(body.describe() for body in self.bodies), draw)

    def roll(self, *_: Any, **__: Any) -> NoReturn:
        """Refused: steady rolling is offered for half-spaces, see `HalfSpace.roll`.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(
            "Steady rolling of finite elements is not offered. Take HalfSpace.roll, with layers for a coating or a "
            "tread; for rollers follow the load path in steps: sections with solve_path(..., finite_motion=True).",
            code="rolling-of-scenes",
        )
