"""Half-spaces: free, periodic, layered, pressed by shapes and rough surfaces, with friction and without."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from frame import Frame
from judging import Answer

import fecontact as fc


def _half_space(rng: np.random.Generator, frame: Frame, friction: bool) -> tuple[fc.HalfSpace, np.ndarray, float]:
    """A half-space, heights at home over its grid, and the largest height that counts."""
    cells = int(rng.choice([12, 16, 24, 32]))
    periodic, layered = bool(rng.random() < 0.3), bool(rng.random() < 0.3)
    nu = float(rng.choice([0.0, 0.3, 0.45]))
    thickness = float(10 ** rng.uniform(-1.5, 0.5))
    layers = (
        [fc.Layer(frame.material(float(10 ** rng.uniform(-1, 1)), 0.3), thickness * frame.length)] if layered else []
    )
    half = fc.HalfSpace(
        frame.material(1.0, nu), (frame.length, frame.length), (cells, cells), periodic=periodic, layers=layers
    )
    x = (np.arange(cells) + 0.5) / cells - 0.5
    X, Y = np.meshgrid(x, x, indexing="ij")
    radius, kind = float(10 ** rng.uniform(0, 2)), rng.random()
    if periodic:
        waves = rng.normal(size=(6, 4))
        turns = rng.integers(1, 4, (6, 2))
        z = sum(
            a * np.cos(2 * np.pi * (p * X + q * Y) + 6 * b) for (a, b, *_), (p, q) in zip(waves, turns, strict=True)
        ) * float(10 ** rng.uniform(-3, -1))
    elif kind < 0.4:
        z = (X**2 + Y**2) / 2 / radius
    elif kind < 0.7:  # a rough dome
        z = (X**2 + Y**2) / 2 / radius + 0.05 / radius * rng.normal(size=X.shape)
    else:
        z = 0.3 * np.hypot(X - 0.1, Y) / radius
    return half, z, float(np.ptp(z))


def _answer(contact: Any, frame: Frame, grows: str = "") -> Answer:
    out = {
        "force": contact.force / frame.force,
        "peak": contact.max_pressure / frame.modulus,
        "approach": contact.approach / frame.length,
    }
    if hasattr(contact, "tangential"):
        out |= {
            f"force {k}": float(v) / frame.force * (-1 if frame.mirrored and not k else 1)
            for k, v in enumerate(contact.tangential)
        }
    return Answer(out, (str(contact), repr(contact)), contact.residuals.worst, 1e-6, grows)


def _written(half: fc.HalfSpace, z: np.ndarray, frame: Frame) -> np.ndarray:
    return (z[::-1] if frame.mirrored else z) * frame.length


def half_space_pressed(number: int, frame: Frame) -> Callable[[], Answer]:
    """By a force or by an approach."""
    rng = np.random.default_rng([5, number])
    half, z, high = _half_space(rng, frame, False)
    given = _written(half, z, frame)
    share = float(10 ** rng.uniform(-3, -0.7))
    if rng.random() < 0.5:
        return lambda: _answer(half.press(given, force=share * high * frame.force * 0.2), frame)
    depth = (share * high if not half.periodic else share * float(z.mean() - z.min())) * frame.deeper
    return lambda: _answer(half.press(given, approach=(z.min() + depth) * frame.length), frame, "force")


def half_space_dragged(number: int, frame: Frame) -> Callable[[], Answer]:
    """With friction, by a force and a tangential force or a shift."""
    rng = np.random.default_rng([6, number])
    half, z, high = _half_space(rng, frame, True)
    given = _written(half, z, frame)
    load, mu = float(10 ** rng.uniform(-3, -1)) * high, float(rng.choice([0.1, 0.3, 0.8]))
    pull = rng.uniform(-0.6, 0.6, 2) * mu * load * ([-1, 1] if frame.mirrored else [1, 1])
    return lambda: _answer(
        half.press(given, force=load * frame.force, friction=mu, tangential=tuple(pull * frame.force)), frame
    )
