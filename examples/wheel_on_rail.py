"""A wheel on a rail, S1002 on UIC60 of the Manchester contact benchmark: patches over
lateral shifts, to the flange.

Run: python examples/wheel_on_rail.py
"""

from pathlib import Path

import numpy as np

import fecontact as fc

HERE = Path(__file__).parent
# copied, they lie beside this script
MESHES = HERE.parent / "meshes" if (HERE.parent / "meshes").is_dir() else HERE
WHEEL, RAIL = MESHES / "MBench_S1002_v3.prw", MESHES / "MBench_UIC60_v3.prr"
STEEL = fc.Material(E=2 * 82000 * 1.28, nu=0.28)  # mm, N, MPa


def main(
    n: int = 17, cells: int = 48, out: str | Path = "out"
) -> list[dict[str, float]]:
    pair = fc.WheelRail(
        fc.surfaces.read_profile(WHEEL), fc.surfaces.read_profile(RAIL), 460.0, STEEL
    )
    # of the axle towards the flange, with a yaw of 2.4 mrad per mm
    shifts = np.linspace(0.0, 8.0, n)
    path = pair.positions(10e3, shifts, yaws=2.4e-3 * shifts, friction=0.3, cells=cells)
    print(path)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    names = {"length": "mm", "force": "N", "units": "MPa"}
    path.plot(folder / "wheel_on_rail.png", **names)
    two = max(path.steps, key=lambda at: len(at.patches))
    two.plot(folder / "wheel_on_rail_patches.png", **names)
    return path.rows()


if __name__ == "__main__":
    main()
