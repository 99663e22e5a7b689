"""A numerics researcher's first picture: a mesh and a stiffness of scikit-fem, an own solver, certified.

Run: python examples/own_model.py
"""

from pathlib import Path

import numpy as np
from skfem import Basis, ElementHex2, ElementVector, MeshHex
from skfem.models.elasticity import lame_parameters, linear_elasticity

import fecontact as fc


def projected_gauss_seidel(problem: fc.solvers.ComplementarityProblem, sweeps: int = 200) -> tuple:
    """Forces and rigid motions of a scene without free motions (B is empty); checked by the caller."""
    forces = np.zeros(problem.n)
    for _ in range(sweeps):
        for k in range(problem.n):
            w = problem.S[k] @ forces + problem.g[k]
            forces[k] = max(0.0, forces[k] - w / problem.S[k, k])
    return forces, np.zeros(problem.m)


def main(n: int = 10, out: str | Path = "out") -> fc.ContactResult:
    x = np.linspace(-1, 1, n + 1)
    x = x * (0.25 + 0.75 * x**2)  # small elements in the middle
    theirs = MeshHex.init_tensor(x, x, x[: n // 2 + 1]).with_boundaries(
        {"below": lambda x: x[2] == -1.0, "above": lambda x: x[2] == 0.0}
    )
    basis = Basis(theirs, ElementVector(ElementHex2()), intorder=5)
    K = linear_elasticity(*lame_parameters(1.0, 0.3)).assemble(basis)
    rubber = fc.Material(E=1.0, nu=0.3)
    body = fc.AssembledBody.from_skfem(basis, K, rubber, contact="above", supports={"below": "xyz"}, name="own")
    ball = fc.RigidBody(fc.Sphere(20.0), name="ball")
    scene = fc.Scene([body, ball], [fc.Contact(body, ball)])
    result = scene.solve(motions={ball: {"z": -0.006}}, solver=projected_gauss_seidel)
    print(result)
    Path(out).mkdir(parents=True, exist_ok=True)
    result.plot("pressure", Path(out) / "own_model.png")
    return result


if __name__ == "__main__":
    main()
