"""What the documents say is run or looked up."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest

from fecontact.app.cli import _parser, main

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(p for p in DOCS.rglob("*.md") if "_api" not in p.parts)]
WRITTEN = [page for page in PAGES if page.relative_to(ROOT).parts[1:2] != ("verification",)]
#: What a shell block may begin with, besides names of files.
PROGRAMS = ("fecontact", "make", "pip", "python", "apt", "conda", "source", "cd", ".venv/bin/pytest-benchmark")


def name(page):
    return page.relative_to(ROOT).as_posix()


def blocks(page):
    """The fenced blocks of a page, in order: (language, text)."""
    return re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def commands(text):
    """The lines of a shell block without comments."""
    lines = (shlex.split(line, comments=True) for line in text.replace("\\\n", " ").splitlines())
    return [line for line in lines if line]


@pytest.mark.parametrize("page", WRITTEN, ids=name)
def test_blocks_run(page, tmp_path, monkeypatch, capsys):
    """Python runs in one namespace for a page, TOML is read and kept by the name in it, commands are carried out."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for language, text in blocks(page):
        if language == "python":
            exec(compile(text, str(page), "exec"), names)
        elif language == "toml":
            tomllib.loads(text)
            if file := re.match(r"# (\S+\.toml)\n", text):
                Path(file[1]).write_text(text, encoding="utf-8")
        elif language == "bash":
            for line in commands(text):
                run(line, page)


def run(line, page):
    """A command of the package is carried out; of others what can be looked up is."""
    assert line[0].startswith(PROGRAMS), f"{name(page)}: {line}"
    if line[0] == "fecontact" and line[1] not in ("--version", "hertz"):  # the latter is run by make hertz
        assert main(line[1:]) == 0, f"{name(page)}: {line}"
    elif line[0] == "make":
        assert re.search(rf"^{line[1]}:", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE), line


@pytest.mark.parametrize("page", WRITTEN, ids=name)
def test_indented_commands_are_understood(page):
    """Commands that take too long for a test have options that exist."""
    for text in re.findall(r"^ {4}fecontact (.*)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE):
        _parser().parse_args(shlex.split(text, comments=True))


def anchors(page):
    """Anchors of a page's headings, as browsers of repositories and the site make them."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    heads = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_and_pictures_exist(page):
    for target, anchor in re.findall(r"\]\(([^)#\s]*)#?([^)\s]*)\)", page.read_text(encoding="utf-8")):
        if target.startswith("http"):
            continue
        there = page.parent / target if target else page
        assert there.exists(), f"{name(page)} points to {target}"
        assert not anchor or anchor in anchors(there), f"{name(page)} points to #{anchor} of {name(there)}"


def test_every_page_is_in_the_contents():
    trees = "\n".join(text for text in re.findall(r"```\{toctree\}(.*?)```", contents(), flags=re.DOTALL))
    for page in DOCS.rglob("*.md"):
        place = page.relative_to(DOCS).with_suffix("").as_posix()
        if place != "index" and not place.startswith("_api"):
            assert re.search(rf"^{place}$", trees, flags=re.MULTILINE), f"add {place} to a toctree of docs/index.md"


def contents():
    return "\n".join((DOCS / page).read_text(encoding="utf-8") for page in ("index.md", "verification.md"))


def test_every_public_name_is_in_the_api():
    import fecontact

    listed = re.findall(r"^   (\w+)$", (DOCS / "api.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert not set(fecontact.__all__) - set(listed), "add it to docs/api.md"


def test_the_gallery_has_every_example():
    page = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    for script in (ROOT / "examples").glob("*.py"):
        assert f"../examples/{script.name}" in page, f"{script.name} is not in docs/gallery.py"
