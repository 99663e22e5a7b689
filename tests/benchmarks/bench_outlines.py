"""Outlines of contacts, their areas and recovered pressures against the truth; writes docs/generated/outlines.md.

python tests/benchmarks/bench_outlines.py
"""

import warnings
from dataclasses import replace
from pathlib import Path

import bench_accuracy
import estimate_cases
import numpy as np
from estimate_cases import CONTACT, FAMILIES, cut_by_gmsh, grid, on_rigid, parabola, raised, two_bodies
from matplotlib.figure import Figure
from references import layer_on_rigid_plane, pin_in_hole

import fecontact as fc
from fecontact.common.units import Units
from fecontact.results.facet_samples import facet_samples, hats
from fecontact.results.field_map import field_map
from fecontact.results.pictures.contact_map import draw_field, draw_outlines
from fecontact.results.pictures.map_projection import map_of
from fecontact.results.recovery import recovered_field
from fecontact.surfaces import Paraboloid

PAGE = Path(__file__).parents[2] / "docs" / "generated" / "outlines.md"
PICTURE = PAGE.parent / "images" / "outlines.png"
#: Faces a radius.
FACES = (2, 4, 8)
BALL = Paraboloid(estimate_cases.RADIUS)
MESHES = {
    "hex20 grid": lambda h: on_rigid(grid(h), BALL),
    "hex8 grid": lambda h: on_rigid(grid(h, "hex8"), BALL),
    "gmsh tet10": lambda h: on_rigid(cut_by_gmsh("tet10", "block", h), BALL),
    "gmsh hex20": lambda h: on_rigid(cut_by_gmsh("hex20", "block", h), BALL),
    "raised hex20 grid on a plane": lambda h: on_rigid(raised(grid(h), parabola), fc.Plane()),
    "gmsh hex20 ball on a plane": lambda h: on_rigid(cut_by_gmsh("hex20", "ball", h), fc.Plane()),
    "ellipse, hex20 grid": estimate_cases.ellipse,
    "punch with a rounded edge, hex20 grid": estimate_cases.rounded_punch,
    "two bodies, hex20 grids, mortar": lambda h: two_bodies(grid(h), grid(0.84 * h)),
}
#: Of two bodies with eight faces a radius the meshes are large.
LARGEST = {"two bodies, hex20 grids, mortar": 4}
STEEL = fc.Material(E=210e3, nu=0.3)


def end_of(places, pressure):
    """Where the square of a tabulated pressure falls to zero."""
    last = np.flatnonzero(pressure > 0)[-2:]
    (x1, x2), (s1, s2) = places[last], pressure[last] ** 2
    return x2 + (x2 - x1) * s2 / (s1 - s2)


#: Families with a true area of their own.
OTHERS = {
    "receding layer": lambda: 0.2 * end_of(*layer_on_rigid_plane(1.0, 1.0, 0.25, 1.0, n=200)),
    "pin in a hole": lambda: 10.0 * end_of(*pin_in_hole(10.0, 0.01, 0.02, (4.0, STEEL), (30.0, STEEL), n=200)),
    "cylinder, section": lambda: CONTACT,
}
HEAD = "| mesh | faces a radius | area by points | by squares | outline | pressure | its squares | recovered |"


def true_area(contact, exact):
    """Area on which the true pressure is positive, from fine samples of the facets."""
    x, _, areas = contact.sampled(contact.pressure, 48)
    return float(areas[exact(x) > 0].sum())


def row(name, size, result, exact, true=None):
    contact = result.contacts[0]
    true, mortar = true or true_area(contact, exact), contact.coupling == "mortar"
    before = 0.0 if contact._readings is None else float(contact._readings.in_contact.sum())
    x, nodal, areas = contact.sampled(contact.pressure, 12)
    _, recovered, _ = contact.recovered.sampled(12)
    samples = facet_samples(contact.nodes, contact.facets, mortar, contact._extent, 12)
    squares = (contact._at_nodes @ contact.pressure)[contact.facets] ** 2
    root = np.sqrt(np.maximum(np.einsum("fqa,fa->fq", hats(contact.facets, samples.local, mortar), squares), 0.0))
    known = exact(x)
    errors = [np.sqrt(areas @ (p - known) ** 2 / (areas @ known**2)) for p in (nodal, root.ravel(), recovered)]
    offs = [a / true - 1 for a in (contact.point_area, before, contact._whole.area)]
    print(name, size, *offs, *errors, flush=True)
    return (
        f"| {name} | {size} | "
        + " | ".join(f"{v:+.2%}" for v in offs)
        + " | "
        + " | ".join(f"{v:.2%}" for v in errors)
        + " |"
    )


def rows():
    for name, solve in MESHES.items():
        for n in FACES:
            if n <= LARGEST.get(name, n):
                yield row(name, n, *solve(CONTACT / n))
    for name, area in OTHERS.items():
        sizes, solve = FAMILIES[name]
        for size in sizes[:2]:
            yield row(name, f"{size} *", *solve(size), area())
    for kind in ("grid", "tet10", "hex20"):
        scene, forces, exact = bench_accuracy.rigid(kind)
        result = scene.solve(forces=forces, accuracy=0.02)
        yield row(bench_accuracy.NAMES[kind], "asked: 2 %", result, exact)


def picture():
    """The pressure of the coupling and the recovered one, with outlines, at four faces a radius."""
    figure = Figure(figsize=(11, 8.4), layout="constrained")
    for line, kind in zip(figure.subplots(2, 2), ("gmsh tet10", "gmsh hex20"), strict=True):
        contact = MESHES[kind](CONTACT / 4)[0].contacts[0]
        nodal = replace(contact)
        nodal.__dict__["recovered"] = recovered_field(contact, 0.0)
        for axes, shown, what in zip(line, (nodal, contact), ("nodal", "recovered"), strict=True):
            draw_field(axes, field_map(shown, "pressure"))
            draw_outlines(axes, map_of(contact), field_map(contact, "pressure"), Units())
            axes.set_title(f"{kind}, {what} pressure", fontsize="medium")
    figure.savefig(PICTURE, dpi=90)


def page(lines):
    table = "\n".join(lines)
    return rf"""# Outlines and recovered pressures against the truth

Generated by `python tests/benchmarks/bench_outlines.py`; no figure is typed. [What they are](../outlines.md).

Areas relative to the true ones: the areas of the points that carry force, the area where recovered squares of the
pressure are positive, and that within the outline. Errors of three pressures in L2 over the contact's faces: that of
the coupling, the root of its interpolated squares, and the recovered one, which in mortar couplings is recovered inside
only, and in sections and in contacts of fewer than four faces across not at all. None of the meshes has faces that end
at the edge of the contact.

{HEAD}
|---|---|---|---|---|---|---|---|
{table}

\* Size of the faces, or their number, as in [the table of error estimates](../error_estimates.md).

![Pressures on unstructured meshes with their outlines](images/outlines.png)
"""


def main():
    warnings.simplefilter("ignore")
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(list(rows())))
    picture()


if __name__ == "__main__":
    main()
