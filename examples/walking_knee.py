"""A biomechanics researcher's first picture: STL surfaces of two bones and a motion
file become maps of a gait cycle.

The surfaces are those of `knee.py` as triangles; angles, and the force on the tibia,
are made up like those of walking. The femur turns as the file says, is pressed down,
and finds its place and its tilt (varus, valgus) on both plateaus.

Run: python examples/walking_knee.py
"""

from pathlib import Path

import numpy as np

import fecontact as fc

HERE = Path(__file__).parent
# copied, they lie beside this script
MESHES = HERE.parent / "meshes" if (HERE.parent / "meshes").is_dir() else HERE
CARTILAGE = fc.Material(E=10.0, nu=0.45)  # MPa; mm and N throughout


def main(poses: int = 6, out: str | Path = "out") -> fc.CaseTable:
    # under the cartilage
    femur, tibia = (
        fc.read_surface(MESHES / name) for name in ("femur.stl", "tibia.stl")
    )
    axes = {"lateral": (1, 0, 0), "anterior": (0, 1, 0)}
    names = {"units": ("mm", "N", "MPa"), "names": ("femur", "tibia"), "axes": axes}
    middle = fc.DividingPlane((0, 0, 0), (1, 0, 0), sides=("lateral", "medial"))
    joint = fc.Joint(femur, tibia, thickness=2.0, material=CARTILAGE, **names)
    motion = fc.read_motion(HERE / "walk.mot")
    motion = motion.at(np.linspace(motion.times[0], motion.times[-1], poses))
    angles = zip(
        motion.angle("-knee_angle_r"), motion.angle("knee_rotation_r"), strict=True
    )
    turns = [
        fc.GroodSuntay(flexion=a, external_rotation=b).femur.rotation for a, b in angles
    ]
    # about where the cartilage touches
    path = [fc.Pose(turn, (0.0, 0.0, 31.6)) for turn in turns]
    forces = np.outer(motion.column("knee_force_r"), (0.0, 0.0, -1.0))
    folder = Path(out) / "walking_knee"
    folder.parent.mkdir(parents=True, exist_ok=True)
    table = joint.follow(
        path,
        forces,
        at=(0, 0, 0),
        free="x y z ry",
        times=motion.times,
        maps=folder,
        split=middle,
    )
    print(table)
    table.save(folder / "table.csv")
    table.plot(over="time", path=folder / "table.png")
    return table


if __name__ == "__main__":
    main()
