"""Two solid spheres pressed together, solved by finite elements and compared with Hertz.

The mesh of each sphere is fitted to the edge of the contact, which is found by first passes: dimensional analysis gives
the size of the contact to within a factor, meshes of the spheres' sections of that size are solved, and the second
moment of their contact forces gives the radius to some hundredths of a percent. The bodies are solids of revolution, so
their sections give the same radius at a tenth of the cost. Hertz's formulas are used for comparison only.
"""

from __future__ import annotations

import math
import time
from dataclasses import asdict

import numpy as np

from fecontact.ancf.bricks.body import AncfBody
from fecontact.app.options import ELEMENTS, MODELS, PRESSURES
from fecontact.app.spheres.case import CASES, Spheres
from fecontact.app.spheres.figures import SpheresResult, moment_radius
from fecontact.bodies import AxisymmetricBody, ElasticBody, Plane, RigidBody, rotation_about
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.contact.contact import Contact
from fecontact.mesh import section_shapes as sections
from fecontact.mesh import shapes
from fecontact.mesh.shapes import Level
from fecontact.results.result import ContactResult
from fecontact.scene.scene import Scene

#: Section element of each hexahedron.
SECTIONS = {"hex20": "quad8", "hex27": "quad9"}


#: Sections that find the contact radius: to some tenths of a percent by the first, to 1 or 2 parts in 10,000 then.
FIRST_PASSES = (
    Level(core=2, rings=2, edge=0.2, layer=0.2, growth=2.0),
    Level(core=3, rings=6, edge=0.02, layer=0.035, growth=2.0),
)


def solve_spheres(
    case: str | Spheres = "equal",
    *,
    element: str = "hex20",
    pressure: str = "midface",
    model: str = "two-bodies",
    level: int | Level = 2,
    solver: str = "auto",
    edge_fit: bool = True,
    backend: str = "auto",
    coupling: str = "auto",
) -> SpheresResult:
    """Press two spheres together and compare with Hertz.

    Parameters
    ----------
    case : str or Spheres
        'equal', 'unequal', 'light' or a `Spheres` object.
    element : {'hex20', 'hex8', 'hex27', 'ancf'}
        'ancf': bricks with gradient coordinates, on the geometry of 20-node ones.
    pressure : {'midface', 'nodal'}
        Contact faces with a ninth node, or the report's plain 20-node faces.
    model : {'two-bodies', 'symmetric', 'axisymmetric'}
        'symmetric': one sphere on a rigid plane, for equal spheres; 'axisymmetric': sections of both, of the
        quadrilaterals that are sections of the hexahedra (8 nodes for 20, 9 for 27).
    level : int or Level
        1 (coarse) to 5 (fine).
    solver, backend : str
    edge_fit : bool
        Whether first passes find the contact radius and the mesh is fitted to it. Without it the mesh has rings of
        equal width out to twice the radius that dimensional analysis gives.
    coupling : {'auto', 'nodal', 'mortar'}
        See `Contact`; the first passes use 'auto'.

    Returns
    -------
    SpheresResult

    Raises
    ------
    InputError
        If an option is unknown, or the symmetric model is requested for spheres of different size.

    Examples
    --------
    >>> out = solve_spheres("equal", model="symmetric", level=1)
    >>> abs(out.errors["contact_radius"]) < 0.002
    True
    """
    spheres = _check(case, element, pressure, model)
    began = time.perf_counter()
    shapes.as_level(level)
    fitted = spheres.scale_radius
    seconds: dict[str, float] = {"first_pass": 0.0}
    if edge_fit:
        fitted = radius_by_sections(spheres, fitted, backend)
        seconds["first_pass"] = time.perf_counter() - began
    cut = shapes.as_level(level) if edge_fit else _unfitted(shapes.as_level(level))
    at = fitted if edge_fit else 2 * fitted
    result, upper, meshing = _press(
        spheres,
        at,
        cut,
        solver,
        element=element,
        pressure=pressure,
        model=model,
        backend=backend,
        coupling=coupling,
    )
    stages = {"mesh": meshing, **{k: v for k, v in result.seconds.items() if k != "total"}}
    at_edge = time.perf_counter()
    (edge,) = result.edge_pressures
    now = time.perf_counter()
    seconds = {**stages, **seconds, "edge": now - at_edge, "total": now - began}
    chosen = {
        "element": SECTIONS[element] if model == "axisymmetric" else element,
        "pressure": _pressures_of(element, pressure, model),
        "model": model,
        "level": level if isinstance(level, int) else asdict(level),
        "edge_fit": edge_fit,
        "edge_pressure": edge.accepted,
    }
    return SpheresResult(spheres, chosen, result, upper, fitted if edge_fit else math.nan, seconds)


