"""A shrink fit: a steel tyre on an aluminium hub with an interference, against Lame's
pressure.

An interference is nothing but a negative initial gap; there is no load and nothing to
iterate.

Run: python examples/shrink_fit.py
"""

from pathlib import Path

import numpy as np

import fecontact as fc
from fecontact.analytic import cylinder

HUB = fc.Material(E=70e3, nu=0.33)  # mm, N, MPa
TYRE = fc.Material(E=210e3, nu=0.3)
BORE, SEAT, RIM, INTERFERENCE = 20.0, 30.0, 45.0, 0.03


def main(n: int = 6, out: str | Path = "out") -> float:
    held = {"sym_x": "x", "sym_y": "y", "bottom": "z", "top": "z"}  # plane strain
    inner = fc.shapes.thick_ring(BORE, SEAT + INTERFERENCE / 2, 5.0, (n, n // 2, 1))
    outer = fc.shapes.thick_ring(SEAT - INTERFERENCE / 2, RIM, 5.0, (n, n // 2 + 1, 1))
    hub = fc.ElasticBody(inner, HUB, contact="outer", supports=held, name="hub")
    tyre = fc.ElasticBody(outer, TYRE, contact="inner", supports=held, name="tyre")
    result = fc.Scene(
        [hub, tyre], [fc.Contact(hub, tyre)], units=("mm", "N", "MPa")
    ).solve()
    print(result)

    lame = cylinder.shrink_fit(
        radii=(BORE, SEAT, RIM),
        materials=(HUB, TYRE),
        interference=INTERFERENCE,
        plane="strain",
    )
    pressure = result.contacts[0].pressure
    error = float(pressure.mean() / lame.pressure - 1)
    print(
        f"\npressure {pressure.mean():.4f} MPa, Lame {lame.pressure:.4f} MPa, error "
        f"{100 * error:+.2f} %"
    )
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    result.save(folder / "shrink_fit.vtu")
    result.plot("von_mises", folder / "shrink_fit.png", view="z")
    hoop = np.abs(result.stress(tyre)[:, :2]).max()
    print(
        f"largest in-plane stress in the tyre {hoop:.1f} MPa; bodies in "
        f"{folder / 'shrink_fit.vtu'}"
    )
    return error


if __name__ == "__main__":
    main()
