"""Hertz contact of two spheres by NGSolve (Schoeberl et al., ngsolve.org), the elements near the pole of given size.

Two equal spheres as in `fecontact hertz` (R = 25 cm, E = 2.0e6 kgf/cm2, nu = 0.3, P = 726.4 kgf): by symmetry one of
them, a quarter of it, on a rigid plane. Curved tetrahedra of degree 2 or more, of one size within 1.5 a of the pole;
contact by an augmented Lagrangian (Hestenes, Powell; Alart and Curnier 1991): the pressure
max(0, lambda - gamma gap) at the points of integration, Newton's method inside, multipliers brought up to date outside.
The force is prescribed: the approach is one more unknown.

Knowing a beforehand, where to refine, and modelling one body instead of two are in NGSolve's favour.
"""

from __future__ import annotations

import math
import time
from functools import partial
from typing import Any

import ngsolve as ng
from _hertz import APPROACH, FORCE, NU, P0, A, E, R, adapter
from netgen import occ

#: Elements near the pole, over a.
SIZES = (0.4, 0.28, 0.2, 0.14, 0.1, 0.07)
#: Augmentation over E / element size, and updates of the multipliers: of those tried, the quickest that left the error
#: to the elements.
FACTOR, UPDATES = 5.0, 3


def meshed(size: float, order: int) -> ng.Mesh:
    """A quarter of a half ball on the plane z = 0, its elements `size` a wide near the pole."""
    ball = occ.Sphere(occ.Pnt(0, 0, R), R) * occ.Box(occ.Pnt(0, 0, -R), occ.Pnt(R, R, R))
    near = occ.Sphere(occ.Pnt(0, 0, 0), 1.5 * A)
    inner, outer = ball * near, ball - near
    body = occ.Glue([inner, outer])
    for solid in body.solids:
        solid.maxh = R / 3
    for face in body.faces:
        c = face.center
        if face.bounding_box[1].z < 1.6 * A:
            face.maxh = size * A
            face.edges.maxh = size * A
        if abs(c.x) < 1e-9:
            face.name = "x"
        elif abs(c.y) < 1e-9:
            face.name = "y"
        elif abs(c.z - R) < 1e-9:
            face.name = "base"
        elif face.bounding_box[1].z < 0.1 * R and math.hypot(c.x, c.y) < A:
            face.name = "cap"
    mesh = ng.Mesh(occ.OCCGeometry(body).GenerateMesh(grading=0.35))
    mesh.Curve(order)
    return mesh


def elastic_energy(u: ng.CoefficientFunction) -> ng.CoefficientFunction:
    """Energy density of an isotropic body."""
    strain = ng.Sym(ng.Grad(u))
    mu, lame = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
    return mu * ng.InnerProduct(strain, strain) + lame / 2 * ng.Trace(strain) ** 2


