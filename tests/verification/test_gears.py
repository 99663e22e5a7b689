"""A pair of involute gears: against Hertz, the stiffness of ISO 6336, and CalculiX on the same meshes."""

import math
import shutil

import numpy as np
import pytest

import fecontact as fc
from fecontact.app.decks.ccx import beside_ccx
from fecontact.mesh.gear_section import Gear, centre_distance

STEEL = fc.Material(E=206e3, nu=0.3)
PINION, WHEEL = Gear(4.0, 20), Gear(4.0, 30)
WIDTH = 20.0
#: Where the flank of the pinion's tooth passes the pitch point.
AT_PITCH = -math.pi / 2 / PINION.teeth


def about(angle):
    """Rotation of rows (x, z)."""
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def one_pair(flank, count=1):
    """Teeth of the pinion and one more of the wheel held at their rims; the middle ones touch at the pitch point."""
    held = {"bore": "xz", "cut": "xz"}
    one, other = (
        fc.PlaneBody(gear.section(n, flank=flank), STEEL, f"right {(count - 1) // 2}", held, thickness=WIDTH, name=name)
        for gear, n, name in ((PINION, count, "P"), (WHEEL, count + 1, "W"))
    )
    back = math.pi - AT_PITCH * PINION.teeth / WHEEL.teeth
    one = one.placed(rotation=fc.rotation_about((0, 1, 0), AT_PITCH))
    return one, other.placed((0, 0, centre_distance(PINION, WHEEL)), fc.rotation_about((0, 1, 0), back))


def turned(one, other, along, accuracy=None):
    """The pinion's rim turned about its axis, by so much along the line of action."""
    turn = along / PINION.base_radius
    about_middle = turn * (one.pose.to_world(one.reference_point))[[2, 0]] * [1, -1]  # where its frame turns
    motion = {"x": about_middle[0], "z": about_middle[1], "ry": turn}
    scene = fc.Scene([one, other], [fc.Contact(one, other)])
    return scene.solve(motions={one: motion}, finite_motion=False, accuracy=accuracy)


@pytest.mark.full
def test_pressure_at_the_pitch_point(row):
    """The peak pressure at the pitch point, and the stiffness of a pair of teeth.

    Source: Hertz's line contact of the involutes' radii of curvature, which vary along the flank.
    ISO 6336-1, theoretical stiffness c' of a pair of spur gears from solid blanks, N/(mm um), fitted to elastic
    solutions; rims of 2.5 modules are held here, of five and six teeth.
    """
    result = turned(*one_pair(60, 5), 0.0164, accuracy={"pressure": 0.03, "peak": 0.01})
    force = float(np.linalg.norm(result.contacts[0].force)) / WIDTH
    radii = [gear.pitch_radius * math.sin(gear.pressure_angle) for gear in (PINION, WHEEL)]
    exact = fc.hertz.line(radii, (STEEL, STEEL), force=force)
    case = "gears, m = 4 mm, 20 and 30 teeth, at the pitch point"
    row(case, "max_pressure", exact.p0, result.contacts[0].max_pressure, within=0.01, dofs=result.n_dofs)
    one, other = PINION.teeth, WHEEL.teeth
    stiffness = 1 / (0.04723 + 0.15551 / one + 0.25791 / other)
    row(case, "stiffness of a pair, ISO 6336 [N/(mm um)]", stiffness, force / 16.4, within=0.1, dofs=result.n_dofs)
    # the force acts along the line of action
    along = np.array([math.cos(PINION.pressure_angle), math.sin(PINION.pressure_angle)])
    assert -result.contacts[0].force[[0, 2]] @ along == pytest.approx(WIDTH * force, rel=1e-4)


def deck(one, other, moved, penalty):
    """The pair for CalculiX; the nodes of the pinion's rim are moved by (n_points, 2), of them those held count."""
    text = ""
    for body, first in ((one, 1), (other, 100001)):
        mesh, x = body.mesh, body.pose.to_world(body.mesh.points)[:, [0, 2]]
        text += "*NODE\n" + "".join(f"{first + k}, {a:.12e}, {b:.12e}\n" for k, (a, b) in enumerate(x.tolist()))
        cells = (mesh.cells + first).tolist()
        text += f"*ELEMENT, TYPE=CPE8, ELSET={body.name}\n"
        text += "".join(f"{first + k}, {', '.join(map(str, cell))}\n" for k, cell in enumerate(cells))
        faces = "".join(f"{first + cell}, S{k + 1}\n" for cell, k in mesh.faces("right 0").tolist())
        text += f"*SURFACE, NAME={body.name}_FLANK\n{faces}"
    held = [np.union1d(b.mesh.boundary_nodes("bore"), b.mesh.boundary_nodes("cut")).tolist() for b in (one, other)]
    text += "*MATERIAL, NAME=M\n*ELASTIC\n206000., .3\n"
    text += "".join(f"*SOLID SECTION, ELSET={name}, MATERIAL=M\n{WIDTH}\n" for name in "PW")
    text += f"*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{penalty:.3e}\n"
    text += "*CONTACT PAIR, INTERACTION=I, TYPE=SURFACE TO SURFACE\nP_FLANK, W_FLANK\n*BOUNDARY\n"
    text += "".join(f"{100001 + n}, 1, 2\n" for n in held[1]) + "*STEP\n*STATIC\n1., 1.\n*BOUNDARY\n"
    for n in held[0]:
        text += "".join(f"{1 + n}, {k + 1}, {k + 1}, {moved[n, k]:.10e}\n" for k in (0, 1))
    return text + "*END STEP\n"


@pytest.mark.full
@pytest.mark.skipif(shutil.which("ccx") is None, reason="needs CalculiX")
def test_beside_calculix(tmp_path, row):
    """The force of a pair of teeth for a given turn, by CalculiX 2.20 on the same meshes.

    Its contact gives way by a penalty of 1e7 N/mm3: .1 um at 1000 MPa, of 14 um along the line of action.
    """
    one, other = one_pair(24)
    x = one.pose.to_world(one.mesh.points)
    moved = 0.0144 / PINION.base_radius * x[:, [2, 0]] * [1, -1]
    path = tmp_path / "gears.inp"
    path.write_text(deck(one, other, moved, 1e7))
    read = fc.read_scene(path).solve()
    direct = turned(one, other, 0.0144)
    assert np.abs(read.contacts[0].force - direct.contacts[0].force).max() < 1e-6 * np.abs(read.contacts[0].force).max()
    beside = beside_ccx(path, read)
    ours, theirs = next((a, b) for name, a, b in beside.rows if "force" in name)
    row("gears, m = 4 mm, beside CalculiX", "force of a pair", theirs, ours, within=0.02, dofs=read.n_dofs)
    assert max(beside.apart.values()) < 0.02
