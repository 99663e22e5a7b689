"""Commands of the command line: each takes its options and returns the exit status."""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, TextIO

from fecontact.app.decks.ccx import beside_ccx, check_ccx
from fecontact.app.options import STOPPED
from fecontact.app.scene_file.contents import SceneFile
from fecontact.app.scene_file.scene_file import read_scene
from fecontact.app.studies.study import Study
from fecontact.common.checks import among
from fecontact.common.errors import FecontactError, InputError, MeshError
from fecontact.common.files import check_writable, make_folder, save_json, written_files
from fecontact.mesh.gmsh import SUFFIXES, cad_solids
from fecontact.mesh.mesh import Mesh
from fecontact.mesh.section_mesh import SectionMesh
from fecontact.mesh.surface_mesh import SurfaceMesh
from fecontact.results.case_table import ANIMATIONS
from fecontact.results.result import ContactResult

#: Types of files that hold results, with fields.
RESULTS = (".vtu", ".vtk", ".xdmf")


def _check_files(*paths: str | None) -> None:
    """Refuse files that cannot be written, before any work."""
    for path in paths:
        if path not in (None, "-"):
            check_writable(path)


def say(text: object, stream: TextIO | None = None) -> None:
    """Print a text at once. Once nobody reads on (as behind ``| head``), nothing more is shown; files are written."""
    stream = sys.stdout if stream is None else stream
    try:
        print(text, file=stream, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _worded(text: object) -> str:
    """A text with remedies as options of commands and keys of scene files in place of arguments of Python."""

    def accuracy(found: re.Match[str]) -> str:
        pairs = re.findall(r"'(\w+)': ([\d.]+)", found[0])
        shares = [f"{name}={100 * float(share):g}%" for name, share in pairs]
        return f"--accuracy {','.join(shares) or f'{100 * float(found[1]):g}%'}"

    worded = re.sub(r"\baccuracy=(?:([\d.]*\d)|\{[^}]*\})", accuracy, str(text))
    return worded.replace("finite_motion='auto' (or True)", 'finite_motion = "auto" in [solve]').replace(
        "periodic=True", "--periodic"
    )


def _show(result: object, figures: dict[str, Any], to: str | None) -> TextIO:
    """Print a result and save its figures, or print only figures if they go to '-'; return the stream for remarks."""
    if to == "-":
        say(json.dumps(figures, indent=2))
        return sys.stderr
    say(_worded(result))
    if to is not None:
        say(f"wrote {save_json(to, figures)}")
    return sys.stdout


def _write(to: str | None, write: Callable[[str], object], remarks: TextIO) -> None:
    """Write a requested file and report it."""
    if to:
        write(to)
        say(f"wrote {Path(to)}", remarks)


def _study(options: argparse.Namespace, solve: Callable[[], Study]) -> int:
    """Run a study; print it and write the files that the options ask for, which are checked before."""
    kinds = ("csv", "plot", "vtu")
    files = {kind: to for kind in kinds if (to := getattr(options, kind, None))}
    _check_files(options.json, *files.values())
    study = solve()
    remarks = _show(study, dict(study.data), options.json)
    for kind, to in files.items():
        if kind == "plot":
            study.plot(to, units=getattr(options, "units", ()))
        else:
            (study if kind == "csv" else study.solved).save(to)
        say(f"wrote {Path(to)}", remarks)
    return 0


def _titled(scene: SceneFile, text: object) -> str:
    """Printed text with the scene's title."""
    return f"{scene.title}\n{text}" if scene.title else str(text)


def hertz(options: argparse.Namespace) -> int:
    """Solve two spheres and compare with Hertz."""
    from fecontact.app.studies.report import report_table, route_table
    from fecontact.app.studies.spheres import solve_spheres

    names = ("element", "pressure", "model", "solver", "backend", "level")
    chosen = {**{name: getattr(options, name) for name in names}, "edge_fit": not options.no_edge_fit}
    if options.case != "report":
        if options.route == "1978":
            raise InputError("--route 1978 is for --case report: it is dense and has its own coarse mesh.")
        return _study(options, lambda: solve_spheres(options.case, **chosen))
    if options.json or options.plot or options.vtu or options.csv:
        raise InputError(
            "--case report prints a table and writes no files; for files take --case equal, unequal or light."
        )
    model = "axisymmetric" if options.model == "axisymmetric" else "two-bodies"
    say(route_table() if options.route == "1978" else report_table(**{**chosen, "model": model}))
    return 0


def halfspace(options: argparse.Namespace) -> int:
    """Press a shape on a half-space."""
    from fecontact.app.studies.indentation import run

    return _study(options, lambda: run(vars(options)))


def friction(options: argparse.Namespace) -> int:
    """Run a study of friction on a half-space."""
    from fecontact.app.studies.friction import run

    return _study(options, lambda: run(options.study, vars(options)))


def roll(options: argparse.Namespace) -> int:
    """Roll a curved body on a plane."""
    from fecontact.app.studies.rolling import run

    return _study(options, lambda: run(vars(options)))


def ancf(options: argparse.Namespace) -> int:
    """Solve a problem of slender beams."""
    from fecontact.app.studies.slender import run

    return _study(options, lambda: run(options.problem, vars(options)))


def solve(options: argparse.Namespace) -> int:
    """Solve a scene file."""
    _check_files(options.json, options.montage, options.animate, options.report, options.beside_plot)
    if options.beside:
        check_ccx(Path(options.scene))
    elif options.beside_plot:
        raise InputError("--beside-plot is the picture of --beside ccx; give both.", code="belongs-to-beside")
    if options.animate:
        among("suffix of an animation", Path(options.animate).suffix.lower(), ANIMATIONS)
    out = None if options.out is None else make_folder(options.out)
    names = ("accuracy", "max_seconds", "engine", "ranks")
    asked = {name: value for name in names if (value := getattr(options, name)) is not None}

    def change(values: dict[str, Any]) -> None:
        values.setdefault("solve", {}).update(asked)
        if any(options.units):
            values["units"] = dict(zip(("length", "force", "stress"), options.units, strict=True))

    scene = read_scene(options.scene, out=out, change=change, laws=options.laws, divide=options.divide)
    if options.dry_run:
        say(scene.describe())
        return 0
    if options.report and (scene.cases or scene.steps):
        raise InputError("--report is of one state; this scene has several, of which there is a table.", code="cases")
    if scene.cases:
        for note in (*scene.notes, *([scene.tightened.note] if scene.tightened else [])):  # a table has none
            say(f"note: {note}", sys.stderr)
        return _sweep(scene, options)
    if options.montage or options.animate:
        raise InputError("--montage and --animate show the cases of a sweep; this scene has no [[cases]].")
    if scene.steps:
        return _follow(scene, options)
    result = scene.solve()
    remarks = _show(*_beside(options, result, _titled(scene, result), scene.summary(result)), options.json)
    for path in scene.write(result):
        say(f"wrote {path}", remarks)
    _write(options.report, lambda to: result.report(to, title=scene.title or "Contact of bodies"), remarks)
    return 0


def _sweep(scene: SceneFile, options: argparse.Namespace) -> int:
    table = scene.sweep(("pressure",) if options.montage or options.animate else ())
    text, figures = _titled(scene, table), {"cases": list(table)}
    if options.beside:  # the other program ends with the last of the deck's steps
        name, result = scene.last_case()
        text, figures = _beside(options, result, text, figures, int(name.split()[-1]))
    remarks = _show(text, figures, options.json)
    _write(options.montage, lambda to: table.montage(path=to), remarks)
    _write(options.animate, table.animate, remarks)
    for output in scene.outputs:
        say(f"wrote {output.path}", remarks)
    return 0


def _beside(
    options: argparse.Namespace,
    result: ContactResult,
    text: str,
    figures: dict[str, Any],
    n_steps: int | None = None,
) -> tuple[str, dict[str, Any]]:
    """Text and figures with those of another program, if asked, after some steps of the deck."""
    if not options.beside:
        return text, figures
    beside = beside_ccx(Path(options.scene), result, n_steps, options.divide)
    if options.beside_plot:
        beside.plot(options.beside_plot, units=result.unit_names)
        text = f"{text}\nwrote {options.beside_plot}"
    return f"{text}\n{beside}", {**figures, "beside_ccx": beside.as_dict()}


def _follow(scene: SceneFile, options: argparse.Namespace) -> int:
    path = scene.solve_path()
    figures = {"steps": [result.summary() for result in path.steps], "friction_work": path.friction_work.tolist()}
    text = _titled(scene, f"{path[-1]}\n{path}")
    remarks = _show(*_beside(options, path[-1], text, figures), options.json)
    for written in scene.write(path[-1]):
        say(f"wrote {written}", remarks)
    return 0


def explain(options: argparse.Namespace) -> int:
    """Estimate the cost of a scene."""
    from fecontact.scene.cost import explain

    _check_files(options.json)
    if Path(options.scene).suffix.lower() in SUFFIXES:
        return _explain_cad(options)
    scene = read_scene(options.scene, laws=options.laws)
    loads = [*scene.cases, *scene.steps, scene.loads][0]
    cost = explain(scene.scene, loads, scene.options.get("solver", "auto"), scene.options.get("accuracy"))
    _show(_titled(scene, cost), cost.as_dict(), options.json)
    return 0


def _explain_cad(options: argparse.Namespace) -> int:
    """List the solids of a CAD file."""
    solids = cad_solids(Path(options.scene))
    rows = [f"{s.name:<24} {s.volume:>12.5g} {s.faces:>6}  {_box(s.low)} to {_box(s.high)}" for s in solids]
    head = f"{'solid':<24} {'volume':>12} {'faces':>6}  box"
    tail = f"fc.mesh_solid({Path(options.scene).name!r}, size=..., part={solids[0].name!r}) meshes one of them."
    _show("\n".join([head, *rows, tail]), {"solids": [asdict(s) for s in solids]}, options.json)
    return 0


def _box(corner: tuple[float, float, float]) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in corner) + ")"


