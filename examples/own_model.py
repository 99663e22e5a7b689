"""A numerics researcher's first picture: a mesh and a stiffness of scikit-fem, an own
solver, certified, beside Hertz.

Run: python examples/own_model.py
"""

from pathlib import Path

import numpy as np
from skfem import Basis, ElementHex2, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

import fecontact as fc

RUBBER = fc.Material(E=1.0, nu=0.3)


def projected_gauss_seidel(
    problem: fc.solvers.ContactProblem, sweeps: int = 200
) -> tuple:
    """Forces and motions of a scene without free motions; checked by the caller."""
    forces = np.zeros(problem.n)
    for k in sweeps * list(range(problem.n)):
        forces[k] = max(
            0.0, forces[k] - (problem.S[k] @ forces + problem.g[k]) / problem.S[k, k]
        )
    return forces, np.zeros(problem.m)


def main(n: int = 10, out: str | Path = "out") -> fc.ContactResult:
    x = np.linspace(0, 1, n + 1)
    # a quarter of a block, with small elements at the middle of its top
    x = x * (0.3 + 0.7 * x**2)
    sides = {
        "below": lambda x: x[2] == -1,
        "above": lambda x: x[2] == 0,
        "x0": lambda x: x[0] == 0,
    }
    theirs = MeshHex.init_tensor(x, x, -x[::-2]).with_boundaries(
        sides | {"y0": lambda x: x[1] == 0}
    )
    basis = Basis(theirs, ElementVector(ElementHex2()), intorder=5)
    K = linear_elasticity(*lame_parameters(RUBBER.E, RUBBER.nu)).assemble(basis)
    body = fc.AssembledBody.from_skfem(
        basis, K, RUBBER, "above", {"below": "xyz", "x0": "x", "y0": "y"}, name="own"
    )
    ball = fc.RigidBody(fc.Sphere(20.0), name="ball")
    scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
    result = scene.solve(motions={ball: {"z": -0.003}}, solver=projected_gauss_seidel)
    print(result)
    exact = fc.hertz.spheres(
        (20.0, np.inf), (None, RUBBER), force=4 * result.contacts[0].total_force
    )
    print(
        f"peak {result.contacts[0].max_pressure:.6f}, of Hertz at this force "
        f"{exact.p0:.6f}"
    )
    Path(out).mkdir(parents=True, exist_ok=True)
    result.plot("pressure", Path(out) / "own_model.png")
    return result


if __name__ == "__main__":
    main()
