"""Rigid motions of the bodies of a scene: held, prescribed, loaded or free.

Every body has a frame to which its supports are fixed. Its six components (x, y, z, rx, ry, rz: world axes, rotations
about the body's reference point) are

- **held**, if a support resists them and nothing else is given;
- **prescribed** by `motions`;
- **loaded**, along the direction of the force and about that of the moment that `forces` and `moments` give: there
  the frame follows; across it the frame is held. The direction is that of the load, not its components along the world
  axes, so that the result does not change with a rotation of the scene. A load along what supports leave free, such as
  a guide, is held across by them, however far the body has turned. Another load with a component in which no contact
  resists the body is refused (`equilibrium.check_balance`): held across it, the body would act as a wedge. Where the
  constraint across carries a large share of the load, a warning says so and how to free it. A force at a point of a
  rigid body also lets the body rotate about that point, like a load through a ball joint;
- **free**, if no support resists them, or if `free` names them.

A load on a body acts through its supports as through a rigid platen; on a component without support it is distributed
over the body like gravity. A prescribed component without support prescribes the body's mean position (weighted by
mass, as in Elangovan 1978, eq. A-17), and its constraint force is distributed in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body
from fecontact.common.arguments import items, mapping
from fecontact.common.arrays import Array, Mask
from fecontact.common.checks import finite, vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.fem.expansion import Heated
from fecontact.fem.rigid import COMPONENTS, describe_motion, gram_schmidt

#: Part of a component in motions without support, rotations by their length at the body's size, that counts.
MIN_BESIDE = 0.02


@compact_repr
@dataclass(frozen=True, eq=False)
class RigidMotionConstraints:
    """Rigid motions of one body, in world axes about its reference point.

    Attributes
    ----------
    free : (6, k) array
        Unknown motions of the contact problem.
    prescribed : (6,) array
        Prescribed motion.
    mean_held : (6, j) array
        Prescribed motions without support, imposed on the body's mean position.
    load : (6,) array
        Force and moment on the body as a whole.
    spread : bool
        Whether that load is distributed over the mass instead of acting through the supports.
    prescribed_components : tuple of int
        Components that `motions` prescribes, including zero values.
    freed_in_vain : tuple of int
        Components that `free` names though no support resists them, where others are as free.
    held_beside : tuple of int
        Prescribed components that supports resist in part: what they leave free moves in others too, such as a tilt
        about a row of supports, and is held by the mean position.
    imposed : (n_dofs,) array, optional
        Displacements that supports and linear conditions prescribe beside the frame's, in the body's axes.
    heated : Heated, optional
        Forces and free strains of a change of temperature.
    guided : (bool, bool)
        Whether force and moment drove, where the body began, only what its supports leave free: these hold across.
    """

    body: Body
    free: Array
    prescribed: Array
    mean_held: Array
    load: Array
    spread: bool
    prescribed_components: tuple[int, ...] = ()
    freed_in_vain: tuple[int, ...] = ()
    held_beside: tuple[int, ...] = ()
    imposed: Array | None = None
    heated: Heated | None = None
    guided: tuple[bool, bool] = (False, False)

    @property
    def point(self) -> Array:
        """Reference point (3,) in the world."""
        return self.body.pose.to_world(self.body.reference_point)

    def in_body_axes(self, motions: Array) -> Array:
        """World motions (6, k) as motions in the body's axes."""
        Q = self.body.pose.rotation
        return np.concatenate([Q.T @ motions[:3], Q.T @ motions[3:]])

    def modes(self, motions: Array) -> Array:
        """Displacement fields (n_dofs, k) in the body's axes of world motions (6, k)."""
        return self.body.rigid_modes @ self.in_body_axes(motions)

    @property
    def given(self) -> Array | None:
        """Displacements (n_dofs,) that are prescribed, of its frame and beside it; None where there are none."""
        rigid = self.modes(self.prescribed[:, None])[:, 0] if self.prescribed.any() else None
        if self.imposed is None or rigid is None:
            return rigid if self.imposed is None else self.imposed
        return rigid + self.imposed

    def describe(self, motion: Array) -> str:
        """A world motion (6,) of this body in words."""
        return f"{self.body.name}: {describe_motion(motion, self.point, self.body.size)}"


