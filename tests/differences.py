"""Forces and tangents of members beside central differences of their energies and forces, for tests."""

import numpy as np


def off_differences(member, q, d, h=1e-6):
    """Relative errors of the work along d and of the tangent times d, at coordinates q, by a step h."""
    ends = [q + h * d, q - h * d]
    slope, change = (np.subtract(*map(f, ends)) / (2 * h) for f in (member.energy, member.forces))
    return abs(slope / (member.forces(q) @ d) - 1), np.abs(change - member.tangent(q) @ d).max() / np.abs(change).max()
