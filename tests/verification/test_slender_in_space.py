"""Beams, plates and shells of absolute nodal coordinates in space, against published and closed solutions."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from exact_rod import cantilever
from refusals import refused
from scipy.spatial.transform import Rotation

import fecontact as fc
from fecontact.ancf import Assembly, GeneralisedAlpha, Joints, Stage, equilibrium, move
from fecontact.ancf.slender import Surface, beam, plate, shell, straight, strip, thick_plate
from fecontact.ancf.slender.kinds import rectangle_torsion

#: The Princeton beam of aluminium 7075: length, width and height of its section, material, in SI units.
PRINCETON = 0.508, 12.377e-3, 3.2024e-3, fc.Material(E=71.7e9, nu=0.31)


def clamped_beam(bar, force, steps=1):
    """Tip and section's axes of a `beam` clamped at its first node, at every load step."""
    joints = Joints([bar])
    held = [joints.pinned((0, 0)), joints.guided((0, 0), 2), joints.guided((0, 0), 3)]
    f = np.zeros(bar.vectors.shape)
    f[-1, 0] = force
    assembly = Assembly([bar], held)
    path = equilibrium(lambda level: Stage(assembly, level * f.ravel()), steps=steps)
    assert path.success
    return [(bar.positions(state.q)[-1], bar.gradients(state.q)[-1].T) for state in path.steps if state.level > 0]


def rigidities(width, height, material, torsion):
    """(EA, GA2, GA3) and (GJ, EI2, EI3) of a rectangle; y along the width."""
    E, G, A = material.E, material.shear_modulus, width * height
    return (E * A, 5 / 6 * G * A, 5 / 6 * G * A), (G * torsion, E * width * height**3 / 12, E * height * width**3 / 12)


def test_exact_rod_against_the_elastica(row):
    """The reference of the tests below: a cantilever under a force across it, P L^2 / (E I) = 4."""
    tip, _ = cantilever(1.0, (0.0, 0.0, 4.0), (1e9, 1e9, 1e9), (1.0, 1.0, 1.0))
    row("exact rod, end force", "tip across, of the length", 0.66996, tip[2], 1e-5)
    row("exact rod, end force", "tip short, of the length", 0.32894, 1 - tip[0], 1e-5)


@pytest.mark.parametrize("force", [4.448, 8.896, 13.345])
def test_princeton_beam(force, row):
    """A flat bar under a weight at its tip, in seven positions from upright to flat: it bends both ways and twists.

    Experiment: E. H. Dowell & J. J. Traybar, AMS reports 1194 and 1257, Princeton 1975. Data: O. A. Bauchau et al.,
    Multibody Syst. Dyn. 37 (2016). Reference: the exact rod, with the same torsion constant. Ten elements; the linear
    turn of their sections makes the angles converge with the second power.
    """
    length, width, height, material = PRINCETON
    bar = beam(straight((0, 0, 0), (length, 0, 0), 10), material, width=width, height=height)
    stretch, bend = rigidities(width, height, material, rectangle_torsion(width, height))
    off, twists = [], []
    for angle in np.radians(np.arange(0, 91, 15)):
        weight = force * np.array([0.0, -np.cos(angle), np.sin(angle)])
        known, frame = cantilever(length, weight, stretch, bend)
        ((tip, axes),) = clamped_beam(bar, weight)
        off.append(np.linalg.norm(tip - known) / np.linalg.norm(known - [length, 0, 0]))
        twists.append([np.degrees(np.arctan2(A[2, 1], A[1, 1])) for A in (axes, frame)])
    found, known = np.array(twists).T
    case = f"Princeton beam, {force} N, 0 to 90 degrees"
    row(case, "tip off, of its deflection", 0.0, max(off), 0.004, dofs=120)
    row(case, "twist off, of the largest", 0.0, np.abs(found - known).max() / known.max(), 0.01, dofs=120)


