"""Independent routes by which the closed forms are checked: point loads summed, fields differentiated."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipkm1

from fecontact.analytic import boussinesq


def _divergence(stress, point, step):
    """div(sigma) by central differences of fourth order; stress maps (3,) to (3, 3)."""
    total = np.zeros(3)
    for axis in range(3):
        shift = np.zeros(3)
        shift[axis] = step
        derivative = (
            8 * (stress(point + shift) - stress(point - shift)) - stress(point + 2 * shift) + stress(point - 2 * shift)
        ) / (12 * step)
        total += derivative[:, axis]
    return total


def _hooke(displacement, point, material, step):
    """Stress from the gradient of a displacement field, by central differences of fourth order."""
    gradient = np.zeros((3, 3))
    for axis in range(3):
        shift = np.zeros(3)
        shift[axis] = step
        gradient[:, axis] = (
            8 * (displacement(point + shift) - displacement(point - shift))
            - displacement(point + 2 * shift)
            + displacement(point - 2 * shift)
        ) / (12 * step)
    strain = (gradient + gradient.T) / 2
    return material.lame * np.trace(strain) * np.eye(3) + 2 * material.shear_modulus * strain


def _summed_disc(pressure, a, point, material, n_radial=80, n_angle=128):
    """Stress at a point from point loads all over a disc; the substitution r = a sin(t) removes a root at the edge."""
    nodes, weights = np.polynomial.legendre.leggauss(n_radial)
    t, w = (nodes + 1) * np.pi / 4, weights * np.pi / 4
    r, w_r = a * np.sin(t), w * a * np.cos(t) * a * np.sin(t)
    angle = 2 * np.pi * np.arange(n_angle) / n_angle
    offsets = np.zeros((n_radial, n_angle, 3))
    offsets[..., 0] = point[0] - r[:, None] * np.cos(angle)
    offsets[..., 1] = point[1] - r[:, None] * np.sin(angle)
    offsets[..., 2] = point[2]
    stress = boussinesq.stress(offsets, force=(0.0, 0.0, 1.0), material=material)
    return np.einsum("r,r,raij->ij", w_r, pressure(r), stress) * 2 * np.pi / n_angle


def _ring_displacement(pressure, a, r, modulus):
    """Surface displacement from an axisymmetric pressure, as a sum of rings (complete elliptic integral)."""

    def integrand(s):
        complement = ((r - s) / (r + s)) ** 2
        return float(pressure(s)) * s / (r + s) * ellipkm1(max(complement, 1e-300))

    total = 0.0
    for low, high in ((0.0, min(r, a)), (min(r, a), a)):
        if high > low:  # s = high - (high - low) v^2 and its mirror soften the ends; two halves, one for each end
            middle = (low + high) / 2
            total += quad(lambda v, m=middle, e=low: integrand(e + (m - e) * v**4) * 4 * (m - e) * v**3, 0, 1)[0]
            total += quad(lambda v, m=middle, e=high: integrand(e + (m - e) * v**4) * 4 * (e - m) * v**3, 0, 1)[0]
    return 4 / (np.pi * modulus) * total


@pytest.fixture
def divergence():
    return _divergence


@pytest.fixture
def hooke():
    return _hooke


@pytest.fixture
def summed_disc():
    return _summed_disc


@pytest.fixture
def ring_displacement():
    return _ring_displacement
