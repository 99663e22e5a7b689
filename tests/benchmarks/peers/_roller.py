"""What the adapters of the rubber roller share: the problem, and a grid of points in half its section.

A rubber roller of radii 17.5 and 35 and width 28 on a rigid core, in plane strain, is pressed by 8 on a rigid floor,
46 % of its rubber. Neo-Hookean law of E = 0.275 and nu = 0.475; without friction. The right half is meshed.

The force converges to 256.09 in quadrilaterals of 8 and of 9 nodes of this package (256.105 in 24 x 96 of each,
256.094 in 48 x 192); felupe's of 4 nodes, with the gap closed to 4e-5, tend to 256.10 (256.79 in 32 x 64, 256.27 in
64 x 128 cells of the whole).
"""

from __future__ import annotations

import numpy as np

INNER, OUTER, WIDTH = 17.5, 35.0, 28.0
E, NU = 0.275, 0.475
DEPTH, FORCE = 8.0, 256.09
#: Cells become narrower towards the tread and towards the middle of the contact, as powers of this.
GRADING = 1.3


def place(s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points x, z by parameters from 0 to 1 through the rubber and around it; the tread's lowest line is (1, 0)."""
    radius = INNER + (OUTER - INNER) * (1 - (1 - s) ** GRADING)
    angle = np.pi * (t**GRADING - 0.5)
    return radius * np.cos(angle), radius * np.sin(angle)
