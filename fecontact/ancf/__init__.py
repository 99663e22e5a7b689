"""Absolute nodal coordinates: elements whose coordinates are positions and position gradients; contacts are results.

Four notions carry everything. `bricks/` and `slender/` have the members, `system/` what works on all of them.

`Member`
    A deformable thing with coordinates q of its own: energy, forces (its gradient), tangent, mass. `bricks/` has
    `AncfSolid`, eight-node bricks on any mesh of hexahedra; `slender/` has lines, beams and plates. Coordinates are
    positions and gradients, three numbers each: of bricks ``q.reshape(-1, 3)[4 k]`` is the position of node k, the
    next three rows dr/dX, dr/dY, dr/dZ. Functions are shared by neighbours, so that q is all there is.
`Assembly`
    Members one after the other in one q, with supports and joints, which are rows of conditions with a reaction and
    leave directions free (q = q0 + Z y), and with contacts: ``fc.Contact(solid.side("top"), ball, friction=0.3)``. A
    contact is a row of gaps g(q) for each multiplier of the side, made anew at every q (`system/moving_contact`), and
    rows of slip since the last state (`system/slip`).
`Stage`
    What acts on an assembly at one load level or time: dead loads, prescribed motions, loads that follow.
`State`
    What `equilibrium` finds at a level: q, forces, reactions, friction; its `contacts` are results as a scene's, with
    pressures per present area. `move` gives the same in time; the contacts of a `Motion` are those at its end.

A Newton step (`system/newton`) is one contact problem: a factor of the tangent gives the compliance of all rows, and
the solvers of scenes the forces. Statics and both time schemes take it; joints are eliminated before, rigid hubs are
equations in it.

=============================  =======================================================================================
`AncfSpace(mesh)`              numbering and functions: `q0`, `affine(A, b)`, `rigid_modes`, `points_at`, `gradient_at`,
                               `nodes`, `start`, `n_dofs`
`AncfSolid(space, material)`   `energy(q)`, `forces(q)` (elastic, the gradient of the energy), `tangent(q)` (sparse,
                               symmetric), `stiffness` (at q0), `mass` (sparse, constant)
`Joints(solids)`               supports, joints and hubs as linear conditions on coordinates, for an `Assembly`
`hold(space, supports)`        `Supports.free`: q = q0 + Z y with free y; then Z^T forces, Z^T tangent Z, Z^T mass Z
`weight, body_force`           constant forces Q (n_dofs,) of gravity
`force_at(space, point, f)`    constant forces Q (n_dofs,) of a single force; also `point_force, nodal_force`
`traction, dead_pressure`      constant forces Q (n_dofs,) on boundaries
`pressure_forces(space, q)`    pressure that follows the surface, with `pressure_tangent`
`FollowerPressure, Moment`     loads that change with the deformation, for `Stage(assembly, follow=[..])`
`InvertedError`                is raised where a law, ``fc.NeoHookean(E=, nu=)`` as the material, meets det F <= 0
`Plastic`                      von Mises' yield with linear hardening, as the material of bricks or a layered `line`
`FloatingBody(modes)`          a body of small strains that moves and turns, with modes of `ElasticBody.with_modes(n)`
`Liquid`                       a liquid of bricks, for motion in time, with `Viscosity(newtonian=)`
`Viscosity`                    Kelvin-Voigt and a Prony series beside the law, for motion in time
`sides_by_label, released_at`  neighbours that do not share all gradients; `reentrant_points` finds such edges
=============================  =======================================================================================

Equilibrium is forces(q) = Q; motion is mass q'' + forces(q) = Q. With contact and large deformation:

=============================  =======================================================================================
`Assembly.of(solids, ..)`      solids with supports and contacts, against rigid bodies or each other, and friction
`equilibrium(stage)`           statics: Newton's method with contact, load steps that adapt
`move(assembly, until, step)`  dynamics by `GeneralisedAlpha` or `EnergyMomentum`; `save_motion` writes a PVD series
=============================  =======================================================================================

Examples
--------
>>> import numpy as np, scipy.sparse.linalg, fecontact as fc
>>> from fecontact.ancf import AncfSolid, AncfSpace, hold, traction
>>> space = AncfSpace(fc.shapes.block((10.0, 1.0, 1.0), (4, 1, 1), element="hex8"))
>>> solid = AncfSolid(space, fc.Material(E=1e3, nu=0.0))
>>> Z = hold(space, {"x_min": "xyz"}).free
>>> load = traction(space, "x_max", (0.0, 0.0, -0.05))
>>> q = space.q0
>>> for _ in range(8):
...     rest = Z.T @ (load - solid.forces(q))
...     q = q + Z @ scipy.sparse.linalg.spsolve((Z.T @ solid.tangent(q) @ Z).tocsc(), rest)
>>> bool(np.abs(Z.T @ (load - solid.forces(q))).max() < 1e-10)
True
"""

