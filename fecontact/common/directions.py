"""Names of three directions at right angles, for the axes of maps: x, y, z, or given ones such as the anatomical."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.common.arguments import mapping, text
from fecontact.common.arrays import Array
from fecontact.common.checks import vector
from fecontact.common.errors import InputError

#: Largest cosine between two given directions that counts as a right angle: half a degree.
SQUARE = 0.01
#: Cosine from which on a direction has the name of an axis of the world: its coordinate is that of the world.
ALONG = 0.999
#: The same for a given name, which is that of a direction and not of a coordinate: 45 degrees.
TOWARDS = 0.7


@dataclass(frozen=True, eq=False)
class Directions:
    """Three directions at right angles with their names; by default the axes of the world.

    Attributes
    ----------
    names : tuple of str
    vectors : (3, 3) array
        A unit vector in each row, in world axes.
    given : bool
        Whether a user gave them.

    Examples
    --------
    >>> knee = Directions.of({"medial": (-1, 0, 0), "anterior": (0, 2, 0)})
    >>> knee.names, knee.vectors.tolist()
    (('medial', 'anterior', '-z'), [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
    """

    names: tuple[str, ...] = ("x", "y", "z")
    vectors: Array = field(default_factory=lambda: np.eye(3))
    given: bool = False

    @classmethod
    def of(cls, given: object) -> Directions:
        """Directions as users give them: a vector by each name.

        Parameters
        ----------
        given : mapping of str to (3,) array, or Directions
            Two or three directions at right angles, of any length; the third is normal to two. Without any, the axes
            of the world.

        Raises
        ------
        InputError
            For other numbers of directions, names that are no text, or directions that are not at right angles.
        """
        if isinstance(given, Directions):
            return given
        named = mapping("the axes", cast(Mapping[str, ArrayLike] | None, given))
        if not named:
            return WORLD
        names = [text("the name of an axis", name) for name in named]
        if len(named) not in (2, 3):
            raise InputError(f"The axes are two or three directions by name; found {len(named)}: {', '.join(names)}.")
        vectors = [vector(f"the axis {name!r}", named[name]) for name in names]
        if zero := [name for name, v in zip(names, vectors, strict=True) if not v.any()]:
            raise InputError(f"The axis {zero[0]!r} has no direction: its vector is zero.", code="axis-zero")
        rows = np.array([_unit(v) for v in vectors])
        cosines = np.abs(np.triu(rows @ rows.T, 1))
        if cosines.max() > SQUARE:
            i, j = np.unravel_index(cosines.argmax(), cosines.shape)
            angle = np.degrees(np.arccos(np.clip(rows[i] @ rows[j], -1.0, 1.0)))
            raise InputError(f"Axes are at right angles; {names[i]!r} and {names[j]!r} are at {angle:.3g} degrees.")
        if len(rows) == 2:
            rows = np.vstack([rows, _unit(np.cross(*rows))])
            names.append(WORLD.name(rows[2]))
        return cls(tuple(names), rows, True)

    def name(self, direction: Array) -> str:
        """Name of a unit vector: of the direction beside it, or its components in the world's axes."""
        cosines = self.vectors @ direction
        k = int(np.argmax(np.abs(cosines)))
        if abs(cosines[k]) < (TOWARDS if self.given else ALONG):
            return "({:.2f}, {:.2f}, {:.2f})".format(*np.round(direction, 2) + 0.0)
        return f"-{self.names[k]}" if cosines[k] < 0 else self.names[k]

    def beside(self, normal: Array, cosine: float) -> Array:
        """The direction, or its opposite, within an angle of a unit vector (3,); the vector itself if there is none."""
        cosines = self.vectors @ normal
        k = int(np.argmax(np.abs(cosines)))
        return self.vectors[k] * np.sign(cosines[k]) if abs(cosines[k]) >= cosine else normal

    def across(self, normal: Array) -> Array:
        """Two unit vectors (2, 3) that span the plane normal to a unit vector: the nearest directions, in order."""
        first, second = sorted(np.argsort(np.abs(self.vectors @ normal), kind="stable")[:2])
        u = _unit(self.vectors[first] - normal @ self.vectors[first] * normal)
        v = self.vectors[second] - normal @ self.vectors[second] * normal
        return np.stack([u, _unit(v - (v @ u) * u)])


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v))


WORLD = Directions()
