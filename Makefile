# Everything is set up on first use in .venv, from pyproject.toml and the pinned versions in constraints/.
PYTHON ?= python3
BIN := .venv/bin
RUN := .venv/.run
READY := .venv/.ready

.PHONY: hertz test check day whole rest verification doctest lint types examples docs package release rounding pages gallery bench mutants fuzz compare clean

hertz: $(RUN)  ## the main job: two spheres, table and picture
	@mkdir -p out
	$(BIN)/fecontact hertz --plot out/hertz.png --vtu out/hertz.vtu
	@if [ -n "$$DISPLAY" ] && command -v xdg-open >/dev/null; then xdg-open out/hertz.png; fi

# processes that test at once, one thread each (conftest.py)
JOBS ?= 2
PYTEST := $(BIN)/python -m pytest --numprocesses $(JOBS) --dist worksteal

TESTS := tests/unit tests/benchmarks tests/verification tests/fuzz --figures out/verification.json

test: day doctest  ## every day: unit tests, verification, random scenes, docstring examples; not what is marked full

# everything, before a release: hours. The same tests at all sizes, of which none may take long without the mark
check: whole doctest lint types examples docs package rounding fuzz mutants  ## everything, before a release

day: $(READY)
	$(PYTEST) -m "not full" $(TESTS)

whole: $(READY)
	$(PYTEST) --no-slow $(TESTS)

rest: $(READY)  ## of what `make test` leaves out, examples, scenes and coupling of surfaces
	$(PYTEST) -m full tests/unit/test_examples.py tests/unit/scene tests/unit/contact

verification: $(READY)  ## tests against closed forms; the record of their figures becomes chapters of the site
	$(PYTEST) tests/verification --figures out/verification.json

doctest: $(READY)
	$(PYTEST) --doctest-modules fecontact tests/benchmarks/compare --ignore-glob="*/test_*.py"

# instructions of NumPy beyond the basic ones, as this processor has them
EXTRAS = $$($(BIN)/python -c "from numpy._core import _multiarray_umath as m; print(*(f for f in m.__cpu_dispatch__ if m.__cpu_features__[f]))")

release: $(READY)  ## what is published, checked, with checksums and a conda recipe, in out/release; uploads nothing
	$(BIN)/python -m pip install --quiet --constraint constraints/pinned.txt --editable '.[release]'
	$(BIN)/python docs/release/release.py

rounding: $(READY)  ## geometric decisions under 30 changes by rounding; they and the examples by other instructions
	$(PYTEST) -m rounding --rounding 30 tests/unit tests/verification
	@set -e; for core in Haswell Prescott; do \
		export OPENBLAS_CORETYPE=$$core MKL_CBWR=SSE4_2 NPY_DISABLE_CPU_FEATURES="$(EXTRAS)"; \
		$(PYTEST) -m rounding tests/unit tests/verification; \
		$(MAKE) doctest; \
	done

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

examples: $(READY)  ## every example, at its full size; the site shows what they print
	$(BIN)/python docs/gallery.py

docs: $(READY)  ## the site, out/site/index.html; a broken link or reference fails
	$(BIN)/python -m sphinx -W --keep-going -q -b html -d out/site-trees docs out/site
	@echo "wrote out/site/index.html"

package: $(READY)  ## wheel and source, installed in clean environments of every Python found
	$(BIN)/python -m pytest tests/packaging

# scripts that measure pages of the site, about a quarter of an hour; compare and error_estimates are kept for each release
PAGES ?= docs/accuracy.py docs/half_space_page.py docs/baselines_page.py docs/solvers.py \
	tests/benchmarks/bench_outlines.py tests/benchmarks/bench_accuracy.py

pages: $(READY)  ## measured pages of the site, and pictures of docs/
	@set -e; for script in $(PAGES); do $(BIN)/python $$script; done

gallery: $(READY)  ## pictures of docs/gallery.md from a run of the examples
	$(BIN)/python docs/gallery.py --pictures

bench: $(READY)  ## benchmarks; ratios in one run, never part of a test
	$(BIN)/python -m pytest tests/benchmarks --benchmark-autosave -o python_files='bench_*.py'

# which guards no test sees: half an hour; MUTANTS="--module solvers --jobs 4" judges all of some modules
MUTANTS ?= --sample 4

mutants: $(READY)  ## weakened guards, and whether a test notices; kept in out/mutation, so it may be interrupted
	$(BIN)/python -m pip install --quiet --constraint constraints/pinned.txt --editable '.[mutation]'
	$(BIN)/python tests/mutation $(MUTANTS)

# scenes of every door, by number; FUZZ="--doors paths,decks --frames 3" for some doors, more ways of writing them
SEEDS ?= 0:30

fuzz: $(READY)  ## random scenes through every door: classes of outcomes, numbers to repeat
	$(BIN)/python tests/fuzz --seeds $(SEEDS) --jobs $(JOBS) $(FUZZ)

# other programs: PEERS="--peers tests/benchmarks/peers --peer-python PYTHON", a Python that has them
PEERS ?= --peers tests/benchmarks/peers

compare: $(READY)  ## speed against error; finished runs are kept in out/compare, so it may be interrupted
	$(BIN)/python tests/benchmarks/compare hertz --enough 100 --out out/compare --page docs/compare.md --plot docs/images/compare.png $(PEERS)

$(RUN): pyproject.toml constraints/pinned.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --constraint constraints/pinned.txt --editable '.[fast]'
	@touch $(RUN)

$(READY): $(RUN)  # what tests, types and the site need, when they are first asked for
	$(BIN)/python -m pip install --quiet --constraint constraints/pinned.txt --editable '.[dev]'
	@touch $(READY)

clean:
	rm -rf .venv out build dist .pytest_cache .mypy_cache .ruff_cache
