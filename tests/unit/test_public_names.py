"""The public names: imported when first used, the same for type checkers, and nothing heavy before."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import fecontact
from fecontact.app.cli import main
from fecontact.common.renamed import FormerNames

HEAVY = ("numpy", "scipy", "skfem", "meshio", "matplotlib", "gmsh", "pyvista", "qpsolvers", "pypardiso")


def imported_by(program: str) -> set[str]:
    """The heavy packages, and the modules of fecontact, that a program in a fresh process has imported at its end."""
    told = f"{program}\nimport sys\nprint('modules', *sys.modules)"
    out = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True).stdout
    return set(out.splitlines()[-1].split()[1:])


QUICK = {
    "import": "import fecontact",
    "dir": "import fecontact; dir(fecontact); fecontact.__version__",
    "error": "import fecontact; fecontact.InputError",
    **{
        option: f"from fecontact.app.cli import main\ntry:\n    main({option.split()})\nexcept SystemExit:\n    pass"
        for option in ("--help", "--version", "halfspace --help", "solve --help")
    },
}


@pytest.mark.parametrize("program", QUICK.values(), ids=QUICK)
def test_nothing_heavy_is_imported_before_it_is_used(program: str) -> None:
    assert not imported_by(program) & {*HEAVY, "fecontact.scene", "fecontact.mesh"}


def test_what_is_used_is_imported() -> None:
    assert {"numpy", "fecontact.mesh.shapes"} <= imported_by("import fecontact; fecontact.shapes")


SOLVED = """
import fecontact as fc
block = fc.shapes.block((1.0, 1.0, 1.0), (2, 2, 2))
body = fc.ElasticBody(block, fc.Material(E=1.0, nu=0.0), contact="bottom", supports={"top": "xyz"})
floor = fc.RigidBody(fc.Plane())
print(fc.Scene([body, floor], [fc.Contact(body, floor)]).solve(motions={body: {"z": -0.01}}))
"""


def test_a_solve_and_its_text_import_nothing_for_pictures_and_files() -> None:
    heavy = {"matplotlib", "meshio", "scipy.interpolate", "scipy.ndimage", "scipy.signal", "scipy.stats"}
    assert not imported_by(SOLVED) & heavy  # a second of 2.3 before the first answer


def test_a_name_of_a_room_is_pointed_to() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'Cylinder'; did you mean fecontact\.surfaces\.Cylinder\?"):
        fecontact.Cylinder  # noqa: B018
    with pytest.raises(AttributeError, match=r"no attribute 'Cilinder'$"):
        fecontact.Cilinder  # noqa: B018


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"fecontact {fecontact.__version__}\n"


def test_every_public_name_has_its_place_and_is_the_one_of_the_type_checkers() -> None:
    tree = ast.parse(Path(str(fecontact.__file__)).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    static = {}
    for node in block.body:
        assert isinstance(node, ast.ImportFrom)
        for alias in node.names:
            static[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    assert set(static) == set(fecontact._PLACES) == set(fecontact.__all__)
    assert {name: place.replace(":", ".") for name, place in fecontact._PLACES.items()} == static
    for name in fecontact.__all__:
        assert getattr(fecontact, name) is not None


def test_dir_shows_the_public_names_only() -> None:
    shown = {name for name in dir(fecontact) if not name.startswith("__")}
    assert shown == set(fecontact.__all__)


@pytest.mark.parametrize("module", [fecontact.shapes, fecontact.sections, fecontact.pick])
def test_modules_of_functions_complete_their_own_names_only(module) -> None:
    assert dir(module) == sorted(module.__all__)
    assert all(hasattr(module, name) for name in module.__all__)
    assert not {"np", "cKDTree", "math"} & set(dir(module))


def test_rooms_are_attributes_and_others_are_not() -> None:
    assert fecontact.ancf.__name__ == "fecontact.ancf"
    assert fecontact.solvers.available_solvers is fecontact.available_solvers
    assert "fecontact.analytic" in imported_by("import fecontact; fecontact.analytic")
    with pytest.raises(AttributeError, match="no attribute 'Skene'"):
        fecontact.Skene  # noqa: B018
    with pytest.raises(ImportError, match="Skene"):
        from fecontact import Skene  # noqa: F401


#: What a class shows its users; what only the package uses begins with an underscore.
SHOWN = {
    "Body": """
        name pose placed is_rigid notes contact n_dofs size reference_point contact_modulus rigid_modes free_motions
        surface attachment reduce displacement describe
    """,
    "ContactFields": """
        slave master bodies surfaces label note coupling friction points normals weights forces pressure gap active
        nodes facets loaded_facets directions region regions outline recovered stick stick_outline area point_area
        stick_area slip_area mean_pressure max_pressure total_force centre_of_pressure force moment reference_point
        error_estimate error_indicators split_by_plane sampled summary edge_area edge_mean_pressure
        wear_error worn worn_volume overclosure
    """,
}


@pytest.mark.parametrize("name", SHOWN)
def test_a_class_shows_what_users_handle(name: str) -> None:
    kind = {"Body": fecontact.Body, "ContactFields": fecontact.ContactFields}[name]
    shown = {member for member in (*dir(kind), *kind.__annotations__) if not member.startswith("_")}
    assert shown == set(SHOWN[name].split())


def test_an_own_body_that_defines_a_default_under_its_former_name_is_understood() -> None:
    with pytest.warns(DeprecationWarning, match="Heavy.body_force is now _body_force"):

        class Heavy(fecontact.Body):
            def body_force(self, gravity: object) -> str:
                return "heavy"

    assert Heavy()._body_force(None) == "heavy"


def test_a_member_that_has_become_private_is_found_under_its_former_name_and_warns() -> None:
    class Ball(FormerNames):
        _depth = 2.0

    with pytest.warns(DeprecationWarning, match="used by the package alone"):
        assert Ball().depth == 2.0
    with pytest.raises(AttributeError, match="no attribute 'width'"):
        Ball().width  # noqa: B018
