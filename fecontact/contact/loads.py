"""Loads of a scene on bodies as a whole, on their boundaries and in their volume.

Pressures and tractions on boundaries: a number or vector, a function of position, or values at the nodes.

Values at the nodes are interpolated by the functions of the faces, as the loads of the source report (Elangovan 1978,
appendix B: intensities at the nodes of a face, in three directions).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from fecontact.bodies.body import Body
from fecontact.common.arguments import mapping
from fecontact.common.arrays import Array
from fecontact.common.checks import array_of, finite, vector
from fecontact.common.compact_repr import compact_repr
from fecontact.common.errors import InputError, shown
from fecontact.contact.dimension import Dimension, setting_of
from fecontact.contact.rigid_motion import RigidMotionConstraints, constrain_rigid_motion
from fecontact.fem.expansion import Heated

#: What a user gives for an intensity over a boundary.
Distribution = ArrayLike | Callable[[Array], ArrayLike]


def pressed(body: Body, name: str, given: Distribution) -> Array:
    """Nodal forces (n_dofs,) of a pressure against a boundary.

    Parameters
    ----------
    body : Body
    name : str
        The boundary.
    given : float, callable or (n_nodes,) array
        Pressure; as a function of points (n, 3) in the body's axes, of n values; or at the boundary's nodes, in the
        order of ``mesh.boundary_nodes(name)``.

    Raises
    ------
    InputError
        For values that are not finite or not as many.
    """
    what = f"The pressure on {name!r} of {body.name!r}"
    numbers = None if callable(given) else array_of(given)
    if not callable(given) and (numbers is None or numbers.ndim == 0):
        constant = finite(what, cast(float, given))
        return body._boundary_traction(name, lambda x, n: -constant * n)
    p = _intensity(what, body, name, given, ())
    return body._boundary_traction(name, lambda x, n: -p(x)[:, None] * n)


def pulled(body: Body, name: str, given: Distribution, setting: Dimension) -> Array:
    """Nodal forces (n_dofs,) of a traction (3,) in world axes, a function of position or nodal values (n_nodes, 3)."""
    what = f"The traction on {name!r} of {body.name!r}"
    rotation = body.pose.rotation
    numbers = None if callable(given) else array_of(given)
    if numbers is not None and numbers.ndim == 1:
        constant = vector(what, numbers)
        setting.check_traction(constant, what)
        return body._boundary_traction(name, lambda x, n: np.broadcast_to(constant @ rotation, x.shape))
    t = _intensity(what, body, name, given, (3,))

    def field(x: Array, n: Array) -> Array:
        values = t(x)
        # the largest along each axis: a section has no forces across it
        setting.check_traction(np.abs(values).max(axis=0), what)
        return values @ rotation

    return body._boundary_traction(name, field)


def _intensity(
    what: str, body: Body, name: str, given: Distribution, shape: tuple[int, ...]
) -> Callable[[Array], Array]:
    """Checked values (n, *shape) at points."""
    if callable(given):

        def field(x: Array) -> Array:
            return _checked(f"{what}, a function of points {x.shape},", given(x), (len(x), *shape))

        return field
    return body._over_boundary(name, _checked(f"{what}, given by nodes,", given, (body._count_nodes(name), *shape)))


def _at_nodes(what: str, body: Body, name: str, given: Distribution) -> Array:
    """Vectors (n_nodes, 3) at the nodes of a boundary: one for all, a function of points, or values."""
    mesh = cast(Any, body).mesh
    nodes = mesh.boundary_nodes(name)
    if callable(given):
        return _checked(f"{what}, a function of points,", given(mesh.points[nodes]), (len(nodes), 3))
    return _checked(
        what, np.broadcast_to(given, (len(nodes), 3)) if np.shape(given) == (3,) else given, (len(nodes), 3)
    )


def _checked(what: str, given: Distribution, shape: tuple[int, ...]) -> Array:
    values = array_of(given)
    if values is None:
        raise InputError(f"{what} must be numbers {shape}; found {shown(given)}.", code="not-numbers")
    if values.shape != shape:
        raise InputError(f"{what} must have the shape {shape}; found {values.shape}.", code="wrong-shape")
    if not np.isfinite(values).all():
        raise InputError(
            f"{what} must be finite; {(~np.isfinite(values)).sum()} of its values are not.", code="not-finite"
        )
    return values


#: Fields of a `LoadStep` whose keys are bodies or places on them, and all of them.
KEYED = ("forces", "moments", "motions", "free", "pressures", "tractions", "displacements", "temperatures")
LOADS = (*KEYED, "gravity")


@compact_repr
@dataclass(frozen=True, eq=False)
class LoadStep:
    """Loads and prescribed motions at the end of a load step, as the arguments of `Scene.solve` of the same names.

    Keys are bodies, or places on them: (body, boundary) or (body, point).
    """

    forces: Mapping[Any, ArrayLike] = field(default_factory=dict)
    moments: Mapping[Body, ArrayLike] = field(default_factory=dict)
    motions: Mapping[Body, Mapping[str, float]] = field(default_factory=dict)
    free: Mapping[Body, str] = field(default_factory=dict)
    pressures: Mapping[tuple[Body, str], Distribution] = field(default_factory=dict)
    tractions: Mapping[tuple[Body, str], Distribution] = field(default_factory=dict)
    displacements: Mapping[Any, Distribution] = field(default_factory=dict)
    temperatures: Mapping[Body, Distribution] = field(default_factory=dict)
    gravity: ArrayLike | Callable[[Array], ArrayLike] | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> LoadStep:
        """The loads among arguments of `Scene.solve`.

        Raises
        ------
        InputError
            If one is no mapping.
        """
        keyed = {name: mapping(name, given.get(name)) for name in KEYED}
        return cls(**keyed, gravity=given.get("gravity"))

    def on(self, bodies: Sequence[Body], start: Sequence[Body] = ()) -> Loading:
        """The loads sorted by body; `start` has the bodies in the poses where they began, if these are others.

        Raises
        ------
        InputError
            If a key is not a body of the scene or a boundary of its mesh, or gravity acts on a body without density.
        """
        whole, local = self._checked(bodies)
        setting = setting_of(bodies)
        _check_forces(setting, local, self.gravity)
        frames, distributed = [], []
        for body, begun in zip(bodies, start or bodies, strict=True):
            pose, parts, pushes = body.pose, [], []
            for (b, place), force in local.items():
                if b is not body:
                    continue
                if isinstance(place, str):
                    f = vector(f"The force on {place!r} of {body.name!r}", force)
                    parts.append(body._boundary_force(place, f @ pose.rotation))
                    continue
                point = vector(f"The point of the force on {body.name!r}", place)
                f = vector(f"The force at {place} of {body.name!r}", force)
                if (nodal := body._point_force(point, f @ pose.rotation)) is None:
                    pushes.append((pose.to_world(point), f))
                else:
                    parts.append(nodal)
            frame = constrain_rigid_motion(
                body, whole.get(body), self.moments.get(body), self.motions.get(body), self.free.get(body, ()),
                pushes, setting.turning, begun.pose.rotation,
            )  # fmt: skip
            frame = replace(frame, imposed=self._imposed(body), heated=self._heated(body))
            setting.check_frame(frame)
            parts += [pressed(b, name, p) for (b, name), p in self.pressures.items() if b is body]
            parts += [pulled(b, name, t, setting) for (b, name), t in self.tractions.items() if b is body]
            if self.gravity is not None:
                weight = body._body_force(self._gravity(body, setting))
                parts += [] if weight is None else [weight]
            if frame.heated is not None:
                parts.append(frame.heated.forces)
            if frame.spread:
                parts.append(_spread(frame))
            frames.append(frame)
            distributed.append(np.sum(parts, axis=0) if parts else None)
        farthest = max((b._farthest / b.size for b in bodies), default=0.0)
        return Loading(tuple(frames), tuple(distributed), max(SMALLEST, LAST_DIGITS * farthest))

    def _checked(self, bodies: Sequence[Body]) -> tuple[dict[Body, ArrayLike], dict[tuple[Body, Any], ArrayLike]]:
        """Forces on bodies as a whole, and on their boundaries and points, after a check of all keys."""
        whole: dict[Any, ArrayLike] = {}
        local: dict[tuple[Body, Any], ArrayLike] = {}
        for key, value in self.forces.items():
            if not isinstance(key, tuple):
                whole[key] = value
                continue
            if len(key) != 2 or not (isinstance(key[1], str) or _is_point(key[1])):
                raise InputError(
                    "A force acts on a body, on (body, 'boundary') or on (body, (x, y, z)); found the key "
                    f"{shown(key)}.",
                    code="load-key",
                )
            local[key] = value
        for what, spread in (("pressure", self.pressures), ("traction", self.tractions)):
            for place in spread:
                if not isinstance(place, tuple) or len(place) != 2 or not isinstance(place[1], str):
                    raise InputError(
                        f"A {what} acts on (body, 'boundary'); found the key {shown(place)}.", code="load-key"
                    )
        for place in self.displacements:
            if isinstance(place, tuple) and (len(place) != 2 or not isinstance(place[1], str)):
                raise InputError(
                    f"A displacement is that of a support (body, 'boundary'), or of a body's conditions; found the "
                    f"key {shown(place)}.",
                    code="load-key",
                )
        moved = (place[0] if isinstance(place, tuple) else place for place in self.displacements)
        members = [*whole, *self.moments, *self.motions, *self.free, *moved, *self.temperatures]
        for member in [*members, *(place[0] for place in (*local, *self.pressures, *self.tractions))]:
            check_member(member, bodies)
        return whole, local

    def _imposed(self, body: Body) -> Array | None:
        """Displacements (n_dofs,) prescribed for its supports and conditions, in its axes; None where there are none.

        Raises
        ------
        InputError
            For a boundary without support, or values of another shape.
        """
        what, rotation = f"The displacement of {{}} of {body.name!r}", body.pose.rotation
        supports: dict[str, Array] = {}
        values: Array | None = None
        for place, given in self.displacements.items():
            if place is body:
                rows = getattr(body, "conditions", None)
                if rows is None:
                    raise InputError(f"{body.name!r} has no linear conditions to prescribe values of.", code="no-rows")
                values = _checked(what.format("the conditions"), given, (cast(Any, body)._n_conditions,))
                values = np.pad(values, (0, rows.shape[0] - len(values)))
            elif isinstance(place, tuple) and place[0] is body:
                name, known = place[1], getattr(body, "supports", {})
                if name not in known:
                    listed = ", ".join(map(repr, known)) or "none"
                    raise InputError(
                        f"{body.name!r} has no support on {name!r} whose displacement could be prescribed; its "
                        f"supports are on: {listed}.",
                        code="no-support",
                    )
                supports[name] = _at_nodes(what.format(repr(name)), body, name, given) @ rotation
        return body._prescribed(supports, values) if supports or values is not None else None

    def _gravity(self, body: Body, setting: Dimension) -> Callable[[Array], Array]:
        """Forces per mass (n, 3) at points (n, 3), both in a body's axes."""
        pose, given = body.pose, self.gravity
        if not callable(given):
            constant = vector("Gravity", cast(ArrayLike, given)) @ pose.rotation
            return lambda x: np.broadcast_to(constant, x.shape)

        def field(x: Array) -> Array:
            values = _checked(f"Gravity, a function of points {x.shape},", given(pose.to_world(x)), x.shape)
            setting.check_traction(np.abs(values).max(axis=0), "Gravity")
            return values @ pose.rotation

        return field

    def _heated(self, body: Body) -> Heated | None:
        """Forces and free strains of a change of a body's temperature."""
        given = self.temperatures.get(body)
        if given is None:
            return None
        what = f"The change of temperature of {body.name!r}"

        def change(points: Array) -> Array:
            values = given(points) if callable(given) else given
            return _checked(what, np.full(len(points), values) if np.ndim(values) == 0 else values, (len(points),))

        return body._heated(change)

    def carried(self, body: Callable[[Any], Any]) -> LoadStep:
        """The same loads on other bodies."""

        def moved(given: Mapping[Any, Any]) -> dict[Any, Any]:
            return {(body(k[0]), *k[1:]) if isinstance(k, tuple) else body(k): v for k, v in given.items()}

        return LoadStep(**{name: moved(getattr(self, name)) for name in KEYED}, gravity=self.gravity)

    def between(self, end: LoadStep, share: float) -> LoadStep:
        """Loads and motions a share of the way to those of another step; what one of them leaves out is zero there.

        Components are free as at the end.
        """
        if share in (0, 1):
            return end if share else self

        def mean(name: str) -> dict[Any, Any]:
            one, other = getattr(self, name), getattr(end, name)
            return {key: _between(one.get(key), other.get(key), share) for key in {**one, **other}}

        means = {name: mean(name) for name in KEYED if name != "free"}
        return LoadStep(**means, free=end.free, gravity=_between(self.gravity, end.gravity, share))

    def refuse_nodal_values(self) -> None:
        """Refuse distributions that are bound to the nodes of meshes which will be divided.

        Raises
        ------
        InputError
            With the boundary.
        """
        supports = {place: v for place, v in self.displacements.items() if isinstance(place, tuple)}
        heated = {(body, "all nodes"): v for body, v in self.temperatures.items()}
        for loads, constant in ((self.pressures, 0), (self.tractions, 1), (supports, 1), (heated, 0)):
            for (body, name), value in loads.items():
                if not callable(value) and np.ndim(value) > constant:
                    raise InputError(
                        f"The load on {name!r} of {body.name!r} is given at the nodes of its mesh, which accuracy= "
                        "divides; give it as a function of position.",
                        code="load-at-nodes",
                    )


