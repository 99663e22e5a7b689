"""A bracket from a STEP file, clamped by a bolt between a washer and a plate: contact
areas with holes in them.

The bracket is cut once into hexahedra and once into tetrahedra; forces, areas and
pressures of both are set side by side. The bolt's pretension presses on the washer;
nothing else holds the bracket.

Run: python examples/bracket.py                  (one mesh of each kind)
     python examples/bracket.py --accuracy 0.05  (divided until the pressure is within
                                                  5 %, or to 60,000 unknowns)
"""

import argparse
from pathlib import Path

import fecontact as fc

HERE = Path(__file__).parent
# copied, they lie beside this script
MESHES = HERE.parent / "meshes" if (HERE.parent / "meshes").is_dir() else HERE
STEP = MESHES / "bracket.step"
STEEL = fc.Material(E=210e3, nu=0.3)  # mm, N, MPa
ALUMINIUM = fc.Material(E=70e3, nu=0.33)
PRETENSION = 8000.0
# unknowns of divided meshes: at the washer's sharp edges the pressure has no bound
MAX_DOFS = 60_000
HOLE = (24.0, 15.0, 5.0)  # where the bolt comes out of the flange


def clamped(
    element: str, size: float, accuracy: float | None = None
) -> fc.ContactResult:
    """Plate, bracket and washer under the bolt's pretension."""
    mesh = fc.mesh_solid(
        STEP,
        size=size,
        element=element,
        near=[HOLE, (24.0, 15.0, 0.0)],
        near_size=0.6 * size,
    )
    mesh = mesh.with_boundary("under", fc.pick.plane((0, 0, 0), (0, 0, 1)))
    mesh = mesh.with_boundary("seat", fc.pick.plane((0, 0, 5), (0, 0, 1)))
    bracket = fc.ElasticBody(mesh, ALUMINIUM, contact=("under", "seat"), name="bracket")

    block = fc.shapes.block((60.0, 50.0, 10.0), (15, 13, 2)).translated(
        (-10.0, -10.0, -10.0)
    )
    plate = fc.ElasticBody(
        block, STEEL, contact="top", supports={"bottom": "xyz"}, name="plate"
    )
    ring = fc.shapes.thick_ring(5.5, 10.0, 3.0, (6, 3, 1), sector="full")
    # the bolt's head holds the washer flat: its top is a rigid platen
    washer = fc.ElasticBody(
        ring, STEEL, contact="bottom", supports={"top": "xyz"}, name="washer"
    ).placed(HOLE)

    # the smaller surface of each pair is kept as the slave: it is covered as a whole,
    # which makes whole pictures; but triangles cannot be the slave of a mortar
    # coupling, so under tetrahedra the plate is
    contacts = [
        fc.Contact(
            bracket,
            plate,
            surfaces=("under", "top"),
            swap="never" if element == "hex20" else "auto",
        ),
        fc.Contact(washer, bracket, surfaces=("bottom", "seat"), swap="never"),
    ]
    scene = fc.Scene([plate, bracket, washer], contacts, units=("mm", "N", "MPa"))
    limits = {} if accuracy is None else {"accuracy": accuracy, "max_dofs": MAX_DOFS}
    return scene.solve(forces={washer: (0.0, 0.0, -PRETENSION)}, **limits)


def main(
    size: float = 5.0, out: str | Path = "out", accuracy: float | None = None
) -> dict[str, dict[str, float]]:
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    rows = {}
    print(
        f"{'':8}{'dofs':>8}{'force N':>10}{'under mm2':>11}{'mean MPa':>10}"
        f"{'seat mm2':>10}{'mean MPa':>10}{'s':>7}"
    )
    for element in ("hex20", "tet10"):
        result = clamped(element, size, accuracy)
        under, seat = result.contacts
        rows[element] = {
            "force": under.total_force,
            "area": under.area,
            "mean": under.mean_pressure,
            "seat_area": seat.area,
            "seat_mean": seat.mean_pressure,
            "equilibrium": result.residuals().equilibrium,
        }
        row = rows[element]
        print(
            f"{element:8}{result.n_dofs:>8}{row['force']:>10.1f}{row['area']:>11.1f}"
            f"{row['mean']:>10.2f}"
            f"{row['seat_area']:>10.1f}{row['seat_mean']:>10.2f}"
            f"{result.seconds['total']:>7.1f}"
        )
        result.plot("pressure", folder / f"bracket_{element}.png")
    result.save(folder / "bracket.vtu")
    return rows


def arguments() -> argparse.Namespace:
    """Options of the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument(
        "--accuracy",
        type=float,
        help="of the pressure, such as 0.05: divides the meshes",
    )
    return parser.parse_args()


if __name__ == "__main__":
    main(accuracy=arguments().accuracy)
