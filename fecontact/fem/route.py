"""Choice of a route of condensation (`fem.condensation`) by measured times and the free memory."""

from __future__ import annotations

import os
from pathlib import Path

#: Largest share of the free memory for dense matrices of a body.
MEMORY_SHARE = 0.5
#: Candidate nodes, over the root of the degrees of freedom, above which the columns of given rows are faster than the
#: Schur complement on their nodes, although that one serves other rows on the same nodes too: 500 nodes at 3e4
#: (docs/figures/scale.md).
MANY_NODES = 3.0
#: The same above which products are faster than solving for columns one by one, without PARDISO.
MANY_PRODUCTS = 10.0
#: Seconds on one thread, of which only ratios matter, to a third of what was measured: layers of 15-node wedges of
#: 26,000 to 83,000 unknowns on 300 to 2,500 nodes, blocks of 20-node hexahedra of 8,400 and 46,000 unknowns. A factor
#: per entry squared over the unknowns (as of a band), and per byte.
SECONDS_PER_FACTOR, SECONDS_PER_BYTE = 3e-11, 1.5e-9
#: A Schur complement, its Cholesky factor and its inverse, per degree of freedom cubed, and rows by it, squared.
SECONDS_PER_SCHUR, SECONDS_PER_POSE = 4e-11, 1e-8


def choose_route(
    n_dofs: int,
    n_retained: int,
    budget: float,
    poses: int = 1,
    one_by_one: bool = False,
    n_rows: int | None = None,
    factor: float = 0.0,
) -> tuple[str, str]:
    """Choose a route of condensation; return it with the reason.

    Parameters
    ----------
    n_dofs : int
        Unknowns of the solve.
    n_retained : int
        Degrees of freedom of the nodes in the rows.
    budget : float
        Bytes available for dense matrices.
    poses : int
        Number of cases that share what is condensed onto these nodes. Columns are made anew for each of them.
    one_by_one : bool
        Whether columns are solved for one by one, see `fem.factor.has_bordered`.
    n_rows : int, optional
        Number of rows, if they are known; each is taken to be on one node otherwise. A row of a mortar coupling is on
        dozens of nodes.
    factor : float
        Bytes of a factor of this stiffness, for several poses.

    Examples
    --------
    >>> choose_route(40000, 900, 4e9)[0], choose_route(100000, 15000, 64e9)[0], choose_route(40000, 900, 1e6)[0]
    ('schur', 'columns', 'operator')
    >>> choose_route(400000, 30000, 1e9)[0], choose_route(400000, 30000, 1e9, n_rows=300)[0]
    ('operator', 'columns')
    """
    nodes, root = n_retained // 3, n_dofs**0.5
    rows = nodes if n_rows is None else n_rows
    # S and a solver's copies; K_hat twice (one inside PARDISO) and Y
    columns = 8.0 * 5 * rows**2
    dense = columns + 8.0 * (2 * n_retained**2 + n_retained * rows)
    if columns > budget or (one_by_one and dense > budget and n_rows is None):
        what = f"{nodes} nodes" if n_rows is None else f"{rows} rows"
        return "operator", f"a dense matrix for {what} takes {columns / 1e9:.2g} GB of {budget / 1e9:.2g} GB"
    if poses > 1 and dense <= budget and (one_by_one or once_for_all(n_dofs, n_retained, poses, factor)):
        return "schur", f"{nodes} candidate nodes, shared by {poses} poses"
    # many rows on few nodes are few columns
    if one_by_one and min(rows, nodes) >= (many := int(MANY_PRODUCTS * root)):
        return "operator", f"{rows} candidates, from {many} on products with the factor are quicker"
    if dense > budget:
        return "columns", f"the Schur complement on {nodes} nodes takes {dense / 1e9:.2g} GB of {budget / 1e9:.2g} GB"
    if poses > 1:
        return "columns", f"columns for each of {poses} poses are quicker than a Schur complement on {nodes} nodes"
    if not one_by_one and nodes >= (many := int(MANY_NODES * root)):
        return "columns", f"{nodes} candidate nodes, from {many} on only their columns are computed"
    if one_by_one and rows < nodes:
        return "schur", f"{rows} rows on {nodes} candidate nodes, fewer than {many}"
    return "schur", f"{nodes} candidate nodes, fewer than {int((MANY_PRODUCTS if one_by_one else MANY_NODES) * root)}"


def once_for_all(n_dofs: int, n_retained: int, poses: int, factor: float) -> bool:
    """Whether one Schur complement with its inverse is quicker than columns, and so a factor, for each of some poses.

    Parameters
    ----------
    n_dofs, n_retained, poses : int
    factor : float
        Bytes of a factor.

    Examples
    --------
    A layer of cartilage, 26,340 unknowns: 800 nodes are condensed for twenty poses, 2,500 nodes are not.

    >>> once_for_all(26340, 2400, 20, 53e6), once_for_all(26340, 7500, 20, 53e6), once_for_all(26340, 2400, 2, 53e6)
    (True, False, False)
    """
    entries = factor / 8
    anew = SECONDS_PER_FACTOR * entries**2 / max(n_dofs, 1) + SECONDS_PER_BYTE * factor
    once = SECONDS_PER_SCHUR * float(n_retained) ** 3
    return once + poses * SECONDS_PER_POSE * float(n_retained) ** 2 < (poses - 1) * anew


def memory_budget() -> float:
    """Bytes for dense matrices: `MEMORY_SHARE` of the memory free on this machine and in its container."""
    free = _physical_memory()
    try:
        text = Path("/proc/meminfo").read_text()
        free = 1024.0 * int(text.split("MemAvailable:")[1].split()[0])
        limit = Path("/sys/fs/cgroup/memory.max").read_text().strip()
        if limit != "max":
            free = min(free, float(limit) - float(Path("/sys/fs/cgroup/memory.current").read_text()))
    except (OSError, IndexError, ValueError):
        pass  # not Linux, or no container: keep the value found so far
    return MEMORY_SHARE * max(free, 0.0)


def _physical_memory() -> float:
    """Bytes of memory of this machine; 8 GB where unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * float(os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return 8e9
