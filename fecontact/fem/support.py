"""Supports: which degrees of freedom are held, which rigid motions are left, and where to ground the rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from fecontact.errors import InputError
from fecontact.mesh.mesh import Mesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def check_supports(mesh: Mesh, supports: Mapping[str, str]) -> None:
    """Refuse unknown boundaries and components.

    Raises
    ------
    InputError
    """
    for name, components in supports.items():
        mesh.boundary_nodes(name)
        if not isinstance(components, str) or not components or set(components) - set("xyz"):
            raise InputError(
                f"The support of {name!r} must name components out of 'x', 'y', 'z', such as 'xyz' or 'z'; "
                f"found {components!r}."
            )


def held_dofs(mesh: Mesh, supports: Mapping[str, str]) -> IntArray:
    """Degrees of freedom (3 * node + component) held by supports such as ``{"base": "xyz", "sym_x": "x"}``."""
    held = [
        3 * mesh.boundary_nodes(name) + "xyz".index(component)
        for name, components in supports.items()
        for component in components
    ]
    return np.unique(np.concatenate(held)) if held else np.zeros(0, dtype=np.int64)


def grounding(modes: Array, held: IntArray, length: float) -> IntArray:
    """As many degrees of freedom as there are free motions, well placed to ground a body artificially.

    Loads that are in equilibrium put no reaction on them, whichever they are (Elangovan 1978, section IV.3), so they
    only have to be far apart: pivoted QR picks the rows of the modes that span the largest volume.

    Parameters
    ----------
    modes : (3 n, k) array
        Displacement fields of the free motions.
    held : int array
        Degrees of freedom that supports hold already.
    length : float
        Size of the body, by which rotations are scaled.
    """
    if modes.shape[1] == 0:
        return np.zeros(0, dtype=np.int64)
    candidates = np.setdiff1d(np.arange(len(modes)), held)
    scaled = modes[candidates] / np.linalg.norm(modes, axis=0)
    _, _, pivots = scipy.linalg.qr(scaled.T, mode="economic", pivoting=True)
    return np.sort(candidates[pivots[: modes.shape[1]]])
