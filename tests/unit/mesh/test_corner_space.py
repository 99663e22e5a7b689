"""Trilinear functions on corners."""

from dataclasses import replace

import numpy as np
import pytest
from refine_cases import CASES, mesh_of

from fecontact.fem.amg import corner_space


@pytest.mark.parametrize(("kind", "width"), CASES)
@pytest.mark.parametrize("midfaces", [False, True])
def test_linear_fields_are_those_of_their_corners(kind, width, midfaces):
    """Edges are straight, with nodes in their middles, so that the positions of all nodes follow from the corners'."""
    mesh = mesh_of(kind, width)
    if midfaces and width == 20:
        mesh = replace(mesh, boundaries={"skin": mesh.outer_faces}).with_midface_nodes(("skin",))
    corners, weights = corner_space(mesh)
    assert weights.shape == (len(mesh.points), len(corners))
    assert np.abs(weights @ mesh.points[corners] - mesh.points).max() < 1e-12
    assert np.abs(weights.sum(axis=1) - 1.0).max() < 1e-12
    assert weights.min() >= 0.0
    assert np.array_equal(np.unique(mesh.cells[:, :8]), corners)
