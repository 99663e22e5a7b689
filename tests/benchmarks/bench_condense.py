"""Time and memory of the three ways to the compliance, by number of candidates and degrees of freedom.

    python tests/benchmarks/bench_condense.py                  the whole table, each row in a process of its own
    python tests/benchmarks/bench_condense.py 28 1000 schur    one row: divisions, candidates, way

A block of 20-node hexahedra is pressed by a rigid ball; the candidates are the nodes of its face that are nearest to
the middle, and two in three of them come into contact. Processor seconds of one thread.
"""

import os
import subprocess
import sys
import time

import numpy as np
import scipy.sparse as sp

import fecontact as fc
from fecontact.common.stopwatch import Stopwatch
from fecontact.results.report import peak_memory
from fecontact.solvers import ContactProblem, solve

#: Divisions of the face; a block is four times as wide as it is high. 24k, 54k, 111k, 155k degrees of freedom.
SIZES = (20, 26, 34, 38)
CANDIDATES = (200, 600, 1200, 2500, 5000)
WAYS = ("schur", "columns", "operator")
HEAD = "| dofs | candidates | way | factorise | condense | solve | together | products | factor, MB | peak, MB |"


def row(divisions, candidates, way):
    mesh = fc.shapes.block((4.0, 4.0, 1.0), (divisions, divisions, max(divisions // 4, 1)))
    body = fc.ElasticBody(mesh, fc.Material(1.0, 0.3), "top", {"bottom": "xyz"}, condensation=way)
    top = body.surface("top").nodes
    r = np.hypot(*body.mesh.points[top, :2].T)
    near = np.argsort(r, kind="stable")[:candidates]
    n = len(near)
    entries = (np.full(n, -1.0), (np.arange(n), 3 * top[near] + 2))
    rows = sp.csr_matrix(entries, shape=(n, body.n_dofs))
    began, timer = time.process_time(), Stopwatch()
    model = body.model
    K = model.stiffness
    spans = {"assemble": time.process_time() - began}
    began = time.process_time()
    model.condensed(top[near], timer, rows=model.solved_rows(rows))
    spans["factorise"] = time.process_time() - began
    began = time.process_time()
    S = body.reduce(rows, None, timer).compliance
    spans["condense"] = time.process_time() - began
    began = time.process_time()
    # the force that closes two thirds of the candidates' area on a half-space
    edge = np.sqrt(2 / 3) * r[near].max()
    force = 4 / 3 * edge**3 / 10.0 / (1 - 0.3**2)
    problem = ContactProblem(S, r[near] ** 2 / 20.0, np.ones((1, n)), np.array([force]))
    solution = solve(problem)
    spans["solve"] = time.process_time() - began
    together = spans["factorise"] + spans["condense"] + spans["solve"]
    products = solution.nit if way == "operator" else 0
    del K
    return (
        f"| {body.n_dofs} | {n} | {way} | {spans['factorise']:.1f} | {spans['condense']:.1f} | {spans['solve']:.1f} "
        f"| {together:.1f} | {products or ''} | {model.condensation.memory / 1e6:.0f} | {peak_memory():.0f} |"
    )


def main():
    if len(sys.argv) > 1:
        print(row(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]))
        return
    print(HEAD)
    print("|" + "---|" * (HEAD.count("|") - 1))
    for divisions in SIZES:
        for candidates in CANDIDATES:
            for way in WAYS:
                command = [sys.executable, __file__, str(divisions), str(candidates), way]
                environment = {**os.environ, "OMP_NUM_THREADS": "1"}
                out = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
                print(out.stdout.strip() or f"| {divisions} | {candidates} | {way} | failed |", flush=True)


if __name__ == "__main__":
    main()