def test_strains_of_the_section_lock_inside_elements(row):
    """The flat bar under the largest weight, ten elements: the section's strains at nodes, and at Gauss points."""
    length, width, height, material = PRINCETON
    bar = beam(straight((0, 0, 0), (length, 0, 0), 10), material, width=width, height=height)
    known, _ = cantilever(length, (0, 0, 13.345), *rigidities(width, height, material, 1e-10))
    x, w = np.polynomial.legendre.leggauss(3)
    inside = replace(bar.parts[1], points=np.outer((1 + x) / 2, [1, 0, 0]), weights=w / 2)
    locked = replace(bar, parts=[bar.parts[0], inside, *bar.parts[2:]])
    off = [np.linalg.norm(clamped_beam(s, (0, 0, 13.345))[0][0] - known) for s in (bar, locked)]
    off = np.array(off) / np.linalg.norm(known - [length, 0, 0])
    row(
        "Princeton beam, flat, strains of the section at nodes",
        "tip off, of its deflection",
        0.0,
        off[0],
        0.001,
        dofs=120,
    )
    row(
        "Princeton beam, flat, strains of the section inside",
        "tip off, of its deflection",
        0.073,
        off[1],
        0.05,
        dofs=120,
    )


def test_princeton_beam_beside_another_program(row):
    """The exact rod beside beams of ANSYS, at 0, 45 and 90 degrees under the larger weights.

    Source: L. Obrezkov, A. Mikkola & M. K. Matikainen, Nonlinear Dyn. 109 (2022), by Exudyn's test ANCFBeamTest. The
    program's torsion is another, which tells where the bar twists.
    """
    length, width, height, material = PRINCETON
    stretch, bend = rigidities(width, height, material, rectangle_torsion(width, height))
    known = {
        8.896: ((1.071418e-2, 0.0), (8.837226e-3, 0.108988), (0.0, 0.146246)),
        13.345: ((1.606424e-2, 0.0), (1.518618e-2, 0.156467), (0.0, 0.200678)),
    }
    for force, tips in known.items():
        for angle, (down, across) in zip(np.radians([0.0, 45.0, 90.0]), tips, strict=True):
            tip, _ = cantilever(length, (0.0, -force * np.cos(angle), force * np.sin(angle)), stretch, bend)
            off = np.hypot(-tip[1] - down, tip[2] - across) / np.hypot(down, across)
            row(f"Princeton beam, {force} N, {np.degrees(angle):.0f} degrees", "rod off ANSYS", 0.0, off, 0.0015)


def test_forty_five_degree_bend(row):
    """A curved cantilever, an eighth of a circle, bent and twisted out of its plane by a dead force at its tip.

    Sources: K. J. Bathe & S. Bolourchi, Int. J. Numer. Methods Eng. 14 (1979): displacements (-13.4, -23.5, 53.4) under
    600, as the test decks of OpenFAST and Kratos have them; J. C. Simo & L. Vu-Quoc, Comput. Methods Appl. Mech. Engrg.
    58 (1986), eight elements, as Exudyn's has them. The torsion constant is that of those decks, 1/6; the exact rod
    with it lies 0.2 % of the radius off Simo & Vu-Quoc.
    """
    a = np.linspace(0, np.pi / 4, 17)
    nodes = 100 * np.stack([np.sin(a), 1 - np.cos(a), 0 * a], axis=1)
    tangents = np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
    material = fc.Material(E=1e7, nu=0.0)
    bend = beam(nodes, material, width=1.0, height=1.0, tangents=tangents, torsion=1 / 6)
    published = {300: (58.84, 22.33, 40.08), 600: (47.23, 15.79, 53.37)}
    found = clamped_beam(bend, (0.0, 0.0, 600.0), steps=2)
    for (tip, _), (force, simo) in zip(found, published.items(), strict=True):
        exact, _ = cantilever(25 * np.pi, (0, 0, force), *rigidities(1.0, 1.0, material, 1 / 6), curvature=(0, 0, 0.01))
        case = f"45-degree bend, force {force}"
        row(case, "tip off the exact rod, of the radius", 0.0, np.linalg.norm(tip - exact) / 100, 0.002, dofs=204)
        row(case, "tip off Simo & Vu-Quoc, of the radius", 0.0, np.linalg.norm(tip - simo) / 100, 0.0035, dofs=204)
    moved = tip - nodes[-1]
    row(case, "tip off Bathe & Bolourchi", 0.0, np.linalg.norm(moved - [-23.5, -13.4, 53.4]) / 100, 0.0035, dofs=204)


