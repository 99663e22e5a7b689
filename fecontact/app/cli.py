"""Command line: ``fecontact hertz``, ``halfspace``, ``solve``, ``explain``, ``view`` and ``compare``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TextIO

from fecontact.app.scene_file.scene_file import SceneFile
from fecontact.common.errors import FecontactError, InputError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status (0 success, 2 an error that was explained)."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except FecontactError as error:
        print(f"fecontact: {error}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="fecontact", description="Frictionless elastic contact of solids, certified.")
    commands = parser.add_subparsers(required=True, metavar="command")
    _add_hertz(commands)
    _add_halfspace(commands)
    _add_solve(commands)
    _add_explain(commands)
    _add_view(commands)
    _add_compare(commands)
    return parser


def _check_files(*paths: str | None) -> None:
    """Refuse files that cannot be written before any work."""
    from fecontact.common.text_files import check_writable

    for path in paths:
        if path not in (None, "-"):
            check_writable(path)


def _show(result: object, figures: dict[str, Any], to: str | None) -> TextIO:
    """Print a result and save its figures, or print the figures alone where they go to '-'; says where remarks go."""
    from fecontact.common.text_files import save_json

    if to == "-":
        json.dump(figures, sys.stdout, indent=2)
        print()
        return sys.stderr
    print(result)
    if to is not None:
        print(f"wrote {save_json(to, figures)}")
    return sys.stdout


def _titled(scene: SceneFile, text: object) -> str:
    """What is to be printed, under the scene's title."""
    return f"{scene.title}\n{text}" if scene.title else str(text)


