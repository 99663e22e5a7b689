"""The law of the house: what a room may import, by the table in docs/house.md; no circles, no hidden imports."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).parents[2]
PACKAGE = "fecontact"

Rooms = dict[str, set[str]]
Imports = dict[tuple[str, str], int]


#: Texts in three quotes, and statements that import, on one line or in parentheses.
QUOTED, IMPORTING = re.compile('""".*?"""', re.S), re.compile(r"^[ \t]*(?:from|import)\b[^(\n]*(?:\([^)]*\))?", re.M)
#: What else may import, or hide an import.
OTHER = re.compile(r"\bimport\b|import_module|__import__|TYPE_CHECKING")


@cache
def nodes(text: str) -> list[ast.AST]:
    """All nodes of a module's tree, the whole first."""
    return list(ast.walk(ast.parse(text)))


@cache
def importing(text: str) -> list[ast.AST]:
    """Nodes of a module, with all that import; a tenth of the time of the whole tree, which is taken where in doubt."""
    plain = QUOTED.sub(lambda found: "\n" * found[0].count("\n"), text)
    if OTHER.search(IMPORTING.sub("", plain)):
        return nodes(text)
    found = [(each, ast.parse(each[0].strip()).body[0]) for each in IMPORTING.finditer(plain)]
    return [ast.increment_lineno(node, plain.count("\n", 0, each.start())) for each, node in found]


def table_of_rooms(page: str) -> tuple[Rooms, dict[str, str]]:
    """Of the page's table: what each room may import, in the order of the rooms, and its purpose."""
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \| (.+?) \|$", page, flags=re.MULTILINE)
    return {room: set(may.split(", ")) - {"nothing"} for room, _, may in rows}, {room: why for room, why, _ in rows}


def modules_of(root: Path) -> dict[str, Path]:
    """Modules of the package in a folder, by their dotted names."""
    files = sorted((root / PACKAGE).rglob("*.py"))
    return {".".join(f.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): f for f in files}


def targets(node: ast.AST, module: str, is_package: bool) -> list[str]:
    """Dotted names that a node of a module's tree imports, `from a import b` as ``a.b``."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        above = module.split(".")[: len(module.split(".")) - node.level + is_package] if node.level else []
        return [".".join([*above, *filter(None, [node.module]), alias.name]) for alias in node.names]
    called = getattr(node, "func", None)
    if getattr(called, "attr", getattr(called, "id", "")) in ("import_module", "__import__"):
        return [str(a.value) for a in node.args[:1] if isinstance(a, ast.Constant)]
    return []


def for_types(text: str) -> set[ast.AST]:
    """Nodes of a module's tree under ``if TYPE_CHECKING``, which run in no program."""
    if "TYPE_CHECKING" not in text:
        return set()
    tests = (n for n in nodes(text) if isinstance(n, ast.If) and ast.unparse(n.test).endswith("TYPE_CHECKING"))
    return {node for test in tests for part in test.body for node in ast.walk(part)}


def imports_of(modules: dict[str, Path], types: bool = False) -> Imports:
    """All imports between modules with a line each, those in functions too; names belong to the module they are of.

    Those for type checkers only, if `types`; else the others.
    """
    found: Imports = {}
    for module, path in modules.items():
        text = path.read_text(encoding="utf-8")
        hidden = for_types(text)
        for node in hidden if types else (n for n in importing(text) if n not in hidden):
            for name in targets(node, module, path.name == "__init__.py"):
                target = name if name in modules else name.rpartition(".")[0]
                if target in modules and target != module:
                    found.setdefault((module, target), getattr(node, "lineno", 0))
    return found


def room_of(module: str) -> str:
    """The room a module is in; '' for the package itself."""
    return module.partition(".")[2].partition(".")[0]


def entries(root: Path, rooms: Rooms) -> Iterator[str]:
    """Files and folders at the root that are no rooms, and rooms that are missing."""
    for entry in sorted((root / PACKAGE).iterdir()):
        held = entry.is_file() or any(f.is_file() for f in entry.rglob("*") if "__pycache__" not in f.parts)
        if held and entry.name not in ("__init__.py", "__main__.py", "py.typed", *rooms):
            yield f"unknown entry: {PACKAGE}/{entry.name}"
    for room in rooms:
        if not (root / PACKAGE / room / "__init__.py").is_file():
            yield f"no such room: {PACKAGE}/{room}"


