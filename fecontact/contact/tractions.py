"""Pressures and tractions on boundaries: a number or vector, a function of position, or values at the nodes.

Values at the nodes are interpolated by the functions of the faces, as the loads of the source report (Elangovan 1978,
appendix B: intensities at the nodes of a face, in three directions).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.protocol import Body
from fecontact.common.arrays import Array
from fecontact.common.checks import array_of, finite, vector
from fecontact.common.errors import InputError, shown
from fecontact.contact.dimension import Dimension

#: What a user gives for an intensity over a boundary.
Distribution = ArrayLike | Callable[[Array], ArrayLike]


def pressed(body: Body, name: str, given: Distribution) -> Array:
    """Nodal forces (n_dofs,) of a pressure against a boundary.

    Parameters
    ----------
    body : Body
    name : str
        The boundary.
    given : float, callable or (n_nodes,) array
        Pressure; as a function of points (n, 3) in the body's axes, of n values; or at the boundary's nodes, in the
        order of ``mesh.boundary_nodes(name)``.

    Raises
    ------
    InputError
        For values that are not finite or not as many.
    """
    what = f"The pressure on {name!r} of {body.name!r}"
    numbers = None if callable(given) else array_of(given)
    if not callable(given) and (numbers is None or numbers.ndim == 0):
        constant = finite(what, cast(float, given))
        return body.boundary_traction(name, lambda x, n: -constant * n)
    p = _intensity(what, body, name, given, ())
    return body.boundary_traction(name, lambda x, n: -p(x)[:, None] * n)


def pulled(body: Body, name: str, given: Distribution, setting: Dimension) -> Array:
    """Nodal forces (n_dofs,) of a traction (3,) in world axes, a function of position or nodal values (n_nodes, 3)."""
    what = f"The traction on {name!r} of {body.name!r}"
    rotation = body.pose.rotation
    numbers = None if callable(given) else array_of(given)
    if numbers is not None and numbers.ndim == 1:
        constant = vector(what, numbers)
        setting.check_traction(constant, what)
        return body.boundary_traction(name, lambda x, n: np.broadcast_to(constant @ rotation, x.shape))
    t = _intensity(what, body, name, given, (3,))

    def field(x: Array, n: Array) -> Array:
        values = t(x)
        # the largest along each axis: a section has no forces across it
        setting.check_traction(np.abs(values).max(axis=0), what)
        return values @ rotation

    return body.boundary_traction(name, field)


def _intensity(
    what: str, body: Body, name: str, given: Distribution, shape: tuple[int, ...]
) -> Callable[[Array], Array]:
    """Checked values (n, *shape) at points."""
    if callable(given):

        def field(x: Array) -> Array:
            return _checked(f"{what}, a function of points {x.shape},", given(x), (len(x), *shape))

        return field
    return body.over_boundary(name, _checked(f"{what}, given by nodes,", given, (body.count_nodes(name), *shape)))


def _checked(what: str, given: Distribution, shape: tuple[int, ...]) -> Array:
    values = array_of(given)
    if values is None:
        raise InputError(f"{what} must be numbers {shape}; found {shown(given)}.")
    if values.shape != shape:
        raise InputError(f"{what} must have the shape {shape}; found {values.shape}.")
    if not np.isfinite(values).all():
        raise InputError(f"{what} must be finite; {(~np.isfinite(values)).sum()} of its values are not.")
    return values


def refuse_nodal_values(
    pressures: Mapping[tuple[Body, str], Distribution] | None, tractions: Mapping[tuple[Body, str], Distribution] | None
) -> None:
    """Refuse distributions that are bound to the nodes of meshes which will be divided.

    Raises
    ------
    InputError
        With the boundary.
    """
    for loads, constant in ((pressures, 0), (tractions, 1)):
        for (body, name), value in (loads or {}).items():
            if not callable(value) and np.ndim(value) > constant:
                raise InputError(
                    f"The load on {name!r} of {body.name!r} is given at the nodes of its mesh, which accuracy= "
                    "divides; give it as a function of position."
                )