class Contact:
    """Total energy of the quarter ball and of its contact, as a function of displacements and of the approach."""

    def __init__(self, mesh: ng.Mesh, order: int, gamma: float) -> None:
        self.mesh, self.gamma = mesh, gamma
        self.cap = mesh.Boundaries("cap")
        self.space = ng.VectorH1(mesh, order=order, dirichletx="x|base", dirichlety="y|base", dirichletz="base")
        self.multiplier = ng.GridFunction(ng.SurfaceL2(mesh, order=order, definedon=self.cap))
        self.solution = ng.GridFunction(self.space)
        self.down = ng.Parameter(APPROACH / 2)  # of the ball onto the plane
        u, v = self.space.TnT()
        trial = self.trial(u)
        surface = ng.ds("cap", bonus_intorder=2)
        self.energy = ng.BilinearForm(self.space, symmetric=True)
        self.energy += ng.Variation(elastic_energy(u) * ng.dx)
        self.energy += ng.Variation(ng.IfPos(trial, trial * trial / (2 * gamma), 0) * surface)
        self.touching = ng.IfPos(self.trial(self.solution), 1, 0)
        self.pressure = self.touching * self.trial(self.solution)
        self.border = ng.LinearForm(self.space)
        self.border += -gamma * self.touching * v[2] * surface

    def trial(self, u: ng.CoefficientFunction) -> ng.CoefficientFunction:
        """The pressure, where it is positive."""
        return self.multiplier - self.gamma * (ng.z + u[2] - self.down)

    def integral(self, f: ng.CoefficientFunction, order: int = 12) -> float:
        """Over the cap."""
        return ng.Integrate(f, self.mesh, ng.BND, order=order, definedon=self.cap)

    def total(self) -> float:
        """Energy with the work of the load."""
        return self.energy.Energy(self.solution.vec) - FORCE / 4 * self.down.Get()

    def newton(self, tolerance: float, most: int) -> int:
        """Newton steps with halving until the energy does not rise; how many there were.

        Points of integration that switch between contact and gap may keep it from settling further.
        """
        vector, down = self.solution.vec, self.down
        residual, du, along = (vector.CreateVector() for _ in range(3))
        energy = self.total()
        steps = 0
        while steps < most:
            steps += 1
            self.energy.AssembleLinearization(vector)
            self.energy.Apply(vector, residual)
            self.border.Assemble()
            unbalanced = self.integral(self.pressure) - FORCE / 4
            inverse = self.energy.mat.Inverse(self.space.FreeDofs(), "sparsecholesky")
            du.data = inverse * residual
            along.data = inverse * self.border.vec
            stiffness = self.gamma * self.integral(self.touching) - ng.InnerProduct(self.border.vec, along)
            dd = (unbalanced - ng.InnerProduct(self.border.vec, du)) / stiffness
            du.data -= dd * along
            decrease = abs(ng.InnerProduct(du, residual) + dd * unbalanced)
            scale, was = 1.0, down.Get()
            while True:
                vector.data -= scale * du
                down.Set(was - scale * dd)
                lower = self.total()
                if lower <= energy + 1e-12 * abs(energy) or scale < 1e-2:
                    break
                vector.data += scale * du
                scale /= 2
            energy = lower
            if decrease < tolerance * abs(energy):
                break
        return steps

    def solve(self) -> int:
        """Augmented Lagrangian; how many Newton steps it took."""
        steps = self.newton(1e-3, 20)
        for _ in range(UPDATES):
            self.multiplier.Set(self.pressure, definedon=self.cap)
            steps += self.newton(1e-4, 5)
        return steps


def solved(order: int, size: float) -> dict[str, Any]:
    """Solve at one size (elements near the pole, over a) and measure the errors."""
    began = time.process_time()
    mesh = meshed(size, order)
    meshing = time.process_time() - began
    contact = Contact(mesh, order, FACTOR * E / (size * A))
    steps = contact.solve()
    seconds = time.process_time() - began
    return {
        "dofs": contact.space.ndof,
        "seconds": seconds,
        "mesh_seconds": meshing,
        "steps": steps,
        "errors": errors(contact),
    }


def errors(contact: Contact) -> dict[str, float]:
    """Relative errors: L2 norm of the pressure over r <= 1.2 a, pressure over r <= 0.05 a, approach, second moment."""
    r2 = (ng.x**2 + ng.y**2) / A**2
    exact = P0 * ng.sqrt(ng.IfPos(1 - r2, 1 - r2, 0))
    near = ng.IfPos(1.44 - r2, 1, 0)
    middle = ng.IfPos(0.0025 - r2, 1, 0)
    p, integral = contact.pressure, contact.integral
    return {
        "pressure_l2": math.sqrt(integral(near * (p - exact) ** 2) / integral(near * exact**2)),
        "centre_pressure": integral(middle * p) / integral(middle * exact) - 1,
        "edge_radius": math.sqrt(2.5 * integral(p * r2) / integral(p)) - 1,
        "approach": 2 * contact.down.Get() / APPROACH - 1,
    }


def main(order: int, sizes: tuple[float, ...]) -> None:
    """Answer the command line."""
    ng.SetNumThreads(1)
    about = {"method": f"NGSolve, curved P{order} tetrahedra, one sphere", "kind": "solid", "version": ng.__version__}
    adapter(about, sizes, partial(solved, order))


if __name__ == "__main__":
    main(2, SIZES)