def _between(one: Any, other: Any, share: float) -> Any:
    """A load or motion a share of the way from one to another; what is not given is zero."""
    given = [(load, weight) for load, weight in ((one, 1 - share), (other, share)) if load is not None]
    if not given:
        return None
    if isinstance(given[0][0], Mapping):
        return {c: sum(w * load.get(c, 0.0) for load, w in given) for c in {c: 0 for load, _ in given for c in load}}
    if any(callable(load) for load, _ in given):  # a load that varies over its boundary
        return lambda *at: sum(w * np.asarray(load(*at) if callable(load) else load, float) for load, w in given)
    return sum(w * np.asarray(load, float) for load, w in given)


#: Share of the largest possible opening by a rigid motion, and of the largest possible work of the loads, that counts
#: as rounding: with a normal wrong by 1e-17 a huge tangential motion must not open the contact, nor a huge pressure
#: balance a tangential load.
SMALLEST = 1e-12
#: The same for coordinates far from the origin of a mesh, in units of their rounding over the body's size: normals of
#: facets of a tenth or a hundredth of that size have errors larger by as much.
LAST_DIGITS = 100 * float(np.finfo(float).eps)


@compact_repr
@dataclass(frozen=True, eq=False)
class Loading:
    """Loads and rigid motion constraints of a scene.

    Attributes
    ----------
    frames : tuple of RigidMotionConstraints
        One for each body.
    distributed : tuple of (n_dofs,) array or None
        Nodal forces on each body, in its axes.
    rounding : float
        Share of the largest possible value up to which openings and work by rigid motions are rounding.
    """

    frames: tuple[RigidMotionConstraints, ...]
    distributed: tuple[Array | None, ...]
    rounding: float = SMALLEST

    @property
    def magnitude(self) -> float:
        """Sum of the magnitudes of all applied forces, for estimates."""
        total = sum(
            float(np.linalg.norm(f.load[:3])) + float(np.linalg.norm(f.load[3:])) / f.body.size for f in self.frames
        )
        return total + sum(
            float(np.linalg.norm(f.reshape(-1, 3).sum(axis=0))) for f in self.distributed if f is not None
        )

    def resultant(self, k: int) -> Array:
        """Applied force and moment (6,) on body k about its reference point, in world axes."""
        frame, nodal = self.frames[k], self.distributed[k]
        total = np.zeros(6) if frame.spread else frame.load.copy()
        if nodal is not None:
            total += frame.modes(np.eye(6)).T @ nodal
        return total

    def driving(self, k: int, motions: Array) -> Array:
        """Work (m,) of the loads on body k along world motions (6, m), with rounding set to zero.

        Nodal forces that cancel leave 1e-16 of their magnitudes, which must not count as an unbalanced load.
        """
        frame, nodal = self.frames[k], self.distributed[k]
        sizes = (
            np.zeros(motions.shape[1]) if frame.spread else _lengths(motions).T @ _lengths(frame.load[:, None])[:, 0]
        )
        if nodal is not None:
            sizes += _lengths(frame.modes(motions)).T @ _lengths(nodal[:, None])[:, 0]
        work = motions.T @ self.resultant(k)
        work[np.abs(work) < self.rounding * sizes] = 0.0
        return work


