"""Changes of points and poses by a few units of rounding, under which every geometric decision must stay the same.

Tests marked `rounding` run as they are and again under `--rounding N` such changes (2 unless given; `make rounding`
gives 30), each with its own random numbers: every mesh, surface and pair of surfaces that a test makes, and the
polynomials of every facet, are moved by some units in the last place of their largest number, as another processor's
arithmetic does. Tolerances stay, so a test fails where rounding decides.
"""

import numpy as np

from fecontact import Mesh
from fecontact.contact.coupling.nodal import SurfacePair
from fecontact.surfaces.closest_point import FacetPolynomials
from fecontact.surfaces.facet_surface import FacetSurface

# units in the last place of the largest number: those of another order of a few sums
UNITS = 4
MOVED = {Mesh: ["points"], FacetSurface: ["points"], FacetPolynomials: ["coefficients"]}
MOVED[SurfacePair] = ["rotation", "translation"]


def moved(rng, x):
    """An array moved by some units in the last place of its largest number."""
    return x + UNITS * np.finfo(float).eps * np.abs(x).max(initial=0.0) * rng.uniform(-1.0, 1.0, x.shape)


def change_by_rounding(monkeypatch, seed):
    """Move the coordinates of all that is made from now on."""
    rng = np.random.default_rng(seed)
    for made, names in MOVED.items():

        def init(self, *args, plain=made.__init__, names=names, **kwargs):
            plain(self, *args, **kwargs)
            hanging = getattr(self, "hanging", None)
            for name in names:
                changed = moved(rng, getattr(self, name))
                # hanging nodes follow the others; facets apart have no others
                follows = hanging is not None and hanging.n_points == len(changed)
                object.__setattr__(self, name, hanging.followed(changed) if follows else changed)

        monkeypatch.setattr(made, "__init__", init)
