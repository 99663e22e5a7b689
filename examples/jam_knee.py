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

import numpy as np

import fecontact as fc

BONES, WHAT = ("femur", "tibia"), ("cartilage", "bone")
CONTACT = "smith2019/forceset/Smith2018ArticularContactForce/tf_contact/tibia_cartilage"
KNEE = {"surfaces": "cartilage", "material": fc.Material(E=5.0, nu=0.45)}
KNEE |= {"names": BONES, "units": ("mm", "N", "MPa"), "anatomy": "opensim"}
KNEE |= {"axes": {"lateral": (0, 0, 1), "anterior": (1, 0, 0)}}
KNEE |= {"least": (1.0, 2.0)}  # where the bone is nearer: <min_thickness>


def main(folder, every=1, size=2.0, turned=0.0, cartilage="foundation", out="out"):
    folder, out = Path(folder), Path(out) / "jam_knee"
    out.mkdir(parents=True, exist_ok=True)
    results = fc.read_motion(folder / "walking.h5")
    results = results.at(results.times[::every])
    theirs = np.linalg.norm(results.vector(f"{CONTACT}/total_contact_force"), axis=1)
    model = fc.read_osim(folder / "smith2019.osim")
    poses = model.poses("femur_distal_r", "tibia_proximal_r", results, scale=1000.0)
    turn, found = fc.rotation_about((0, 1, 0), np.radians(turned)), {}
    for what, bone in ((what, bone) for what in WHAT for bone in BONES):
        (path,) = folder.glob(f"*-R-{bone}-{what}.stl")
        facets = size if what == "cartilage" else None
        surface = fc.repair_surface(path, size=facets, scale=1000.0)
        found.setdefault(what, []).append(surface.mapped(lambda x: x @ turn))
    given = {"thickness": tuple(found["bone"]), "foundation": cartilage == "foundation"}
    joint = fc.Joint(*found["cartilage"], **given, **KNEE)
    more = {"parameters": {"force of JAM": theirs}, "keep": "pressure"}
    table = joint.follow(poses, times=results.times, **more)
    ours = table.column("force") / theirs
    print(table, f"Force over JAM's: {ours.min():.3f} to {ours.max():.3f}", sep="\n")
    table.save(out / f"{cartilage}.csv")
    shown = "force", "force of JAM", "max_pressure"
    table.plot(*shown, over="time", path=out / f"{cartilage}.png")
    table.montage(path=out / f"{cartilage}_maps.png", cases=6)
    table.animate(out / f"{cartilage}.gif")
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("folder", help="with the files named in this script")
    given = {"--every": 1, "--turned": 0.0, "--cartilage": "foundation"}
    for name, default in given.items():
        parser.add_argument(name, type=type(default), default=default)
    main(**vars(parser.parse_args()))
