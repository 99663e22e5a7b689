"""Beams, plates and shells of absolute nodal coordinates in space, against published and closed solutions."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.ancf import Assembly, GeneralisedAlpha, Stage, equilibrium, move
from fecontact.ancf.slender import Joints, beam, plate, straight


def test_forty_five_degree_bend(row):
    """A curved cantilever, an eighth of a circle, bent and twisted out of its plane by a dead force at its tip.

    Sources: K. J. Bathe & S. Bolourchi, Int. J. Numer. Methods Eng. 14 (1979): tip at (15.9, 47.2, 53.4) under 600; J.
    C. Simo & L. Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986): (15.79, 47.23, 53.37), and (22.33, 58.84, 40.08)
    under 300; M. A. Crisfield, same journal 81 (1990): (15.61, 46.84, 53.71). They lie 0.6 % of the radius apart.
    """
    a = np.linspace(0, np.pi / 4, 17)
    nodes = 100 * np.stack([1 - np.cos(a), np.sin(a), 0 * a], axis=1)
    tangents = np.stack([np.sin(a), np.cos(a), 0 * a], axis=1)
    bend = beam(nodes, fc.Material(E=1e7, nu=0.0), width=1.0, height=1.0, tangents=tangents)
    joints = Joints([bend])
    held = [joints.pinned((0, 0)), joints.guided((0, 0), 2), joints.guided((0, 0), 3)]
    f = np.zeros(bend.vectors.shape)
    f[-1, 0, 2] = 600.0
    assembly = Assembly([bend], joints.free(held))
    path = equilibrium(lambda level: Stage(assembly, level * f.ravel()), steps=2)
    assert path.success
    for state, known in zip(path.states, [(22.33, 58.84, 40.08), (15.79, 47.23, 53.37)], strict=True):
        off = float(np.linalg.norm(bend.positions(state.q)[-1] - known)) / 100
        row(f"45-degree bend, force {600 * state.level:.0f}", "tip off, of the radius", 0.0, off, 0.005, dofs=204)


def test_plate_strip_under_an_end_force(row):
    """A cantilever plate lifted at its end; with nu = 0 the elastica under a force across, P L^2 / (E I) = 4.

    Source: K. Mattiasson, Int. J. Numer. Methods Eng. 17 (1981): the tip at 0.66996 L across, 0.32894 L short; K. Y.
    Sze, X. H. Liu & S. H. Lo, Finite Elem. Anal. Des. 40 (2004), section 3.1, for shells: 6.698, 3.286 of L = 10.
    """
    sheet = plate([(0, 0, 0), (10, 0, 0), (0, 1, 0)], (8, 1), fc.Material(E=1.2e6, nu=0.0), 0.1)
    joints = Joints([sheet])
    across = [(0, 1, 0), (0, 0, 1)]
    held = [joints.pinned((0, k)) for k in (0, 1)] + [joints.guided((0, k), 2) for k in (0, 1)]
    held += [joints.guided((0, k), 1, across) for k in (0, 1)]
    f = np.zeros(sheet.vectors.shape)
    f[-2:, 0, 2] = 2.0
    assembly = Assembly([sheet], joints.free(held))
    path = equilibrium(lambda level: Stage(assembly, level * f.ravel()), steps=3)
    assert path.success
    tip = sheet.positions(path.last.q)[-1] / 10
    row("plate strip, end force, 8 x 1", "tip across, of the length", 0.66996, tip[2], 0.002, dofs=162)
    row("plate strip, end force, 8 x 1", "tip short, of the length", 0.32894, 1 - tip[0], 0.002, dofs=162)


def pinched(n, radius, length, thickness, E, nu, force, diaphragms):
    """Deflection under the force of an eighth of a cylinder, from its middle to an end and from crown to side."""
    corners = [(0, 0, 0), (length / 2, 0, 0), (0, radius * np.pi / 2, 0)]
    shell = plate(corners, (n, n), fc.Material(E=E, nu=nu), thickness, radius=radius)
    nodes = np.arange((n + 1) ** 2).reshape(n + 1, n + 1).tolist()
    joints, held = Joints([shell]), []
    x, y, z = np.eye(3)[:, None]
    # planes of symmetry: the displacement across them, the gradient along them across, the one across them along
    planes = [(nodes[0], x, 2, 1), ([k[0] for k in nodes], y, 1, 2), ([k[-1] for k in nodes], z, 1, 2)]
    for edge, normal, along, over in planes:
        within = np.eye(3)[normal[0] == 0] if over == 1 else [x[0], (z if normal is y else y)[0]]
        for k in edge:
            held += [joints.pinned((0, k), normal), joints.guided((0, k), along, normal)]
            held.append(joints.guided((0, k), over, within))
    if diaphragms:
        for k in nodes[-1]:
            held += [joints.pinned((0, k), np.eye(3)[1:]), joints.guided((0, k), 2, np.eye(3)[1:])]
    Z = joints.free(held)
    f = np.zeros(shell.vectors.shape)
    f[0, 0, 2] = force / 4
    u = Z @ spla.spsolve((Z.T @ shell.tangent(shell.q0) @ Z).tocsc(), Z.T @ f.ravel())
    return float(u[2])


def test_pinched_cylinders(row):
    """Two opposite forces on a cylinder with free ends, bent without stretch, and with rigid diaphragms.

    Sources: for free ends T. Belytschko et al., Comput. Methods Appl. Mech. Engrg. 51 (1985): 0.1139, and S. Timoshenko
    & S. Woinowsky-Krieger, Theory of Plates and Shells, section 122: 0.1084 if nothing stretches; for diaphragms R. H.
    MacNeal & R. L. Harder, Finite Elem. Anal. Des. 1 (1985): 1.8248e-5. Adini's functions do not conform and may be too
    soft.
    """
    free = pinched(8, 4.953, 10.35, 0.094, 10.5e6, 0.3125, 100.0, diaphragms=False)
    row("pinched cylinder, free ends, 8 x 8", "deflection", 0.1139, free, 0.01, dofs=729)
    held = pinched(16, 300.0, 600.0, 3.0, 3e6, 0.3, 1.0, diaphragms=True)
    row("pinched cylinder, diaphragms, 16 x 16", "deflection", 1.8248e-5, held, 0.015, dofs=2601)


def test_rolled_plates_turn_without_forces():
    """A shell is free of stress as made, and small rigid motions are all that costs nothing."""
    shell = plate([(0, 0, 0), (2, 0, 0), (0, 1, 0)], (1, 2), fc.Material(E=3.0, nu=0.3), 0.1, radius=0.8)
    assert shell.energy(shell.q0) == 0
    assert np.allclose(np.linalg.norm(shell.vectors[:, 0, 1:] - [0, 0.8], axis=1), 0.8)
    values = np.linalg.eigvalsh(shell.tangent(shell.q0).toarray())
    assert (values < 1e-10 * values[-1]).sum() == 6
    with pytest.raises(fc.InputError, match="radius"):
        plate([(0, 0, 0), (2, 0, 0), (0, 1, 0)], (1, 2), fc.Material(E=3.0, nu=0.3), 0.1, radius=-1.0)


def test_free_flight_of_a_spinning_bar(row):
    """A stiff square bar spins about its axis and across it: its axis goes round the angular momentum on a cone.

    Source: L. D. Landau & E. M. Lifshitz, Mechanics, section 33: the rate is the angular momentum over the moment of
    inertia across. Half a turn on a cone of 71 degrees in 120 steps, a bar of one element.
    """
    length, side, spin, tilt = 2.0, 0.5, 3.0, 1.0
    material = fc.Material(E=1e4, nu=0.3, density=1.0)
    bar = beam(straight((-1, 0, 0), (1, 0, 0), 1), material, width=side, height=side)
    mass = length * side**2
    along, across = mass * side**2 / 6, mass * (length**2 + side**2) / 12
    momentum = np.array([along * spin, 0.0, across * tilt])
    rate, axis = np.linalg.norm(momentum) / across, momentum / np.linalg.norm(momentum)
    v = np.cross((spin, 0.0, tilt), bar.vectors).ravel()
    free = Assembly([bar], sp.identity(bar.n_dofs, format="csr"))
    until = np.pi / rate
    motion = move(free, until=until, step=until / 120, scheme=GeneralisedAlpha(0.8), velocity=v, every=1)
    assert motion.success
    first, off = np.array([1.0, 0.0, 0.0]), []
    for time, q in zip(motion.frame_times, motion.frames, strict=True):
        nodes = bar.positions(q)
        known = Rotation.from_rotvec(rate * time * axis).apply(first)
        off.append(np.linalg.norm((nodes[1] - nodes[0]) / np.linalg.norm(nodes[1] - nodes[0]) - known))
    row("spinning bar, half a turn of its cone", "axis off, radians", 0.0, max(off), 0.01, dofs=24)
    speeds = (motion.frames[-1] - motion.frames[-2]) / np.diff(motion.frame_times)[-1]
    middle = (motion.frames[-1] + motion.frames[-2]) / 2
    arms = np.stack([np.cross(e, middle.reshape(-1, 3)).ravel() for e in np.eye(3)])
    lost = np.linalg.norm(arms @ (bar.mass @ speeds) - momentum) / np.linalg.norm(momentum)
    row("spinning bar, half a turn of its cone", "change of the angular momentum", 0.0, lost, 0.02, dofs=24)