@pytest.mark.parametrize(("make", "most"), [(plate, 0.002), (thick_plate, 0.003), (strip, 0.01)])
def test_strip_under_an_end_force(make, most, row):
    """A cantilever of eight elements lifted at its end; with nu = 0 the elastica, P L^2 / (E I) = 4.

    Source: K. Mattiasson, Int. J. Numer. Methods Eng. 17 (1981), which the exact rod meets; K. Y. Sze, X. H. Liu & S.
    H. Lo, Finite Elem. Anal. Des. 40 (2004), section 3.1, for shells: 6.698, 3.286 of L = 10, as MBDyn's decks have it.
    """
    material = fc.Material(E=1.2e6, nu=0.0)
    if make is strip:
        sheet = strip(straight((0, 0, 0), (10, 0, 0), 8), material, width=1.0, height=0.1)
        ends, last, up = [0], [-1], 1
    else:
        sheet = make([(0, 0, 0), (10, 0, 0), (0, 1, 0)], (8, 1), material, 0.1)
        ends, last, up = [0, 1], [-2, -1], 2
    joints, across = Joints([sheet]), [(0, 1, 0), (0, 0, 1)]
    held = [joints.pinned((0, k)) for k in ends] + [joints.guided((0, k), 2) for k in ends]
    held += [joints.flat()] if make is strip else [joints.guided((0, k), 1, across) for k in ends]
    held += [joints.guided((0, k), 3) for k in ends if make is thick_plate]
    f = np.zeros(sheet.vectors.shape)
    f[last, 0, up] = 4.0 / len(last)
    assembly = Assembly([sheet], held)
    path = equilibrium(lambda level: Stage(assembly, level * f.ravel()), steps=3)
    assert path.success
    tip, case = sheet.positions(path.last.q)[-1] / 10, f"{sheet.name}, end force, 8 elements"
    row(case, "tip across, of the length", 0.66996, tip[up], most, dofs=sheet.n_dofs)
    row(case, "tip short, of the length", 0.32894, 1 - tip[0], most * 2, dofs=sheet.n_dofs)


def mirrored(joints, sheet, normal, level=0.0):
    """Conditions of a plane of symmetry on its nodes: displacement across it, and the surface's normal stays in it."""
    N, held = np.asarray(normal, dtype=float), []
    within = np.eye(3)[N == 0]
    for k in np.flatnonzero(np.abs(sheet.vectors[:, 0] @ N - level) < 1e-9):
        held.append(joints.pinned((0, k), [N]))
        for number in (1, 2):
            across = abs(sheet.vectors[k, number] @ N) > 0.5
            held.append(joints.guided((0, k), number, within if across else [N]))
        if len(sheet.shape.gradients) == 3:
            held.append(joints.guided((0, k), 3, [N]))
        if sheet.shape.mixed:
            held.append(joints.guided((0, k), sheet.shape.per_node - 1, within))
    return held


def on_diaphragms(joints, sheet, x):
    """Conditions of an end that a stiff membrane across x holds."""
    ends = np.flatnonzero(np.abs(sheet.vectors[:, 0, 0] - x) < 1e-9)
    across = [(0, 1, 0), (0, 0, 1)]
    return [c for k in ends for c in (joints.pinned((0, k), across), joints.guided((0, k), 2, across))]


