"""Command line: the options of every command, see `COMMANDS`.

Only the options are defined here, so that help needs no numerical package; `commands` runs them.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence

from fecontact.app.options import (
    CASES,
    ELEMENTS,
    FINITE,
    LAWS,
    MODELS,
    OPTIONS,
    PRESSURES,
    PROBLEMS,
    ROUTES,
    STOPPED,
    STUDIES,
)
from fecontact.common.version import VERSION


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit status: 0 success, 2 an error with a message, 130 stopped by Ctrl-C."""
    options = _parser().parse_args(arguments)
    set_threads()
    try:
        from fecontact.app import commands

        return commands.run(options)
    except KeyboardInterrupt:  # of the import of numerical packages
        print("fecontact: stopped by Ctrl-C.", file=sys.stderr)
        return STOPPED


def set_threads() -> None:
    """Give numpy's matrix products one thread, unless ``OPENBLAS_NUM_THREADS`` says otherwise.

    It is read when numpy is imported. The matrices are small: their threads wait for each other, on a busy machine a
    third of the processor time of a run. PARDISO, the costly part, has MKL's own threads.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="fecontact", description="Elastic contact of solids, certified.")
    parser.add_argument("--version", action="version", version=f"%(prog)s {VERSION}")
    commands = parser.add_subparsers(required=True, metavar="command")
    for name, (summary, description, add_options) in COMMANDS.items():
        own_help = name == "halfspace"
        command = commands.add_parser(
            name, help=summary, description=description, formatter_class=_Formatter, add_help=not own_help
        )
        command.set_defaults(run=name)
        add_options(command)
    return parser


class _HelpOfShape(argparse.Action):
    """Help of ``halfspace KIND --help``, without the options of other kinds; of all before a kind is given."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, *_: object) -> None:
        shape = getattr(namespace, "shape", None)
        others = {name for kind, names in OPTIONS.items() if kind != shape for name in names}
        for action in parser._actions if shape else ():
            if action.dest in others - set(OPTIONS.get(str(shape), ())):
                action.help = argparse.SUPPRESS
        parser.print_help()
        parser.exit()


