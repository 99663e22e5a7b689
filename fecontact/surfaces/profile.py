"""Profiles: cross-sections of wheels and rails, smooth curves through points read from a file.

References
----------
E. A. H. Vollebregt, User guide for CONTACT, 2023, on profiles of wheels and rails: files of Simpack and MiniProf.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import scipy

from fecontact.common.arguments import file_path
from fecontact.common.arrays import Array
from fecontact.common.checks import among, check_magnitude, finite, positive
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError

#: Kinds of files by their suffix.
READABLE = (".prr", ".prw", ".ban", ".whl", ".csv")
#: Least distance of neighbouring points, relative to their median one; closer ones are left out.
CLOSEST = 0.01
#: Points along the curve at which it is sampled.
SAMPLES = 6001
#: Least cosine of the angle between a tangent and an axis over which the curve is a graph.
LEAST_COSINE = 0.3

_NUMBER = re.compile(r"^\s*[-+.\d]")


@compact_repr
@dataclass(frozen=True, eq=False)
class Profile:
    """Cross-section of a wheel or of a rail: a cubic spline through points, over the length of their chords.

    Parameters
    ----------
    points : (n, 2) array
        Distances y towards the field side, away from the middle of the track, and heights z, upwards, along the curve.
        Of a wheel y = z = 0 is where its radius is the nominal one; the flange is at negative y.
    smoothing : float
        Root mean square distance by which the curve may miss the points: zero goes through all of them.

    Attributes
    ----------
    left_out : int
        Points left out, as they are next to the one before.
    deviation : float
        Root mean square distance of the points from the curve.

    Raises
    ------
    InputError
        If the points are no curve of at least four.

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.linspace(-0.3, 0.3, 41)
    >>> crown = Profile(np.stack([300 * np.sin(angle), 300 * np.cos(angle) - 300], axis=1))
    >>> float(crown.height(30.0).round(4))
    -1.5038
    """

    points: Array
    smoothing: float = 0.0

    def __post_init__(self) -> None:
        points = np.asarray(self.points, dtype=float)
        if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 4 or not np.isfinite(points).all():
            raise InputError(
                f"A profile needs at least four finite points (n, 2); found shape {points.shape}.", code="wrong-shape"
            )
        check_magnitude("the points of a profile", points)
        if finite("the smoothing of a profile", self.smoothing) < 0:
            raise InputError(f"The smoothing of a profile must not be negative; found {self.smoothing:g}.")
        points = points if points[-1, 0] > points[0, 0] else points[::-1]
        steps = np.hypot(*np.diff(points, axis=0).T)
        kept = np.concatenate([[True], steps > CLOSEST * np.median(steps)])
        if kept.sum() < 4:
            raise InputError("A profile needs at least four points apart from each other.", code="wrong-shape")
        object.__setattr__(self, "points", points[kept])
        object.__setattr__(self, "left_out", int((~kept).sum()))

    left_out = 0

    @cached_property
    def _chords(self) -> Array:
        return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.points, axis=0).T))])

    @cached_property
    def _spline(self) -> scipy.interpolate.BSpline:
        scale = np.abs(self.points).max()
        (t, c, k), _ = scipy.interpolate.splprep(
            self.points.T / scale, u=self._chords, s=len(self.points) * (self.smoothing / scale) ** 2, k=3
        )
        return scipy.interpolate.BSpline(t, scale * np.transpose(c), k)

    @property
    def deviation(self) -> float:
        """Root mean square distance of the points from the curve."""
        return float(np.sqrt(((self._spline(self._chords) - self.points) ** 2).sum(axis=1).mean()))

    @cached_property
    def samples(self) -> tuple[Array, Array]:
        """Points (n, 2) along the curve and its unit tangents there."""
        along = np.linspace(0.0, self._chords[-1], SAMPLES)
        tangent = self._spline(along, 1)
        return self._spline(along), tangent / np.hypot(*tangent.T)[:, None]

    @cached_property
    def _seen(self) -> tuple[Array, Array, Array]:
        """Distances y, heights and angles of the samples that are seen from above."""
        (y, z), (dy, dz) = (a.T for a in self.samples)
        seen = np.concatenate([[True], y[1:] > np.maximum.accumulate(y)[:-1]]) & (dy > 0)
        return y[seen], z[seen], np.arctan2(dz, dy)[seen]

    def height(self, y: Array | float) -> Array:
        """Height at y of what is seen from above; not a number beyond it."""
        return np.asarray(np.interp(y, self._seen[0], self._seen[1], left=np.nan, right=np.nan))

    def angle(self, y: Array | float) -> Array:
        """Angle of the tangent there, in radians."""
        return np.asarray(np.interp(y, self._seen[0], self._seen[2], left=np.nan, right=np.nan))

    def gauge_face(self, below: float) -> float:
        """Distance y of the inner side of a rail at a depth below its top.

        Raises
        ------
        InputError
            If the profile does not reach so far down.
        """
        y, z = self.samples[0].T
        top = int(z.argmax())
        if z[: top + 1].min() > z[top] - below:
            raise InputError(
                f"The rail's profile ends {z[top] - z[: top + 1].min():.3g} below its top on the inner side, above "
                f"where the gauge is measured ({below:g}). Give rail_position= instead of a gauge.",
                code="gauge-face",
            )
        first = np.flatnonzero(z[: top + 1] <= z[top] - below)[-1]
        return float(np.interp(z[top] - below, z[first : first + 2], y[first : first + 2]))

    def graph(self, y: float, angle: float) -> scipy.interpolate.CubicHermiteSpline:
        """The curve near a y over axes turned by an angle: -y sin + z cos over y cos + z sin, in radians."""
        points, tangents = self.samples
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        leaning = tangents @ axes[0]
        flat = leaning > LEAST_COSINE
        middle = int(np.where(flat, np.abs(points[:, 0] - y), np.inf).argmin())
        steep = np.flatnonzero(np.concatenate([[True], ~flat, [True]])) - 1
        at = int(np.searchsorted(steep, middle))
        part = slice(steep[at - 1] + 1, steep[at])
        u, v = (points[part] @ axes.T).T
        return scipy.interpolate.CubicHermiteSpline(u, v, (tangents[part] @ axes[1]) / leaning[part], extrapolate=False)

    def turned(self, angle: float) -> Profile:
        """The profile turned about its origin, counter-clockwise with y to the right and z upwards, in radians."""
        c, s = np.cos(angle), np.sin(angle)
        return Profile(self.points @ np.array([[c, s], [-s, c]]), self.smoothing)


def read_profile(
    path: str | Path, *, unit: float = 1e-3, mirror: bool = False, smoothing: float = 0.0, kind: str | None = None
) -> Profile:
    r"""Read the profile of a wheel or a rail; the suffix decides.

    ==================  =============================================================================================
    ``.prr``, ``.prw``  Simpack: its keys are obeyed; heights in the file point down, y towards the field side
    ``.ban``, ``.whl``  MiniProf, in mm: columns X and Y; what is farthest from the median height is taken as below
    ``.csv``            columns y, z in mm, heights upwards
    ==================  =============================================================================================

    Parameters
    ----------
    path : str or Path
    unit : float
        The unit of length of what is returned, in metres: millimetres unless given.
    mirror : bool
        Change the sign of y, of profiles with the flange, or the gauge face, at positive y.
    smoothing : float
        As of `Profile`.
    kind : str, optional
        The format, as a suffix, for files with another one.

    Raises
    ------
    InputError
        For an unknown suffix, a missing file, contents that do not fit, or keys that are not offered.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "cone.csv"
    ...     _ = file.write_text("-2,0.1\n-1,0.05\n0,0\n1,-0.05\n")
    ...     read_profile(file).points[0].tolist()
    [-2.0, 0.1]
    """
    file = file_path("the path of a profile", path)
    suffix = (kind or file.suffix).lower()
    among("suffix of a profile", suffix, READABLE)
    positive("the unit of length in metres", unit)
    if not file.is_file():
        raise InputError(f"There is no file {str(file)!r}.", code="no-file")
    try:
        lines = file.read_text(encoding="latin-1").splitlines()
        points = _simpack(lines) if suffix in (".prr", ".prw") else _columns(lines, suffix)
    except (ValueError, OSError) as error:
        raise InputError(f"{file.name!r} is not a readable {suffix} profile: {error}", code="unreadable") from error
    if mirror:
        points = points * [-1, 1]
    return Profile(points / unit, smoothing)


def _rows(lines: list[str], comment: str) -> Array:
    """The first two columns (n, 2) of lines that begin with a number."""
    kept = [line.split(comment)[0].replace(",", " ").replace(";", " ").split() for line in lines]
    kept = [words for words in kept if words and _NUMBER.match(words[0])]
    if short := [words for words in kept if len(words) < 2]:
        raise ValueError(f"a point needs two numbers, found {short[0][0]!r} alone")
    if len(kept) < 4:
        raise ValueError(f"found {len(kept)} points; a profile needs at least four")
    return np.array([words[:2] for words in kept], dtype=float)


def _columns(lines: list[str], suffix: str) -> Array:
    """Points (n, 2) in metres of MiniProf, whose Y may point down, or of CSV."""
    start = max((i + 1 for i, line in enumerate(lines) if "=" in line.split('"')[0]), default=0)
    points = 1e-3 * _rows(lines[start:], '"' if suffix != ".csv" else "#")
    far = points[:, 1] - np.median(points[:, 1])
    down = suffix != ".csv" and far[np.abs(far).argmax()] > 0
    return points * [1, -1] if down else points


def _simpack(lines: list[str]) -> Array:
    """Points (n, 2) in metres, heights upwards, with what the keys ask for, in the order of their numbers."""
    text = [line.split("!")[0].strip() for line in lines]
    keys = dict(re.split(r"\s*=\s*", line, maxsplit=1) for line in text if "=" in line)
    places = [i for i, line in enumerate(text) if line.lower() in ("point.begin", "point.end")]
    if len(places) != 2:
        raise ValueError("it has no point.begin and point.end")

    def key(name: str, default: float) -> float:
        return float(keys.get(name, default))

    if "units.len.f" not in keys or key("units.len.f", 0) <= 0:
        raise ValueError("units.len.f, lengths of the file in a metre, is missing or not positive")
    for name in ("rotate", "point.dist.min", "approx.smooth"):
        if key(name, 0):
            raise ValueError(f"{name} = {keys[name]} is not offered: set it to 0, and turn, thin or smooth here")
    points = _rows(text[places[0] + 1 : places[1]], "!") + np.array([key("shift.y", 0), key("shift.z", 0)])
    for column, name in enumerate("yz"):
        low, high = key(f"bound.{name}.min", 1), key(f"bound.{name}.max", 0)
        if high > low:
            points = points[(points[:, column] >= low) & (points[:, column] <= high)]
    signs = np.array([-1.0 if key("mirror.y", 0) else 1.0, 1.0 if key("mirror.z", 0) else -1.0])
    return points * signs / key("units.len.f", 1)
