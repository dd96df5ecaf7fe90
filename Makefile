# make study, make test, make docs and make bench set up what they need in .venv.
PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: study test tests slow coverage fuzz importers browser docs bench lint clean
study: .venv/ready
	$(BIN)/pyident study paper emps -o out

# Lint, types, tests. A process per core runs tests: a BLAS with a thread per core in each would only wait.
test tests slow coverage: export OPENBLAS_NUM_THREADS = 1
test: .venv/dev
	$(MAKE) -j2 lint tests

tests: .venv/dev
	$(BIN)/pytest -n auto --dist worksteal -m "not slow and not importers and not browser"

# What takes half a minute each, or races with the clock.
slow: .venv/dev
	$(BIN)/pytest -n auto --dist worksteal -m slow

# How much of pyident the tests of `make test` reach, branch by branch, in other processes too. A part per folder of
# tests, kept in out/coverage: after an interruption the same call goes on; `make -j2 coverage` runs two at once.
COVERED_BY ?= not slow and not importers and not browser
PARTS := $(sort $(foreach file,$(wildcard tests/*/test_*.py),$(word 2,$(subst /, ,$(file)))))
PARTS := $(filter-out importers browser,$(PARTS)) $(basename $(notdir $(wildcard tests/test_*.py)))
COVERED := $(PARTS:%=out/coverage/%.data)
SOURCES = $(shell find models fmu pyident tests studies -name '*.py' -not -path '*/.*')
.SECONDEXPANSION: # so that the tree is searched when a part is asked for, not at every call of make
out/coverage/%.data: $$(SOURCES)
	mkdir -p $(@D)
	rm -f $@.part*
	$(BIN)/python -m coverage run --data-file=$@.part -m pytest -q \
	  -m "$(COVERED_BY)" $(or $(wildcard tests/$*.py),tests/$*)
	@for again in 1 2 3 4 5; do sleep $$again; $(COMBINED) && exit; done; exit 1 # processes may still be writing
COMBINED = $(BIN)/python -m coverage combine --quiet --data-file=$@ $@.part*

coverage: .venv/dev $(COVERED)
	$(BIN)/python -m coverage combine --quiet --keep --data-file=out/coverage/all $(COVERED)
	$(BIN)/python -m coverage json --quiet --data-file=out/coverage/all -o out/coverage/all.json
	$(BIN)/python tests/branch_coverage.py out/coverage/all.json

# Thousands of hostile inputs; what it counts goes to docs/reliability.md.
fuzz: export HOSTILE_EXAMPLES ?= 200
fuzz: .venv/dev
	$(BIN)/pytest tests/hostile

# The FMU in other people's tools; each gets an environment of its own at first.
importers: .venv/dev
	$(BIN)/pytest -n auto -m importers

browser: .venv/dev
	$(BIN)/pytest -m browser

docs: export PATH := $(CURDIR)/$(BIN):$(PATH)
docs: .venv/docs
	$(BIN)/python -m sphinx -W --keep-going -n -b html docs out/docs

bench: .venv/ready
	$(PIP) -e ".[bench]"
	$(BIN)/python -m benchmarks -o out/bench

lint: .venv/dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

# Without a C compiler on the path, the pip package ziglang compiles the FMUs.
.venv/ready: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed; set PYTHON=...")'
	@echo "setting up .venv (once; about a minute)"
	test -x $(BIN)/python || $(PYTHON) -m venv .venv || { rm -rf .venv; echo "python3 -m venv failed: on Debian, apt install python3-venv" >&2; exit 1; }
	if command -v cc || command -v gcc || command -v clang; then what=.; else what='.[compiler]'; fi >/dev/null; \
	$(PIP) -e "$$what"
	touch $@

.venv/dev .venv/docs: .venv/ready
	@echo "installing what $(@F) needs"
	$(PIP) -e ".[$(@F)]"
	touch $@

clean:
	rm -rf .venv out