def arrows(imports: Imports, rooms: Rooms) -> Iterator[str]:
    """Imports that run up, and imports that the table does not permit."""
    order = list(rooms)
    for (module, target), line in sorted(imports.items()):
        here, there = room_of(module), room_of(target)
        if not here or here == there or here not in order:
            continue
        if there not in order or order.index(there) > order.index(here):
            yield f"upward: {module} imports {target} (line {line})"
        elif there not in rooms[here]:
            yield f"not permitted: {module} imports {target} (line {line})"


def circles(imports: Imports, modules: dict[str, Path]) -> Iterator[str]:
    """Modules that import each other, at once or by way of others: the strongly connected components."""
    number = {name: k for k, name in enumerate(modules)}
    ends = np.array([[number[m], number[t]] for m, t in imports], dtype=int).reshape(-1, 2).T
    graph = coo_array((np.ones(ends.shape[1]), (ends[0], ends[1])), shape=(len(number), len(number)))
    _, label = connected_components(graph, directed=True, connection="strong")
    for of in np.flatnonzero(np.bincount(label) > 1):
        yield "circle: " + ", ".join(name for name, k in number.items() if label[k] == of)


def hidden(modules: dict[str, Path]) -> Iterator[str]:
    """Imports for type checkers from another room; the package itself has its public names there."""
    for (module, target), line in sorted(imports_of(modules, types=True).items()):
        if module != PACKAGE and room_of(module) != room_of(target):
            yield f"TYPE_CHECKING: {module} imports {target} (line {line})"


def complaints(root: Path, rooms: Rooms) -> list[str]:
    """Whatever in the package breaks the law."""
    modules = modules_of(root)
    imports = imports_of(modules)
    return [*entries(root, rooms), *arrows(imports, rooms), *circles(imports, modules), *hidden(modules)]


ROOMS, PURPOSES = table_of_rooms((ROOT / "docs" / "house.md").read_text(encoding="utf-8"))


def test_the_law_is_kept() -> None:
    assert complaints(ROOT, ROOMS) == []


def test_the_table_names_thirteen_rooms_and_permits_only_rooms_above() -> None:
    order = list(ROOMS)
    assert len(order) == 13
    for k, room in enumerate(order):
        assert ROOMS[room] <= set(order[:k]), room


@pytest.mark.parametrize("room", list(ROOMS))
def test_the_room_says_what_the_table_says(room: str) -> None:
    tree = ast.parse((ROOT / PACKAGE / room / "__init__.py").read_text(encoding="utf-8"))
    assert (ast.get_docstring(tree) or "").splitlines()[0] == PURPOSES[room]


