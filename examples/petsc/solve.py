"""Solve a contact problem out of its neutral file with PETSc, on as many processes as
there are.

    mpiexec -n 2 python3 solve.py problem.npz forces.npz [PETSc's options]

Needs numpy and petsc4py (Debian: python3-petsc4py) and nothing of fecontact;
docs/neutral-file.md describes the file. Every body's stiffness is distributed by rows.
Its compliance along the contact's rows comes from one solution for each row, by MUMPS'
Cholesky factor unless the options say otherwise; with -ksp_type cg -pc_type gamg it is
multigrid with the rigid modes as near-nullspace. The variational inequality

    w = S l + g + B^T q >= 0,   l >= 0,   l . w = 0,   B l = F

is solved by the reduced-space Newton method of SNES (vinewtonrsls) in the unknowns (l,
q), l >= 0 and q free.
"""

import sys

import numpy as np
import petsc4py

petsc4py.init(sys.argv)
from petsc4py import PETSc  # noqa: E402


def everywhere(v):
    """The whole of a distributed vector on every process."""
    scatter, whole = PETSc.Scatter.toAll(v)
    scatter.scatter(v, whole)
    return whole.getArray().copy()


def distributed(indptr, indices, data, n):
    """Square matrix (n, n) of which every process takes its rows."""
    A = PETSc.Mat().create()
    A.setSizes(n)
    A.setType("aij")
    A.setUp()
    first, last = A.getOwnershipRange()
    start, stop = indptr[first], indptr[last]
    own = (indptr[first : last + 1] - start).astype(PETSc.IntType)
    A = PETSc.Mat().createAIJ(
        n, csr=(own, indices[start:stop].astype(PETSc.IntType), data[start:stop])
    )
    A.assemble()
    return A


def solver(K, modes):
    """Linear solver of a stiffness: MUMPS unless PETSc's options say otherwise."""
    first, last = K.getOwnershipRange()
    vectors = []
    for mode in np.linalg.qr(modes)[0].T:
        v = K.createVecLeft()
        v.setArray(mode[first:last])
        vectors.append(v)
    K.setNearNullSpace(PETSc.NullSpace().create(vectors=vectors))
    K.setOption(PETSc.Mat.Option.SPD, True)
    ksp = PETSc.KSP().create()
    ksp.setOperators(K)
    ksp.setType("preonly")
    ksp.getPC().setType("cholesky")
    ksp.getPC().setFactorSolverType("mumps")
    ksp.setTolerances(rtol=1e-13, max_it=10000)
    ksp.setFromOptions()
    return ksp


def condensed(file, key):
    """Compliance (n_rows, n_rows) of a body along its rows, and its response (n_rows,)
    to its loads.
    """
    indptr, indices, data = (
        file[f"{key}_stiffness_{part}"] for part in ("indptr", "indices", "data")
    )
    n = len(indptr) - 1
    K = distributed(indptr, indices, data, n)
    ksp = solver(K, file[f"{key}_rigid_modes"])
    b, x = K.createVecRight(), K.createVecLeft()
    first, last = K.getOwnershipRange()
    start, column, value = (
        file[f"{key}_coupling_{part}"] for part in ("indptr", "indices", "data")
    )
    n_rows = len(start) - 1
    row = np.repeat(np.arange(n_rows), np.diff(start))
    own = (column >= first) & (column < last)
    row, column, value = row[own], column[own] - first, value[own]

    def along():
        """Displacement along all rows, summed over the processes."""
        total = PETSc.Vec().createMPI(n_rows)
        part = np.bincount(row, value * x.getArray()[column], minlength=n_rows)
        total.setValues(
            np.arange(n_rows, dtype=PETSc.IntType),
            part,
            addv=PETSc.InsertMode.ADD_VALUES,
        )
        total.assemble()
        return everywhere(total)

    S = np.empty((n_rows, n_rows))
    for k in range(n_rows):
        mine = row == k
        local = np.zeros(last - first)
        np.add.at(local, column[mine], value[mine])
        b.setArray(local)
        ksp.solve(b, x)
        S[:, k] = along()
    b.setArray(file[f"{key}_loads"][first:last])
    ksp.solve(b, x)
    return (S + S.T) / 2, along()


def contact(S, g, B, F):
    """Forces l and motions q of the variational inequality."""
    n, m = len(g), len(F)
    # units in which forces and gaps are of order one
    gap, stiff = max(np.abs(g).max(), 1e-300), np.abs(S).max()
    force = gap / stiff
    size = np.abs(B).max(axis=1, keepdims=True) if m else np.ones((0, 1))
    A = np.block([[S / stiff, (B / size).T], [-B / size, np.zeros((m, m))]])
    c = np.concatenate([g / gap, F / size[:, 0] / force])
    J = PETSc.Mat().createAIJ(n + m, nnz=n + m)
    first, last = J.getOwnershipRange()
    J.setValues(
        np.arange(first, last, dtype=PETSc.IntType),
        np.arange(n + m, dtype=PETSc.IntType),
        A[first:last],
    )
    J.assemble()
    x, low, high = J.createVecRight(), J.createVecRight(), J.createVecRight()
    constant = J.createVecLeft()
    constant.setArray(c[first:last])
    low.setArray(np.where(np.arange(first, last) < n, 0.0, PETSc.NINFINITY))
    high.set(PETSc.INFINITY)
    # all points in touch at first: without any, nothing would carry the load
    x.setArray(np.where(np.arange(first, last) < n, 1.0, 0.0))

    def residual(snes, at, out):
        J.mult(at, out)
        out.axpy(1.0, constant)

    snes = PETSc.SNES().create()
    snes.setOptionsPrefix("contact_")
    snes.setType("vinewtonrsls")
    snes.setFunction(residual, J.createVecLeft())
    snes.setJacobian(lambda snes, at, A, P: None, J)
    snes.setVariableBounds(low, high)
    snes.setTolerances(rtol=1e-14, atol=1e-13, stol=0.0, max_it=200)
    ksp = snes.getKSP()
    ksp.setType("preonly")
    ksp.getPC().setType("lu")
    ksp.getPC().setFactorSolverType("mumps")
    snes.setFromOptions()
    snes.solve(None, x)
    z = everywhere(x)
    return z[:n] * force, z[n:] * gap / size[:, 0], snes


def main(problem, answer):
    file = np.load(problem, allow_pickle=False)
    g, B, F = file["gap"].copy(), file["equilibrium"], file["load"]
    S = np.diag(file["own_compliance"])
    for k in range(int(file["n_bodies"])):
        rows = file[f"body{k}_coupling_rows"]
        compliance, response = condensed(file, f"body{k}")
        S[np.ix_(rows, rows)] += compliance
        g[rows] += response
    forces, motions, snes = contact(S, g, B, F)
    gap = S @ forces + g + B.T @ motions
    if PETSc.COMM_WORLD.getRank() == 0:
        np.savez(answer, forces=forces, motions=motions, gap=gap)
        print(
            f"PETSc {'.'.join(map(str, PETSc.Sys.getVersion()))}, "
            f"{PETSc.COMM_WORLD.getSize()} processes: "
            f"{(forces > 0).sum()} of {len(g)} points in contact, "
            f"{snes.getIterationNumber()} steps "
            f"(reason {snes.getConvergedReason()})"
        )


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
