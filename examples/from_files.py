"""Files of others: one scene by decks of three programs, and measured heights pressed
on a half-space.

The decks of Abaqus, CalculiX and FEBio describe the same two blocks, so they have the
same force. The heights are a terrain, measured by radar, in the place of a rough
surface: 128 x 128 cells on 9.5 x 11.9 km, here mm, and a hundredth as high.

Run: python examples/from_files.py
"""

from pathlib import Path

import numpy as np

import fecontact as fc

HERE = Path(__file__).parent
# copied, they lie beside this script
MESHES = HERE.parent / "meshes" if (HERE.parent / "meshes").is_dir() else HERE
DECKS = [
    MESHES / name
    for name in ("blocks_abaqus.inp", "blocks_calculix.inp", "blocks_febio.feb")
]
HILLS = MESHES / "hills.txt"


def main(out: str | Path = "out") -> tuple[list[float], fc.HalfSpaceContact]:
    # FEBio's law is one of finite strain
    scenes = [fc.read_scene(deck, laws="small-strain") for deck in DECKS]
    forces = [float(scene.solve().contacts[0].total_force) for scene in scenes]
    for deck, force in zip(DECKS, forces, strict=True):
        print(f"{deck.name:20} {force:.6f} N")
    heights = -fc.surfaces.detrend(
        fc.surfaces.read_topography(HILLS, unit=1e-5).z
    )  # flatter too; peaks press downwards
    # the map ends there
    heights = np.pad(heights - heights.min(), 8, constant_values=np.inf)
    cells = np.array(heights.shape)
    half = fc.HalfSpace(
        fc.Material(E=1e4, nu=0.2),
        size=tuple(cells * [0.0745, 0.0927]),
        cells=tuple(cells),
    )
    contact = half.press(heights, force=500.0)
    print(contact)
    Path(out).mkdir(parents=True, exist_ok=True)
    contact.plot(Path(out) / "from_files.png", units=("mm", "N", "MPa"))
    return forces, contact


if __name__ == "__main__":
    main()