#: A small package that keeps the law: `low` below `middle` below `high`, which may not import `low`.
SMALL: Rooms = {"low": set(), "middle": {"low"}, "high": {"middle"}}
KEPT = {
    "__init__.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from fecontact.high.top import top\n",
    "py.typed": "",
    "low/__init__.py": '"""Low."""\n',
    "low/one.py": "import math\nif TYPE_CHECKING:\n    from fecontact.low import two\n\n\ndef one():\n    return 1\n",
    "low/two.py": "from fecontact.low import one\n",
    "middle/__init__.py": "from .mean import mean\n",
    "middle/mean.py": "from fecontact.low.one import one as mean\n",
    "high/__init__.py": "",
    "high/top.py": "def top():\n    from fecontact.middle import mean\n    return mean\n",
}
BROKEN = [
    ({"low/one.py": "from fecontact.high.top import top\n"}, "upward: fecontact.low.one imports fecontact.high.top"),
    ({"low/one.py": "import fecontact.high.top as t\n"}, "upward: fecontact.low.one imports fecontact.high.top"),
    ({"low/one.py": "from fecontact import high\n"}, "upward: fecontact.low.one imports fecontact.high "),
    ({"low/one.py": "from ..high import top\n"}, "upward: fecontact.low.one imports fecontact.high.top"),
    ({"low/one.py": "import fecontact as fc\n"}, "upward: fecontact.low.one imports fecontact "),
    (
        {"low/one.py": "def f():\n    from fecontact.middle.mean import mean\n"},
        "upward: fecontact.low.one imports fecontact.middle.mean (line 2)",
    ),
    (
        {"low/one.py": "from importlib import import_module\nimport_module('fecontact.high.top')\n"},
        "upward: fecontact.low.one imports fecontact.high.top (line 2)",
    ),
    ({"high/top.py": "import fecontact.low.one\n"}, "not permitted: fecontact.high.top imports fecontact.low.one"),
    ({"low/one.py": "def f():\n    import fecontact.low.two\n"}, "circle: fecontact.low.one, fecontact.low.two"),
    ({"middle/mean.py": "from fecontact.middle import x\n"}, "circle: fecontact.middle, fecontact.middle.mean"),
    ({"loose.py": ""}, "unknown entry: fecontact/loose.py"),
    ({"attic/__init__.py": ""}, "unknown entry: fecontact/attic"),
    (
        {"low/one.py": "import typing\nif typing.TYPE_CHECKING:\n    from fecontact.middle import mean\n"},
        "TYPE_CHECKING: fecontact.low.one imports fecontact.middle.mean (line 3)",
    ),
    (
        {"middle/mean.py": "if TYPE_CHECKING:\n    pass\nelse:\n    from fecontact.middle import x\n"},
        "circle: fecontact.middle, fecontact.middle.mean",
    ),
]


def built(root: Path, files: dict[str, str]) -> Path:
    """A folder with a package of these files."""
    for name, text in files.items():
        path = root / PACKAGE / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root


def test_a_package_that_keeps_the_law_has_no_complaints(tmp_path: Path) -> None:
    root = built(tmp_path, KEPT)
    (root / PACKAGE / "old" / "__pycache__").mkdir(parents=True)
    assert complaints(root, SMALL) == []


@pytest.mark.parametrize(("change", "said"), BROKEN, ids=[said for _, said in BROKEN])
def test_whatever_breaks_the_law_is_named(change: dict[str, str], said: str, tmp_path: Path) -> None:
    found = complaints(built(tmp_path, {**KEPT, **change}), SMALL)
    assert any(f.startswith(said) for f in found), found


def test_a_missing_room_is_named(tmp_path: Path) -> None:
    assert "no such room: fecontact/roof" in complaints(built(tmp_path, KEPT), {**SMALL, "roof": set()})


def strangers_path(root: Path, page: str) -> Iterator[str]:
    """Paths in the table of new things that do not exist, and names that are not in the files they stand by."""
    path = page.partition("## Where does a new X go")[2]
    for what in re.findall(r"`([\w/.]+(?:/|\.py|\.md))`", path):
        if what != f"{PACKAGE}/" and not any((root / base / what).exists() for base in ("", PACKAGE)):
            yield f"no such path: {what}"
    for names, file in re.findall(r"(`\w+`(?: or `\w+`)*) in `([\w/]+\.py)`", path):
        for name in re.findall(r"\w+", names.replace(" or ", " ")):
            if not re.search(rf"^(def |class )?{name}\b", (root / PACKAGE / file).read_text(encoding="utf-8"), re.M):
                yield f"no {name} in {file}"


def test_the_strangers_path_is_true() -> None:
    page = (ROOT / "docs" / "house.md").read_text(encoding="utf-8")
    assert page.partition("## Where does a new X go")[2].count("\n| ") > 20
    assert list(strangers_path(ROOT, page)) == []


def test_a_strangers_path_that_is_not_true_is_named() -> None:
    rows = "## Where does a new X go\n`attic/`, `mesh/` and `mesh/loose.py`; `READERS` or `WRITERS` in `mesh/read.py`\n"
    expected = ["no such path: attic/", "no such path: mesh/loose.py", "no WRITERS in mesh/read.py"]
    assert list(strangers_path(ROOT, rows)) == expected


