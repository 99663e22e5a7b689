"""A tribologist's first picture: the pressure of a rough ball on a coated surface, and
its stress in the coating.

Run: python examples/coated_rough.py
"""

from pathlib import Path

import fecontact as fc

# mm, N, MPa
STEEL, COATING = fc.Material(E=210e3, nu=0.3), fc.Material(E=400e3, nu=0.22)


def main(n: int = 256, out: str | Path = "out") -> fc.HalfSpaceContact:
    half = fc.HalfSpace(
        STEEL,
        size=(0.6, 0.6),
        cells=(n, n),
        layers=[fc.Layer(COATING, thickness=0.005)],
    )
    roughness = fc.surfaces.self_affine(
        (n, n),
        (0.6, 0.6),
        hurst=0.8,
        rms_height=5e-5,
        longest=0.1,
        shortest=0.02,
        seed=2,
    )
    # or your own, np.load("measured.npy")
    ball = fc.Sphere(10.0).heights(half.grid.x[:, None], half.grid.y)
    contact = half.press(ball + roughness.z, force=100.0)
    print(contact)
    found = contact.stress([[0.0, 0.0, -0.0049], [0.0, 0.0, -0.0051]])
    print(
        f"stress along the surface: {found[0, 0]:.0f} MPa in the coating, "
        f"{found[1, 0]:.0f} MPa in the steel below"
    )
    Path(out).mkdir(parents=True, exist_ok=True)
    contact.plot(Path(out) / "coated_rough.png", units=("mm", "N", "MPa"))
    return contact


if __name__ == "__main__":
    main()