def _lengths(vectors: Array) -> Array:
    """Lengths (n, k) of the vectors in columns (3 n, k)."""
    return np.asarray(np.linalg.norm(vectors.reshape(len(vectors) // 3, 3, vectors.shape[1]), axis=1))


def _check_forces(setting: Dimension, local: Mapping[tuple[Body, Any], ArrayLike], gravity: Any) -> None:
    """Refuse forces and gravity that do not exist in a plane or axisymmetric scene."""
    for (body, place), force in local.items():
        what = f"The force on {place!r} of {body.name!r}"
        setting.check_force(vector(what, force), what)
    if gravity is not None and not callable(gravity):
        setting.check_force(vector("Gravity", gravity), "Gravity")


def _is_point(place: object) -> bool:
    point = array_of(place)
    return point is not None and point.shape == (3,)


def check_member(key: object, bodies: Sequence[Body], what: str = "A load or motion") -> None:
    """Refuse a key that is not a body of the scene, such as a body's name."""
    if not any(key is b for b in bodies):
        names = ", ".join(repr(b.name) for b in bodies)
        if isinstance(key, str):
            raise InputError(
                f"{what} is given for the string {key!r}; pass the body object itself, not its name "
                f"(this scene's bodies are named {names}).",
                code="load-key",
            )
        name, namesake = getattr(key, "name", None) or shown(key), ""
        if any(name == b.name for b in bodies):
            namesake = " One of that name is, but it is another object: a body that was placed or made again is new."
        raise InputError(
            f"{what} is given for {name!r}, which is not a body of this scene (they are {names}).{namesake}",
            code="not-in-scene",
        )


def mass_weighted(frame: RigidMotionConstraints, motions: Array) -> Array:
    """Nodal forces (n_dofs, k) of unit accelerations in world motions (6, k): M R."""
    return np.asarray(frame.body._weighted_modes @ frame.in_body_axes(motions))


def _spread(frame: RigidMotionConstraints) -> Array:
    """Nodal forces of a resultant distributed over the mass, as by an acceleration of the whole body."""
    columns = mass_weighted(frame, np.eye(6))
    inertia = frame.modes(np.eye(6)).T @ columns
    # a section does not move in all components
    moving = np.flatnonzero(np.diag(inertia) > 0)
    return columns[:, moving] @ np.linalg.solve(inertia[np.ix_(moving, moving)], frame.load[moving])