from collections.abc import Callable
from typing import Any

from fecontact.ancf.bricks.hexahedron import ElementHexAncf, gauss, shapes
from fecontact.ancf.bricks.loads import (
    Follower,
    FollowerPressure,
    Moment,
    body_force,
    dead_pressure,
    force_at,
    nodal_force,
    point_force,
    pressure_forces,
    pressure_tangent,
    traction,
    weight,
)
from fecontact.ancf.bricks.solid import AncfSolid
from fecontact.ancf.bricks.space import AncfSpace, reentrant_points, released_at, sides_by_label
from fecontact.ancf.bricks.viscosity import Viscosity
from fecontact.ancf.floating import FloatingBody
from fecontact.ancf.picture import save_motion
from fecontact.ancf.system.assembly import Assembly
from fecontact.ancf.system.dynamics import Motion, move
from fecontact.ancf.system.joints import Joints, Supports, hold
from fecontact.ancf.system.schemes import EnergyMomentum, GeneralisedAlpha
from fecontact.ancf.system.stage import Stage
from fecontact.ancf.system.statics import Path, State, equilibrium
from fecontact.common.renamed import renamed_names
from fecontact.fem import laws
from fecontact.fem.laws import InvertedError
from fecontact.fem.liquid import Liquid
from fecontact.fem.plastic import Plastic

__all__ = [
    "AncfSolid",
    "AncfSpace",
    "Assembly",
    "ElementHexAncf",
    "EnergyMomentum",
    "FloatingBody",
    "Follower",
    "FollowerPressure",
    "GeneralisedAlpha",
    "InvertedError",
    "Joints",
    "Liquid",
    "Moment",
    "Motion",
    "Path",
    "Plastic",
    "Stage",
    "State",
    "Supports",
    "Viscosity",
    "body_force",
    "dead_pressure",
    "equilibrium",
    "force_at",
    "gauss",
    "hold",
    "move",
    "nodal_force",
    "point_force",
    "pressure_forces",
    "pressure_tangent",
    "reentrant_points",
    "released_at",
    "save_motion",
    "shapes",
    "sides_by_label",
    "traction",
    "weight",
]


def _former(kind: type[laws.Law]) -> Callable[..., Any]:
    """A law under its former name, whose call without constants chose the law of Materials."""
    return lambda *args, **given: kind(*args, **given) if args or given else kind


#: Laws are those of `fecontact.fem.laws`, given in place of the material.
__getattr__ = renamed_names(
    {
        "__name__": __name__,
        "fecontact.NeoHookean": _former(laws.NeoHookean),
        "fecontact.StVenantKirchhoff": _former(laws.StVenantKirchhoff),
        "fecontact.fem.laws.Law": laws.Law,
        "fecontact.fem.laws.Response": laws.Response,
    },
    NeoHookean="fecontact.NeoHookean",
    StVenantKirchhoff="fecontact.StVenantKirchhoff",
    Law="fecontact.fem.laws.Law",
    Response="fecontact.fem.laws.Response",
)
