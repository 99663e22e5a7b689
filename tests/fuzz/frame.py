"""The same scene otherwise: in other units, turned, mirrored, renumbered, with sides swapped, by another solver."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.mesh.element import FACES
from fecontact.mesh.refine import refined


@dataclass(frozen=True)
class Frame:
    """How a scene is written and solved; generators describe it at home, and a frame puts it down."""

    length: float = 1.0
    modulus: float = 1.0
    turn: np.ndarray = field(default_factory=lambda: np.eye(3))
    mirrored: bool = False
    shuffled: int | None = None
    swapped: bool = False
    solver: str = "auto"
    #: steps of a path after which it is interrupted and resumed
    resumed: int = 0
    #: factor on a prescribed depth
    deeper: float = 1.0
    #: how often every cell is divided
    divided: int = 0
    #: bodies alike are made each by itself, not as copies of one
    separate: bool = False

    @property
    def force(self) -> float:
        return self.modulus * self.length**2

    @property
    def _mirror(self) -> np.ndarray:
        return np.diag([-1.0, 1.0, 1.0]) if self.mirrored else np.eye(3)

    def vector(self, v: Any, unit: float = 1.0) -> tuple[float, ...]:
        """A direction, force or place of the home frame."""
        return tuple(float(c) for c in unit * self.turn @ self._mirror @ np.asarray(v, dtype=float))

    def own(self, v: Any) -> tuple[float, ...]:
        """A place in a body's own axes, which are turned with the body."""
        return tuple(float(c) for c in self.length * self._mirror @ np.asarray(v, dtype=float))

    def axial(self, v: Any, unit: float = 1.0) -> tuple[float, ...]:
        """A moment or rotation vector of the home frame."""
        return tuple(float(c) for c in unit * self.turn @ (np.linalg.det(self._mirror) * self._mirror @ np.asarray(v)))

    def material(self, E: float, nu: float) -> fc.Material:
        return fc.Material(E * self.modulus, nu)

    def mesh(self, mesh: Any) -> Any:
        """A mesh, or a section, in these units, mirrored and renumbered; it is turned by the pose of its body."""
        made = mesh.scaled(self.length) if self.length != 1 else mesh
        for _ in range(self.divided):
            made = refined(made, np.arange(len(made.cells)))
        if self.mirrored:
            made = mirrored(made)
        return made if self.shuffled is None else renumbered(made, self.shuffled)

    def placed(self, body: Any, at: Any = (0.0, 0.0, 0.0), rotation: np.ndarray | None = None) -> Any:
        """A body in its place of the home frame, turned about its own origin first."""
        own = self._mirror @ (np.eye(3) if rotation is None else rotation) @ self._mirror
        return body.placed(self.vector(at, self.length), self.turn @ own)

    def rigid(self, shape: Any, at: Any, rotation: np.ndarray | None = None, name: str = "rigid") -> fc.RigidBody:
        return self.placed(fc.RigidBody(shape, name=name), at, rotation)

    def contact(self, one: Any, other: Any, surfaces: tuple[str, str] | None = None, **options: Any) -> fc.Contact:
        if self.swapped:
            one, other, surfaces = other, one, surfaces and surfaces[::-1]
        return fc.Contact(one, other, surfaces, **options)


#: Nodes of a cell whose first axis is reversed, and of a side of a section whose sense is. Where cells are collapsed
#: stays the same, as quadrature in wedges and tetrahedra depends on it.
_HEXAHEDRON = np.array(
    [1, 0, 3, 2, 5, 4, 7, 6, 8, 11, 10, 9, 12, 15, 14, 13, 17, 16, 19, 18, 21, 20, 22, 23, 24, 25, 26]
)
_QUADRILATERAL = np.array([0, 3, 2, 1, 7, 6, 5, 4, 8])


def mirrored(mesh: Any) -> Any:
    """The mesh at -x, its cells right-handed again."""
    space = not isinstance(mesh, fc.SectionMesh)
    order = (_HEXAHEDRON if space else _QUADRILATERAL)[: mesh.cells.shape[1]]
    if space:
        corners = [frozenset(order[list(face)]) for face in FACES[:, :4]]
        where = np.array([[frozenset(face) for face in FACES[:, :4]].index(face) for face in corners])
    else:
        where = np.array([3, 2, 1, 0])
    sides = {name: np.column_stack([f[:, 0], where[f[:, 1]]]) for name, f in mesh.boundaries.items()}
    flip = np.array([-1.0, 1.0, 1.0])
    return replace(mesh, points=mesh.points * flip, cells=mesh.cells[:, order], boundaries=sides)


def renumbered(mesh: Any, seed: int) -> Any:
    """The mesh with its points and cells in another order."""
    rng = np.random.default_rng(seed)
    new, order = rng.permutation(len(mesh.points)), rng.permutation(len(mesh.cells))
    points = np.empty_like(mesh.points)
    points[new] = mesh.points
    where = np.argsort(order)
    sides = {k: np.column_stack([where[f[:, 0]], f[:, 1]])[rng.permutation(len(f))] for k, f in mesh.boundaries.items()}
    groups = {k: where[g] for k, g in mesh.groups.items()}
    return replace(mesh, points=points, cells=new[mesh.cells][order], boundaries=sides, groups=groups)


HOME = Frame()
#: By name, how else a scene may be written; a door names those that apply to it.
FRAMES = {
    "in other units": Frame(length=1e3, modulus=2e5),
    "in small units": Frame(length=1e-3, modulus=1e9),
    "turned about z": Frame(turn=Rotation.from_rotvec((0, 0, 1.1)).as_matrix()),
    "turned": Frame(turn=Rotation.from_rotvec((0.7, -0.4, 1.1)).as_matrix()),
    "mirrored": Frame(mirrored=True),
    "renumbered": Frame(shuffled=5),
    "swapped": Frame(swapped=True),
    "by wolfe": Frame(solver="wolfe"),
    "by nnls": Frame(solver="nnls"),
    "by projected-cg": Frame(solver="projected-cg"),
    "resumed": Frame(resumed=1),
    "without copies": Frame(separate=True),
}