def _add_hertz(commands: argparse._SubParsersAction) -> None:
    hertz = commands.add_parser(
        "hertz",
        help="two spheres pressed together, beside Hertz's solution",
        description="Press two spheres of hexahedra or of gradient bricks (ancf) together and compare with Hertz.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    hertz.add_argument("--case", default="equal", choices=("equal", "unequal", "light", "report"), help="test problem")
    hertz.add_argument("--element", default="hex20", choices=("hex8", "hex20", "hex27", "ancf"))
    hertz.add_argument("--pressure", default="midface", choices=("midface", "nodal"), help="contact faces of hex20")
    hertz.add_argument("--model", default="two-bodies", choices=("two-bodies", "symmetric", "axisymmetric"))
    hertz.add_argument("--solver", default="auto", help="auto or a name out of fecontact.available_solvers()")
    hertz.add_argument("--backend", default="auto", choices=("auto", "pardiso", "superlu"), help="factorisation")
    hertz.add_argument("--level", default=2, type=int, help="fineness, 1 to 5")
    hertz.add_argument("--no-edge-fit", action="store_true", help="do not fit the mesh to the contact edge")
    hertz.add_argument("--json", metavar="FILE", help="write the figures; - for standard output instead of the table")
    hertz.add_argument("--plot", metavar="FILE", help="write a picture")
    hertz.add_argument("--vtu", metavar="FILE", help="write the bodies for ParaView")
    hertz.set_defaults(run=_hertz)


def _hertz(options: argparse.Namespace) -> int:
    from fecontact.app.spheres.report import report_table
    from fecontact.app.spheres.spheres import solve_spheres

    _check_files(options.plot, options.vtu, options.json)
    chosen = {
        "element": options.element,
        "pressure": options.pressure,
        "model": options.model,
        "solver": options.solver,
        "backend": options.backend,
        "level": options.level,
        "edge_fit": not options.no_edge_fit,
    }
    if options.case == "report":
        if options.json or options.plot or options.vtu:
            raise InputError(
                "--case report prints a table and writes no files; for files take --case equal, unequal or light."
            )
        print(report_table(**{**chosen, "model": "axisymmetric" if options.model == "axisymmetric" else "two-bodies"}))
        return 0
    out = solve_spheres(options.case, **chosen)
    remarks = _show(out, out.as_dict(), options.json)
    if options.plot:
        out.plot(options.plot)
        print(f"wrote {Path(options.plot)}", file=remarks)
    if options.vtu:
        print(f"wrote {out.result.save(options.vtu)}", file=remarks)
    return 0


def _add_halfspace(commands: argparse._SubParsersAction) -> None:
    from fecontact.app.indentation.command import SHAPES, TRENDS

    job = commands.add_parser(
        "halfspace",
        help="a rigid shape, a rough surface or measured heights on an elastic half-space",
        description="Press a rigid shape on a half-space (homogeneous or layered, free or periodic) and compare with "
        "the closed form where there is one. Any consistent units.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    job.add_argument("shape", choices=SHAPES)
    body = job.add_argument_group("half-space")
    body.add_argument("--E", type=float, default=None, help="Young's modulus; leave out for a rigid base under layers")
    body.add_argument("--nu", type=float, default=0.3, help="Poisson's ratio")
    body.add_argument("--against", nargs=2, type=float, metavar=("E", "NU"), help="the shape is elastic too")
    body.add_argument("--layer", action="append", metavar="E,NU,THICKNESS[,frictionless]", help="from the top down")
    body.add_argument("--periodic", action="store_true", help="the surface repeats beyond the grid")
    body.add_argument("--cells", nargs="+", type=int, default=[256], metavar="N", help="cells along x (and y)")
    body.add_argument("--size", nargs="+", type=float, metavar="L", help="sides of the grid, or of the period")
    load = job.add_argument_group("load")
    load.add_argument("--force", type=float, help="total, on the grid or on one period")
    load.add_argument("--approach", type=float, help="of the shape; periodic: from the mean plane")
    load.add_argument("--loads", metavar="F1,F2,...", help="several forces: curves of area, stiffness, gap")
    load.add_argument("--load-point", nargs=2, type=float, metavar=("X", "Y"), help="the shape is free to tilt")
    load.add_argument("--moment", nargs=2, type=float, metavar=("MX", "MY"), help="the same, by moments")
    form = job.add_argument_group("shape")
    form.add_argument("--radius", type=float, help="sphere, cylinder, flat, paraboloid")
    form.add_argument("--radius-y", type=float, help="paraboloid, if another one")
    form.add_argument("--length", type=float, help="cylinder, along y; endless unless given")
    form.add_argument("--angle", type=float, help="cone, between flank and surface, degrees")
    form.add_argument("--sides", nargs=2, type=float, metavar=("A", "B"), help="flat, rectangular")
    form.add_argument("--semi-axes", nargs=3, type=float, metavar=("A", "B", "C"), help="ellipsoid")
    form.add_argument("--ring", type=float, help="torus, radius of its circle")
    form.add_argument("--tube", type=float, help="torus, radius of its tube")
    form.add_argument("--amplitude", type=float, help="wave along x")
    form.add_argument("--wavelength", type=float, help="wave; the period unless given")
    form.add_argument("--file", help="heights (.npy .txt .csv .xyz .asc) or a surface (.stl .ply .obj), facing down")
    form.add_argument("--peaks-up", action="store_true", help="heights as measured: the highest touch, not the lowest")
    form.add_argument("--trend", default="none", choices=("none", *TRENDS), help="to be taken off the heights")
    form.add_argument("--hurst", type=float, default=0.8, help="rough")
    form.add_argument("--rms-slope", type=float, help="rough; this or --rms-height")
    form.add_argument("--rms-height", type=float, help="rough")
    form.add_argument("--longest", type=float, help="rough, wavelength; a quarter of the size unless given")
    form.add_argument("--shortest", type=float, help="rough, wavelength; eight cells unless given")
    form.add_argument("--seed", type=int, default=1, help="rough")
    out = job.add_argument_group("output")
    out.add_argument("--tolerance", type=float, default=1e-8, help="of the certificate")
    out.add_argument("--json", metavar="FILE", help="write the figures; - for standard output instead of the table")
    out.add_argument("--plot", metavar="FILE", help="pressure, gap, displacement, stress inside; curves for --loads")
    out.add_argument("--csv", metavar="FILE", help="one row per load")
    out.add_argument("--units", nargs=3, default=("", "", ""), metavar=("LENGTH", "FORCE", "STRESS"), help="for labels")
    job.set_defaults(run=_halfspace)


def _halfspace(options: argparse.Namespace) -> int:
    from fecontact.app.indentation.command import run

    _check_files(options.plot, options.csv, options.json)
    found = run(vars(options))
    remarks = _show(found, found.as_dict(), options.json)
    if options.csv:
        print(f"wrote {found.save(options.csv)}", file=remarks)
    if options.plot:
        found.plot(options.plot, *options.units)
        print(f"wrote {Path(options.plot)}", file=remarks)
    return 0


def _add_solve(commands: argparse._SubParsersAction) -> None:
    solve = commands.add_parser(
        "solve",
        help="a scene described in a TOML file",
        description="Solve the scene in a TOML file. All of the file is checked before anything is solved; whatever "
        "is wrong is told at once. The outputs that the file names are written.",
    )
    solve.add_argument("scene", metavar="SCENE.toml")
    solve.add_argument("--dry-run", action="store_true", help="check the file, say what it asks for, and stop")
    solve.add_argument("--json", metavar="FILE", help="write the figures; - for standard output instead of the table")
    solve.add_argument("--out", metavar="FOLDER", help="folder for outputs instead of the scene's own; made if missing")
    solve.set_defaults(run=_solve)


def _solve(options: argparse.Namespace) -> int:
    from fecontact.app.scene_file.scene_file import read_scene

    _check_files(options.json)
    scene = read_scene(options.scene, out=_folder(options.out))
    if options.dry_run:
        print(scene.describe())
        return 0
    if scene.cases:
        return _sweep(scene, options.json)
    result = scene.solve()
    remarks = _show(_titled(scene, result), scene.summary(result), options.json)
    for path in scene.write(result):
        print(f"wrote {path}", file=remarks)
    return 0


def _sweep(scene: SceneFile, to: str | None) -> int:
    from fecontact.app.scene_file.cases import table_of

    rows = scene.sweep()
    remarks = _show(_titled(scene, table_of(rows)), {"cases": rows}, to)
    for output in scene.outputs:
        print(f"wrote {output.path}", file=remarks)
    return 0


def _add_explain(commands: argparse._SubParsersAction) -> None:
    explain = commands.add_parser(
        "explain",
        help="what a scene in a TOML file would take, before it is solved",
        description="Say which bodies, unknowns and candidates a scene has, which methods are chosen and why, and "
        "estimate memory and time. Nothing of the scene is assembled or solved.",
    )
    explain.add_argument("scene", metavar="SCENE.toml")
    explain.add_argument("--json", metavar="FILE", help="write the figures; - for standard output instead of the text")
    explain.set_defaults(run=_explain)


def _explain(options: argparse.Namespace) -> int:
    from fecontact.app.scene_file.scene_file import read_scene
    from fecontact.scene.cost import explain

    _check_files(options.json)
    scene = read_scene(options.scene)
    told = explain(scene.scene, scene.loads, scene.options.get("solver", "auto"))
    _show(_titled(scene, told), told.as_dict(), options.json)
    return 0


def _folder(path: str | None) -> Path | None:
    """A folder for outputs, made if it is missing."""
    if path is None:
        return None
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"Cannot make the folder {path}: {error.strerror}.") from error
    return Path(path)


def _add_view(commands: argparse._SubParsersAction) -> None:
    view = commands.add_parser(
        "view",
        help="picture of the bodies in a VTU file",
        description="Draw the bodies of a result, deformed, with a field on their faces. Needs no screen.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    view.add_argument("result", metavar="RESULT.vtu")
    view.add_argument(
        "--field", default="von_mises", help="von_mises, contact_pressure, displacement_z, stress_xx, ..."
    )
    view.add_argument("--out", metavar="PICTURE", help="file to write; the result's name with .png unless given")
    view.add_argument("--scale", default=1.0, type=float, help="by which displacements are exaggerated; 0: undeformed")
    view.add_argument("--view", default="iso", help="iso, below, x, -x, y, -y, z, -z, or AZIMUTH,ELEVATION in degrees")
    view.add_argument("--cut", metavar="'x<0'", help="what is to be kept")
    view.add_argument("--bodies", metavar="0,1", help="numbers of the bodies to show, separated by commas")
    view.add_argument("--limits", nargs=2, type=float, metavar=("LOW", "HIGH"), help="of the colours")
    view.add_argument("--units", default="", help="unit of the field, for the colour bar")
    view.add_argument("--length", default="", help="unit of length, for the ruler")
    view.add_argument("--no-edges", action="store_true", help="do not draw the mesh")
    view.add_argument("--show", action="store_true", help="open a window instead (needs pyvista)")
    view.set_defaults(run=_view)


def _view(options: argparse.Namespace) -> int:
    from fecontact.results.pictures import bodies as view
    from fecontact.results.pictures.solids import solids_of_file

    solids = solids_of_file(options.result)
    chosen = {
        "scale": options.scale,
        "direction": _direction(options.view),
        "only": options.bodies.split(",") if options.bodies else None,
        "where": options.cut,
        "limits": options.limits,
        "units": options.units,
    }
    if options.show:
        view.show(solids, options.field, options.out, **chosen)
        return 0
    path = Path(options.result).with_suffix(".png") if options.out is None else Path(options.out)
    view.view(solids, options.field, path, length=options.length, edges=not options.no_edges, **chosen)
    print(f"wrote {path}")
    return 0


def _direction(text: str) -> str | tuple[float, float]:
    """A view by name, or two angles separated by a comma."""
    azimuth, comma, elevation = text.partition(",")
    if not comma:
        return text
    try:
        return float(azimuth), float(elevation)
    except ValueError:
        raise InputError(f"A view is a name or AZIMUTH,ELEVATION in degrees; found {text!r}.") from None


def _add_compare(commands: argparse._SubParsersAction) -> None:
    compare = commands.add_parser(
        "compare",
        help="speed against error of discretisations, couplings and solvers",
        description="Run a problem with a known answer by many methods at several refinements, and show error against "
        "time and size. Finished runs are kept: an interrupted command goes on where it stopped.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    compare.add_argument(
        "problem",
        help="hertz, unequal, ellipse, line, layer or punch; or SCENE.toml, whose finest run is the reference",
    )
    compare.add_argument(
        "--methods",
        nargs="+",
        default=(),
        metavar="NAME[:KEY=VALUE]",
        help="such as hex20:coupling=mortar:solver=nnls; all that solve the problem unless given",
    )
    compare.add_argument("--refinements", type=int, metavar="N", help="of each method, the coarsest first; all if left")
    compare.add_argument("--repeats", type=int, default=3, help="of each run; the median counts")
    compare.add_argument("--threads", type=int, default=1)
    compare.add_argument("--enough", type=float, default=20.0, help="CPU seconds after which a method is not refined")
    compare.add_argument("--peers", metavar="FOLDER", help="adapters of other programs, such as examples/peers")
    compare.add_argument("--peer-python", default=sys.executable, metavar="PYTHON", help="that has these programs")
    compare.add_argument("--out", metavar="FOLDER", help="write compare_PROBLEM.jsonl, .json, .csv, .png and .md there")
    compare.add_argument("--page", metavar="FILE.md", help="write the page there instead")
    compare.add_argument("--plot", metavar="FILE", help="write the picture there instead")
    compare.set_defaults(run=_compare)


def _compare(options: argparse.Namespace) -> int:
    from dataclasses import replace

    from fecontact.app.compare.command import Files, run, run_scene
    from fecontact.app.compare.run import Plan

    given = {"page": options.page, "picture": options.plot}
    given = {k: Path(v) for k, v in given.items() if v is not None}
    if options.problem.endswith(".toml"):
        files = Files() if options.out is None else Files.of_folder(options.out, Path(options.problem).stem)
        refinements = 3 if options.refinements is None else options.refinements
        print(run_scene(options.problem, refinements, replace(files, **given)))
        return 0
    plan = Plan(
        options.problem,
        tuple(options.methods),
        options.refinements,
        options.repeats,
        options.threads,
        options.enough,
    )
    files = Files() if options.out is None else Files.of_folder(options.out, options.problem)
    files = replace(files, **given)
    command = f"fecontact compare {options.problem}"
    print(run(plan, files, adapters=options.peers, python=options.peer_python, command=command))
    return 0


if __name__ == "__main__":
    sys.exit(main())
