"""A published knee beside OpenSim-JAM: 101 poses of walking, contact forces of its
results file, maps, an animation.

The knee is that of Lenhart et al. (2015, Ann. Biomed. Eng. 43, 2675) in the model
smith2019 of OpenSim-JAM, whose results file of walking holds joint coordinates and
contact forces. The femur is put in each pose, and the force of the cartilage on the
tibia is compared with JAM's. JAM's cartilage is an elastic foundation: each point gives
by its own pressure, with the modulus of a layer that cannot strain sideways.
`foundation` is that; `solid` is cartilage as a solid of the same E and nu, whose layers
bulge sideways where the contact is only a few times as wide as they are thick.

Files, of github.com/opensim-jam-org/jam-resources (version 73306a0) unless another
place is told, in one folder:

    smith2019.osim                    models/knee_healthy/smith2019
    walking.h5                        matlab/analysis/test/jam_analysis/data/0
    *-R-{femur,tibia}-cartilage.stl   models/knee_healthy/lenhart2015/Geometry
    *-R-{femur,tibia}-bone.stl        the same

Bones as binary files, turned by 1.5 degrees about y, for which --turned 1.5 is given,
are in lenhart2015/Geometry of github.com/mbblomquist/opensim-jam-tutorial.

Run: python examples/jam_knee.py FOLDER             (needs h5py, matplotlib and gmsh)
     python examples/jam_knee.py FOLDER --turned 1.5 --cartilage solid --every 10
"""

import argparse
from pathlib import Path

import h5py
import numpy as np

import fecontact as fc

CARTILAGE = fc.Material(E=5.0, nu=0.45)  # MPa; mm and N throughout
# thickness where the bone is nearer, of the model's <min_thickness>
LEAST = {"femur": 1.0, "tibia": 2.0}
COORDINATES = tuple(
    f"knee_{name}_r" for name in ("flex", "add", "rot", "tx", "ty", "tz")
)
CONTACT = "smith2019/forceset/Smith2018ArticularContactForce/tf_contact"
FORCE = f"{CONTACT}/tibia_cartilage/total_contact_force"
KNEE = {
    "surfaces": "cartilage",
    "material": CARTILAGE,
    "anatomy": "opensim",
    "units": ("mm", "N", "MPa"),
}
AXES = {"lateral": (0, 0, 1), "anterior": (1, 0, 0)}


def main(
    folder, every=1, size=2.0, turned=0.0, cartilage="foundation", out="out"
) -> fc.CaseTable:
    out, turn = Path(out) / "jam_knee", fc.rotation_about((0, 1, 0), np.radians(turned))
    out.mkdir(parents=True, exist_ok=True)
    with h5py.File(Path(folder) / "walking.h5") as file:
        values = [
            file[f"smith2019/coordinateset/{name}/value"][::every]
            for name in COORDINATES
        ]
        motion = fc.Motion(
            file["time"][::every],
            COORDINATES,
            np.stack(values, axis=1),
            in_degrees=True,
        )
        theirs = np.linalg.norm(file[FORCE][::every], axis=1)
    model = fc.read_osim(Path(folder) / "smith2019.osim")
    poses = model.poses("femur_distal_r", "tibia_proximal_r", motion, scale=1000.0)
    free, thick = {}, []
    for bone, least in LEAST.items():
        for what, facets in (("cartilage", size), ("bone", None)):
            (file,) = Path(folder).glob(f"*-R-{bone}-{what}.stl")
            free[what] = fc.repair_surface(file, size=facets, scale=1000.0).mapped(
                lambda x: x @ turn
            )
        free[bone] = free["cartilage"]
        thick.append(
            fc.thickness_between(free[bone].flipped(), free["bone"].flipped(), least)
        )
    given = {
        "thickness": tuple(thick),
        "foundation": cartilage == "foundation",
        "names": tuple(LEAST),
        "axes": AXES,
    }
    joint = fc.Joint(free["femur"], free["tibia"], **KNEE, **given)
    table = joint.follow(
        poses, times=motion.times, parameters={"force of JAM": theirs}, keep="pressure"
    )
    ours = table.column("force") / theirs
    print(table, f"Force over JAM's: {ours.min():.3f} to {ours.max():.3f}", sep="\n")
    table.save(out / f"{cartilage}.csv")
    table.plot(
        "force",
        "force of JAM",
        "max_pressure",
        over="time",
        path=out / f"{cartilage}.png",
    )
    shown = np.linspace(0, len(poses) - 1, min(6, len(poses))).astype(int)
    table.montage(path=out / f"{cartilage}_maps.png", cases=shown.tolist())
    table.animate(out / f"{cartilage}.gif")
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("folder", help="with the files named in this script")
    parser.add_argument("--every", type=int, default=1, help="take every so many poses")
    parser.add_argument(
        "--turned",
        type=float,
        default=0.0,
        help="degrees by which the surfaces are turned about y",
    )
    parser.add_argument(
        "--cartilage", choices=["foundation", "solid"], default="foundation"
    )
    main(**vars(parser.parse_args()))
