"""A ball and a rough surface on an elastic half-space: matrix-free, in seconds, against
Hertz.

Run: python examples/half_space.py
"""

import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.common.files import save_figure

STEEL = fc.Material(E=210e3, nu=0.3)
UNITS = ("mm", "N", "MPa")


def main(n: int = 256, out: str | Path = "out") -> dict[str, float]:
    exact = fc.hertz.spheres((10.0, np.inf), (None, STEEL), force=100.0)
    half = fc.HalfSpace(STEEL, size=(3 * exact.a, 3 * exact.a), cells=(n, n))
    start = time.perf_counter()
    ball = half.press(fc.Sphere(radius=10.0), force=100.0)
    seconds = time.perf_counter() - start
    target = exact.pressure(np.hypot(ball.grid.x[:, None], ball.grid.y[None, :]))
    error = float(np.linalg.norm(ball.pressure - target) / np.linalg.norm(target))
    print(
        f"ball on {n} x {n} cells: {seconds:.2f} s, pressure L2 error "
        f"{100 * error:.2f} %, approach {ball.approach:.6g}"
    )
    print(ball)

    rough = fc.surfaces.self_affine(
        (n, n), size=(1.0, 1.0), hurst=0.8, rms_slope=0.05, seed=1
    )
    sheet = fc.HalfSpace(STEEL, size=(1.0, 1.0), cells=(n, n), periodic=True)
    squeezed = sheet.press(rough.z, force=0.02 * STEEL.plane_strain_modulus * 0.05)
    share = float(squeezed.active.mean())
    print(f"rough surface: {100 * share:.1f} % of the area in contact")

    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    ball.plot(units=UNITS, ax=left)
    left.set_title(f"ball, {ball.force:g} N")
    squeezed.plot(units=UNITS, ax=right)
    right.set_title(
        f"rough surface: {100 * share:.1f} % in contact,\nlargest "
        f"{squeezed.max_pressure:.0f} MPa"
    )
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder / "half_space.png")
    return {"error": error, "share": share}


if __name__ == "__main__":
    main()
