"""Methods that can be compared: a registry. One more is one more function with `@method`.

A function takes the problem, one of its settings (a refinement) and the options of the variant, solves, and gives what
was measured. What is timed is the whole function: mesh, first pass, solution and certificate.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from compare.bodies import foundation, indented, section_of_cylinder, start
from compare.problems import Problem
from fecontact import Contact, ContactResult, InputError, Layer, Material, Scene, mesh_solid
from fecontact.app.studies.spheres import CASES, Spheres, solve_spheres
from fecontact.app.studies.study import Study
from fecontact.bodies import ElasticBody, HalfSpace, LocalBody, Plane, Pose, RigidBody, Sphere
from fecontact.mesh import pick
from fecontact.mesh.shapes import Level, block, quarter_sphere
from fecontact.surfaces import FlatPunch, Paraboloid

Options = Mapping[str, str]

ROUND = ("hertz", "unequal")
RIGID = ("ellipse", "line", "layer", "punch")


@dataclass(frozen=True)
class Measured:
    """What one run gave.

    Attributes
    ----------
    dofs : int
        Degrees of freedom of the discretisation (cells of a half-space's grid).
    candidates : int
        Size of the contact problem.
    residual : float
        The worst of the certificate's relative residuals.
    errors : dict
        'pressure_l2' and, signed, 'centre_pressure', 'edge_radius', 'approach', as far as they mean something.
    """

    dofs: int
    candidates: int
    residual: float
    errors: dict[str, float]


Run = Callable[[Problem, Any, Options], Measured]


@dataclass(frozen=True, eq=False)
class Method:
    """A way to solve some of the problems.

    Attributes
    ----------
    name, label : str
    kind : str
        'solid': bodies of any shape; 'section': of revolution or in the plane; 'half-space': flat and unbounded ones;
        'foundation': springs.
    problems : tuple of str
    settings : tuple
        From coarse to fine; whatever `run` understands and JSON can hold.
    takes : mapping of str to tuple of str
        Options of a variant and their values; empty: any text.
    run : callable
    """

    name: str
    label: str
    kind: str
    problems: tuple[str, ...]
    settings: tuple[Any, ...]
    takes: Mapping[str, tuple[str, ...]]
    run: Run = field(repr=False)


#: All methods by name.
METHODS: dict[str, Method] = {}

_SOLVING: Mapping[str, tuple[str, ...]] = {"solver": (), "backend": ("auto", "pardiso", "superlu")}


def method(
    name: str,
    label: str,
    *,
    kind: str = "solid",
    problems: Sequence[str],
    settings: Sequence[Any],
    takes: Mapping[str, tuple[str, ...]] | None = None,
) -> Callable[[Run], Run]:
    """Register a function as a method, see `Method`."""

    def add(run: Run) -> Run:
        METHODS[name] = Method(name, label, kind, tuple(problems), tuple(settings), takes or {}, run)
        return run

    return add


def _of_spheres(out: Study) -> Measured:
    e = out.errors
    errors = {
        "pressure_l2": out.figures["pressure, L2"].found,
        "centre_pressure": e["centre pressure"],
        "edge_radius": e["contact radius"],
        "approach": e["approach"],
    }
    return Measured(out.solved.n_dofs, out.solved.n_candidates, out.solved.residuals().worst, errors)


def _of_solid(problem: Problem, result: ContactResult, approach: float | None) -> Measured:
    contact = result.contacts[0]
    points, pressure, areas = contact.sampled(contact.pressure, 12)
    errors = problem.errors(points[:, :2], pressure, areas)
    errors["centre_pressure"] = problem.centre_error(contact.points[:, :2], contact.pressure)
    if approach is not None and problem.approach is not None:
        errors["approach"] = approach / problem.approach - 1
    dofs = result.n_dofs or len(contact.points)  # springs: one per point
    return Measured(dofs, result.n_candidates, result.residuals().worst, errors)


def _solid(problem: Problem, level: int, options: Options, element: str, pressure: str, model: str) -> Measured:
    """Hexahedra: `solve_spheres` for two spheres, a body under a rigid indenter for the others."""
    solver, backend = options.get("solver", "auto"), options.get("backend", "auto")
    if problem.name in ROUND:
        coupling = options.get("coupling", "auto")
        return _of_spheres(
            solve_spheres(
                problem.data["case"],
                element=element,
                pressure=pressure,
                model=model,
                level=level,
                solver=solver,
                backend=backend,
                coupling=coupling,
            )
        )
    if "coupling" in options:
        raise InputError(f"Problem {problem.name!r} has a rigid indenter: there is no choice of coupling.")
    result, indenter = indented(problem, element, pressure, level, solver, backend)
    # a body of finite size that stands for a half-space gives more or less far away, so its approach means nothing
    approach = float(result.rigid_motion(indenter).translation[2]) if problem.name == "layer" else None
    return _of_solid(problem, result, approach)


_COUPLED = {**_SOLVING, "coupling": ("auto", "nodal", "mortar")}
_LEVELS = (1, 2, 3, 4, 5)


@method("hex8", "8-node hexahedra", problems=ROUND + RIGID, settings=_LEVELS, takes=_COUPLED)
def _hex8(problem: Problem, setting: Any, options: Options) -> Measured:
    return _solid(problem, setting, options, "hex8", "nodal", "two-bodies")


@method("hex20", "20-node hexahedra, mid-face nodes", problems=ROUND + RIGID, settings=_LEVELS, takes=_COUPLED)
def _hex20(problem: Problem, setting: Any, options: Options) -> Measured:
    return _solid(problem, setting, options, "hex20", "midface", "two-bodies")


@method(
    "hex20-root",
    "20-node hexahedra, root at the edge",
    problems=(*ROUND, "ellipse"),
    settings=_LEVELS[:4],
    takes=_SOLVING,
)
def _hex20_root(problem: Problem, setting: Any, options: Options) -> Measured:
    """The pressure with its square root at the edge, on the same solution; the nodal one where it is not accepted."""
    solver, backend = options.get("solver", "auto"), options.get("backend", "auto")
    if problem.name in ROUND:
        out = solve_spheres(problem.data["case"], level=setting, solver=solver, backend=backend)
        measured, result = _of_spheres(out), out.solved
    else:
        result, _ = indented(problem, "hex20", "midface", setting, solver, backend)
        measured = _of_solid(problem, result, None)
    points, pressure, areas = result.edge_pressures[0].sampled(12)
    return replace(measured, errors={**measured.errors, **problem.errors(points[:, :2], pressure, areas)})


@method("hex20-plain", "20-node hexahedra, plain faces", problems=ROUND + RIGID, settings=_LEVELS[:4], takes=_SOLVING)
def _hex20_plain(problem: Problem, setting: Any, options: Options) -> Measured:
    return _solid(problem, setting, options, "hex20", "nodal", "two-bodies")


@method("hex27", "27-node hexahedra", problems=ROUND + RIGID, settings=_LEVELS[:4], takes=_COUPLED)
def _hex27(problem: Problem, setting: Any, options: Options) -> Measured:
    return _solid(problem, setting, options, "hex27", "nodal", "two-bodies")


@method("symmetric", "one sphere on its mirror plane, hex20", problems=("hertz",), settings=_LEVELS, takes=_SOLVING)
def _symmetric(problem: Problem, setting: Any, options: Options) -> Measured:
    return _solid(problem, setting, options, "hex20", "midface", "symmetric")


@method("ancf", "8-node bricks with gradients (ANCF)", problems=ROUND + RIGID, settings=_LEVELS[:3], takes=_SOLVING)
def _ancf(problem: Problem, setting: Any, options: Options) -> Measured:
    return _solid(problem, setting, options, "ancf", "midface", "two-bodies")


@method(
    "axisymmetric",
    "section, axisymmetric quadrilaterals",
    kind="section",
    problems=ROUND,
    settings=_LEVELS,
    takes=_SOLVING,
)
def _axisymmetric(problem: Problem, setting: Any, options: Options) -> Measured:
    return _solid(problem, setting, options, "hex20", "midface", "axisymmetric")


@method(
    "plane",
    "section, plane-strain quadrilaterals",
    kind="section",
    problems=("line",),
    settings=_LEVELS,
    takes=_SOLVING,
)
def _plane(problem: Problem, setting: Any, options: Options) -> Measured:
    solver, backend = options.get("solver", "auto"), options.get("backend", "auto")
    return _of_solid(problem, section_of_cylinder(problem, setting, solver, backend), None)


#: Element edge in and near the contact, over the radius by dimensional analysis.
_TET_SIZES = (0.6, 0.45, 0.32, 0.24, 0.18)


@method("tet10", "10-node tetrahedra, mirror plane", problems=("hertz",), settings=_TET_SIZES, takes=_SOLVING)
def _tet10(problem: Problem, setting: Any, options: Options) -> Measured:
    """A quarter ball meshed by gmsh, evenly within the contact and a little around; nothing is fitted to the edge."""
    case: Spheres = CASES[problem.data["case"]]
    R, a = case.radii[0], 1.3 * case.scale_radius
    fine = setting * case.scale_radius
    script = (
        'SetFactory("OpenCASCADE");\n'
        f"Sphere(1) = {{0, 0, {R!r}, {R!r}}};\nBox(2) = {{0, 0, 0, {R!r}, {R!r}, {R!r}}};\n"
        "BooleanIntersection{ Volume{1}; Delete; }{ Volume{2}; Delete; }\n"
    )
    s = np.linspace(0.0, a, 8)
    x, y = (c.ravel() for c in np.meshgrid(s, s))
    inside = np.hypot(x, y) <= 1.01 * a
    near = np.stack([x, y, (x**2 + y**2) / (2 * R)], axis=1)[inside]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ball.geo"
        path.write_text(script, encoding="utf-8")
        mesh = mesh_solid(path, size=R / 4, element="tet10", near=near, near_size=fine, growth=0.4, run_script=True)
    mesh = mesh.with_boundary("cap", pick.flood((0.5 * a, 0.5 * a, 0.0)) & pick.box((0, 0, 0), (R / 2, R / 2, R / 5)))
    for name, normal, point in (("x", (1, 0, 0), (0, 0, 0)), ("y", (0, 1, 0), (0, 0, 0)), ("z", (0, 0, 1), (0, 0, R))):
        mesh = mesh.with_boundary(name, pick.plane(point, normal))
    supports = {"x": "x", "y": "y", "z": "xyz"}
    ball = ElasticBody(mesh, case.material, "cap", supports, name="ball", backend=options.get("backend", "auto"))
    plane = RigidBody(Plane(), name="plane")
    scene = Scene([ball, plane], [Contact(ball, plane)])
    result = scene.solve(forces={ball: (0.0, 0.0, -case.force / 4)}, solver=options.get("solver", "auto"))
    return _of_solid(problem, result, -2 * float(result.rigid_motion(ball).translation[2]))


def _grid(problem: Problem, n: int, pressure: str = "uniform") -> tuple[HalfSpace, Paraboloid | FlatPunch]:
    """Half-space (or layer) and rigid surface; the grid is sized by dimensional analysis."""
    material: Material = problem.data["material"]
    if problem.name == "punch":
        a = problem.semi_axes[0]
        return HalfSpace(material, (3 * a, 3 * a), (n, n), pressure=pressure), FlatPunch(radius=a)
    if problem.name in ROUND:
        box = 4 * CASES[problem.data["case"]].scale_radius
        half = HalfSpace(material, (box, box), (n, n), against=material, pressure=pressure)
        return half, Paraboloid(problem.data["R"])
    rx, ry = problem.data["radii"]
    size = tuple(4 * a for a in start(problem))
    surface = Paraboloid(rx, ry)
    if problem.name == "layer":
        stack = [Layer(material, problem.data["thickness"])]
        return HalfSpace(None, size, (n, n), layers=stack), surface  # type: ignore[arg-type]
    return HalfSpace(material, size, (n, n), pressure=pressure), surface  # type: ignore[arg-type]


@method(
    "half-space",
    "half-space, Love's cells, transforms",
    kind="half-space",
    problems=("hertz", "unequal", "ellipse", "layer", "punch"),
    settings=(32, 64, 128, 256, 512, 1024),
)
def _half_space(problem: Problem, setting: Any, options: Options) -> Measured:
    half, surface = _grid(problem, setting)
    contact = half.press(surface, force=problem.force)
    x, y = np.meshgrid(half.grid.x, half.grid.y, indexing="ij")
    points, pressure = np.stack([x.ravel(), y.ravel()], axis=1), contact.pressure.ravel()
    errors = problem.errors(points, pressure, np.full(len(pressure), half.grid.area))
    errors["centre_pressure"] = problem.centre_error(points, pressure)
    if problem.approach is not None:
        errors["approach"] = contact.approach / problem.approach - 1
    return Measured(half.grid.n_cells, int(contact.active.sum()), contact.residuals.worst, errors)


@method(
    "local",
    "local body, one coarse mesh and cells",
    problems=("hertz", "layer"),
    settings=(32, 64, 128, 256),
    takes={"backend": _SOLVING["backend"]},
)
def _local(problem: Problem, setting: Any, options: Options) -> Measured:
    """A quarter of the body, meshed alike for all settings and not for the contact; window and cells by the load."""
    backend = options.get("backend", "auto")
    if problem.name == "hertz":
        case: Spheres = CASES[problem.data["case"]]
        R, images = case.radii[0], 2.0
        mesh = quarter_sphere(R, contact_radius=R / 6, level=Level(2, 2, 0.4, 0.4, 2.0))
        supports = {"base": "xyz", "sym_x": "x", "sym_y": "y"}
        ball = ElasticBody(mesh, case.material, "cap", supports, geometry=Sphere(R), name="ball", backend=backend)
        body, at, other = ball, (0.0, 0.0, 0.0), RigidBody(Plane(), name="plane")
    else:
        h, images = problem.data["thickness"], 1.0
        along = h * np.array([0, 0.4, 0.8, 1.2, 1.6, 2, 2.4, 2.8, 3.2, 3.7, 4.5, 6, 8.0])
        mesh = block((8 * h, 8 * h, h), (along, along, h * np.linspace(0, 1, 6)))
        supports = {"bottom": "xyz", "x_min": "x", "y_min": "y"}
        body = ElasticBody(mesh, problem.data["material"], supports=supports, name="layer", backend=backend)
        at = (0.0, 0.0, h)
        other = RigidBody(Paraboloid(problem.data["radii"][0]), pose=Pose(translation=at), name="indenter")
    local = LocalBody(body, at=at, cells=(setting, setting))
    pushed = local if problem.name == "hertz" else other
    result = Scene([local, other], [Contact(local, other)]).solve(forces={pushed: (0.0, 0.0, -problem.force / 4)})
    contact = result.contacts[0]
    points = contact.points[:, :2]
    errors = problem.errors(points, contact.pressure, contact.weights)
    errors["centre_pressure"] = problem.centre_error(points, contact.pressure)
    if problem.approach is not None:
        errors["approach"] = -images * float(result.rigid_motion(pushed).translation[2]) / problem.approach - 1
    return Measured(body.n_dofs, result.n_candidates, result.residuals().worst, errors)


@method(
    "boussinesq",
    "half-space, point forces, full matrix (1978)",
    kind="half-space",
    problems=("hertz", "unequal", "ellipse"),
    settings=(10, 14, 20, 28, 36),
    takes={"solver": ()},
)
def _boussinesq(problem: Problem, setting: Any, options: Options) -> Measured:
    """The report's version (Elangovan 1978): forces at the middles of cells, their compliance a full matrix."""
    half, surface = _grid(problem, setting, "point")
    # the rigid surface comes from above, as a body of a scene: its compliance matrix is handed to the solver
    ball = RigidBody(surface, name="indenter")
    scene = Scene([half, ball], [Contact(half, ball)])
    result = scene.solve(
        forces={ball: (0.0, 0.0, -problem.force)}, solver=options.get("solver", "auto"), tolerance=1e-8
    )
    contact = result.contacts[0]
    points = contact.points[:, :2]
    errors = problem.errors(points, contact.pressure, contact.weights)
    errors["centre_pressure"] = problem.centre_error(points, contact.pressure)
    if problem.approach is not None:
        errors["approach"] = -float(result.rigid_motion(ball).translation[2]) / problem.approach - 1
    return Measured(half.grid.n_cells, result.n_candidates, result.residuals().worst, errors)


@method("winkler", "elastic foundation", kind="foundation", problems=("layer",), settings=(1, 2, 3))
def _winkler(problem: Problem, setting: Any, options: Options) -> Measured:
    """Springs under each point: a model error that no refinement takes away."""
    result, indenter = foundation(problem, setting)
    return _of_solid(problem, result, float(result.rigid_motion(indenter).translation[2]))


@dataclass(frozen=True)
class Variant:
    """A method with options, written ``name:key=value:key=value``; one curve of the diagram."""

    method: Method
    options: Mapping[str, str]

    @property
    def spec(self) -> str:
        """As written."""
        return ":".join([self.method.name, *(f"{k}={v}" for k, v in self.options.items())])

    @property
    def label(self) -> str:
        """For the legend."""
        return ", ".join([self.method.label, *self.options.values()])


def variant(spec: str, problem: str) -> Variant:
    """Read ``name:key=value...``.

    Raises
    ------
    InputError
        If there is no such method, it does not solve the problem, or it has no such option.

    Examples
    --------
    >>> variant("hex20:coupling=mortar", "hertz").label
    '20-node hexahedra, mid-face nodes, mortar'
    """
    name, *given = spec.split(":")
    if name not in METHODS:
        raise InputError(f"There is no method {name!r}; expected one of {', '.join(METHODS)}.")
    chosen = METHODS[name]
    if problem not in chosen.problems:
        raise InputError(f"Method {name!r} does not solve {problem!r}, only {', '.join(chosen.problems)}.")
    options = {}
    for part in given:
        key, equals, value = part.partition("=")
        if not equals or key not in chosen.takes:
            known = ", ".join(chosen.takes) or "none"
            raise InputError(f"Method {name!r} has no option {part!r}; written key=value, its options are: {known}.")
        if chosen.takes[key] and value not in chosen.takes[key]:
            raise InputError(
                f"Option {key} of {name!r} must be one of {', '.join(chosen.takes[key])}; found {value!r}."
            )
        options[key] = value
    return Variant(chosen, options)


def default_variants(problem: str) -> list[str]:
    """All methods that solve a problem, and mortar coupling beside nodal forces where there are two elastic bodies."""
    specs = [m.name for m in METHODS.values() if problem in m.problems]
    return [*specs, "hex20:coupling=mortar"] if problem in ROUND else specs
