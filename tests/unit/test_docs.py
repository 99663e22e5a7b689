"""What the documents say is run or looked up."""

import csv
import re
import shlex
import tomllib
from pathlib import Path

import pytest

from fecontact.app.cli import _parser, main

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
#: What a person wrote, and `compare` and `error_estimates`: other pages are made when the site is built.
PAGES = [
    ROOT / "README.md",
    *sorted(p for p in DOCS.rglob("*.md") if not {"_api", "generated"} & set(p.relative_to(DOCS).parts)),
]
#: Words of docs/ without pictures and listings.
MAX_WORDS = 45_000
#: Letters of a line of code.
WIDEST = 88
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


@pytest.mark.by_day(every=5)
@pytest.mark.parametrize("page", PAGES, ids=name)
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


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_indented_commands_are_understood(page):
    """Commands that take too long for a test have options that exist."""
    whole = page.read_text(encoding="utf-8").replace("\\\n", " ")
    for text in re.findall(r"^ {4}fecontact (.*)$", whole, flags=re.MULTILINE):
        _parser().parse_args(shlex.split(text, comments=True))


@pytest.mark.parametrize("page", PAGES[1:], ids=name)
def test_code_is_no_wider_than_a_page(page):
    """Listings that are run or typed; what programs print is as they print it, and formulas are text."""
    typed = [line for language, text in blocks(page) if language not in ("", "text") for line in text.splitlines()]
    typed += re.findall(r"^ {4}(?:fecontact|make) .*$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert not [line for line in typed if len(line) > WIDEST]


@pytest.mark.parametrize("script", sorted((ROOT / "examples").rglob("*.py")), ids=name)
def test_examples_are_no_wider_than_a_page(script):
    """The site shows them whole, with what they say about themselves."""
    lines = script.read_text(encoding="utf-8").splitlines()
    assert not [line for line in lines if len(line) > WIDEST]


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
    trees = "\n".join(re.findall(r"```\{toctree\}(.*?)```", (DOCS / "index.md").read_text(encoding="utf-8"), re.DOTALL))
    for page in PAGES[1:]:
        place = page.relative_to(DOCS).with_suffix("").as_posix()
        if place != "index":
            assert re.search(rf"^{place}$", trees, flags=re.MULTILINE), f"add {place} to a toctree of docs/index.md"


def words(text):
    """Words of a text, without pictures, listings and addresses."""
    text = re.sub(r"^```.*?^```$|!\[[^]]*\]\([^)]*\)", "", text, flags=re.DOTALL | re.MULTILINE)
    return sum(re.search(r"\w", word) is not None for word in re.sub(r"\]\([^)]*\)", "]", text).split())


def test_documents_are_short():
    counts = {name(page): words(page.read_text(encoding="utf-8")) for page in PAGES[1:]}
    assert sum(counts.values()) <= MAX_WORDS, sorted(counts.items(), key=lambda item: -item[1])[:10]


def test_decisions_are_short():
    for section in (DOCS / "design.md").read_text(encoding="utf-8").split("\n## ")[1:]:
        assert words(section) <= 200, section.splitlines()[0]


@pytest.mark.parametrize("page", sorted((DOCS / "theory").glob("*.md")), ids=name)
def test_theory_is_short_and_has_no_timings(page):
    text = page.read_text(encoding="utf-8")
    assert words(text) <= 1500
    assert not re.search(r"\d (s|ms|seconds)\b|processor (time|seconds)|CPU", text)


def record_of_a_run():
    """What a run of the verification leaves."""
    test = "tests/verification/test_hertz.py::test_pressures"
    figure = {"test": test, "case": "ball", "quantity": "peak", "target": 2.0, "obtained": 2.02, "error": 0.01}
    figure |= {"within": 0.02, "dofs": 3, "seconds": 0.5}
    return {"tests": [{"test": test, "text": "a test. More.", "outcome": "passed", "reason": ""}], "figures": [figure]}


def test_chapters_have_every_figure_of_the_record(monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    import manual

    pages = manual.pages(record_of_a_run())
    assert set(pages) == {"verification", "verification/hertz"}
    assert "1 figures, of which 1 are held to a tolerance and 1 lie within it" in pages["verification"]
    assert "| ball | peak | 2 | 2.02 | 1.0e-02 | 0.02 | 3 | 0.50 |" in pages["verification/hertz"]
    assert "(../../../tests/verification/test_hertz.py)" in pages["verification/hertz"]


def test_pages_that_are_not_made_say_how(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    import generated_pages

    monkeypatch.setattr(generated_pages, "FOLDER", tmp_path)
    monkeypatch.setattr(generated_pages, "RECORD", tmp_path / "none.json")
    generated_pages.prepare(quick=())
    listed = re.findall(r"^generated/(\w+)$", (DOCS / "measured.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert {path.stem for path in tmp_path.glob("*.md")} == {*listed, "verification"}
    assert set(generated_pages.MEASURED) == set(listed)
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for name_, (title, script) in generated_pages.MEASURED.items():
        assert (ROOT / script).exists()
        assert script in makefile
        assert script in (tmp_path / f"{name_}.md").read_text(encoding="utf-8").removeprefix(f"# {title}")


def test_every_public_name_is_in_the_api():
    import fecontact

    listed = re.findall(r"^   (\w+)$", (DOCS / "api.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert not set(fecontact.__all__) - set(listed), "add it to docs/api.md"


def test_the_gallery_has_every_example():
    page = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    for script in (ROOT / "examples").glob("*.py"):
        assert f"../examples/{script.name}" in page, f"{script.name} is not in docs/gallery.md"


def test_errors_of_half_spaces_are_measured(monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    import half_space_page

    monkeypatch.setattr(half_space_page, "CELLS", (16, 32))
    rows = [line.strip("|").split("|") for line in half_space_page.errors().splitlines()[2:]]
    assert [row[0].strip() for row in rows] == list(half_space_page.CASES)
    # five cells across a contact: an error of first order is below half of their share
    assert all(0 <= float(cell) < 0.1 for row in rows for cell in row[1:3])
    assert all(abs(float(cell)) < 0.1 for row in rows for cell in row[5:7])


def test_the_site_lists_the_examples(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(DOCS)
    import gallery

    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    monkeypatch.setattr(gallery, "PRINTED", tmp_path)
    (tmp_path / "knee_menisci.txt").write_text("what the knee prints\n", encoding="utf-8")
    found = list(gallery.entries(page))
    assert sum(len(entry.pictures) for entry in found) == page.count("](images/gallery/")
    shown = gallery.with_listings(page)
    assert shown.count("<summary>The code") == len(found) == page.count("\n## ")
    assert shown.count("What it prints") == 1
    assert "what the knee prints" in shown


def table_rows(page):
    """Cells of the tables of a page, row by row."""
    lines = re.findall(r"^\|(.*)\|$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return [[cell.strip() for cell in line.split("|")] for line in lines]


def csv_rows(path):
    """Cells of a file of measured figures that a page shows, row by row."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def test_speeds_of_the_readme_are_those_of_the_comparison():
    runs = {(row[0], row[1]): row for row in csv_rows(DOCS / "compare_runs.csv")}
    page = (DOCS / "compare.md").read_text(encoding="utf-8")
    other = re.search(r"(\S+) % takes the fastest other program .*? as it takes here: (\S+) s, NGSolve", page)
    chosen = {
        "20-node hexahedra, both bodies": ("20-node hexahedra, mid-face nodes", "1"),
        "the same, pressure with its root at the edge": ("20-node hexahedra, root at the edge", "1"),
        "`LocalBody`: a coarse mesh, a fine grid at the contact": ("local body, one coarse mesh and cells", "64"),
        "half-spaces": ("half-space, Love's cells, transforms", "512"),
    }
    found = {name_: (runs[run_][4].removesuffix(" %"), runs[run_][8]) for name_, run_ in chosen.items()}
    found["fastest other program with solid elements in this comparison"] = other.groups()
    told = {row[0]: row[1:] for row in table_rows(ROOT / "README.md") if row[-1].endswith(" s")}
    assert told == {k: [f"{float(e):.2g} %", f"{float(s):.2g} s"] for k, (e, s) in found.items()}


def test_errors_of_the_readme_are_those_of_the_estimates():
    rows = {row[0]: row[1:] for row in table_rows(DOCS / "error_estimates.md")}
    number, within, least, largest = rows["all"]
    pressures = [cell for row in csv_rows(DOCS / "error_estimates.csv")[1:] for cell in row[4].split("/")]
    assert len(pressures) == int(number)
    for figure in ("peak", "area", "force at a given motion", "approach under a given force"):
        assert rows[figure][5] == "0", f"{figure}: told less than half of the error"
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert f"In [{number} runs](docs/error_estimates.md)" in text
    assert (
        f"the estimate was {least} to 3 times the true error in {within.split()[0]}, and {largest} times in the" in text
    )