def view(options: argparse.Namespace) -> int:
    """Draw a result, or a mesh with its boundaries."""
    if Path(options.result).suffix.lower() not in RESULTS:
        return _view_mesh(options)
    from fecontact.results.pictures.bodies import plot_solids, show
    from fecontact.results.pictures.solids import solids_of_file

    solids = solids_of_file(options.result)
    field = options.field or "von_mises"
    chosen = {
        "scale": options.scale,
        "view": _direction(options.view or "iso"),
        "bodies": options.bodies.split(",") if options.bodies else None,
        "cut": options.cut,
        "limits": options.limits,
        "units": options.units.split(",") if "," in options.units else options.units,
    }
    if options.show:
        show(solids, field, options.out, **chosen)
        return 0
    path = _picture(options)
    plot_solids(solids, field, path, length=options.length, edges=not options.no_edges, **chosen)
    say(f"wrote {path}")
    return 0


def _view_mesh(options: argparse.Namespace) -> int:
    """Draw a mesh, a solid of CAD, a section or a surface with its named boundaries."""
    given = ("field", "cut", "bodies", "limits", "show")
    if wrong := [f"--{name}" for name in given if getattr(options, name)] + ["--scale"] * (options.scale != 1.0):
        raise InputError(f"{options.result} is a mesh, which has no fields: leave {', '.join(wrong)} out.")
    source = Path(options.result)
    mesh = _mesh_of(source)
    path = _picture(options)
    view = {"view": _direction(options.view)} if options.view else {}
    mesh.plot(path, edges=not options.no_edges, units=options.units.split(","), length=options.length, **view)
    say(repr(mesh))
    say(f"wrote {path}")
    return 0


