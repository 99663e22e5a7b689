"""Two solid spheres pressed together, solved by finite elements and compared with Hertz.

The mesh of each sphere is fitted to the edge of the contact, which is found by first passes: dimensional analysis gives
the size of the contact to within a factor, meshes of the spheres' sections of that size are solved, and the second
moment of their contact forces gives the radius to some hundredths of a percent. The bodies are solids of revolution, so
their sections give the same radius at a tenth of the cost. Hertz's formulas are used for comparison only.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Picture

from fecontact.analytic import hertz
from fecontact.ancf.bricks.body import AncfBody
from fecontact.app import options
from fecontact.app.studies.study import Figure, Study
from fecontact.bodies import AxisymmetricBody, ElasticBody, Plane, RigidBody, rotation_about
from fecontact.common.arrays import Array
from fecontact.common.checks import among
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.common.table import Table
from fecontact.common.units import Units
from fecontact.contact.contact import Contact
from fecontact.mesh import section_shapes as sections
from fecontact.mesh import shapes
from fecontact.mesh.shapes import Level
from fecontact.results.contact_fields import ContactFields
from fecontact.results.field_map import FINENESS, field_map
from fecontact.results.pictures.contact_map import draw_field
from fecontact.results.pictures.section_curve import draw_curve
from fecontact.results.report import peak_memory
from fecontact.results.result import ContactResult
from fecontact.scene.scene import Scene


@dataclass(frozen=True)
class Spheres:
    """Two spheres of one material, pressed together.

    Attributes
    ----------
    name : str
    radii : (float, float)
        Either may be the smaller; both are convex.
    force : float
    material : Material
    length, unit_force : str
        Units, for tables.
    """

    name: str
    radii: tuple[float, float]
    force: float
    material: Material
    length: str = "cm"
    unit_force: str = "kgf"

    @property
    def hertz(self) -> hertz.CircularContact:
        """Hertz's solution."""
        return hertz.spheres(self.radii, (self.material, self.material), force=self.force)

    @property
    def scale_radius(self) -> float:
        """Contact radius by dimensional analysis, (P R / pi E*)^(1/3): p ~ P / (pi a^2) ~ E* a / R."""
        radius = 1 / (1 / self.radii[0] + 1 / self.radii[1])
        modulus = self.material.plane_strain_modulus / 2
        return (self.force * radius / (math.pi * modulus)) ** (1 / 3)


#: In kgf and cm.
STEEL = Material(E=2.0e6, nu=0.3)
#: The report's test problems.
CASES = {name: Spheres(name, radii, force, STEEL) for name, (radii, force) in options.CASES.items()}

#: Samples along each side of a face for errors of the pressure.
SAMPLES = 12
#: Contact radii up to which pressures are compared, and drawn.
COMPARED, DRAWN = 1.2, 1.35
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
) -> Study:
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
    Study
        `solved` is the `ContactResult`.

    Raises
    ------
    InputError
        If an option is unknown, or the symmetric model is requested for spheres of different size.

    Examples
    --------
    >>> out = solve_spheres("equal", model="symmetric", level=1)
    >>> abs(out.errors["contact radius"]) < 0.002
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
    how = {"element": element, "pressure": pressure, "model": model, "backend": backend, "coupling": coupling}
    result, meshing = press(spheres, at, cut, solver, **how)
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
    return beside_hertz(spheres, chosen, result, fitted if edge_fit else math.nan, seconds)


def radius_by_sections(spheres: Spheres, start: float, backend: str = "auto") -> float:
    """Contact radius from the spheres' sections, fitted to a first guess and then to the radius found with it.

    Examples
    --------
    >>> equal = CASES["equal"]
    >>> abs(radius_by_sections(equal, equal.scale_radius) / equal.hertz.a - 1) < 5e-4
    True
    """
    how = {"element": "hex20", "pressure": "auto", "model": "axisymmetric", "backend": backend}
    for cut in FIRST_PASSES:
        start = moment_radius(press(spheres, start, cut, "auto", **how)[0].contacts[0])
    return start


def _pressures_of(element: str, pressure: str, model: str) -> str:
    """Kind of pressure points, for tables."""
    if model == "axisymmetric":
        return "sides"
    return {"hex20": pressure, "ancf": "eight"}.get(element, "nodal")


