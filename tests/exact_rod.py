"""A geometrically exact rod as a boundary-value problem, for tests: no finite elements and none of the package's code.

Unknown along the initial length s are the place r, the section's frame R as a unit quaternion and the moment m in fixed
axes; a dead force f acts at the tip. R^T f = diag(EA, GA2, GA3) (R^T r' - e1), R^T m = diag(GJ, EI2, EI3) (k - k0) with
R' = R [k]x and the initial curvature k0, and m' = -r' x f.

Source: J. C. Simo, A finite strain beam formulation, Comput. Methods Appl. Mech. Engrg. 49 (1985), sections 2 to 4.
"""

import numpy as np
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation

#: Nodes of the first mesh of collocation.
NODES = 41


def cantilever(length, force, stretch, bend, curvature=(0.0, 0.0, 0.0), steps=2):
    """Tip of a rod clamped along x under a force (3,): place (3,) and section's axes as columns (3, 3).

    In the section's axes, `stretch` is (EA, GA2, GA3), `bend` (GJ, EI2, EI3), `curvature` that of the initial shape.
    """
    stretch, bend, bent = (np.array(a, dtype=float) for a in (stretch, bend, curvature))
    s = np.linspace(0.0, length, NODES)
    start = Rotation.from_rotvec(s[:, None] * bent)
    along = start.apply([1.0, 0.0, 0.0])
    place = np.concatenate([np.zeros((1, 3)), np.cumsum((along[1:] + along[:-1]) / 2, axis=0) * s[1]])
    found = np.concatenate([place.T, start.as_quat().T, np.zeros((3, NODES))])

    def slopes(_, y, f):
        turn = Rotation.from_quat(y[3:7].T)
        strain = turn.apply(np.tile(f, (y.shape[1], 1)), inverse=True) / stretch
        k = turn.apply(y[7:].T, inverse=True) / bend + bent
        r = turn.apply(np.array([1.0, 0.0, 0.0]) + strain)
        vector, scalar = y[3:6].T, y[6:7].T
        q = np.hstack([scalar * k + np.cross(vector, k), -(vector * k).sum(axis=1, keepdims=True)]) / 2
        return np.vstack([r.T, q.T, -np.cross(r, f).T])

    def ends(first, last):
        return np.concatenate([first[:6], [first[6] - 1.0], last[7:]])

    for share in np.arange(1, steps + 1) / steps:
        load = share * np.asarray(force, dtype=float)
        solved = solve_bvp(lambda s, y, f=load: slopes(s, y, f), ends, s, found, tol=1e-8)
        assert solved.success, solved.message
        s, found = solved.x, solved.y
    return found[:3, -1], Rotation.from_quat(found[3:7, -1]).as_matrix()
