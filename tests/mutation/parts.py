"""Parts of the package whose guards are judged: their modules, and the tests that are to see a change in them."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

PARTS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "estimate of errors": (
        ("*.error_estimate", "*.energy_error", "*.grid_error", "*.response_error", "results.recover*"),
        (
            "results/test_*error*.py",
            "results/test_resolution.py",
            "fem/test_energy_error.py",
            "halfspace/test_halfspace_error.py",
        ),
    ),
    "refinement": (
        ("scene.adaptive", "results.geometry_error"),
        ("scene/test_marking.py", "scene/test_to_an_accuracy.py", "results/test_geometry_error.py"),
    ),
    "edge pressure": (
        ("results.edge_*", "results.*outline", "halfspace.edge"),
        ("results/test_edge_*.py", "results/test_*outline*.py", "halfspace/test_halfspace_error.py"),
    ),
    "between nodes": (
        ("*.between_nodes", "halfspace.validity"),
        ("results/test_between_nodes.py", "results/test_geometry_error.py", "halfspace/test_halfspace_error.py"),
    ),
    "unbounded places": (
        ("results.singular", "results.rough_corner", "surfaces.rigid.tip"),
        ("results/test_singular.py", "results/test_rigid_patches.py"),
    ),
    "rims": (
        ("bodies.rims", "results.warnings"),
        ("results/test_rims.py", "results/test_overlaps.py", "bodies/test_section_bodies.py"),
    ),
    "friction": (
        ("solvers.friction*",),
        ("solvers/test_friction_*.py", "solvers/test_certificate.py", "scene/test_held_by_friction.py"),
    ),
    "scaling": (("solvers.scaling", "solvers.problem"), ("solvers",)),
    "solvers": (("solvers.*",), ("solvers",)),
    "hanging nodes": (("mesh.hanging_nodes",), ("mesh/test_hanging_nodes.py", "mesh/test_refine_*.py")),
    "local bodies": (("bodies.local.*",), ("bodies/test_local_*.py",)),
    "half-spaces": (("halfspace.*", "bodies.halfspace"), ("halfspace",)),
    "decks": (("app.decks.*",), ("app/test_decks*.py",)),
    "slender members": (("ancf.slender.*",), ("ancf/test_slender*.py", "ancf/test_corotational.py")),
    "pairing": (("contact.search_region", "contact.candidates"), ("contact", "scene/test_scene.py")),
    "coupling": (("contact.coupling.*",), ("contact",)),
    "balance and reduction": (("contact.*", "fem.constrained_cg"), ("contact", "fem/test_con*.py")),
    "solution procedures": (("scene.*",), ("scene",)),
    "results": (("results.*",), ("results",)),
}
"""Patterns of modules, and files or folders of unit tests; a module belongs to the first part that names it."""

BESIDES = ("*.pictures*", "*.array_module", "*.export", "*.cost", "*.model_size", "*.files")
"""Modules that are about something else: pictures, files, costs."""

SLOW = ("pictures", "model_size", "cost", "export", "processes")
"""Words in the names of test files that are about something else, or start programs that see no mutant."""


def part_of(module: str) -> str:
    """The part that a module belongs to; empty for one that is not judged."""
    inner = module.partition(".")[2]
    if any(fnmatchcase(inner, each) for each in BESIDES):
        return ""
    return next((name for name, (some, _) in PARTS.items() if any(fnmatchcase(inner, each) for each in some)), "")


def judges(part: str, root: Path, given: Sequence[str] | None) -> list[Path]:
    """Files of the tests that judge a part, or of those given."""
    found: set[Path] = set()
    for pattern in given or PARTS[part][1]:
        for path in (root / "tests" / "unit").glob(pattern):
            found |= set(path.rglob("test_*.py")) if path.is_dir() else {path}
    return sorted(path for path in found if not any(word in path.name for word in SLOW))