def _check(case: str | Spheres, element: str, pressure: str, model: str) -> Spheres:
    if isinstance(case, str) and case not in CASES:
        raise InputError(f"Unknown case {case!r}; expected one of {', '.join(map(repr, CASES))} or a Spheres object.")
    among("element", element, options.ELEMENTS)
    among("pressure", pressure, options.PRESSURES)
    among("model", model, options.MODELS)
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


def press(
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
) -> tuple[ContactResult, float]:
    """Press quarters or sections of both spheres, which touch at the origin; the result and the seconds of meshing."""
    began = time.perf_counter()
    sectioned = model == "axisymmetric"
    supports = {"base": "xz"} if sectioned else {"base": "xyz", "sym_x": "x", "sym_y": "y"}
    # a rotation by pi about the line x = y maps a quarter with its body above to the same quarter with its body below
    downwards = rotation_about((1.0, 0.0 if sectioned else 1.0, 0.0), math.pi)

    def body(radius: float, name: str) -> ElasticBody:
        if sectioned:
            section = sections.half_disc(radius, contact_radius=ring, level=level, element=SECTIONS[element])
            return AxisymmetricBody(section, spheres.material, "cap", supports, name=name, backend=backend)
        geometry = "hex20" if element == "ancf" else element
        mesh = shapes.quarter_sphere(radius, contact_radius=ring, level=level, element=geometry)
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
    force = spheres.force if sectioned else spheres.force / 4
    return scene.solve(forces={upper: (0.0, 0.0, -force)}, solver=solver), meshing


def moment_radius(contact: ContactFields) -> float:
    """Contact radius of a Hertz profile by the second moment of its forces, a^2 = 5/2 sum(F r^2) / sum(F).

    It hardly depends on the mesh. Zero without contact.
    """
    total = contact.forces.sum()
    return float(np.sqrt(2.5 * (contact.forces @ _radius(contact.points) ** 2) / total)) if total > 0 else 0.0


def _radius(points: Array) -> Array:
    """Distance (n,) of points from the axis."""
    return np.hypot(points[:, 0], points[:, 1])


def pressure_error(exact: hertz.CircularContact, points: Array, pressure: Array, area: Array) -> float:
    """Relative L2 error over r <= 1.2 a of pressures (n,) sampled at points with their areas."""
    r = _radius(points)
    inside = r <= COMPARED * exact.a
    target, weight = exact.pressure(r[inside]), area[inside]
    return float(np.sqrt((weight * (pressure[inside] - target) ** 2).sum() / (weight * target**2).sum()))


def beside_hertz(
    case: Spheres, chosen: Mapping[str, Any], result: ContactResult, fitted: float, seconds: Mapping[str, float]
) -> Study:
    """The study of a solution.

    Parameters
    ----------
    case : Spheres
    chosen : mapping
        Options: element, pressure, model, level, edge_fit, edge_pressure.
    result : ContactResult
        Its first body is the upper sphere.
    fitted : float
        Radius of the mesh ring.
    seconds : mapping
        Wall time by stage of the main pass, 'first_pass' and 'total'.
    """
    exact, (contact,), (edge,) = case.hertz, result.contacts, result.edge_pressures
    length, force = case.length, case.unit_force
    down = -float(result.rigid_motion(result.scene.bodies[0]).translation[2])
    # the force on a whole sphere, of which a quarter is modelled unless the model is axisymmetric
    total = (1 if chosen["model"] == "axisymmetric" else 4) * float(contact.force[2])
    centre = float(contact.pressure[np.argmin(_radius(contact.points))])
    figures = {
        "contact radius": Figure(moment_radius(contact), exact.a, length),
        "centre pressure": Figure(centre, exact.p0, f"{force}/{length}2"),
        "approach": Figure(2 * down if chosen["model"] == "symmetric" else down, exact.approach, length),
        "force": Figure(total, case.force, force),
        "pressure, L2": Figure(pressure_error(exact, *contact.sampled(contact.pressure, SAMPLES)), 0.0),
    }
    rooted = pressure_error(exact, *edge.sampled(SAMPLES)) if edge.accepted else None
    if rooted is not None:
        figures["pressure with its root, L2"] = Figure(rooted, 0.0)
    errors = {name: figures[name].error for name in ("contact radius", "centre pressure", "approach")}
    data = {
        "case": case.name,
        **chosen,
        "n_dofs": result.n_dofs,
        "n_dofs_factorised": result._n_dofs_factorised,
        "n_candidates": result.n_candidates,
        "n_active": result.n_active,
        "fitted_radius": fitted,
        **{_key(name): figures[name].found for name in errors},
        "max_pressure": contact.max_pressure,
        "total_force": total,
        "pressure_l2_error": figures["pressure, L2"].found,
        "edge_pressure_l2_error": rooted,
        "edge_pressure_note": edge.note,
        "errors": {_key(name): error for name, error in errors.items()},
        "exact": {"a": exact.a, "p0": exact.p0, "approach": exact.approach},
        "residuals": result.residuals().as_dict(),
        "seconds": seconds,
        "solver": result.solution.solver,
        "peak_rss_mb": peak_memory(),
        "units": {"length": length, "force": force},
    }
    level = chosen["level"] if isinstance(chosen["level"], int) else "own"
    pressed = f"R = {case.radii[0]:g} and {case.radii[1]:g} {length}, P = {case.force:g} {force}"
    made = f"{chosen['element']}, {chosen['pressure']} pressures"
    notes = [
        *([edge.note] if rooted is None else []),
        *(body.describe() for body in result.scene.bodies),
        _modelled(result, chosen["model"]),
        f"{result.n_candidates} candidates, {result.n_active} in contact; {result.solution.solver}, "
        f"{result.nit} iterations",
        f"residuals: {result.residuals()}",
        "seconds: " + ", ".join(f"{k} {v:.2f}" for k, v in seconds.items()),
    ]

    def draw(_: Units) -> Picture:
        error = f"{pressed}: L2 error {100 * figures['pressure, L2'].found:.2f} %"
        return _picture(case, contact, error, f"{made}, {result.n_dofs} dofs, {seconds['total']:.1f} s")

    name = f"Two spheres, {pressed}: {made}, {chosen['model']}, level {level}"
    rows = Table(list(figures), [tuple(f.found for f in figures.values())])
    return Study(name, figures, rows, draw, data, result, "Hertz", notes)


