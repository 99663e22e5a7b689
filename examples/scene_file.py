"""A scene in a TOML file, solved from Python: the same as `fecontact solve
examples/ball_on_block.toml --out out`.

Run: python examples/scene_file.py
"""

from pathlib import Path

import fecontact as fc

SCENE = Path(__file__).with_name("ball_on_block.toml")


def main(out: str | Path = "out") -> fc.ContactResult:
    Path(out).mkdir(parents=True, exist_ok=True)
    # all faults of the file are told together, before anything is solved
    file = fc.read_scene(SCENE, out=out)
    result = file.solve()
    print(result)
    near, far = result.contacts[0].split_by_plane(point=(0, 0, 0), normal=(1, 0, 0))
    print(f"force at x > 0: {near.force[2]:.3f} N, at x < 0: {far.force[2]:.3f} N")
    held = result.reaction(file.bodies["block"])
    print(f"the block is held by {held[2]:.3f} N and {held[4]:.3f} N mm about y")
    for path in file.write(result):
        print(f"wrote {path}")
    return result


if __name__ == "__main__":
    main()