class _Formatter(argparse.ArgumentDefaultsHelpFormatter):
    """Help formatter that shows defaults that are names or numbers."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        shown = isinstance(action.default, str | int | float) and action.default not in ("", False)
        return super()._get_help_string(action) if shown else action.help


def _outputs(
    parser: argparse._ActionsContainer, plot: str = "", csv: str = "", units: bool = False, printed: str = "table"
) -> None:
    """Options of what a command writes; pictures and rows where there are any."""
    shown = f"write the figures; - for standard output instead of the {printed}"
    parser.add_argument("--json", metavar="FILE", help=shown)
    if plot:
        parser.add_argument("--plot", metavar="FILE", help=plot)
    if csv:
        parser.add_argument("--csv", metavar="FILE", help=csv)
    if units:
        names = ("LENGTH", "FORCE", "STRESS")
        parser.add_argument("--units", nargs=3, default=("", "", ""), metavar=names, help="for labels")


def _hertz(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--case", default="equal", choices=(*CASES, "report"), help="test problem")
    parser.add_argument(
        "--route", default="fast", choices=ROUTES, help="1978: the report's cases by its own dense route, timed beside"
    )
    parser.add_argument("--element", default="hex20", choices=ELEMENTS)
    parser.add_argument("--pressure", default="midface", choices=PRESSURES, help="contact faces of hex20")
    parser.add_argument("--model", default="two-bodies", choices=MODELS)
    parser.add_argument("--solver", default="auto", help="auto or a name out of fecontact.available_solvers()")
    parser.add_argument(
        "--backend", default="auto", choices=("auto", "pardiso", "rslab", "superlu"), help="factorisation"
    )
    parser.add_argument("--level", default=2, type=int, help="fineness, 1 to 5")
    parser.add_argument("--no-edge-fit", action="store_true", help="do not fit the mesh to the contact edge")
    _outputs(parser, "pressure over the radius beside Hertz, and its map", "the figures in one row")
    parser.add_argument("--vtu", metavar="FILE", help="write the bodies for ParaView")


def _halfspace(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-h", "--help", action=_HelpOfShape, nargs=0, help="show this, after a shape for it alone")
    parser.add_argument("shape", choices=OPTIONS)
    body = parser.add_argument_group("half-space")
    body.add_argument("--E", type=float, default=None, help="Young's modulus; leave out for a rigid base under layers")
    body.add_argument("--nu", type=float, default=0.3, help="Poisson's ratio")
    body.add_argument("--against", nargs=2, type=float, metavar=("E", "NU"), help="the shape is elastic too")
    prony = "visco-elastic, E at t = 0: a share of it that relaxes, and its time; repeated"
    body.add_argument("--prony", action="append", metavar="SHARE,TIME", help=prony)
    body.add_argument("--layer", action="append", metavar="E,NU,THICKNESS[,frictionless]", help="from the top down")
    body.add_argument("--periodic", action="store_true", help="the surface repeats beyond the grid")
    body.add_argument(
        "--cells", nargs="+", type=int, default=[256], metavar="N", help="cells along x (and y); 256 unless given"
    )
    body.add_argument("--size", nargs="+", type=float, metavar="L", help="sides of the grid, or of the period")
    load = parser.add_argument_group("load")
    load.add_argument("--force", type=float, help="total, on the grid or on one period")
    load.add_argument("--approach", type=float, help="of the shape; periodic: from the mean plane")
    load.add_argument("--loads", metavar="F1,F2,...", help="several forces: curves of area, stiffness, gap")
    load.add_argument(
        "--hardness", type=float, help="largest pressure, at which the half-space yields and keeps a dent"
    )
    moves = "of a contact that rolls or slides over a visco-elastic half-space"
    load.add_argument("--velocity", nargs=2, type=float, metavar=("VX", "VY"), help=moves)
    load.add_argument("--adhesion", metavar="WORK,RANGE", help="of surfaces that attract each other, Dugdale's law")
    load.add_argument(
        "--wear", metavar="K,LENGTH", help="Archard's volume per force and length; slides so far in place"
    )
    load.add_argument("--approaches", metavar="A1,A2,...", help="with adhesion: a curve, on and off")
    load.add_argument("--load-point", nargs=2, type=float, metavar=("X", "Y"), help="the shape is free to tilt")
    load.add_argument("--moment", nargs=2, type=float, metavar=("MX", "MY"), help="the same, by moments")
    form = parser.add_argument_group("shape")
    form.add_argument("--radius", type=float, help="sphere, cylinder, flat, paraboloid")
    form.add_argument("--radius-y", type=float, help="paraboloid, if another one")
    form.add_argument("--length", type=float, help="cylinder, along y; infinite unless given")
    form.add_argument("--angle", type=float, help="cone, between flank and surface, degrees")
    form.add_argument("--sides", nargs=2, type=float, metavar=("A", "B"), help="flat, rectangular")
    form.add_argument("--semi-axes", nargs=3, type=float, metavar=("A", "B", "C"), help="ellipsoid")
    form.add_argument("--ring", type=float, help="torus, radius of its circle")
    form.add_argument("--tube", type=float, help="torus, radius of its tube")
    form.add_argument("--amplitude", type=float, help="wave along x")
    form.add_argument("--wavelength", type=float, help="wave; the period unless given")
    form.add_argument("--file", help="heights (.npy .txt .csv .xyz .asc) or a surface (.stl .ply .obj), facing down")
    form.add_argument("--height-unit", type=float, help="of the heights in that of lengths: 1e-6 for nm beside mm")
    form.add_argument("--peaks-up", action="store_const", const=True, help="heights as measured: the highest touch")
    form.add_argument("--holes", choices=("fill", "open"), help="of heights: filled smoothly, or without a surface")
    form.add_argument("--trend", help="mean, plane or quadratic, subtracted from the heights; none unless given")
    form.add_argument("--hurst", type=float, help="rough; 0.8 unless given")
    form.add_argument("--rms-slope", type=float, help="rough; this or --rms-height")
    form.add_argument("--rms-height", type=float, help="rough")
    form.add_argument("--longest", type=float, help="rough, wavelength; a quarter of the size unless given")
    form.add_argument("--shortest", type=float, help="rough, wavelength; eight cells unless given")
    form.add_argument("--seed", type=int, help="rough; 1 unless given")
    out = parser.add_argument_group("output")
    out.add_argument("--tolerance", type=float, default=1e-8, help="of the certificate")
    passes = "conductance, leakage or both with a comma: for conductivities, a drop along x and a viscosity of 1"
    out.add_argument("--also", metavar="FIGURES", help=passes)
    _outputs(out, "pressure, gap, displacement, stress inside; curves for --loads", "one row per load", units=True)


def _friction(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("study", choices=STUDIES, help="; ".join(f"{name}: {what}" for name, what in STUDIES.items()))
    parser.add_argument(
        "--radius", type=float, default=10.0, help="of the ball or the roller, on a plane; side of the block"
    )
    parser.add_argument("--E", type=float, default=210e3, help="Young's modulus of both bodies")
    parser.add_argument("--nu", type=float, default=0.3, help="Poisson's ratio of both bodies")
    parser.add_argument("--force", type=float, default=100.0, help="normal force; per length of a roller")
    parser.add_argument("--friction", type=float, default=0.3, help="Coulomb's mu")
    parser.add_argument("--tangential", type=float, help="tangential force; 0.6 of what friction holds unless given")
    parser.add_argument(
        "--cells", type=int, metavar="N", help="along a side; 128 (carter: 32 across the contact; block: 8)"
    )
    pictures = "tractions, stick and slip, loop or creep beside the closed form"
    _outputs(parser, pictures, "one row per step", units=True)


def _roll(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--radius", type=float, help="of the body along x, 10 unless given; nominal one of a wheel")
    parser.add_argument("--radius-y", type=float, help="along y; the same unless given")
    parser.add_argument("--E", type=float, default=210e3, help="Young's modulus of both bodies")
    parser.add_argument("--nu", type=float, default=0.3, help="Poisson's ratio of both bodies")
    parser.add_argument("--force", type=float, default=100.0, help="normal force")
    parser.add_argument("--friction", type=float, default=0.3, help="Coulomb's mu; inf: what touches sticks")
    parser.add_argument(
        "--creepage",
        nargs=2,
        type=float,
        action="append",
        metavar=("ALONG", "LEFT"),
        help="as 0.001 or -0.001, repeated: a creep curve",
    )
    parser.add_argument(
        "--tangential", nargs=2, type=float, metavar=("ALONG", "LEFT"), help="force in place of creepage; 0 0: free"
    )
    parser.add_argument("--spin", nargs="+", type=float, help="0 unless given; several: a family of creep curves")
    parser.add_argument(
        "--towards", nargs=2, type=float, metavar=("X", "Y"), help="direction of rolling; along x unless given"
    )
    parser.add_argument(
        "--rule", choices=("blended", "contact"), help="difference along the rolling; blended unless given"
    )
    parser.add_argument("--cells", type=int, default=64, metavar="N", help="along a side, of each patch")
    pair = parser.add_argument_group("wheel and rail")
    files = ("WHEEL", "RAIL")
    pair.add_argument(
        "--profiles", nargs=2, metavar=files, help="files .prw .prr .whl .ban .csv, in mm, of a left wheel"
    )
    for name, text in {
        "shift": "of the axle to the left; 0 unless given",
        "yaw": "about z in radians, one or as many as shifts; 0 unless given",
        "roll": "about x, likewise",
        "turning": "speed of the tread over that along the track, likewise; 1 unless given",
    }.items():
        pair.add_argument(f"--{name}", nargs="+", type=float, metavar="V", help=text)
    gauge = "of the track, and how far below the rail's top; 1435 14 unless given"
    pair.add_argument("--gauge", nargs=2, type=float, metavar=("WIDTH", "BELOW"), help=gauge)
    pair.add_argument("--rail-position", type=float, metavar="Y", help="of the rail's origin, in place of the gauge")
    pair.add_argument("--wheel-position", type=float, metavar="Y", help="of the wheel's origin; 750 unless given")
    pair.add_argument("--join", type=float, metavar="D", help="patches nearer than this share a plane, as in CONTACT")
    pictures = "stick, slip and tractions, or curves; patches on the profiles, or figures over the shifts"
    _outputs(parser, pictures, "one row per creepage and spin, or patch", units=True)


def _ancf(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("problem", choices=PROBLEMS, help="; ".join(f"{n}: {what}" for n, what in PROBLEMS.items()))
    parser.add_argument("--elements", type=int, metavar="N", help="10; pendulum: 12; fourbar: 2 each bar")
    parser.add_argument("--measure", default="turn", choices=("turn", "geometric", "chord"), help="strains of the axis")
    parser.add_argument("--gravity", type=float, default=9.81, help="pendulum: 9.81 or 50")
    parser.add_argument("--step", type=float, help="of time; pendulum: 0.002 or, under 50, 0.001; fourbar: 0.0005")
    until = "pendulum: seconds, up to 1.1, with corotational beams beside to 0.7; 0.4 without, unless given"
    parser.add_argument("--until", type=float, metavar="T", help=until)
    _outputs(parser, "shapes on the way", "one row per case")


def _solve(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", help="SCENE.toml, or a deck: .inp (Abaqus, CalculiX) or .feb (FEBio)")
    parser.add_argument(
        "--accuracy",
        type=_accuracy,
        metavar="2%",
        help="divide the meshes until the pressure is within it, or figures by name: pressure=2%%,force=1%%",
    )
    parser.add_argument("--max-seconds", type=float, metavar="S", help="limit of the way there; the best is then kept")
    parser.add_argument("--engine", metavar="petsc", help="solve by PETSc on several processes under MPI")
    parser.add_argument("--beside", choices=("ccx",), help="a deck: solve it by CalculiX too, and compare")
    parser.add_argument("--divide", type=int, default=0, metavar="N", help="a deck: divide each cell so many times")
    parser.add_argument("--beside-plot", metavar="FILE", help="with --beside: a picture of both")
    parser.add_argument("-n", "--ranks", type=int, metavar="N", help="number of processes of the engine petsc")
    _laws(parser)
    parser.add_argument("--dry-run", action="store_true", help="check the file, print a summary, and stop")
    _outputs(parser, units=True)
    parser.add_argument("--report", metavar="FILE.html", help="write a page of tables and pictures")
    parser.add_argument("--montage", metavar="FILE", help="cases: maps of the pressure of the first contact")
    parser.add_argument("--animate", metavar="FILE", help="cases: the same as an animation, .gif or .mp4")
    parser.add_argument(
        "--out",
        metavar="FOLDER",
        help="folder for outputs instead of the scene's (of a deck: .vtu, .json); made if missing",
    )


def _laws(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--laws", default=FINITE, choices=LAWS, help="hyperelastic laws of a deck, or their moduli at rest"
    )


def _share(text: str) -> float:
    """A share such as '2%' or '0.02'."""
    number = text.strip().removesuffix("%")
    return float(number) / 100 if number != text.strip() else float(number)


def _accuracy(text: str) -> float | dict[str, float]:
    """An accuracy of the pressure such as '2%', or of figures by name such as 'pressure=2%,force=1%'."""
    if "=" not in text:
        return _share(text)
    pairs = (part.partition("=") for part in text.split(","))
    return {name.strip(): _share(value) for name, _, value in pairs}


def _explain(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE.toml | PART.step")
    _laws(parser)
    _outputs(parser, printed="text")


def _scale(text: str) -> float | str:
    return text if text == "auto" else float(text)


def _view(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "result", metavar="RESULT.vtu | MESH", help="a result, a mesh or a section: .step, .msh, .stl, .."
    )
    parser.add_argument("--field", help="von_mises (unless given), contact_pressure, displacement_z, stress_xx")
    parser.add_argument("--out", metavar="PICTURE", help="file to write; the result's name with .png unless given")
    parser.add_argument("--scale", default=1.0, type=_scale, help="factor of the displacements, or auto; 0 undeformed")
    parser.add_argument("--view", help="iso (unless given), below, x, -x, y, -y, z, -z or AZIMUTH,ELEVATION in degrees")
    parser.add_argument("--cut", metavar="'x<0'", help="part to keep")
    parser.add_argument("--bodies", metavar="0,1", help="numbers of the bodies to show, separated by commas")
    parser.add_argument("--limits", nargs=2, type=float, metavar=("LOW", "HIGH"), help="of the colours")
    parser.add_argument("--units", default="", metavar="MPa | mm,N,MPa", help="unit of the field, or all, for labels")
    parser.add_argument("--length", default="", help="unit of length, for the ruler")
    parser.add_argument("--no-edges", action="store_true", help="do not draw the mesh")
    parser.add_argument("--show", action="store_true", help="open a window instead (needs pyvista)")


def _compare(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?", metavar="SCENE.toml")
    parser.add_argument(
        "--runs", type=int, default=3, metavar="N", help="accuracies of 20 %%, 10 %%, 5 %% ..; at least 2"
    )
    _outputs(parser, "error over time and size", "one row per run")


def _examples(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", choices=("list", "copy"), help="what there is; or copy one with its data")
    parser.add_argument("name", nargs="?", help="copy: name of an example, or all")
    parser.add_argument("--to", default=".", metavar="FOLDER", help="where to copy it; made if missing")


#: Short and long help of each command, and the function that adds its options.
COMMANDS: dict[str, tuple[str, str, Callable[[argparse.ArgumentParser], None]]] = {
    "hertz": (
        "two spheres pressed together, beside Hertz's solution",
        "Press two spheres of hexahedra or of gradient bricks (ancf) together and compare with Hertz.",
        _hertz,
    ),
    "halfspace": (
        "a rigid shape, a rough surface or measured heights on an elastic half-space",
        "Press a rigid shape on a half-space (homogeneous or layered, free or periodic) and compare with "
        "the closed form where there is one. Any consistent units.",
        _halfspace,
    ),
    "friction": (
        "a ball or a roller in partial slip, fretting or rolling, on a half-space; a block on a plane",
        "Drag a ball or a roller on a half-space of its own material, or a block on a rigid plane, with Coulomb "
        "friction, and compare with the closed form. Any consistent units.",
        _friction,
    ),
    "roll": (
        "a ball, an ellipsoid or a wheel that rolls steadily, with creepage and spin; creep curves, lateral shifts",
        "Roll a curved body on a plane of the same material, or a wheel on a rail of profiles in files: tractions, "
        "slip, forces and work of friction of Kalker's problem, with their errors. Any consistent units.",
        _roll,
    ),
    "ancf": (
        "slender beams at large rotations: elastica, full circle, falling pendulum",
        "Solve a problem of Campanelli, Berzeri & Shabana (1999) by lines of absolute nodal coordinates and compare "
        "with the closed form or a fine solution.",
        _ancf,
    ),
    "solve": (
        "a scene described in a TOML file or in a deck (.inp, .feb)",
        "Solve the scene in a TOML file, or in a deck of Abaqus, CalculiX or FEBio. The whole file is checked before "
        "the solve; all errors "
        "are reported together. The outputs that the file names are written.",
        _solve,
    ),
    "explain": (
        "estimated cost of a scene in a TOML file, before it is solved",
        "Say which bodies, unknowns and candidates a scene has, which methods are chosen and why, and "
        "estimate memory and time. Nothing of the scene is assembled or solved. Of a CAD file, list the solids.",
        _explain,
    ),
    "view": (
        "picture of a result's bodies, or of a mesh with its boundaries",
        "Draw a result's bodies, deformed, with a field on their faces; or a mesh, a solid of CAD or a surface with "
        "its named boundaries in colours. Needs no screen.",
        _view,
    ),
    "compare": (
        "error against time of a scene in a TOML file at several accuracies",
        "Solve a scene to accuracies of 20 %%, 10 %%, 5 %% and so on, and show the errors beside the run of the "
        "smallest estimate over time and size. Grids of half-spaces get 1, 2, 3 .. times their cells.",
        _compare,
    ),
    "examples": (
        "scripts and scene files to start from",
        "List the examples that come with the package, or copy one, with its data, to a folder.",
        _examples,
    ),
}


if __name__ == "__main__":
    sys.exit(main())
