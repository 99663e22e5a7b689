"""Equilibrium of bodies at finite strain, as Newton's method found it, and as forces at the nodes tell it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fecontact.bodies.elastic import elastic_among
from fecontact.common.arrays import Array
from fecontact.contact.condensed_problem import BodyBlock

#: Largest force inside a body that counts as none, over its size and its largest stiffness.
REST = 1e-9


@dataclass(frozen=True)
class Equilibrium:
    """How a load step at finite strain ended.

    Attributes
    ----------
    iterations : int
    change : float
        Largest displacement of the last iteration, relative to the size of the bodies.
    residual : float
        Largest force on a node that is not balanced, relative to the largest force inside.
    unstable : str
        Of an equilibrium that is not stable: the body and the motion, in words.
    """

    iterations: int
    change: float
    residual: float
    unstable: str = ""


def unbalanced(part: BodyBlock, forces: Array, inner: Array | None) -> float:
    """Largest force on a node that is not balanced, relative to the largest inside; zero of bodies without nodes.

    Parameters
    ----------
    part : BodyBlock
    forces : (n,) array
        Of the problem.
    inner : (n_dofs,) array, optional
        Forces inside the body.
    """
    if inner is None:
        return 0.0
    (body,) = elastic_among([part.body])
    given = part.rows.T @ forces[part.index] + part.external
    rest = body.model.solved_forces((given if part.hold is None else part.hold.balanced(given)) - inner)
    unstrained = REST * body.size * float(body.model.stiffness.diagonal().max())
    return float(np.abs(rest).max(initial=0.0)) / max(float(np.abs(inner).max()), unstrained)
