import numpy as np
import pytest

from fecontact import Material
from fecontact.bodies.local.window import Window, fit, own_part, sources
from fecontact.halfspace import Grid


def _on_a_ball(half):
    """A window on a ball of unit radius, of sides 2 half."""
    relief = fit(lambda x, y: 1 - np.sqrt(1 - x**2 - y**2), np.array([half, half]), (True, True))
    return Window(np.zeros(3), np.eye(3), Grid((2 * half, 2 * half), (8, 8)), (True, True), relief)


@pytest.mark.parametrize("nu", [0.0, 0.45])
def test_what_the_kernel_leaves_at_a_load_is_of_the_order_of_slopes_squared(nu):
    material, order = Material(1.0, nu), 8
    found = [own_part(window := _on_a_ball(half), order, sources(window, order), material) for half in (0.05, 0.1)]
    slopes = np.linalg.norm(np.stack(_on_a_ball(0.1).node_places(order)), axis=0)
    corner = np.argmax(slopes)
    assert np.abs(found[1]).argmax() == corner
    # in a window of half the size all slopes are halved; beside slope^2 there is curvature times the circle's radius
    assert 3 < found[1][corner] / found[0][corner] < 4.5
    assert abs(found[1][corner]) > 0.05 * slopes[corner] ** 2
