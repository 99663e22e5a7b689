"""Linear elastic materials of decks, *ELASTIC in all its types, and their axes, *ORIENTATION.

Source: Abaqus Keywords Reference and Dhondt, CalculiX CrunchiX User's Manual, *ELASTIC and *ORIENTATION. Stiffnesses
D_ijkl are given by the columns of the upper triangle, components in the order 11, 22, 33, 12, 13, 23.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from fecontact.common.anisotropic import AnisotropicMaterial, CylindricalAxes, OrthotropicMaterial
from fecontact.common.arrays import Array
from fecontact.common.errors import InputError
from fecontact.common.material import Material
from fecontact.fem.model import AnyMaterial
from fecontact.mesh.formats.abaqus_deck import KeywordSection, values_of

#: Places of the components 11, 22, 33, 12, 13, 23 in the order of `common.material.VOIGT`.
ORDER = np.array([0, 1, 2, 3, 5, 4])
#: Number of constants of each type; the temperature comes after them.
COUNTS = {"ISOTROPIC": 2, "ENGINEERING CONSTANTS": 9, "ORTHOTROPIC": 9, "ANISOTROPIC": 21}
#: Constants and a temperature that a line takes.
IN_LINE = 8


#: Coefficient of expansion, or those along axes.
Expansion: TypeAlias = float | tuple[float, float, float] | None


def linear_elastic(s: KeywordSection, density: float | None, expansion: Expansion) -> tuple[AnyMaterial, bool]:
    """Material of *ELASTIC at the first temperature, and whether there are others.

    Raises
    ------
    InputError
        For another type, too few constants, or those of no elastic material.

    Examples
    --------
    >>> given = KeywordSection("ELASTIC", {"TYPE": "ENGINEERING CONSTANTS"}, ["9,1,1,.3,.3,.3,2,2", "1"], "a.inp: 1")
    >>> linear_elastic(given, None, None)[0].E
    (9.0, 1.0, 1.0)
    """
    asked = s.parameters.get("TYPE", "ISOTROPIC").upper()
    kind = next((name for name in COUNTS if name.startswith(asked) and asked), "")
    c = [v for line in s.lines for v in values_of(line)]
    if not kind or len(c) < (n := COUNTS[kind]):
        known = ", ".join(f"{name} ({count} constants)" for name, count in COUNTS.items())
        raise InputError(
            f"{s.place}: expected *ELASTIC of a type {known}; found type {asked}, {len(c)} constants.", code="elastic"
        )
    try:
        return _made(kind, c[:n], density, expansion), len(s.lines) > -(-(n + 1) // IN_LINE)
    except InputError as error:
        raise InputError(f"{s.place}: {error}", code=error.code) from None


def _made(kind: str, c: Sequence[float], density: float | None, expansion: Expansion) -> AnyMaterial:
    if kind == "ISOTROPIC":
        if not isinstance(expansion, tuple):
            return Material(c[0], c[1], density, expansion)
        kind, c = "ENGINEERING CONSTANTS", [*[c[0]] * 3, *[c[1]] * 3, *[c[0] / (2 + 2 * c[1])] * 3]
    given: dict[str, Any] = {"density": density, "expansion": expansion}
    if kind == "ENGINEERING CONSTANTS":
        return OrthotropicMaterial((c[0], c[1], c[2]), (c[3], c[4], c[5]), (c[6], c[7], c[8]), **given)
    rows, columns = (np.array([i for j in range(6) for i in range(j + 1)]), np.repeat(np.arange(6), np.arange(1, 7)))
    if kind == "ORTHOTROPIC":
        kept = ((rows < 3) & (columns < 3)) | (rows == columns)
        rows, columns = rows[kept], columns[kept]
    C = np.zeros((6, 6))
    C[ORDER[rows], ORDER[columns]] = C[ORDER[columns], ORDER[rows]] = c
    return AnisotropicMaterial(C, **given)


def rectangular(a: Array, b: Array) -> Array | None:
    """Axes (3, 3), as rows, by a point on the first one and another in the plane of two; None of points in a line."""
    third = np.cross(a, b)
    axes = np.stack([a, np.cross(third, a), third])
    size = np.linalg.norm(axes, axis=1, keepdims=True)
    return axes / size if size.all() else None


def orientation(s: KeywordSection) -> Array | Callable[[Array], Array]:
    """Axes of *ORIENTATION: rectangular, turned about one of them, or cylindrical (radial, tangential, axial).

    Raises
    ------
    InputError
        For another system, or points that give no axes.
    """
    system, (first, *more) = s.parameters.get("SYSTEM", "RECTANGULAR").upper(), s.lines or [""]
    given = np.array(values_of(first)) if first else np.zeros(0)
    turn = [*values_of(more[0]), 0.0] if more else [1.0, 0.0]
    if "DEFINITION" not in s.parameters and len(given) == 6:
        a, b = given[:3], given[3:]
        if system.startswith("RECT") and (axes := rectangular(a, b)) is not None and turn[0] in (1, 2, 3):
            return np.asarray(axes @ Rotation.from_rotvec(np.radians(turn[1]) * axes[int(turn[0]) - 1]).as_matrix().T)
        if system.startswith("CYL") and (a != b).any() and turn[1] == 0:
            return CylindricalAxes(b - a, a)
    raise InputError(
        f"{s.place}: expected *ORIENTATION, SYSTEM=RECTANGULAR with two points that are not in a line with the origin, "
        f"and a line with an axis and an angle, or CYLINDRICAL with two points; found {system}, {s.lines}.",
        code="orientation",
    )
