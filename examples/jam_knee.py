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

    smith2019.osim                             models/knee_healthy/smith2019
    walking.h5                                 matlab/analysis/test/jam_analysis/data/0
    smith2019-R-{femur,tibia}-cartilage.stl    models/knee_healthy/smith2019/Geometry
    smith2019-R-{femur,tibia}-bone.stl         the same

The same surfaces as binary files, turned by 1.5 degrees about y, for which --turned 1.5
is given, are lenhart2015/Geometry/lenhart2015-R-*.stl of
github.com/mbblomquist/opensim-jam-tutorial; name them as above.

Run: python examples/jam_knee.py FOLDER             (needs h5py, matplotlib and gmsh)
     python examples/jam_knee.py FOLDER --turned 1.5 --cartilage solid --every 10
"""

import argparse
from pathlib import Path

import numpy as np

import fecontact as fc

CONTACT = "smith2019/forceset/Smith2018ArticularContactForce/tf_contact/tibia_cartilage"
AXES = {"lateral": (0, 0, 1), "anterior": (1, 0, 0)}
KNEE = {"scale": 1000.0, "units": ("mm", "N", "MPa"), "axes": AXES}


def main(folder, every=1, size=2.0, turned=0.0, cartilage="foundation", out="out"):
    folder, out = Path(folder), Path(out) / "jam_knee"
    out.mkdir(parents=True, exist_ok=True)
    results = fc.read_motion(folder / "walking.h5")
    results = results.at(results.times[::every])
    theirs = np.linalg.norm(results.vector(f"{CONTACT}/total_contact_force"), axis=1)
    model = fc.read_osim(folder / "smith2019.osim")
    poses = model.poses("femur_distal_r", "tibia_proximal_r", results, scale=1000.0)
    turn = fc.rotation_about((0, 1, 0), np.radians(-turned))
    given = {"size": size, "turned": turn, "foundation": cartilage == "foundation"}
    joint = model.joint("femur_cartilage", "tibia_cartilage", folder, **given, **KNEE)
    more = {"force of JAM": theirs}
    table = joint.follow(poses, times=results.times, parameters=more, keep="pressure")
    ours = table.column("force") / theirs
    print(table, f"Force over JAM's: {ours.min():.3f} to {ours.max():.3f}", sep="\n")
    table.save(out / f"{cartilage}.csv")
    table.plot("force", "force of JAM", over="time", path=out / f"{cartilage}.png")
    table.montage(path=out / f"{cartilage}_maps.png", cases=6)
    table.animate(out / f"{cartilage}.gif")
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("folder", help="with the files named in this script")
    for name, default in {"every": 1, "turned": 0.0, "cartilage": "foundation"}.items():
        parser.add_argument(f"--{name}", type=type(default), default=default)
    main(**vars(parser.parse_args()))
