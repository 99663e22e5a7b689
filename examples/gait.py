"""A gait cycle of a knee's inner compartment: twenty poses of a condyle on its plateau,
given by clinical angles.

The condyle is a part of a torus, the plateau a shallow dish; both have 2 mm of
cartilage, extruded from irregular triangles as a segmented bone has them. Flexion,
adduction and rotation prescribe the turn of each pose (Grood & Suntay 1983); the femur
is pressed down on the tibia and finds its place forwards and sideways. Rows are written
to a file as they are done: the same command goes on where it was stopped.

The course of flexion and load is made up, with the two humps and the swing of walking.

Run: python examples/gait.py                  (2,500 triangles a bone, twenty poses)
     python examples/gait.py --processes 2    (two poses at a time)
"""

import argparse
from pathlib import Path

import numpy as np

import fecontact as fc
from fecontact.results.case_table import CaseTable

CARTILAGE = fc.Material(E=10.0, nu=0.45)  # MPa; mm and N throughout
THICKNESS = 2.0
SAGITTAL, FRONTAL = 32.0, 20.0  # radii of the condyle's free surface
# of the axis of flexion over the tibial bone, at first touch
HEIGHT = SAGITTAL + THICKNESS


def irregular(n: int, m: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates u, v between 0 and 1 of a grid whose inner points are moved about,
    and its triangles as facets.
    """
    moved = np.random.default_rng(seed).uniform(-0.25, 0.25, (2, n + 1, m + 1))
    moved[0, [0, -1]] = moved[1, :, 0] = moved[1, :, -1] = 0.0
    u, v = np.meshgrid(np.arange(n + 1), np.arange(m + 1), indexing="ij")
    number = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (
        q.ravel()
        for q in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    facets = np.concatenate(
        [np.stack([a, b, c, c], axis=1), np.stack([a, c, d, d], axis=1)]
    )
    return (u + moved[0]) / n, (v + moved[1]) / m, facets


def condyle(n: int) -> fc.SurfaceMesh:
    """Bone of the condyle, facing down; the axis of flexion is the x axis, extension at
    angle 0.
    """
    u, v, facets = irregular(2 * n, n, 1)
    turn, lean = np.radians(-35.0 + 155.0 * u), np.radians(-42.0 + 84.0 * v)
    tube = FRONTAL - THICKNESS
    radius = SAGITTAL - FRONTAL + tube * np.cos(lean)
    points = np.stack(
        [tube * np.sin(lean), -radius * np.sin(turn), -radius * np.cos(turn)], axis=-1
    )
    return fc.SurfaceMesh(points.reshape(-1, 3), facets).flipped()


def plateau(n: int) -> fc.SurfaceMesh:
    """Bone of the tibia, facing up."""
    u, v, facets = irregular(round(1.44 * n), round(1.36 * n), 2)
    x, y = 36.0 * u - 18.0, 40.0 * v - 20.0
    return fc.SurfaceMesh(
        np.stack([x, y, x**2 / 120 + y**2 / 240], axis=-1).reshape(-1, 3), facets
    )


def gait(poses: int) -> tuple[np.ndarray, list[fc.Pose], np.ndarray]:
    """Shares of the cycle, poses of the femur on the tibia, and forces on it."""
    share = np.linspace(0.0, 1.0, poses, endpoint=False)
    flexion = 7.5 * (1 - np.cos(4 * np.pi * share)) + 45.0 * np.exp(
        -(((share - 0.72) / 0.12) ** 2)
    )
    humps = np.exp(-(((share - 0.13) / 0.08) ** 2)) + 1.15 * np.exp(
        -(((share - 0.45) / 0.09) ** 2)
    )
    rotation = 4.0 * np.sin(2 * np.pi * share)
    turned = [
        fc.GroodSuntay(flexion=a, adduction=1.0, external_rotation=c).femur.rotation
        for a, c in zip(flexion, rotation, strict=True)
    ]
    forces = np.outer(100.0 + 400.0 * humps, (0.0, 0.0, -1.0))
    return share, [fc.Pose(turn, (0.0, 0.0, HEIGHT)) for turn in turned], forces


def main(
    n: int = 25, poses: int = 20, out: str | Path = "out", processes: int = 1
) -> CaseTable:
    folder = Path(out)
    joint = fc.Joint(
        condyle(n),
        plateau(n),
        THICKNESS,
        CARTILAGE,
        units=("mm", "N", "MPa"),
        names=("femur", "tibia"),
    )
    print(*(body.describe() for body in joint.bodies), sep="\n")
    share, path, forces = gait(poses)
    folder.mkdir(parents=True, exist_ok=True)
    table = joint.follow(
        path,
        forces,
        free="x y",
        times=share,
        path=folder / "gait.jsonl",
        maps=folder / "gait",
        processes=processes,
    )
    print(table)
    table.save(folder / "gait.csv")
    for warning in sorted(w for w in table.warnings if "strained" in w)[-1:]:
        print(warning)
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument(
        "--processes", type=int, default=1, help="poses solved at the same time"
    )
    main(processes=parser.parse_args().processes)