def meshed(position, normal, n, uneven, along=(1.0, 0.0, 0.0)):
    """The image of a grid, or of cells of uneven shape: inner nodes moved by up to a quarter of a cell."""
    grid = Surface.mapped(position, (n, n))
    if not uneven:
        return grid
    u, v = (c.ravel() / n for c in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    inner = (u > 0) & (u < 1) & (v > 0) & (v < 1)
    moved = np.random.default_rng(1).uniform(-0.25, 0.25, (2, len(u))) / n * inner
    u, v = u + moved[0], v + moved[1]
    return Surface.of(position(u, v), grid.cells, normal(u, v), along)


def barrel(n, radius, length, angle, uneven=False):
    """A cylinder about the axis x from its crown to an angle, from its middle to an end, the normal outwards."""

    def normal(u, v):
        return np.stack([0 * u, np.sin(angle * v), np.cos(angle * v)], axis=-1)

    return meshed(
        lambda u, v: radius * normal(u, v) + np.multiply.outer(length / 2 * u, [1.0, 0, 0]), normal, n, uneven
    )


def deflected(sheet, held, f):
    """Linear displacements (n_nodes, 3)."""
    Z = Joints([sheet]).free(held)
    u = Z @ spla.spsolve((Z.T @ sheet.tangent(sheet.q0) @ Z).tocsc(), Z.T @ f.ravel())
    return u.reshape(sheet.vectors.shape)[:, 0]


def pinched(surface, thickness, E, nu, force, diaphragms, **kind):
    """Deflection under the force of an eighth of a cylinder, from its middle to an end and from crown to side."""
    sheet = shell(surface, fc.Material(E=E, nu=nu), thickness, **kind)
    joints = Joints([sheet])
    held = [c for N in np.eye(3) for c in mirrored(joints, sheet, N)]
    if diaphragms:
        held += on_diaphragms(joints, sheet, sheet.vectors[:, 0, 0].max())
    f, top = np.zeros(sheet.vectors.shape), np.argmax(sheet.vectors[:, 0, 2] - sheet.vectors[:, 0, 0])
    f[top, 0, 2] = -force / 4
    return -deflected(sheet, held, f)[top, 2]


@pytest.mark.by_day("8-free ends", "16-uneven cells")
@pytest.mark.parametrize("case", ["8-free ends", "16-36 coordinates", "16-uneven cells", "16-r_xy"])
def test_pinched_cylinders(case, row):
    """Two opposite forces on a cylinder with free ends, bent without stretch, and with rigid diaphragms.

    Sources: for free ends 0.1139, H. Takemoto & R. D. Cook, Int. J. Numer. Methods Eng. 7 (1973), by ANSYS's manual of
    verification, VM6; for diaphragms R. H. MacNeal & R. L. Harder, Finite Elem. Anal. Des. 1 (1985), 1.8248e-5, which
    is 164.24 P / (E t) of G. M. Lindberg, M. D. Olson & G. R. Cowper (1969), by decks of Kratos and OpenSees. Adini's
    functions do not conform and may be too soft; those with r_xy do.
    """
    if case.startswith("8"):
        found = pinched(barrel(8, 4.953, 10.35, np.pi / 2), 0.094, 10.5e6, 0.3125, 100.0, diaphragms=False)
        row("pinched cylinder, free ends, 8 x 8", "deflection", 0.1139, found, 0.01, dofs=729)
        return
    surface = barrel(16, 300.0, 600.0, np.pi / 2, "uneven" in case)
    found = pinched(surface, 3.0, 3e6, 0.3, 1.0, diaphragms=True, smooth="r_xy" in case)
    row(f"pinched cylinder, diaphragms, {case[3:]}", "deflection", 1.8248e-5, found, 0.015)


@pytest.mark.parametrize(("uneven", "kind"), [(False, {"smooth": True}), (True, {}), (True, {"thick": True})])
def test_scordelis_and_lo_s_roof(uneven, kind, row):
    """A roof under its weight of 90 per area, 8 x 8 on a quarter: the middle of its free edge.

    Source: .3024, R. H. MacNeal & R. L. Harder, Finite Elem. Anal. Des. 1 (1985). Fine meshes of several shells
    have .3006 to .3010; A. C. Scordelis & K. S. Lo, J. ACI 61 (1964) .3086 for a shallow shell.
    """
    angle = np.radians(40)
    sheet = shell(barrel(8, 25.0, 50.0, angle, uneven), fc.Material(E=4.32e8, nu=0.0, density=360.0), 0.25, **kind)
    joints = Joints([sheet])
    held = [c for N in np.eye(3)[:2] for c in mirrored(joints, sheet, N)] + on_diaphragms(joints, sheet, 25.0)
    weight = sheet.mass @ sheet.translation(np.array([0, 0, -1.0]))
    edge = np.argmax(sheet.vectors[:, 0, 1] - sheet.vectors[:, 0, 0])
    found = -deflected(sheet, held, weight)[edge, 2]
    row(f"Scordelis-Lo roof, {sheet.name}, {'uneven cells' if uneven else 'grid'}", "deflection", 0.3024, found, 0.02)


@pytest.mark.by_day("8-False-kind0", "16-False-kind1")
@pytest.mark.parametrize(
    ("n", "uneven", "kind"),
    [(8, False, {"smooth": True}), (16, False, {}), (16, False, {"thick": True}), (24, True, {})],
)
def test_hemisphere_with_a_hole(n, uneven, kind, row):
    """Forces of 2 at four points of the rim, inwards and outwards: a quarter with a hole of 18 degrees at the pole.

    Source: .094, R. H. MacNeal & R. L. Harder, Finite Elem. Anal. Des. 1 (1985); fine meshes have .0935. A closed one:
    .0924, T. Belytschko, H. Stolarski, W. K. Liu, N. Carpenter & J. S.-J. Ong, Comput. Methods Appl. Mech. Eng. 51.
    """
    top = np.radians(72)

    def up(u, v):
        a, b = u * np.pi / 2, top * v
        return np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)], axis=-1)

    surface = meshed(lambda u, v: 10 * up(u, v), up, n, uneven, (0, 0, 1.0))
    sheet = shell(surface, fc.Material(E=6.825e7, nu=0.3), 0.04, **kind)
    joints, f = Joints([sheet]), np.zeros(sheet.vectors.shape)
    ends = [int(np.argmax(sheet.vectors[:, 0, k])) for k in (0, 1)]
    held = [c for N in np.eye(3)[:2] for c in mirrored(joints, sheet, N)] + [joints.pinned((0, ends[0]), [(0, 0, 1)])]
    f[ends[0], 0, 0], f[ends[1], 0, 1] = 1.0, -1.0
    moved = deflected(sheet, held, f)
    case = f"hemisphere with a hole, {sheet.name}, {n} x {n}{', uneven cells' if uneven else ''}"
    row(case, "deflection outwards", 0.094, moved[ends[0], 0], 0.02, dofs=sheet.n_dofs)
    row(case, "deflection inwards", 0.094, -moved[ends[1], 1], 0.02, dofs=sheet.n_dofs)


def test_rolled_plates_turn_without_forces():
    """A shell is free of stress as made, and small rigid motions are all that costs nothing."""
    shell = plate([(0, 0, 0), (2, 0, 0), (0, 1, 0)], (1, 2), fc.Material(E=3.0, nu=0.3), 0.1, radius=0.8)
    assert shell.energy(shell.q0) == 0
    assert np.allclose(np.linalg.norm(shell.vectors[:, 0, 1:] - [0, 0.8], axis=1), 0.8)
    values = np.linalg.eigvalsh(shell.tangent(shell.q0).toarray())
    assert (values < 1e-10 * values[-1]).sum() == 6
    with refused(fc.InputError, "not-positive", "radius"):
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
    free = Assembly([bar])
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
