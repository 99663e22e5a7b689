"""A rough ball on a thin rubber block: every asperity on a body of finite size, beside
the half-space.

The block, 16 mm wide and 2 mm thick, is bonded to a rigid plate. Its mesh is too coarse
for any asperity: it gives what the plate and the sides change; the half-space's kernel
gives the rest, on 512 x 512 cells of a window of 4 mm.

Run: python examples/rough_block.py
"""

import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.common.files import save_figure

RUBBER = fc.Material(E=5.0, nu=0.45)  # mm, N, MPa
RADIUS, FORCE, WINDOW = 40.0, 0.8, 4.0
WIDTH, THICKNESS = 16.0, 2.0


def rough_ball(n: int) -> np.ndarray:
    """Heights (n, n) of a paraboloid with a self-affine roughness, over the window."""
    roughness = fc.surfaces.self_affine(
        (n, n), (WINDOW, WINDOW), hurst=0.8, rms_slope=0.05, longest=1.0, seed=3
    )
    x = (np.arange(n) + 0.5) * WINDOW / n - WINDOW / 2
    return roughness.z + (x[:, None] ** 2 + x**2) / (2 * RADIUS)


def main(n: int = 512, out: str | Path = "out") -> dict[str, float]:
    heights = rough_ball(n)
    start = time.process_time()
    mesh = fc.shapes.block((WIDTH, WIDTH, THICKNESS), (16, 16, 4))
    block = fc.ElasticBody(mesh, RUBBER, supports={"bottom": "xyz"}, name="block")
    middle = (WIDTH / 2, WIDTH / 2, THICKNESS)
    local = fc.LocalBody(block, at=middle, window=WINDOW, cells=(n, n))
    defect = local.remainder.defect
    modelled = time.process_time() - start
    ball = fc.RigidBody(
        fc.surfaces.HeightMap(heights, (WINDOW, WINDOW)),
        pose=fc.Pose(translation=middle),
        name="ball",
    )
    scene = fc.Scene([local, ball], [fc.Contact(local, ball)])
    start = time.process_time()
    result = scene.solve(forces={ball: (0.0, 0.0, -FORCE)}, finite_motion=False)
    solved = time.process_time() - start
    pressure = result.contacts[0].pressure.reshape(n, n)
    approach = float(-result.rigid_motion(ball).translation[2])
    area = float((pressure > 0).mean()) * WINDOW**2

    alone = fc.HalfSpace(RUBBER, size=(WINDOW, WINDOW), cells=(n, n)).press(
        heights, force=FORCE
    )
    touched = float(alone.active.mean()) * WINDOW**2
    print(
        f"block of {block.n_dofs} dofs: model {modelled:.1f} s, contact on {n} x {n} "
        f"cells {solved:.1f} s (processor)"
    )
    print(f"approach {approach:.4f} mm; of a half-space {alone.approach:.4f} mm")
    print(f"area in contact {area:.3f} mm2; on a half-space {touched:.3f} mm2")
    print(f"Betti defect {100 * defect:.2f} %, residual {result.residuals().worst:.1e}")
    _draw((pressure, alone.pressure), ("block", "half-space"), Path(out))
    return {
        "approach": approach,
        "area": area,
        "half-space": float(alone.approach),
        "defect": defect,
    }


def _draw(
    pressures: tuple[np.ndarray, ...], titles: tuple[str, ...], folder: Path
) -> None:
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    most = max(float(np.quantile(p[p > 0], 0.99)) for p in pressures)
    for axes, field, title in zip(
        figure.subplots(1, 2), pressures, titles, strict=True
    ):
        drawn = axes.imshow(
            field.T,
            origin="lower",
            cmap="inferno_r",
            vmax=most,
            extent=(0, WINDOW, 0, WINDOW),
        )
        axes.set_title(f"{title}, largest {field.max():.2g} MPa")
        axes.set(xlabel="x [mm]", ylabel="y [mm]")
    figure.colorbar(drawn, ax=figure.axes, label="pressure [MPa]", extend="max")
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder / "rough_block.png")


if __name__ == "__main__":
    main()
