"""Load curves, supports, loads and rigid motions of FEBio decks at the times where load curves bend."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree

import numpy as np

from fecontact.app.decks.content import DeckFrame, DeckRigid, DeckStep, Remarks, look_up
from fecontact.common.arrays import Array, IntArray
from fecontact.common.errors import InputError, not_done
from fecontact.fem.rigid import COMPONENTS, rigid_modes
from fecontact.mesh.mesh import Mesh

Element = ElementTree.Element

#: Components by FEBio's names of displacements and of rigid degrees of freedom.
DOFS = {"x": 0, "y": 1, "z": 2, "Rx": 0, "Ry": 1, "Rz": 2, "Ru": 3, "Rv": 4, "Rw": 5}
#: Elements that hold or move something, beside loads.
WOULD_BE_LOST = ("constraint", "rigid_connector", "rigid_bc", "rigid_constraint", "rigid_joint")
#: Difference of times, relative to the last, that is rounding of sums of step sizes.
SAME_TIME = 1e-9
#: Extent of a plane across it, relative to the mesh, that is rounding of a file.
FLAT = 1e-6
#: What load curves may be between their points and beyond them; share of a curve over which a smooth one is taken as
#: straight beyond its end.
BETWEEN = ("linear", "step", "smooth")
BEYOND = ("constant", "extrapolate", "repeat", "repeat offset")
SLOPE = 0.001


@dataclass(frozen=True, eq=False)
class LoadCurve:
    """A load curve of points (n, 2), with its interpolation between them and what holds beyond (FEBio's PointCurve).

    A step has the value of the next point. 'smooth' is the parabola through three points, of more the mean, linear in
    time, of the two parabolas through the ends of a piece and the point before or after it.
    """

    points: Array
    between: str = "linear"
    beyond: str = "constant"

    @classmethod
    def of(cls, c: Element) -> LoadCurve:
        """Of its element, in any version.

        Raises
        ------
        InputError
            For an interpolation that is not known, or times that do not grow.
        """
        rows = [p.text or "" for p in c.iter() if p.tag in ("pt", "point", "loadpoint")]
        points = np.array([row.split(",") for row in rows], dtype=float).reshape(-1, 2)
        given = c.get("type", "") if c.get("type") != "loadcurve" else ""
        between = (c.findtext("interpolate") or given or "linear").strip().lower()
        beyond = (c.findtext("extend") or c.get("extend") or "constant").strip().lower()
        if between not in BETWEEN or beyond not in BEYOND:
            raise InputError(
                f"{c.get('line')}: expected a load curve that is {', '.join(BETWEEN)} and goes on {', '.join(BEYOND)}; "
                f"found {between!r} and {beyond!r}.",
                code="load-curve",
            )
        if not len(points) or (np.diff(points[:, 0]) <= 0).any():
            raise InputError(f"{c.get('line')}: expected points with growing times; found {points[:, 0].tolist()}.")
        return cls(points, between, beyond)

    def at(self, time: float) -> float:
        """Value at a time."""
        t, f = self.points.T
        length = t[-1] - t[0]
        if len(t) == 1 or t[0] <= time <= t[-1]:
            return self._inside(time)
        if self.beyond.startswith("repeat"):
            # at the end of a period its last point counts, not the first one of the next
            periods = np.ceil((time - t[-1]) / length) if time > t[-1] else np.floor((time - t[0]) / length)
            offset = periods * (f[-1] - f[0]) if self.beyond == "repeat offset" else 0.0
            return self._inside(float(np.clip(time - periods * length, t[0], t[-1]))) + float(offset)
        end, inner = (t[0], t[0] + SLOPE * length) if time < t[0] else (t[-1], t[-1] - SLOPE * length)
        if self.beyond == "constant" or self.between == "step":
            return self._inside(end)
        return self._inside(end) + (time - end) * (self._inside(inner) - self._inside(end)) / (inner - end)

    def _inside(self, time: float) -> float:
        t, f = self.points.T
        k = int(np.clip(np.searchsorted(t, time), 1, max(len(t) - 1, 1)))
        if self.between == "step" or len(t) == 1:
            return float(f[min(int(np.searchsorted(t, time)), len(t) - 1)])
        if self.between == "linear" or len(t) == 2:
            return float(np.interp(time, t, f))
        left, right = max(k - 2, 0), min(k - 1, len(t) - 3)
        one, other = (_parabola(t[n : n + 3], f[n : n + 3], time) for n in (left, right))
        share = (time - t[k - 1]) / (t[k] - t[k - 1])
        return one if left == right else (1 - share) * one + share * other

    def bends(self, start: float, end: float) -> Array:
        """Times of its points, repeated where it repeats."""
        t = self.points[:, 0]
        if not self.beyond.startswith("repeat") or len(t) < 2:
            return t
        length = t[-1] - t[0]
        first, last = np.floor((start - t[0]) / length), np.ceil((end - t[0]) / length)
        return np.asarray((t + length * np.arange(first, last + 1)[:, None]).ravel())


def _parabola(t: Array, f: Array, time: float) -> float:
    """Value of the parabola through three points."""
    d = time - t
    weights = [d[1] * d[2], d[0] * d[2], d[0] * d[1]] / ((t - np.roll(t, 1)) * (t - np.roll(t, 2)))
    return float(weights @ f)


@dataclass(frozen=True, eq=False)
class Curves:
    """Load curves by number."""

    curves: Mapping[str, LoadCurve]

    @classmethod
    def of(cls, root: Element) -> Curves:
        """Those of <LoadData>; other controllers are refused where they are used."""
        every = (c for section in root.findall("LoadData") for c in section)
        return cls(
            {c.get("id", ""): LoadCurve.of(c) for c in every if c.tag == "loadcurve" or c.get("type") == "loadcurve"}
        )

    def at(self, entry: Element, time: float) -> float:
        """Factor of an entry's load curve at a time; one without."""
        lc = entry.get("lc")
        if lc is None:
            return 1.0
        if lc not in self.curves:
            raise InputError(f"{entry.get('line')}: there is no load curve {lc!r} of points.", code="unknown-curve")
        return self.curves[lc].at(time)

    def numbers(self, entry: Element, time: float) -> Array:
        """Numbers of an entry times its load curve."""
        try:
            values = np.array((entry.text or "").split(","), dtype=float)
        except ValueError:
            raise InputError(f"{entry.get('line')}: expected numbers; found {entry.text!r}.", code="numbers") from None
        return values * self.at(entry, time)


@dataclass(frozen=True, eq=False)
class Segment:
    """A step: its end and the elements that are active in it."""

    name: str
    start: float
    end: float
    active: Sequence[Element]


@dataclass(eq=False)
class State:
    """What holds at a time, of the points and rigid parts of a mesh; `rigid` names rigid parts by number and name."""

    mesh: Mesh
    curves: Curves
    rigid: Mapping[str, str]
    remarks: Remarks
    time: float
    held: Array
    forces: Array
    pressures: dict[str, float] = field(default_factory=dict)
    tractions: dict[str, Array] = field(default_factory=dict)
    gravity: Array = field(default_factory=lambda: np.zeros(3))
    #: Prescribed motions (6,) of rigid parts, NaN where they are free, and loads (6,).
    motions: dict[str, Array] = field(default_factory=dict)
    loads: dict[str, Array] = field(default_factory=dict)

    def value(self, entry: Element, *tags: str) -> Array:
        """Numbers of the first of these tags."""
        for tag in tags:
            if (found := entry.find(tag)) is not None:
                return self.curves.numbers(found, self.time)
        raise InputError(f"{entry.get('line')}: expected <{'> or <'.join(tags)}>.", code="missing-element")


def segments_of(root: Element) -> list[Segment]:
    """Steps with the elements of <Boundary>, <Rigid>, <Loads> and <Constraints> that are active in them."""

    def active(parent: Element) -> list[Element]:
        tags = ("Boundary", "Rigid", "Loads", "Constraints")
        return [e for tag in tags for section in parent.findall(tag) for e in section]

    def duration(parent: Element) -> float:
        control = parent.find("Control")
        if control is None:
            return 1.0
        return float(control.findtext("time_steps") or 1) * float(control.findtext("step_size") or 1)

    own = active(root)
    inner = [s for section in root.findall("Step") for s in (section.findall("step") or [section])]
    if not inner:
        return [Segment("", 0.0, duration(root), own)]
    out, time = [], 0.0
    for k, step in enumerate(inner, start=1):
        end = time + duration(step)
        out.append(Segment(step.get("name") or f"step {k}", time, end, [*own, *active(step)]))
        time = end
    return out


def deck_steps(
    segments: Sequence[Segment],
    curves: Curves,
    mesh: Mesh,
    rigid: Mapping[str, DeckRigid],
    rigid_names: Mapping[str, str],
    source: str,
    remarks: Remarks,
) -> list[DeckStep]:
    """Supports and loads at the end of each step and wherever one of its load curves bends, if they change there."""
    out: list[DeckStep] = []
    last: list[Array] = []
    for segment in segments:
        for time in _times(segment, curves):
            free, unloaded = np.full(mesh.points.shape, np.nan), np.zeros(mesh.points.shape)
            state = State(mesh, curves, rigid_names, remarks, time, free, unloaded)
            state.motions = {name: np.full(6, np.nan if r.normal is None else 0.0) for name, r in rigid.items()}
            state.loads = {name: np.zeros(6) for name in rigid}
            for entry in segment.active:
                _apply(entry, state)
            frames = [_frame(part, state) for part in rigid.values()]
            now = [state.held, state.forces, state.gravity, *state.motions.values(), *state.loads.values()]
            now += [np.array(list(state.pressures.values())), *state.tractions.values()]
            if last and len(now) == len(last) and all(map(_same, now, last)):
                continue
            if not out and not any(np.nan_to_num(part).any() for part in now):
                continue
            last = now
            name = f"{segment.name} t = {time:.6g}".strip()
            loads = state.forces, state.pressures, state.tractions, state.gravity
            out.append(DeckStep(name, state.held, *loads, frames))
    if not out:
        raise InputError(
            f"{source} has no load and no prescribed motion that is not zero, so there is nothing to solve.",
            code="no-load",
        )
    return out


def _same(one: Array, other: Array) -> bool:
    return one.shape == other.shape and np.array_equal(one, other, equal_nan=True)


def _times(segment: Segment, curves: Curves) -> list[float]:
    """Times of the points of the load curves in use, up to the end of the step, and the end."""
    used = {c.get("lc", "") for entry in segment.active for c in entry.iter()} & set(curves.curves)
    times = np.concatenate([[segment.end], *(curves.curves[lc].bends(segment.start, segment.end) for lc in used)])
    slack = SAME_TIME * max(abs(segment.end), 1e-300)
    inside = np.unique(times[(times > segment.start + slack) & (times <= segment.end + slack)])
    return inside[np.append(np.diff(inside) > slack, True)].tolist()


def _apply(entry: Element, state: State) -> None:
    """Take an element of <Boundary>, <Rigid>, <Loads> or <Constraints>; those that are not used are noted."""
    kind, place = entry.get("type") or entry.tag, entry.get("line")
    known, nodes = OTHERS | (OF_SURFACES if entry.tag == "surface_load" else {}), None
    if entry.get("node_set") is not None:
        nodes = nodes_of(entry, state.mesh, state.remarks)
        if nodes is None:
            if entry.tag == "nodal_load":
                raise InputError(f"{place}: the load on {entry.get('node_set')!r} would be lost: no nodes of solids.")
            return
        known |= OF_NODES
    if kind in known:
        known[kind](entry, kind, state, nodes)
        return
    what = f"<{entry.tag}>" if kind == entry.tag else f"<{entry.tag} type={kind!r}>"
    if entry.tag.endswith("_load") or entry.tag in WOULD_BE_LOST:
        lost = "its load" if entry.tag.endswith("_load") else "what it holds or moves"
        raise not_done(f"{place}: {what} is not done here, and {lost} would be lost.")
    state.remarks.warn(f"{place}: {what} is not used: what it changes is left out.")


def nodes_of(entry: Element, mesh: Mesh, remarks: Remarks) -> IntArray | None:
    """Nodes of an element's set, or of its surface ``@surface:name``; None where they belong to no solid."""
    name = entry.get("node_set", "")
    what, _, of = name.rpartition(":")
    if what == "@surface" and of in mesh.boundaries:
        return mesh.boundary_nodes(of)
    if not what and name in mesh.node_sets:
        return mesh.node_sets[name]
    remarks.note(f"{entry.get('line')}: not used, as {name!r} has no nodes of solids.")
    return None


def _fix(entry: Element, kind: str, state: State, nodes: IntArray) -> None:
    """Hold the components of <bc type="zero displacement">, of <bc type="fix"> or of <fix>."""
    listed = entry.findtext("dofs") or entry.get("bc")
    held = [axis for axis in "xyz" if (entry.findtext(f"{axis}_dof") or "0").strip() == "1"]
    if listed is not None:
        held = [name.strip() for name in listed.split(",") if name.strip() in "xyz"]
    for name in held:
        state.held[nodes, DOFS[name]] = 0.0


def _component(entry: Element) -> int:
    """Component that <dof> or the attribute ``bc`` names."""
    name = (entry.findtext("dof") or entry.get("bc") or "").strip()
    if name not in DOFS:
        raise InputError(f"{entry.get('line')}: expected a component out of {', '.join(DOFS)}; found {name!r}.")
    return DOFS[name]


def _prescribe(entry: Element, kind: str, state: State, nodes: IntArray) -> None:
    if (entry.findtext("relative") or "0").strip() != "0":
        raise InputError(f"{entry.get('line')}: relative displacements are not done here; write them in full.")
    state.held[nodes, _component(entry)] = state.value(entry, "value", "scale")[0]


def _attach(entry: Element, kind: str, state: State, nodes: IntArray) -> None:
    """Nodes of a rigid part, see `decks.febio`; its name is checked."""
    rigid_name(entry, state.rigid)


def _push(entry: Element, kind: str, state: State, nodes: IntArray) -> None:
    """Forces on each node: a vector, or one component."""
    values = state.value(entry, "value", "scale")
    if len(values) == 3:
        state.forces[nodes] += values
    else:
        state.forces[nodes, _component(entry)] += values[0]


def _load_surface(entry: Element, kind: str, state: State, nodes: IntArray | None) -> None:
    """A pressure against the outward normal, or a traction."""
    inner = entry.find("surface")
    name = (entry if inner is None else inner).get("surface", "")
    if name not in state.mesh.boundaries:
        raise InputError(f"{entry.get('line')}: the load on {name!r} would be lost: it is no surface of solids.")
    if kind == "pressure":
        state.pressures[name] = state.pressures.get(name, 0.0) + state.value(entry, "pressure")[0]
    else:
        factor = 1.0 if entry.find("scale") is None else state.value(entry, "scale")[0]
        traction = factor * state.value(entry, "traction")
        state.tractions[name] = state.tractions.get(name, np.zeros(3)) + traction


def _pull(entry: Element, kind: str, state: State, nodes: IntArray | None) -> None:
    """The force per mass of <body_load type="const"> or "body force", whose sign FEBio turns over."""
    if entry.get("elem_set"):
        raise not_done(f"{entry.get('line')}: a body load on a part alone is not done here.")
    if kind == "body force":
        state.gravity = state.gravity - state.value(entry, "force")
    else:
        parts = [entry.find(axis) for axis in "xyz"]
        given = [0.0 if p is None else state.curves.numbers(p, state.time)[0] for p in parts]
        state.gravity = state.gravity - np.array(given)


def wall_of(entry: Element, mesh: Mesh) -> DeckRigid:
    """The plane a . x = d of <constraint type="rigid_wall">, with the body on the side of a.

    Its `centre` is the point of the plane nearest to the middle of the mesh.
    """
    try:
        a, d = np.split(np.array((entry.findtext("plane") or "").split(","), dtype=float), [3])
        size = float(np.linalg.norm(a))
        middle = mesh.points.mean(axis=0)
        centre = middle - (a @ middle - d[0]) / size**2 * a
    except (ValueError, IndexError):
        raise InputError(f"{entry.get('line')}: expected a plane of four numbers.", code="numbers") from None
    name = wall_name(entry)
    return DeckRigid(name, centre, None, frozenset([name]), np.zeros(0, np.int64), a / size)


def wall_name(entry: Element) -> str:
    """Name of the wall of a constraint."""
    return f"wall of {entry.get('surface')}"


def _wall(entry: Element, kind: str, state: State, nodes: IntArray | None) -> None:
    """Move a wall along its normal by its offset."""
    if entry.find("offset") is not None:
        plane = np.array((entry.findtext("plane") or "").split(","), dtype=float)[:3]
        state.motions[wall_name(entry)][:3] = state.value(entry, "offset")[0] * plane / np.linalg.norm(plane) ** 3


def _mirror(entry: Element, kind: str, state: State, nodes: IntArray | None) -> None:
    """Hold the component across a plane of symmetry that is normal to an axis."""
    mesh = state.mesh
    name = look_up(entry.get("surface", ""), mesh.boundaries, "surface of solids", entry.get("line", ""))
    plane = mesh.boundary_nodes(name)
    flat = np.ptp(mesh.points[plane], axis=0) <= FLAT * np.linalg.norm(np.ptp(mesh.points, axis=0))
    if flat.sum() != 1:
        raise InputError(f"{entry.get('line')}: {name!r} is no plane normal to an axis, so it is not held across.")
    state.held[plane, int(np.argmax(flat))] = 0.0


def rigid_name(entry: Element, rigid_names: Mapping[str, str]) -> str:
    """Name of the rigid part of an element, by its <rb> or attribute ``rb``."""
    given = (entry.findtext("rb") or entry.get("rb") or "").strip()
    if given not in rigid_names:
        raise InputError(f"{entry.get('line')}: there is no rigid material {given!r}.", code="unknown-rigid-material")
    return rigid_names[given]


def _rigid(entry: Element, kind: str, state: State, nodes: IntArray | None) -> None:
    """Held, prescribed or loaded degrees of freedom of a rigid part."""
    name = rigid_name(entry, state.rigid)
    if name not in state.motions:
        return
    if kind == "rigid_fixed":
        for dof in ("Rx", "Ry", "Rz", "Ru", "Rv", "Rw"):
            if (entry.findtext(f"{dof}_dof") or "0").strip() == "1":
                state.motions[name][DOFS[dof]] = 0.0
        return
    if kind == "rigid_rotation_vector":
        axes = [entry.find(v) for v in ("vx", "vy", "vz")]
        state.motions[name][3:] = [0.0 if v is None else state.curves.numbers(v, state.time)[0] for v in axes]
        return
    component = _component(entry)
    if kind in ("rigid_rotation", "rigid_moment"):
        component = 3 + component % 3  # named x, y, z or Ru, Rv, Rw
    target = state.loads if kind in ("rigid_force", "rigid_moment") else state.motions
    target[name][component] = state.value(entry, "value")[0]


#: What takes elements of these types: those of nodes, those of <surface_load>, and others.
_Takers = dict[str, Callable[..., None]]
OF_NODES: _Takers = {
    **dict.fromkeys(("zero displacement", "fix"), _fix),
    **dict.fromkeys(("prescribed displacement", "prescribe"), _prescribe),
    **dict.fromkeys(("nodal_force", "nodal_load"), _push),
    "rigid": _attach,
}
OF_SURFACES: _Takers = dict.fromkeys(("pressure", "traction"), _load_surface)
OTHERS: _Takers = {
    **dict.fromkeys(("rigid_fixed", "rigid_displacement", "rigid_rotation", "rigid_rotation_vector"), _rigid),
    **dict.fromkeys(("rigid_force", "rigid_moment"), _rigid),
    "symmetry plane": _mirror,
    "rigid_wall": _wall,
    **dict.fromkeys(("const", "body force"), _pull),
}


def _frame(part: DeckRigid, state: State) -> DeckFrame:
    """Motion of a rigid part; what is attached to it is held in its frame, or moved with it."""
    motion = state.motions[part.name]
    weight = np.append((part.mass or 0.0) * state.gravity, np.zeros(3))
    load = state.loads[part.name] + np.where(np.isnan(motion), weight, 0.0)
    unknown = np.isnan(motion) & (load == 0)
    given = np.where(np.isnan(motion), 0.0, motion)
    frame = DeckFrame(
        part.name,
        {name: float(v) for name, v in zip(COMPONENTS, given, strict=True) if v},
        " ".join(name for name, free in zip(COMPONENTS, unknown, strict=True) if free),
        load[:3],
        load[3:],
    )
    moved = (rigid_modes(state.mesh.points[part.attached], part.centre) @ given).reshape(-1, 3)
    state.held[part.attached] = 0.0 if frame.is_free else moved
    return frame
