# Three commands: `make study`, `make test` and `make bench`. They set up their own environment in .venv.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: study test bench lint clean
study: .venv/ready
	$(BIN)/pyident study paper emps -o out

test: lint
	$(BIN)/pytest -n auto

bench: .venv/ready
	$(BIN)/pip install --quiet --disable-pip-version-check -e ".[bench]"
	$(BIN)/python -m benchmarks -o out/bench

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

# Without a C compiler on the path, the pip package ziglang compiles the FMUs.
.venv/ready: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed; set PYTHON=...")'
	@echo "setting up .venv (once; a few minutes)"
	test -x $(BIN)/python || $(PYTHON) -m venv .venv || { rm -rf .venv; echo "python3 -m venv failed: on Debian, apt install python3-venv" >&2; exit 1; }
	if command -v cc || command -v gcc || command -v clang; then extras=dev; else extras=dev,compiler; fi >/dev/null; \
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[$$extras]"
	touch $@

clean:
	rm -rf .venv out
