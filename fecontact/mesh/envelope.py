"""Tetrahedra within any surface: holes, crossing and branching facets included.

fTetWild (Hu, Schneider, Wang, Zorin and Panozzo (2020), *Fast tetrahedral meshing in the wild*, ACM Trans. Graph. 39,
117) divides a box along the facets, keeps the tetrahedra round which they wind by more than one half, and makes these
larger and better as long as their outer faces stay within an envelope of the facets. It draws at random: another run
gives other cells.
"""

from __future__ import annotations

import importlib.util
from contextlib import chdir
from dataclasses import replace
from tempfile import TemporaryDirectory

import numpy as np

from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import MeshError
from fecontact.mesh.build import build
from fecontact.mesh.facets import components
from fecontact.mesh.formats.raw import RawMesh
from fecontact.mesh.gmsh import DEFAULT_DIVISIONS, run_in_subprocess, smooth_pieces
from fecontact.mesh.mesh import Mesh

#: AMIPS energy of the worst cell (3 for a regular one) at which improvement ends.
ENERGY = 20.0
#: Volume of a part over that of the largest, below which it is left out.
CRUMB = 1e-3
#: What to do where the package is missing.
INSTALL = "With the package pytetwild (pip install 'fecontact[solids]') such surfaces are meshed too."


def available() -> bool:
    """Whether the package pytetwild is installed."""
    return importlib.util.find_spec("pytetwild") is not None


def tetrahedra_in_envelope(points: Array, triangles: IntArray, size: float | None, width: float, source: str) -> Mesh:
    """Linear tetrahedra whose outer faces lie near triangles (n, 3), which need enclose nothing exactly.

    Parameters
    ----------
    points : (n_points, 3) array
    triangles : (n, 3) int array
    size : float, optional
        Largest edge length that is wanted; smaller cells come where the surface asks for them.
    width : float
        Half the width of the envelope over the diagonal of the surface's box.
    source : str
        Name of the surface, for messages.

    Returns
    -------
    Mesh
        Boundaries 'surface_1', ..., between edges sharper than 40 degrees, and element sets 'volume_1', ..., its
        solids, each from the largest. A note says what was left out.

    Raises
    ------
    MeshError
        If nothing is enclosed, or the process crashes.
    """
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    share = 1 / DEFAULT_DIVISIONS if size is None else size / diagonal
    what = f"fTetWild, which was to mesh {source},"
    middle = points.mean(axis=0)
    x, cells = run_in_subprocess(what, _divided, (points - middle) / diagonal, triangles, min(share, 1.0), width)
    if len(cells) == 0:
        raise MeshError(f"{source} encloses no solid: its facets wind round no place by more than one half.")
    solid = _solids(cells)
    edges = x[cells[:, 1:]] - x[cells[:, :1]]
    volume = np.bincount(solid, np.abs(np.linalg.det(edges)))
    kept = np.flatnonzero(volume > CRUMB * volume.max())
    kept = kept[np.argsort(-volume[kept], kind="stable")]
    notes: tuple[str, ...] = ()
    if len(kept) < len(volume):
        notes = (f"{source}: {len(volume) - len(kept)} parts of less than {CRUMB:g} of the largest were left out.",)
    used = np.isin(solid, kept)
    groups = {f"volume_{k + 1}": np.flatnonzero(solid[used] == number) for k, number in enumerate(kept)}
    mesh = build(RawMesh(diagonal * x + middle, [("tet4", cells[used])], groups), source)
    skin = mesh.skin[:, :3]
    part = smooth_pieces(mesh.points, skin)
    names = {f"surface_{k + 1}": mesh.outer[part == k] for k in range(part.max() + 1)}
    return replace(mesh, boundaries=names, notes=(*mesh.notes, *notes))


def _divided(points: Array, triangles: IntArray, share: float, width: float) -> tuple[Array, IntArray]:
    """Points and tetrahedra (n, 4), in a process that ends with it."""
    import pytetwild

    # it leaves a file in the current folder
    with TemporaryDirectory() as folder, chdir(folder):
        x, cells = pytetwild.tetrahedralize(
            points,
            np.ascontiguousarray(triangles, dtype=np.int32),
            edge_length_fac=share,
            epsilon=width,
            stop_energy=ENERGY,
            num_threads=1,
        )
    # its cells are left-handed
    return np.asarray(x, dtype=float), np.asarray(cells, dtype=np.int64).reshape(-1, 4)[:, [0, 2, 1, 3]]


def _solids(cells: IntArray) -> IntArray:
    """Number (n,) of the solid of each of tetrahedra (n, 4), which are joined by faces."""
    faces = cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3)
    key = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order][1:] == key[order][:-1])
    return components(len(cells), np.stack([order[same], order[same + 1]], axis=1) // 4)