def _key(name: str) -> str:
    return name.replace(" ", "_")


def _modelled(result: ContactResult, model: str) -> str:
    """Line on the modelled part and the reductions by symmetry and shared models."""
    n, once = result.n_dofs, result._n_dofs_factorised
    if model == "symmetric":
        return f"modelled: a quarter of one sphere, {n} of {8 * n} dofs: three planes of symmetry"
    quarters = f"a quarter of each sphere, {n} of {4 * n} dofs: two planes of symmetry"
    part = f"the sections of both spheres, {n} dofs" if model == "axisymmetric" else quarters
    shared = f"; {once} factorised, as the lower is the upper in another pose" if once < n else ""
    return f"modelled: {part}{shared}"


def _picture(case: Spheres, contact: ContactFields, over_curve: str, over_map: str) -> Picture:
    """Pressure over the radius with Hertz, and the pressure map of the quarter or the gap of the section."""
    exact = case.hertz
    units = Units(case.length, case.unit_force, f"{case.unit_force}/{case.length}²")
    picture = Picture(figsize=(12.0, 5.0), layout="constrained")
    left, right = picture.subplots(1, 2, width_ratios=(1.15, 1))
    points, pressure, _ = contact.sampled(contact.pressure, FINENESS)
    sampled, nodes, widest = _radius(points), _radius(contact.points), DRAWN * exact.a
    inside, near = sampled <= widest, nodes <= widest
    orange = {"color": "tab:orange", "markersize": 2, "alpha": 0.5, "label": "interpolated in the faces"}
    left.plot(sampled[inside], pressure[inside], ".", **orange)
    left.plot(nodes[near], contact.pressure[near], "o", color="tab:blue", markersize=3.5, label="contact nodes")
    line = np.linspace(0.0, widest, 600)
    left.plot(line, exact.pressure(line), color="black", linewidth=1.2, label="Hertz")
    left.set_xlabel(units.axis_label("radius", "length"))
    left.set_ylabel(units.axis_label("pressure", "stress"))
    left.set_title(over_curve)
    left.set_ylim(bottom=0.0)
    left.legend()
    dashed: dict[str, Any] = {"linestyle": "--", "color": "tab:cyan", "linewidth": 1.5, "label": "Hertz radius"}
    if contact._is_curve:
        draw_curve(right, field_map(contact, "gap"), units)
        right.axvline(exact.a, **dashed)
    else:
        draw_field(right, field_map(contact, "pressure"), units)
        angle = np.linspace(0.0, np.pi / 2, 100)
        right.plot(exact.a * np.cos(angle), exact.a * np.sin(angle), **dashed)
    right.legend(loc="upper left" if contact._is_curve else "upper right")
    right.set_title(over_map)
    return picture
