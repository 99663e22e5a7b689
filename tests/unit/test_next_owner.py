"""The page for the next owner is true: its solve enters the files that it names."""

import contextlib
import re
import sys
from pathlib import Path

import fecontact

PAGE = Path(__file__).parents[2] / "docs" / "next-owner.md"
PACKAGE = Path(fecontact.__file__).parent
#: Named for what they are, or used where a library is installed.
OTHERS = {
    "contact/friction_rows.py",
    "contact/step_end.py",
    "results/friction_fields.py",
    "scene/load_path.py",
    "common/path.py",
    "halfspace/path.py",
    "common/table.py",
}
OPTIONAL = {"fem/pardiso.py"}


def test_the_solve_enters_the_files_that_the_page_names() -> None:
    page = PAGE.read_text()
    named = set(re.findall(r"`((?:\w+/)+\w+\.py)`", page))
    assert [name for name in named if not (PACKAGE / name).is_file() and not name.startswith("docs/")] == []
    solve = compile(re.findall(r"```python\n(.*?)```", page, re.S)[0], "page", "exec")
    entered: set[str] = set()

    def follow(frame, event, _argument):
        if event == "call":
            path = Path(frame.f_code.co_filename)
            if path.is_relative_to(PACKAGE) and frame.f_code.co_name != "<module>":
                entered.add(path.relative_to(PACKAGE).as_posix())

    exec(solve, {})  # imports are no part of the solve
    before = sys.getprofile()
    with contextlib.ExitStack() as stack:
        stack.callback(sys.setprofile, before)
        sys.setprofile(follow)
        exec(solve, {})
    from_page = {name for name in named if not name.startswith("docs/")} - OTHERS - OPTIONAL
    assert entered - OPTIONAL == from_page