#: Rooms above `bodies`, which ask bodies, surfaces and meshes instead of looking at their classes.
ASKING = list(ROOMS)[list(ROOMS).index("bodies") + 1 :]
#: Type tests in them: checks of what a user gave, arrays or operators as compliances, and a shape of the user's own.
MAX_TYPE_TESTS = 10
#: What each of them has, or a class as a key.
LOOKS = r"\b(?:isinstance|issubclass|singledispatch|register|hasattr|type)\(|^ *case |[{,]\s*%s\s*:"


def classes_of(modules: dict[str, Path]) -> set[str]:
    """Names of all classes of the package but its errors."""
    names: set[str] = set()
    for path in modules.values():
        names |= set(re.findall(r"^[ \t]*class (\w+)[:(]", QUOTED.sub("", path.read_text(encoding="utf-8")), re.M))
    return {name for name in names if not name.endswith("Error")}


def type_tests(tree: ast.AST, classes: set[str]) -> Iterator[int]:
    """Lines that look at a class: isinstance, match, type(x) is, hasattr, registries of types; arrays count as well."""

    def named(node: ast.AST) -> set[str]:
        return {getattr(n, "id", getattr(n, "attr", "")) for n in ast.walk(node)} & (
            classes | {"LinearOperator", "ndarray"}
        )

    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            called = ast.unparse(node.func).rpartition(".")[2]
            of_class = called in ("isinstance", "issubclass") and named(node.args[1])
            registered = called in ("singledispatch", "register") and any(map(named, node.args))
            if called == "hasattr" or of_class or registered:
                yield node.lineno
        elif isinstance(node, ast.MatchClass) and named(node.cls):
            yield node.lineno
        elif isinstance(node, ast.Compare | ast.Subscript):
            parts = [node.left, *node.comparators] if isinstance(node, ast.Compare) else [node.slice]
            if any(isinstance(p, ast.Call) and ast.unparse(p.func) == "type" for p in parts):
                yield node.lineno
        elif isinstance(node, ast.Dict):
            yield from (key.lineno for key in node.keys if isinstance(key, ast.Name) and key.id in classes)


def test_rooms_above_bodies_ask_and_do_not_look_at_classes() -> None:
    modules = modules_of(ROOT)
    classes = classes_of(modules)
    texts = {m: path.read_text(encoding="utf-8") for m, path in modules.items() if room_of(m) in ASKING}
    may = re.compile(LOOKS % f"(?:{'|'.join(classes)})", re.M)  # the others need not be parsed
    found = [
        f"{module} (line {line})"
        for module, text in texts.items()
        if may.search(QUOTED.sub("", text))
        for line in type_tests(nodes(text)[0], classes)
    ]
    assert len(found) <= MAX_TYPE_TESTS, found


@pytest.mark.parametrize(
    "code",
    [
        "isinstance(x, Body)",
        "isinstance(x, bodies.Body | Other)",
        "isinstance(x, (int, Body))",
        "issubclass(x, Body)",
        "isinstance(S, np.ndarray)",
        "hasattr(x, 'mesh')",
        "type(x) is Body",
        "type(x) in (Body, Other)",
        "made[type(x)]",
        "{Body: 1}",
        "match x:\n    case Body():\n        pass",
        "singledispatch(f).register(Body)",
    ],
)
def test_every_way_to_look_at_a_class_is_counted(code: str) -> None:
    assert len(list(type_tests(ast.parse(code), {"Body"}))) == 1
    assert re.search(LOOKS % "Body", code, re.M)


@pytest.mark.parametrize("code", ["isinstance(x, str)", "type(x).__name__", "{'Body': 1}", "Body(x)", "x is Body"])
def test_other_code_is_not_counted(code: str) -> None:
    assert list(type_tests(ast.parse(code), {"Body"})) == []


def test_files_of_tests_have_names_of_their_own() -> None:
    """Two of one name cannot be run together, as by ``pytest tests``."""
    names = [path.name for path in (ROOT / "tests").rglob("test_*.py")]
    assert sorted(name for name in set(names) if names.count(name) > 1) == []