def radius_by_sections(spheres: Spheres, start: float, backend: str = "auto") -> float:
    """Contact radius from the spheres' sections, fitted to a first guess and then to the radius found with it.

    Examples
    --------
    >>> equal = CASES["equal"]
    >>> abs(radius_by_sections(equal, equal.scale_radius) / equal.hertz.a - 1) < 5e-4
    True
    """
    for cut in FIRST_PASSES:
        found = _press_sections(spheres, start, cut, "auto", "quad8", backend, "auto")[0].contacts[0]
        start = moment_radius(found, np.hypot(found.points[:, 0], found.points[:, 1]))
    return start


def _pressures_of(element: str, pressure: str, model: str) -> str:
    """Kind of pressure points, for tables."""
    if model == "axisymmetric":
        return "sides"
    return {"hex20": pressure, "ancf": "eight"}.get(element, "nodal")


def _check(case: str | Spheres, element: str, pressure: str, model: str) -> Spheres:
    if isinstance(case, str) and case not in CASES:
        raise InputError(f"Unknown case {case!r}; expected one of {', '.join(map(repr, CASES))} or a Spheres object.")
    among("element", element, ELEMENTS)
    among("pressure", pressure, PRESSURES)
    among("model", model, MODELS)
    spheres = CASES[case] if isinstance(case, str) else case
    if model == "symmetric" and spheres.radii[0] != spheres.radii[1]:
        raise InputError(
            f"The symmetric model needs equal spheres; found radii {spheres.radii}. Use model='two-bodies'.",
            code="unequal-spheres",
        )
    if model == "axisymmetric" and (element not in SECTIONS or pressure == "nodal"):
        raise InputError(
            f"The axisymmetric model takes the sections of hex20 or hex27, with positive weights on their sides; found "
            f"element={element!r} and pressure={pressure!r}."
        )
    return spheres


def _unfitted(level: Level) -> Level:
    """Rings of equal width, as many as the fitted mesh has in twice the radius."""
    rings = 2 * level.rings
    width = 1 / (rings + level.core)
    return Level(level.core, rings, width, width, level.growth)


def _press(
    spheres: Spheres,
    ring: float,
    level: Level,
    solver: str,
    *,
    element: str,
    pressure: str,
    model: str,
    backend: str,
    coupling: str = "auto",
) -> tuple[ContactResult, ElasticBody, float]:
    """Mesh quarters of both spheres, place them in contact at the origin and press the upper one down."""
    if model == "axisymmetric":
        return _press_sections(spheres, ring, level, solver, SECTIONS[element], backend, coupling)
    began = time.perf_counter()
    # a rotation by pi about the line x = y maps a quarter with its body above to the same quarter with its body below
    downwards = rotation_about((1.0, 1.0, 0.0), math.pi)

    def body(radius: float, name: str) -> ElasticBody:
        geometry = "hex20" if element == "ancf" else element
        mesh = shapes.quarter_sphere(radius, contact_radius=ring, level=level, element=geometry)
        supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
        if element == "ancf":
            return AncfBody(mesh, spheres.material, "cap", supports, name=name, backend=backend)
        return ElasticBody(mesh, spheres.material, "cap", supports, pressure=pressure, name=name, backend=backend)

    upper = body(spheres.radii[1], "upper")
    lower: ElasticBody | RigidBody
    if model == "symmetric":
        lower = RigidBody(Plane(), name="plane")
    elif spheres.radii[0] == spheres.radii[1]:
        lower = upper.placed(rotation=downwards, name="lower")
    else:
        lower = body(spheres.radii[0], "lower").placed(rotation=downwards)
    meshing = time.perf_counter() - began
    scene = Scene([upper, lower], [Contact(upper, lower, coupling=coupling)])
    return scene.solve(forces={upper: (0.0, 0.0, -spheres.force / 4)}, solver=solver), upper, meshing


def _press_sections(
    spheres: Spheres, ring: float, level: Level, solver: str, element: str, backend: str, coupling: str
) -> tuple[ContactResult, ElasticBody, float]:
    """The same for the spheres' sections, with the force on the whole spheres."""
    began = time.perf_counter()
    downwards = rotation_about((1.0, 0.0, 0.0), math.pi)

    def body(radius: float, name: str) -> AxisymmetricBody:
        mesh = sections.half_disc(radius, contact_radius=ring, level=level, element=element)
        return AxisymmetricBody(mesh, spheres.material, "cap", {"base": "xz"}, name=name, backend=backend)

    upper = body(spheres.radii[1], "upper")
    same = spheres.radii[0] == spheres.radii[1]
    lower = (upper if same else body(spheres.radii[0], "lower")).placed(rotation=downwards, name="lower")
    meshing = time.perf_counter() - began
    scene = Scene([upper, lower], [Contact(upper, lower, coupling=coupling)])
    return scene.solve(forces={upper: (0.0, 0.0, -spheres.force)}, solver=solver), upper, meshing
