"""An unbonded beam on a half-space, lifted off beyond a contact length that does not
depend on the load.

A bar is pressed in its middle. Rectangles of uniform pressure across its width take
Love's displacement, the bar bends as Bernoulli's, and the complementarity problem finds
where it lifts off, in one solution. H. D. Conway & K. A. Farnham, Int. J. Mech. Sci. 12
(1970), cited by Elangovan's report, take the same rectangles and raise the contact
length step by step; their tables were not at hand, so that the figures here are checked
by such steps with elements for the beam.

Run: python examples/beam_on_half_space.py
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import fecontact as fc
from fecontact.analytic import rectangle
from fecontact.common.files import save_figure
from fecontact.solvers import ContactProblem, solve

HALF, SIDE = 20.0, 1.0  # half the length and the square section of the bar, cm
SOFT = fc.Material(E=1.0, nu=0.3)  # the half-space; stresses in units of its modulus
FORCE = 1e-3
RATIOS = (10.0, 100.0, 1000.0, 10000.0)  # of the moduli


@dataclass(frozen=True)
class Rest:
    """A bar at rest on the half-space.

    Attributes
    ----------
    x : (n,) array
        Middles of the rectangles of one half.
    forces : (n,) array
    approach : float
        Of the bar's middle.
    """

    x: np.ndarray
    forces: np.ndarray
    approach: float

    @property
    def contact(self) -> float:
        """Half the contact length, in whole rectangles."""
        width, last = 2 * self.x[0], int(np.flatnonzero(self.forces)[-1])
        return float(self.x[last] + width / 2)


def settlement(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Middles (n,) of the rectangles of one half, and their displacements (n, n) by
    unit forces on both halves.
    """
    step = HALF / n
    x = (np.arange(n) + 0.5) * step
    unit = 1 / (step * SIDE)
    both = [
        rectangle.surface_displacement(
            x[:, None] - side * x,
            0.0,
            half_sides=(step / 2, SIDE / 2),
            pressure=unit,
            modulus=SOFT.plane_strain_modulus,
        )
        for side in (1, -1)
    ]
    return x, both[0] + both[1]


def press(ratio: float, n: int = 160, force: float = FORCE) -> Rest:
    """A bar `ratio` times as stiff as the half-space; forces F lift it by x^2 (3 X - x)
    / (6 EI), x < X.
    """
    x, sunk = settlement(n)
    near, far = np.minimum(x[:, None], x), np.maximum(x[:, None], x)
    bent = near**2 * (3 * far - near) / (6 * ratio * SOFT.E * SIDE**4 / 12)
    problem = ContactProblem(
        sunk + bent, np.zeros(n), np.ones((1, n)), np.array([force / 2])
    )
    forces = solve(problem).forces
    first = int(np.flatnonzero(forces)[0])
    return Rest(x, forces, float((sunk + bent)[first] @ forces))


def main(
    ratios: tuple[float, ...] = RATIOS, n: int = 160, out: Path | str = "out"
) -> dict[float, Rest]:
    """Contact lengths for some ratios of moduli, and pressures along the bar."""
    found = {ratio: press(ratio, n) for ratio in ratios}
    print(
        "modulus of the bar / half-space   contact length / side   approach x side E "
        "/ force"
    )
    for ratio, rest in found.items():
        print(
            f"{ratio:>31.0f}{2 * rest.contact / SIDE:>24.2f}"
            f"{rest.approach * SIDE * SOFT.E / FORCE:>28.4f}"
        )
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for ratio, rest in found.items():
        pressure = rest.forces / (2 * rest.x[0] * SIDE)
        axes.plot(rest.x / SIDE, pressure * SIDE**2 / FORCE, label=f"{ratio:.0f}")
    axes.set_xlabel("distance from the force / side of the bar")
    axes.set_ylabel("pressure x side² / force")
    axes.set_xlim(0, 1.3 * max(rest.contact for rest in found.values()) / SIDE)
    axes.legend(title="modulus, bar / half-space")
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(figure, folder / "beam_on_half_space.png")
    return found


if __name__ == "__main__":
    main()