def after_prescribed(
    gap: Array, rows: Callable[[Body], sp.csr_matrix | None], frames: Sequence[RigidMotionConstraints]
) -> Array:
    """Gaps (n,) after the prescribed rigid motions; `rows` gives their change by displacements of a body, or None."""
    out = gap.copy()
    for frame in frames:
        given = frame.given
        found = None if given is None else rows(frame.body)
        if found is not None:
            out += found @ given
    return out


def _motion(given: Mapping[str, float] | None, body: Body) -> dict[int, float]:
    """Prescribed components by number."""
    out = {}
    for name, value in mapping(f"the motion of {body.name!r}", given).items():
        if name not in COMPONENTS:
            raise InputError(
                f"Unknown component {name!r} of the motion of {body.name!r}; expected {', '.join(COMPONENTS)}.",
                code="unknown-component",
            )
        out[COMPONENTS.index(name)] = finite(f"The motion {name!r} of {body.name!r}", value)
    return out


def constrain_rigid_motion(
    body: Body,
    force: ArrayLike | None = None,
    moment: ArrayLike | None = None,
    motion: Mapping[str, float] | None = None,
    free: str | Sequence[str] = (),
    pushes: Sequence[tuple[Array, Array]] = (),
    turning: Sequence[int] = (0, 1, 2),
    start: Array | None = None,
) -> RigidMotionConstraints:
    """Sort the six components of a body.

    Parameters
    ----------
    body : Body
    force, moment, motion, free
        As in `Scene.solve`, for this body.
    pushes : sequence of ((3,) array, (3,) array)
        World points of the body's frame and the forces there. They free rotations about their mean point, weighted by
        the magnitudes of the forces, so that the result does not depend on the reference point.
    turning : sequence of int
        Axes about which bodies of this scene can rotate.
    start : (3, 3) array, optional
        Rotation of the body's pose where it began. What a load drives is judged there: along a guide it frees nothing
        across, however far the guide has turned since.

    Raises
    ------
    InputError
        For unknown components, numbers that are not finite, or a component both loaded and prescribed.
    """
    load = np.concatenate(
        [
            np.zeros(3) if force is None else vector(f"The force on {body.name!r}", force),
            np.zeros(3) if moment is None else vector(f"The moment on {body.name!r}", moment),
        ]
    )
    point = body.pose.to_world(body.reference_point)
    for _, push in pushes:
        load[:3] += push
    direct = load.copy()
    for at, push in pushes if len(turning) else ():
        load[3:] += np.cross(at - point, push)
    prescribed_components = _motion(motion, body)
    names = free.split() if isinstance(free, str) else items(f"the free components of {body.name!r}", free, "names")
    if unknown := [name for name in names if not (isinstance(name, str) and name in COMPONENTS)]:
        raise InputError(
            f"Unknown free components {shown(unknown)} of {body.name!r}; expected {', '.join(COMPONENTS)}.",
            code="unknown-component",
        )
    freed = [COMPONENTS.index(n) for n in names]
    if both := (set(np.flatnonzero(direct).tolist()) | set(freed)) & set(prescribed_components):
        which = ", ".join(COMPONENTS[c] for c in sorted(both))
        raise InputError(f"{body.name!r} is both loaded (or free) and moved in {which}; a component takes one of them.")
    scale = np.array([1.0] * 3 + [body.size] * 3)[:, None]
    begun, floating = (
        scale * np.concatenate([Q @ body.free_motions[:3], Q @ body.free_motions[3:]])
        for Q in (body.pose.rotation if start is None else start, body.pose.rotation)
    )
    unit = np.eye(6)
    # directions of force and moment, not components: the result does not change with a rotation of the scene
    along = np.stack([np.concatenate([direct[:3], np.zeros(3)]), np.concatenate([np.zeros(3), direct[3:]])], axis=1)
    guided = _within(along, begun)
    along = along[:, ~guided | _within(along, floating)]
    jointed = _turns_about_pushes(pushes, turning, point, body.size)
    everything = gram_schmidt(np.concatenate([along, jointed, unit[:, freed], floating], axis=1), 1e-8)
    released = _without(everything, list(prescribed_components))
    # unsupported and not free; completing the basis judges dependence by the columns' own length
    mean_held = gram_schmidt(np.concatenate([released, floating], axis=1), 1e-8)[:, released.shape[1] :]
    prescribed = np.zeros(6)
    for component, value in prescribed_components.items():
        prescribed[component] = value
    work = np.abs(floating.T @ (load[:, None] / scale)).max(initial=0.0) if load.any() else 0.0
    spread = bool(work > 1e-9 * np.abs(load[:, None] / scale).max()) if work else False
    return RigidMotionConstraints(
        body,
        released / scale,
        prescribed,
        mean_held / scale,
        load,
        spread,
        tuple(prescribed_components),
        _in_vain(floating, freed, prescribed_components) if freed else (),
        _held_beside(floating, list(prescribed_components)) if prescribed_components else (),
        guided=(bool(guided[0]), bool(guided[1])),
    )


