"""Command line: ``fecontact hertz``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from fecontact.errors import FecontactError


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
    return parser


def _add_hertz(commands: argparse._SubParsersAction) -> None:
    hertz = commands.add_parser(
        "hertz",
        help="two spheres pressed together, beside Hertz's solution",
        description="Press two spheres of 8-, 20- or 27-node hexahedra together and compare with Hertz.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    hertz.add_argument("--case", default="equal", choices=("equal", "unequal", "light", "report"), help="test problem")
    hertz.add_argument("--element", default="hex20", choices=("hex8", "hex20", "hex27"))
    hertz.add_argument("--pressure", default="midface", choices=("midface", "nodal"), help="contact faces of hex20")
    hertz.add_argument("--model", default="two-bodies", choices=("two-bodies", "symmetric"))
    hertz.add_argument("--solver", default="auto", help="auto or a name out of fecontact.available_solvers()")
    hertz.add_argument("--backend", default="auto", choices=("auto", "pardiso", "superlu"), help="factorisation")
    hertz.add_argument("--level", default=2, type=int, help="fineness, 1 to 5")
    hertz.add_argument("--no-edge-fit", action="store_true", help="do not fit the mesh to the contact edge")
    hertz.add_argument("--json", metavar="FILE", help="write the figures; - for standard output instead of the table")
    hertz.add_argument("--plot", metavar="FILE", help="write a picture")
    hertz.add_argument("--vtu", metavar="FILE", help="write the bodies for ParaView")
    hertz.set_defaults(run=_hertz)


def _hertz(options: argparse.Namespace) -> int:
    from fecontact.io import check_writable, save_json
    from fecontact.spheres import report_table, solve_spheres

    for path in (options.plot, options.vtu, options.json if options.json != "-" else None):
        if path is not None:
            check_writable(path)
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
        print(report_table(**{**chosen, "model": "two-bodies"}))
        return 0
    out = solve_spheres(options.case, **chosen)
    if options.json == "-":
        json.dump(out.as_dict(), sys.stdout, indent=2)
        print()
    else:
        print(out)
        if options.json:
            print(f"figures: {save_json(options.json, out.as_dict())}")
    notes = sys.stderr if options.json == "-" else sys.stdout
    if options.plot:
        out.plot(options.plot)
        print(f"picture: {Path(options.plot)}", file=notes)
    if options.vtu:
        print(f"bodies:  {out.result.save(options.vtu)}", file=notes)
    return 0


if __name__ == "__main__":
    sys.exit(main())
