"""A valid call of every public function, class and main method, cheap enough to be repeated with each bad value."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from inspect import signature
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import scipy.sparse as sp
from sample_files import TOML

import fecontact as fc
from fecontact.analytic import hertz
from fecontact.fem.stiffness import assemble_stiffness


@dataclass(frozen=True)
class Call:
    """A function with valid arguments, what uses its result, and arguments of which bad values cost too much."""

    function: Callable[..., Any]
    arguments: Mapping[str, Any] = field(default_factory=dict)
    use: Callable[[Any], object] = lambda made: made

    def __call__(self, **bad: Any) -> object:
        return self.use(self.function(**{**self.arguments, **bad}))


def public_calls(folder: Path) -> dict[str, Call]:
    """By name. Files are written to a folder."""
    steel, soft = fc.Material(E=210e3, nu=0.3, density=1e-9), fc.Material(E=1.0, nu=0.0, density=1.0)
    cube = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1), element="hex8")
    brick = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
    section = fc.sections.rectangle((1.0, 1.0), (1, 1))
    floor = fc.RigidBody(fc.Plane(), name="floor")
    ball = fc.RigidBody(fc.Sphere(1.0), name="ball")
    held = {"top": "xyz"}
    body = fc.ElasticBody(cube, soft, "bottom", held, "nodal", name="cube")
    grouped = cube.with_group("a", lambda x: x[:, 0] > 0)
    corner = fc.Mesh(np.eye(4, 3), [[3, 0, 1, 1, 2, 2, 2, 2]])
    lying = cube.translated((-0.5, -0.5, -1.0))
    under = fc.ElasticBody(lying, soft, "top", {"bottom": "xyz"}, "nodal", name="under")
    scene = fc.Scene([body, floor], [fc.Contact(body, floor)])
    rough = fc.Scene([body, floor], [fc.Contact(body, floor, friction=0.3)])
    pressed: Mapping[str, Any] = {"motions": {body: {"z": -0.01}}}
    result = scene.solve(**pressed)
    table = scene.sweep([pressed], keep="pressure")
    path = rough.solve_path([pressed])
    flat = fc.ElasticBody(fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2)), soft, "bottom", held)
    surface = fc.SurfaceMesh.of(cube, "top")
    stl = folder / "cube.stl"
    _write_stl(stl, cube)
    half = fc.HalfSpace(soft, size=(3.0, 3.0), cells=(8, 8))
    pulled = fc.HalfSpace(soft, size=(3.0, 3.0), cells=(8, 8), against=soft)
    bowl = fc.surfaces.Paraboloid(1.0)
    light = half.press(bowl, force=0.3)
    trip = pulled.press_path(bowl, [fc.PressStep(force=0.3)], friction=0.5)
    circle = hertz.spheres((1.0, 2.0), (steel, soft), force=1.0)
    oval = hertz.ellipse(((1.0, 2.0), (3.0, 4.0)), (steel, soft), force=1.0)
    strip = hertz.line((1.0, 2.0), (steel, soft), force=1.0)
    windows = [fc.LocalBody(flat, at=(x, 0.5, 0.0), window=0.1, cells=(8, 8)) for x in (0.25, 0.75)]
    msh = folder / "cube.msh"
    meshio.Mesh(cube.points, [("hexahedron", cube.cells)]).write(msh, file_format="gmsh")
    toml = folder / "scene.toml"
    toml.write_text(TOML, encoding="utf-8")
    heights = folder / "heights.txt"
    np.savetxt(heights, np.eye(4))

    def only(function: Callable[..., Any], /, use: Callable[[Any], object] = lambda m: m, **given: Any) -> Call:
        return Call(function, given, use)

    def of(function: Callable[..., Any], /, *, without: tuple[str, ...] = (), **given: Any) -> Call:
        """A call that tries the optional arguments too, at their defaults, but for those that it is `without`."""
        every = signature(function).parameters.items()
        known = {name: p.default for name, p in every if p.default is not p.empty and "factory" not in repr(p.default)}
        return only(function, **{name: value for name, value in {**known, **given}.items() if name not in without})

    def contact_with(made: Any) -> object:
        made.describe()
        if "bottom" in made.contact:
            other = fc.Scene([made, floor], [fc.Contact(made, floor)])
            return other.solve(motions={made: {"z": -0.01}})
        return None

    def on_floor(made: Any) -> object:
        return fc.Scene([body, made], [fc.Contact(body, made)]).solve(motions={body: {"z": -0.01}})

    def meets(made: Any) -> object:
        return fc.Scene([under, made], [fc.Contact(under, made)]).solve(motions={made: {"z": -0.01}})

    def shaped(shape: Any) -> object:
        return meets(fc.RigidBody(shape))

    def solves(made: Any) -> object:
        return made.solve(**pressed) if len(made.bodies) == 2 else None

    def tied(spring: Any) -> object:
        return fc.Scene([body, floor], [fc.Contact(body, floor)], [spring]).solve(**pressed)

    calls = {
        "Material": of(fc.Material, E=1.0, nu=0.3, density=1.0, use=lambda m: (m.lame, m.plane_strain_modulus)),
        "ElasticBody": of(
            fc.ElasticBody,
            mesh=cube,
            material=soft,
            contact="bottom",
            supports=held,
            pressure="nodal",
            name="a",
            pose=fc.Pose(),
            geometry="plain",
            use=contact_with,
        ),
        "AncfBody": of(
            fc.AncfBody,
            mesh=cube,
            material=soft,
            contact="bottom",
            supports=held,
            name="a",
            pose=fc.Pose(),
            use=contact_with,
        ),
        "AssembledBody": of(
            fc.AssembledBody,
            mesh=cube,
            material=soft,
            contact="bottom",
            supports=held,
            name="a",
            pose=fc.Pose(),
            stiffness=_stiffness(cube, soft),
            use=contact_with,
        ),
        "PlaneBody": of(
            fc.PlaneBody,
            mesh=section,
            material=soft,
            contact="bottom",
            supports={"top": "xz"},
            name="a",
            pose=fc.Pose(),
            use=contact_with,
        ),
        "AxisymmetricBody": of(
            fc.AxisymmetricBody,
            mesh=section,
            material=soft,
            contact="bottom",
            supports={"top": "xz"},
            name="a",
            pose=fc.Pose(),
            torsion=True,
            use=contact_with,
        ),
        "LocalBody": of(fc.LocalBody, body=flat, at=(0.5, 0.5, 0.0), window=0.4, cells=(8, 8), name="w"),
        "WindowedBody": of(
            lambda first, second, name: fc.WindowedBody(first, second, name=name),
            first=windows[0],
            second=windows[1],
            name="w",
        ),
        "ElasticLayer": of(
            fc.ElasticLayer,
            material=soft,
            thickness=0.1,
            surface=(cube, "bottom"),
            name="a",
            pose=fc.Pose(),
            use=lambda b: fc.Scene([b, ball], [fc.Contact(b, ball)]) and b.describe(),
        ),
        "RigidBody": of(fc.RigidBody, shape=fc.Plane(), name="a", pose=fc.Pose(), use=on_floor),
        "RigidBody.from_heights": of(
            fc.RigidBody.from_heights, z=np.zeros((4, 4)), size=(4.0, 4.0), name="a", use=meets
        ),
        "RigidBody.from_surface": of(fc.RigidBody.from_surface, path=stl, name="a"),
        "RigidBody.from_stl": of(fc.RigidBody.from_stl, path=stl, name="a"),
        "RigidBody.from_function": of(fc.RigidBody.from_function, z=lambda x, y: 0 * x, size=4.0, name="a", use=meets),
        "placed": of(body.placed, rotation=np.eye(3), name="b", use=contact_with),
        "Contact": of(
            fc.Contact,
            slave=body,
            master=floor,
            surfaces=("bottom", "surface"),
            friction=(0.1, 0.3),
            friction_axis=(1.0, 0.0, 0.0),
            use=lambda c: fc.Scene([body, floor], [c]).solve(**pressed),
        ),
        "Spring": of(
            fc.Spring,
            stiffness=1.0,
            start=(body, (0, 0, 0)),
            end=(None, (0, 0, 5)),
            slack_length=1.0,
            name="s",
            use=tied,
            without=("around",),
        ),
        "Spring ends": of(
            lambda point, other: fc.Spring(1.0, (body, point), (None, other)),
            point=(0, 0, 0),
            other=(0, 0, 5),
            use=tied,
        ),
        "Scene": of(fc.Scene, bodies=[body, floor], contacts=[fc.Contact(body, floor)], use=solves),
        "Scene of": of(
            lambda one, contact, spring: fc.Scene([body, one], [contact], [spring]),
            one=floor,
            contact=fc.Contact(body, floor),
            spring=fc.Spring(1.0, (body, (0, 0, 0)), (None, (0, 0, 5))),
        ),
        "Scene.solve": of(
            scene.solve, forces={body: (0, 0, -0.1)}, moments={}, motions={}, free={}, pressures={}, tractions={}
        ),
        "forces": of(
            lambda key, place, force: scene.solve({body: (0, 0, -0.1), (key, place): force}),
            key=body,
            place="top",
            force=(0, 0, 0),
        ),
        "loads": of(
            lambda force, moment, motion, component, value, free, pressure, traction, name: scene.solve(
                {body: force},
                moments={body: moment},
                motions={body: {component: value}, floor: motion},
                free={body: free},
                pressures={(body, name): pressure},
                tractions={(body, name): traction},
            ),
            force=(0, 0, 0),
            traction=(0, 0, 0),
            moment=(0, 0, 0),
            motion={"z": 0.0},
            component="z",
            value=-0.01,
            free="x",
            pressure=0.0,
            name="x_min",
        ),
        "accuracy": of(lambda **k: scene.solve(**pressed, **k), accuracy=0.5, max_dofs=300, max_seconds=1.0),
        "Scene.solve option": of(lambda **k: scene.solve(**pressed, **k), max_iterations=100),
        "Scene.solve_path": of(rough.solve_path, steps=[pressed], without=("finite_motion", "wear")),
        "a step": of(lambda step: rough.solve_path([step]), step=pressed),
        "LoadPath.motions": of(path.motions, body=body),
        "LoadPath.wear_depth": of(path.wear_depth, contact=0, coefficient=1.0),
        "Scene.sweep": of(scene.sweep, cases=[pressed]),
        "CaseTable": of(table.column, name="area"),
        "CaseTable.save": of(table.save, path=folder / "table.csv"),
        "CaseTable.plot": of(lambda quantity, **k: table.plot(quantity, **k), quantity="area", over="area", path=None),
        "CaseTable.montage": of(table.montage, cases=[0]),
        "CaseTable.animate": of(table.animate, path=folder / "table.gif", cases=[0]),
        "HalfSpace.curve": of(half.curve, surface=bowl, forces=[0.1, 0.3], workers=1, without=("also", "hardness")),
        "LoadCurve.plot": of(
            half.curve(bowl, [0.1, 0.3]).plot, length="mm", force="N", units="MPa", without=("stress",)
        ),
        "DividingPlane": of(fc.DividingPlane, point=(0, 0, 0), normal=(1, 0, 0), sides=("a", "b")),
        "a case": of(lambda case: scene.sweep([case]), case=pressed),
        "case name": of(
            lambda **k: scene.sweep([{**pressed, **k}]), name="a", poses={}, parameters={"angle": 1.0}, save=[]
        ),
        "case pose": of(lambda key, pose: scene.sweep([{**pressed, "poses": {key: pose}}]), key=body, pose=fc.Pose()),
        "result.plot": of(result.plot),
        "plot option": of(
            lambda **k: result.plot("pressure", **k),
            units="MPa",
            length="mm",
            force="N",
            style="sensels",
            pitch=0.1,
            contacts=[0],
            same_colours=False,
        ),
        "plot of bodies": of(
            lambda **k: result.plot("von_mises", pixels=(80, 60), **k),
            units="MPa",
            scale=1.0,
            view=(30.0, 20.0),
            cut="z>0",
            bodies=None,
            limits=None,
            edges=True,
            length="mm",
            title="a cube",
        ),
        "result.fields_at": of(result.fields_at, body=body, points=[(0.5, 0.5, 0.5)]),
        "result.save": of(result.save, path=folder / "cube.json"),
        "result.displacement": of(result.displacement, body=body),
        "result.boundary_motion": of(result.boundary_motion, body=body, name="top"),
        "result.reaction": of(result.reaction, body=body),
        "result.rigid_motion": of(result.rigid_motion, body=body),
        "result.stress": of(result.stress, body=body),
        "result.strain": of(result.strain, body=body),
        "result.solved": of(result.solved, body=body),
        "Pose": of(fc.Pose, rotation=np.eye(3), translation=(0, 0, 0)),
        "Pose.then": of(fc.Pose().then, rotation=np.eye(3), translation=(0, 0, 0)),
        "Pose.to_world": of(fc.Pose().to_world, points=np.zeros((2, 3))),
        "Pose.to_body": of(fc.Pose().to_body, points=np.zeros((2, 3))),
        "Pose.relative_to": of(fc.Pose().relative_to, other=fc.Pose()),
        "rotation_about": of(fc.rotation_about, axis=(0, 0, 1), angle=0.1),
        "Plane": of(fc.Plane, use=lambda p: on_floor(fc.RigidBody(p))),
        "Sphere": of(fc.Sphere, radius=1.0, use=shaped),
        "Cone": of(fc.surfaces.Cone, angle=0.1, use=shaped),
        "Cylinder": of(fc.surfaces.Cylinder, radius=1.0, length=4.0, use=shaped),
        "Ellipsoid": of(fc.surfaces.Ellipsoid, semi_axes=(1.0, 2.0, 3.0), use=shaped),
        "FlatPunch": only(fc.surfaces.FlatPunch, radius=2.0, use=shaped),
        "FlatPunch square": only(fc.surfaces.FlatPunch, sides=(2.0, 2.0), use=shaped),
        "Paraboloid": of(fc.surfaces.Paraboloid, radius_x=1.0, radius_y=2.0, use=shaped),
        "Torus": of(fc.surfaces.Torus, ring=2.0, tube=1.0),
        "FunctionSurface": of(fc.surfaces.FunctionSurface, function=lambda x, y: 0 * x, size=4.0, use=shaped),
        "HeightMap": of(fc.surfaces.HeightMap, z=np.zeros((4, 4)), size_xy=(4.0, 4.0), use=shaped),
        "Facets": of(fc.surfaces.Facets, mesh=surface),
        "self_affine": of(fc.surfaces.self_affine, shape=(8, 8), size=(1.0, 1.0), hurst=0.8, seed=1, rms_height=1.0),
        "detrend": of(fc.surfaces.detrend, z=np.eye(4)),
        "read_topography": of(fc.surfaces.read_topography, path=heights),
        "Mesh": of(
            fc.Mesh,
            points=cube.points,
            cells=cube.cells,
            boundaries={},
            groups={},
            node_sets={},
            without=("file_nodes", "file_elements"),
        ),
        "Mesh sets": of(
            lambda name, faces, group, nodes: fc.Mesh(
                cube.points, cube.cells, {name: faces}, {name: group}, {name: nodes}
            ),
            name="a",
            faces=[[0, 1]],
            group=[0],
            nodes=[0],
        ),
        "SectionMesh": of(
            fc.SectionMesh,
            points=section.points,
            cells=section.cells,
            boundaries={},
            groups={},
            node_sets={},
            without=("file_nodes", "file_elements"),
        ),
        "SurfaceMesh": of(fc.SurfaceMesh, points=surface.points, facets=surface.facets),
        "SurfaceMesh.of": of(fc.SurfaceMesh.of, mesh=cube, name="top"),
        "SurfaceMesh.mapped": of(surface.mapped, mapping=lambda x: x),
        "Mesh.boundary_nodes": of(cube.boundary_nodes, name="top"),
        "Mesh.faces": of(cube.faces, name="top"),
        "Mesh.drawn_at": of(cube.drawn_at, points=cube.points),
        "Mesh.with_points": of(cube.with_points, points=cube.points),
        "Mesh.mapped": of(cube.mapped, mapping=lambda x: x),
        "Mesh.scaled": of(cube.scaled, factor=2.0),
        "Mesh.translated": of(cube.translated, offset=(0, 0, 1)),
        "Mesh.part": of(grouped.part, name="a"),
        "Mesh.upgraded": of(cube.upgraded, n_nodes=20),
        "Mesh.with_boundary": of(cube.with_boundary, name="a", where=fc.pick.plane((0, 0, 0), (0, 0, 1))),
        "Mesh.with_group": of(cube.with_group, name="a", where=lambda x: x[:, 0] > 0),
        "Mesh.with_midface_nodes": of(brick.with_midface_nodes, names=("top",)),
        "Mesh.from_skfem": of(fc.Mesh.from_skfem, theirs=cube.to_skfem()),
        "SectionMesh.mapped": of(section.mapped, mapping=lambda x: x),
        "SectionMesh.with_boundary": of(section.with_boundary, name="a", where=lambda x: x[:, 0] > 0.9),
        "pick.box": of(lambda **k: cube.with_boundary("a", fc.pick.box(**k)), low=(-1, -1, -1), high=(2, 2, 0.1)),
        "pick.facing": of(lambda **k: cube.with_boundary("a", fc.pick.facing(**k)), direction=(0, 0, 1), angle=30.0),
        "pick.flood": of(lambda **k: cube.with_boundary("a", fc.pick.flood(**k)), seed=(0, 0, 1), angle=30.0),
        "pick.near": of(lambda **k: cube.with_boundary("a", fc.pick.near(**k)), other=np.zeros((1, 3)), distance=2.0),
        "pick.plane": of(
            lambda **k: cube.with_boundary("a", fc.pick.plane(**k)), point=(0, 0, 0), normal=(0, 0, 1), tolerance=0.1
        ),
        "shapes.block": of(fc.shapes.block, size=(1, 1, 1), divisions=(1, 1, 1), element="hex8"),
        "shapes.block one": of(lambda s, d: fc.shapes.block((s, 1, 1), (d, 1, 1)), s=1.0, d=1),
        "shapes.thick_ring": of(
            fc.shapes.thick_ring, inner=1.0, outer=2.0, height=1.0, divisions=(1, 1, 1), element="hex8"
        ),
        "shapes.cap": of(
            fc.shapes.cap,
            radius=10.0,
            extent=2.0,
            depth=2.0,
            contact_radius=0.2,
            level=1,
            sector="quarter",
            element="hex8",
        ),
        "shapes.cylinder": of(
            fc.shapes.cylinder, radius=2.0, height=2.0, contact_radius=0.2, level=1, sector="quarter", element="hex8"
        ),
        "shapes.half_sphere": of(
            fc.shapes.half_sphere, radius=2.0, contact_radius=0.2, level=1, sector="quarter", element="hex8"
        ),
        "shapes.sphere": of(
            fc.shapes.sphere, radius=2.0, contact_radius=0.2, level=1, sector="quarter", element="hex8"
        ),
        "shapes.ball": of(fc.shapes.ball, radius=2.0, divisions=1, element="hex8"),
        "shapes.quarter_sphere": of(fc.shapes.quarter_sphere, radius=2.0, contact_radius=0.2, level=1, element="hex8"),
        "shapes.extrude": of(fc.shapes.extrude, surface=surface, thickness=0.1, names=("a", "b", "c")),
        "shapes.merge": of(fc.shapes.merge, meshes=[cube, cube.translated((1, 0, 0))], tolerance=1e-9),
        "shapes.Level": of(
            lambda **k: fc.shapes.half_sphere(2.0, level=fc.shapes.Level(**k), sector="quarter", element="hex8"),
            core=1,
            rings=2,
            edge=0.3,
            layer=0.5,
            growth=2.0,
        ),
        "shapes.divided": of(fc.shapes.divided, mesh=corner),
        "sections.annulus": of(fc.sections.annulus, inner=1.0, outer=2.0, divisions=(1, 1)),
        "sections.cap": of(fc.sections.cap, radius=10.0, extent=2.0, depth=2.0, contact_radius=0.2, level=1),
        "sections.half_disc": of(fc.sections.half_disc, radius=2.0, contact_radius=0.2, level=1),
        "sections.rectangle": of(fc.sections.rectangle, size=(1, 1), divisions=(1, 1), names=("a", "b", "c", "d")),
        "sections.ring": of(fc.sections.ring, inner=1.0, outer=2.0, height=1.0, divisions=(1, 1)),
        "sections.merge_sections": of(fc.sections.merge_sections, meshes=[section], tolerance=1e-9),
        "HalfSpace": of(
            fc.HalfSpace, material=soft, size=(3.0, 3.0), cells=(8, 8), name="h", use=lambda h: h.press(bowl, force=0.1)
        ),
        "HalfSpace layered": of(
            lambda **k: fc.HalfSpace(soft, (3.0, 3.0), (8, 8), layers=[fc.Layer(**k)]),
            material=steel,
            thickness=0.5,
            interface="bonded",
            use=lambda h: h.press(bowl, force=0.1),
        ),
        "HalfSpace.press": of(half.press, surface=bowl, force=0.1, tolerance=1e-8, without=("hardness",)),
        "press approach": only(half.press, surface=bowl, approach=0.05),
        "press tilted": only(half.press, surface=bowl, force=0.1, load_point=(0.0, 0.0)),
        "press heights": only(half.press, surface=half.heights_of(bowl), force=0.1),
        "press friction": only(pulled.press, surface=bowl, force=0.1, friction=0.5, tangential=(0.01, 0.0), shift=None),
        "press shift": only(pulled.press, surface=bowl, force=0.1, friction=0.5, shift=(0.001, 0.0)),
        "press_path": of(
            pulled.press_path,
            surface=bowl,
            steps=[fc.PressStep(force=0.1)],
            friction=0.5,
            tolerance=1e-8,
            without=("hardness", "track"),
        ),
        "PressStep": of(
            lambda **k: pulled.press_path(bowl, [fc.PressStep(**k)], 0.5),
            force=0.1,
            approach=None,
            tangential=(0.0, 0.0),
            shift=None,
            torque=None,
            twist=None,
            position=(0.0, 0.0),
        ),
        "HalfSpace.heights_of": of(half.heights_of, surface=bowl, without=("position",)),
        "HalfSpace.stiffness": of(half.stiffness, contact=light),
        "HalfSpaceContact.stress": of(light.stress, points=np.array([[0, 0, -1.0]]), chunk=100),
        "FrictionPath.wear_depth": of(trip.wear_depth, coefficient=1.0),
        "FrictionPath.save": of(trip.save, path=folder / "trip.json"),
        "contact_modulus": of(hertz.contact_modulus, first=soft, second=steel),
        "hertz.spheres": of(hertz.spheres, radii=(1.0, 2.0), materials=(soft, steel), force=1.0),
        "hertz.spheres approach": only(hertz.spheres, radii=(1.0, 2.0), materials=(soft, None), approach=0.1),
        "hertz.ellipse": of(
            hertz.ellipse, radii=((1.0, 2.0), (3.0, 4.0)), materials=(soft, steel), angle=0.1, force=1.0
        ),
        "hertz.line": of(hertz.line, radii=(1.0, 2.0), materials=(soft, steel), force=1.0),
        "hertz pressure": of(circle.pressure, r=0.0),
        "hertz stress": of(circle.stress, r=0.0, z=0.1),
        "ellipse pressure": of(oval.pressure, x=0.0, y=0.0),
        "line stress": of(strip.stress, x=0.0, z=0.1),
        "read_mesh": of(fc.read_mesh, path=msh),
        "read_surface": of(fc.read_surface, path=stl),
        "repair_surface": of(fc.repair_surface, source=stl, holes=4, smoothing=1),
        "read_scene": of(fc.read_scene, path=toml, without=("divide",)),
        "mesh_solid": of(fc.mesh_solid, source=folder / "missing.step", size=1.0, element="tet4", progress=False),
    }
    if importlib.util.find_spec("manifold3d") is not None:
        cube = fc.shapes.block((1.0, 1.0, 1.0), (1, 1, 1))
        calls["trimmed"] = of(
            fc.trimmed,
            part=fc.SurfaceMesh(cube.points, cube.skin),
            plane=((0.5, 0.5, 0.5), (0.0, 0.0, 1.0)),
            outside=False,
            size=None,
        )
    return calls


def _write_stl(path: Path, mesh: fc.Mesh) -> None:
    x = mesh.points[mesh.face_nodes(mesh.outer_faces)[:, :4]]
    triangles = np.concatenate([x[:, [0, 1, 2]], x[:, [0, 2, 3]]])
    lines = ["solid cube"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {a} {b} {c}" for a, b, c in t), "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid cube", ""]), encoding="utf-8")


def _stiffness(mesh: fc.Mesh, material: fc.Material) -> sp.csr_matrix:
    """Stiffness of a mesh as it would come from elsewhere: symmetric, both triangles."""
    n = len(mesh.cells)
    upper = assemble_stiffness(mesh, np.full(n, material.lame), np.full(n, material.shear_modulus))
    return sp.csr_matrix(upper + sp.triu(upper, 1).T)