def _mesh_of(source: Path) -> Mesh | SectionMesh | SurfaceMesh:
    """Mesh of a file: a surface by its suffix, else solids, and where there are none a section."""
    from fecontact.mesh.read import POLYGON_READERS, read_mesh, read_section, read_surface

    if source.suffix.lower() in POLYGON_READERS:
        return read_surface(source)
    try:
        return read_mesh(source)
    except MeshError as no_solid:
        try:
            return read_section(source)
        except FecontactError:
            raise no_solid from None


def _picture(options: argparse.Namespace) -> Path:
    return Path(options.result).with_suffix(".png") if options.out is None else Path(options.out)


def _direction(text: str) -> str | tuple[float, float]:
    """A view by name, or two angles separated by a comma."""
    azimuth, comma, elevation = text.partition(",")
    if not comma:
        return text
    try:
        return float(azimuth), float(elevation)
    except ValueError:
        raise InputError(f"A view is a name or AZIMUTH,ELEVATION in degrees; found {text!r}.") from None


def compare(options: argparse.Namespace) -> int:
    """Solve a scene to several accuracies: error against time and size."""
    if options.scene is None or not options.scene.endswith(".toml"):
        found = "no scene" if options.scene is None else repr(options.scene)
        raise InputError(
            "compare takes a scene file, SCENE.toml, solves it to several accuracies and shows the error of each "
            f"against the finest; found {found}. Problems with a known answer, other methods and other programs are "
            "compared by tests/benchmarks/compare of the source (make compare); docs/compare.md shows what came out."
        )
    from fecontact.app.studies.compare import compare_scene

    return _study(options, lambda: compare_scene(options.scene, options.runs))


def examples(options: argparse.Namespace) -> int:
    """List examples, or copy one."""
    from fecontact.app.examples import copy_example
    from fecontact.app.examples import examples as known

    if options.what == "list":
        found = known()
        width = max(map(len, found))
        say("\n".join(f"{name:{width}}  {about}" for name, about in found.items()))
        return 0
    if options.name is None:
        raise InputError("Which one? fecontact examples copy NAME; fecontact examples list shows the names.")
    for path in copy_example(options.name, options.to):
        say(f"wrote {path}")
    return 0


#: The commands by name.
RUN: dict[str, Callable[[argparse.Namespace], int]] = {
    run.__name__: run for run in (hertz, halfspace, friction, roll, ancf, solve, explain, view, compare, examples)
}


def run(options: argparse.Namespace) -> int:
    """Run a command; an error is its message, and Ctrl-C one line with the files that are complete."""
    with written_files() as files:
        try:
            return RUN[options.run](options)
        except FecontactError as error:
            say(f"fecontact: {_worded(error)}", sys.stderr)
            return 2
        except KeyboardInterrupt:
            kept = ", ".join(f"{p} ({rows} rows)" if rows else f"{p}" for p, rows in files.items())
            say(f"fecontact: stopped by Ctrl-C; {f'kept: {kept}' if kept else 'nothing was written'}.", sys.stderr)
            return STOPPED