def _within(loads: Array, floating: Array) -> Mask:
    """Which loads (6, 2) are along motions (6, k) that supports leave free, of a body with supports."""
    basis, sizes = gram_schmidt(floating, 1e-8), np.linalg.norm(loads, axis=0)
    beside = np.linalg.norm(loads - basis @ (basis.T @ loads), axis=0)
    return np.asarray((sizes > 0) & (beside <= 1e-8 * sizes) & (basis.shape[1] < 6))


def _held_beside(floating: Array, prescribed: list[int]) -> tuple[int, ...]:
    """Prescribed components of motions without support that have others too, rounding and small turns left out."""
    loose = gram_schmidt(floating, 1e-8)
    _, singular, Vt = np.linalg.svd(np.delete(loose, prescribed, axis=0))
    going = loose @ Vt[: int((singular > 1e-8).sum())].T
    return tuple(c for c in prescribed if np.linalg.norm(going[c]) > MIN_BESIDE)


def _in_vain(floating: Array, freed: Sequence[int], prescribed: Iterable[int]) -> tuple[int, ...]:
    """Freed components that are motions without support, if these are more than the freed and the prescribed ones."""
    basis = gram_schmidt(floating, 1e-8)
    within = {c for c in range(6) if np.linalg.norm(basis[c]) > 1 - 1e-8}
    return tuple(c for c in freed if c in within) if within - {*freed, *prescribed} else ()


def _turns_about_pushes(
    pushes: Sequence[tuple[Array, Array]], turning: Sequence[int], point: Array, size: float
) -> Array:
    """Rotations (6, k) about the mean point of forces, as motions of the reference point, rotations times `size`."""
    sizes = np.array([np.linalg.norm(push) for _, push in pushes])
    if not sizes.any():
        return np.zeros((6, 0))
    centre = sizes @ np.array([at for at, _ in pushes]) / sizes.sum()
    axes = np.eye(3)[list(turning)].reshape(-1, 3)
    return np.concatenate([np.cross(axes, point - centre).T, size * axes.T])


def _without(basis: Array, components: list[int]) -> Array:
    """Orthonormal basis of the part of a space in which the given components are zero."""
    _, singular, Vt = np.linalg.svd(basis[components], full_matrices=True)
    rank = int((singular > 1e-8).sum())
    return basis @ Vt[rank:].T
