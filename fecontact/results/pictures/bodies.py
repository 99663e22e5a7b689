"""Pictures of bodies: deformed shape with stress, displacement or contact pressure on the outer faces, or on a section.

Files are drawn without a screen by `mesh.picture` and matplotlib; windows need pyvista.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fecontact.common.arguments import flag, items, known_options, label, text
from fecontact.common.arrays import Array, IntArray
from fecontact.common.checks import among, finite, vector, whole
from fecontact.common.errors import InputError, optional
from fecontact.common.errors import shown as shown_value
from fecontact.common.files import check_writable, save_figure
from fecontact.common.units import UnitNames, Units
from fecontact.contact.model import SceneModel
from fecontact.mesh.picture import PIXELS, Camera, draw_facets, framed, plot_faces, subdivided
from fecontact.results.pictures.solids import (
    COMPONENTS,
    Solid,
    chosen,
    meshed_among,
    rigid_patch,
    rigid_patches,
    solids_of_result,
)

if TYPE_CHECKING:
    from fecontact.results.result import ContactResult

#: Fields of every result; vectors and tensors also by component.
FIELDS = (
    "von_mises",
    "contact_pressure",
    "displacement",
    *(f"displacement_{c}" for c in COMPONENTS[3]),
    *(f"stress_{c}" for c in COMPONENTS[6]),
)
#: Colour maps: fields of one sign from light to dark, so that shading is visible; of two signs about white.
TABLES = {"displacement": "YlGnBu"}
ONE_SIGN, TWO_SIGNS = "YlOrRd", "RdBu_r"
#: Largest displacement drawn with scale='auto', relative to the size of all bodies; what counts as the same factor.
AUTO, ROUNDING = 0.05, 1e-9
#: Ends of a scale beyond which there are values, by whether some are below and above it.
EXTEND = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
#: Divisions per side of a curved face for pyvista, which draws flat faces only.
SUBDIVISION = 6
#: Pixels along a side of a drawing.
MIN_PIXELS, MAX_PIXELS = 16, 20_000


def plot_solids(
    solids: Sequence[Solid],
    field: str = "von_mises",
    path: str | Path | None = None,
    *,
    scale: float | str = 1.0,
    view: str | tuple[float, float] = "iso",
    bodies: Sequence[str] | None = None,
    cut: str | None = None,
    limits: tuple[float, float] | None = None,
    edges: bool = True,
    units: UnitNames = (),
    length: str = "",
    title: str | None = None,
    pixels: tuple[int, int] | None = None,
    rigid: tuple[Array, IntArray] | None = None,
) -> Figure:
    """Draw bodies with a field on their outer faces.

    Parameters
    ----------
    solids : sequence of Solid
    field : str
        Field, such as 'von_mises', 'contact_pressure', 'displacement', 'displacement_z', 'stress_xx'.
    path : str or Path, optional
        File to write; the suffix decides the format.
    scale : float or 'auto'
        Factor of the displacements; 0 shows the bodies undeformed. 'auto': a round one, at least one, by which the
        largest is about `AUTO` of the size of all bodies.
    view : str or (azimuth, elevation) in degrees
        Direction of view, see `renderer.VIEWS`; along y for sections unless given.
    bodies : sequence of str, optional
        Names of the bodies to show.
    cut : str, optional
        Part to keep of a cut, for instance ``"y>0"``.
    limits : (low, high), optional
        Range of the colours; that of the values shown unless given.
    edges : bool
        Whether to draw the mesh.
    units : (length, force) or (length, force, stress), or str
        Names for labels; a text is that of the field.
    length : str
        Unit of length beside a text.
    title : str, optional
    pixels : (width, height)
        Largest size of the drawing; `PIXELS` unless given.
    rigid : (points, quadrilaterals), optional
        Rigid surfaces, drawn translucent.

    Raises
    ------
    InputError
        For an unknown field, body or direction, or a path that cannot be written.
    """
    if path is not None:
        check_writable(path)
    flag("edges", edges)
    label("title", "" if title is None else title)
    named, names = _labelled(field, units, length)
    size = PIXELS if pixels is None else _size(pixels)
    shown = chosen(solids, bodies, cut)
    scale = _factor(shown, scale)
    points, facets, values = _skin(shown, field, scale)
    seen = values[np.unique(facets)]
    table, limits = _colours(field, seen, limits)
    beyond = EXTEND[
        seen.min() < limits[0] - ROUNDING * np.ptp(limits), seen.max() > limits[1] + ROUNDING * np.ptp(limits)
    ]
    flat = isinstance(view, str) and view == "iso" and all(s.mesh.is_flat for s in shown)
    camera = Camera.looking("-y" if flat else view)
    image = draw_facets(
        points,
        facets,
        values,
        lambda v: table(np.interp(v, limits, (0.0, 1.0)))[:, :3],
        camera,
        size,
        edges,
        closed=True,
        veil=rigid,
    )
    shades = ScalarMappable(Normalize(*limits), table), named
    figure, _ = framed(
        image, camera, title if title is not None else _title(shown, scale), names.length, shades, beyond
    )
    return save_figure(figure, path)


def plot_bodies(
    result: ContactResult, field: str = "von_mises", path: str | Path | None = None, **options: Any
) -> Figure:
    """Draw the elastic bodies of a result, and the rigid surfaces near their contacts; options as in `plot_solids`.

    Units are those of the scene unless given. Rigid surfaces are left out of cuts and of pictures of chosen bodies.

    Examples
    --------
    >>> import fecontact as fc
    >>> mesh = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
    >>> body = fc.ElasticBody(mesh, fc.Material(E=1.0, nu=0.3), contact="bottom", supports={"top": "xyz"})
    >>> floor = fc.RigidBody(fc.Plane())
    >>> result = fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}})
    >>> figure = plot_bodies(result, "displacement_z", scale=10, units="mm")
    >>> figure.axes[1].get_ylabel()
    'displacement z [mm]'
    """
    _, names = _labelled(field, options.pop("units", ()), options.pop("length", ""))
    options["units"] = names.with_defaults(result.unit_names)
    whole = options.get("bodies") is None and options.get("cut") is None
    solids = solids_of_result(result)
    factor = _factor(solids, options.get("scale", 1.0))
    rigid = rigid_patches(result, factor) if whole else None
    return plot_solids(solids, field, path, rigid=rigid, **{**options, "scale": factor})


def plot_scene(
    scene: SceneModel,
    path: str | Path | None = None,
    *,
    view: str | tuple[float, float] = "iso",
    edges: bool = True,
    units: UnitNames = (),
    length: str = "",
) -> Figure:
    """Draw the bodies of a scene as given, their contact surfaces in colours, and translucent what has no mesh.

    Parameters
    ----------
    scene : SceneModel
    path, view, edges, units, length
        As for `mesh.picture.plot_faces`; units of the scene unless given.

    Raises
    ------
    InputError
        If no body has a mesh, for an unknown direction, or a file that cannot be written.
    """
    meshed = meshed_among(scene.bodies)
    if not meshed:
        raise InputError("No body of this scene has a mesh: there is nothing to draw.", code="nothing-to-draw")
    points = [b.pose.to_world(b.mesh.points) for b in meshed]
    solids = [
        Solid(b.name, b.mesh.drawn_at(x), {"body": np.zeros(len(x))}) for b, x in zip(meshed, points, strict=True)
    ]
    x, facets, _ = _skin(solids, "body", 0.0)
    first = np.cumsum([0, *(len(b.mesh.skin) for b in meshed)])
    flat = all(b.mesh.is_flat for b in meshed)
    surfaces = (
        {}
        if flat
        else {
            f"{b.name}.{name}": start + np.flatnonzero(np.isin(b.mesh.outer @ (6, 1), b.mesh.faces(name) @ (6, 1)))
            for b, start in zip(meshed, first, strict=False)
            for name in b.contact
            if name in b.mesh.boundaries
        }
    )
    title = f"{len(scene.bodies)} bodies, {len(scene.contacts)} contact{'' if len(scene.contacts) == 1 else 's'}"
    unit = Units.labels(units, "length", length=length).with_defaults(scene.unit_names)
    return plot_faces(
        x, facets, surfaces, path, title, view="-y" if flat and view == "iso" else view, edges=edges, units=unit,
        closed=not flat, veil=None if flat else _others(scene),
    )  # fmt: skip


def _others(scene: SceneModel) -> tuple[Array, IntArray] | None:
    """Surfaces without a mesh, near the meshes that they may touch."""
    points, quads, start = [], [], 0
    for contact in scene.contacts:
        for own, other in ((0, 1), (1, 0)):
            partner, names = contact.bodies[other], contact.surfaces
            if names is None or meshed_among([partner]):
                continue
            for body in meshed_among([contact.bodies[own]]):
                nodes = body.pose.to_world(body.mesh.points[body.mesh.boundary_nodes(names[own])])
                gap = partner.surface(names[other]).project(partner.pose.to_body(nodes)).gap
                x, q = rigid_patch(partner, names[other], nodes[[int(np.argmin(gap))]], nodes)
                points.append(x)
                quads.append(q + start)
                start += len(x)
    return (np.concatenate(points), np.concatenate(quads)) if points else None


def _size(pixels: tuple[int, int]) -> tuple[int, int]:
    """Width and height of a drawing, checked."""
    two = items("pixels", pixels, "two whole numbers")
    if len(two) != 2:
        raise InputError(f"Pixels must be a width and a height; found {shown_value(pixels)}.", code="pixels")
    width, height = (whole("each of pixels", n, least=MIN_PIXELS, most=MAX_PIXELS) for n in two)
    return width, height


def _skin(solids: Sequence[Solid], field: str, scale: float) -> tuple[Array, IntArray, Array]:
    """Points, facets (counter-clockwise seen from outside) and nodal values of all bodies together."""
    points, facets, values = [], [], []
    start = 0
    for solid in solids:
        points.append(solid.deformed(scale))
        values.append(solid.scalar(field))
        facets.append(start + _outwards(solid.mesh.points, solid.mesh.skin))
        start += len(solid.mesh.points)
    widest = max(f.shape[1] for f in facets)
    if any(f.shape[1] != widest for f in facets):
        facets = [f[:, :4] for f in facets]
    return np.concatenate(points), np.concatenate(facets), np.concatenate(values)


def _factor(solids: Sequence[Solid], scale: float | str) -> float:
    """Factor of the displacements: as given, or a round one by which they are seen."""
    if not isinstance(scale, str):
        return finite("the scale", scale)
    among("scale", scale, ("auto",))
    points = np.concatenate([s.mesh.points for s in solids])
    moved = np.concatenate([s.deformed(1.0) for s in solids]) - points
    largest = float(np.linalg.norm(moved, axis=1).max(initial=0.0))
    wanted = AUTO * float(np.linalg.norm(np.ptp(points, axis=0))) / largest if largest > 0 else 1.0
    decade = 10.0 ** np.floor(np.log10(wanted))
    return max(1.0, float(max(f * decade for f in (1.0, 2.0, 5.0) if f * decade <= wanted * (1 + ROUNDING))))


def _outwards(points: Array, faces: IntArray) -> IntArray:
    """Faces of a closed surface, reversed if they enclose a negative volume, as for mirrored cells."""
    corners = points[faces[:, :4]] - points[faces[0, 0]]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    if np.einsum("fi,fi->", corners.mean(axis=1), normals) >= 0:
        return faces
    return faces[:, [1, 0, 3, 2, 4, 7, 6, 5, 8][: faces.shape[1]]]


def _colours(field: str, values: Array, limits: tuple[float, float] | None) -> tuple[Any, tuple[float, float]]:
    """Colour map and its limits for the values shown."""
    low, high = (values.min(), values.max()) if limits is None else vector("limits", limits, 2)
    signed = field.rpartition("_")[2] in (*COMPONENTS[3], *COMPONENTS[6])
    if signed and limits is None:
        high = max(abs(low), abs(high))
        low = -high
    elif not signed and limits is None:
        low = min(low, 0.0)
    if not high > low:
        high = low + 1.0
    return colormaps[TWO_SIGNS if signed else TABLES.get(field, ONE_SIGN)], (float(low), float(high))


def _label(field: str) -> str:
    return {"von_mises": "von Mises stress"}.get(field, field.replace("_", " "))


def _title(solids: Sequence[Solid], scale: float) -> str:
    names = list(dict.fromkeys(s.name for s in solids))
    bodies = f"{'body' if len(names) == 1 else 'bodies'} {', '.join(names)}"
    if scale == 0 or not any("displacement" in s.fields for s in solids):
        return f"{bodies}, undeformed"
    return f"{bodies}, deformed" if scale == 1 else f"{bodies}, displacements × {scale:g}"


def show(
    solids: Sequence[Solid],
    field: str = "von_mises",
    path: str | Path | None = None,
    *,
    scale: float | str = 1.0,
    view: str | tuple[float, float] = "iso",
    bodies: Sequence[str] | None = None,
    cut: str | None = None,
    limits: tuple[float, float] | None = None,
    units: UnitNames = (),
) -> None:
    """Show bodies in an interactive window of pyvista, or write its picture to a file.

    Options as in `plot_solids`.

    Raises
    ------
    MissingPackageError
        If pyvista is not installed.
    InputError
        As `plot_solids`.
    """
    pyvista = optional("pyvista", "Showing bodies on the screen, unlike pictures in files,", "'fecontact[view]'")
    if path is not None:
        check_writable(path)
    shown = chosen(solids, bodies, cut)
    points, facets, values = _skin(shown, field, _factor(shown, scale))
    table, limits = _colours(field, values[np.unique(facets)], limits)
    fine, quads = subdivided(np.column_stack([points, values]), facets, SUBDIVISION)
    faces = np.column_stack([np.full(len(quads), 4), quads]).ravel()
    label, _ = _labelled(field, units)
    camera = Camera.looking(view)
    plotter = pyvista.Plotter(off_screen=path is not None, window_size=PIXELS)
    plotter.set_background("white")
    plotter.add_mesh(
        pyvista.PolyData(fine[:, :3].copy(), faces),
        scalars=fine[:, 3].copy(),
        cmap=table,
        clim=limits,
        ambient=0.5,
        scalar_bar_args={"title": label, "vertical": True, "color": "black"},
    )
    plotter.add_axes(color="black")
    plotter.enable_parallel_projection()
    plotter.view_vector(camera.axes[2], camera.axes[1])
    plotter.show(screenshot=None if path is None else str(path))


def show_result(
    result: ContactResult, field: str = "von_mises", path: str | Path | None = None, **options: Any
) -> None:
    """Show the elastic bodies of a result; options as in `show`."""
    among("field", text("the field", field), FIELDS)
    known_options(show, options)
    _, names = _labelled(field, options.pop("units", ()))
    show(solids_of_result(result), field, path, units=names.with_defaults(result.unit_names), **options)


def _labelled(field: str, units: UnitNames, length: str = "") -> tuple[str, Units]:
    """Label of a field, and the names of units, of which a text is that of the field."""
    kind = "length" if field.startswith("displacement") else "stress"
    names = Units.labels(units, kind, length=length)
    return names.axis_label(_label(field), kind), names
