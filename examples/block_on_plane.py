"""Any two bodies: a rubber block pressed and tilted on a rigid plane until one edge
lifts.

Run: python examples/block_on_plane.py
"""

from pathlib import Path

import fecontact as fc


def main(n: int = 6, out: str | Path = "out") -> fc.ContactResult:
    rubber = fc.Material(E=2.0, nu=0.45)  # MPa, mm, N
    mesh = fc.shapes.block((20.0, 20.0, 10.0), (n, n, max(2, n // 2)))
    block = fc.ElasticBody(
        mesh, rubber, contact="bottom", supports={"top": "xyz"}, name="block"
    )
    floor = fc.RigidBody(fc.Plane(), name="floor")
    scene = fc.Scene(
        [block, floor], [fc.Contact(block, floor)], units=("mm", "N", "MPa")
    )

    # the steel plate bonded to the block's top is pushed down off its centre, free to
    # sink and to tilt about y
    result = scene.solve(forces={block: (0, 0, -5.0)}, moments={block: (0, 30.0, 0)})
    print(result)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    result.plot("pressure", folder / "block_on_plane.png")
    return result


if __name__ == "__main__":
    main()
