# Two commands do everything: `make map` and `make test`. The plain pip lines stand beside them in README.md.
PYTHON ?= python3
VENV := .venv
READY := $(VENV)/.ready
DOCS_READY := $(VENV)/.docs-ready

LOWEST := .venv-lowest
# What a release is called, and where its wheel is tried, as far as they are here.
DIST := dist/bevelmap-$(shell sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)
PYTHONS ?= python3.11 python3.12 python3.13

.PHONY: map warmup test test-costly test-slow check format docs lowest release bench clean

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --constraint constraints.txt --editable '.[test]'
	touch $@

map: $(READY)
	$(VENV)/bin/python -m pipeline plane=omega_fe

warmup: $(READY)
	$(VENV)/bin/python -m pipeline warmup

test: $(READY)
	$(VENV)/bin/python -m pytest

# What takes seconds each; .ci/run has them too.
test-costly: $(READY)
	$(VENV)/bin/python -m pytest -m "costly and not slow"

# What takes minutes each.
test-slow: $(READY)
	$(VENV)/bin/python -m pytest -m "slow or costly"

# Format, lint and imports.
check: $(READY)
	$(VENV)/bin/ruff format --check --quiet .
	$(VENV)/bin/ruff check --quiet .
	$(VENV)/bin/lint-imports --no-cache --no-logo

format: $(READY)
	$(VENV)/bin/ruff format .
	$(VENV)/bin/ruff check --fix .

# The documentation site, in docs/_build; its gallery is written to docs/gallery first, each example run anew. Warnings
# are errors. Sphinx is installed for it alone.
$(DOCS_READY): $(READY)
	$(VENV)/bin/pip install --quiet --constraint constraints.txt --editable '.[docs]'
	touch $@

docs: $(DOCS_READY)
	$(VENV)/bin/python -m sphinx -E -W --keep-going --quiet -b html docs docs/_build

# The lowest versions that pyproject.toml allows, in an environment of their own: a map, its boundaries and its figures.
lowest:
	$(PYTHON) -m venv --clear $(LOWEST)
	sed -n '/^dependencies/,/^]/s/.*"\(.*\)>=\(.*\)".*/\1==\2/p' pyproject.toml > $(LOWEST)/lowest.txt
	$(LOWEST)/bin/pip install --quiet --constraint $(LOWEST)/lowest.txt --editable .
	NUMBA_CACHE_DIR=$(abspath $(LOWEST))/kernels $(LOWEST)/bin/python -m pipeline \
		plane.sweep.num=40 plane.parameter.num=8 'stages=[sweep,boundaries,figures,check,list]' output.root=$(LOWEST)/outputs

# The source distribution and the wheel, in dist/, and a map with what that wheel installs in an empty environment.
release:
	$(PYTHON) -m venv --clear .venv-release
	.venv-release/bin/pip install --quiet build twine
	.venv-release/bin/python -m build
	.venv-release/bin/twine check --strict $(DIST)*
	for python in $(PYTHONS); do tests/try_wheel $$python $(DIST)*.whl || exit; done

# QUICK=1 leaves out what takes long.
bench: $(READY)
	$(VENV)/bin/python -m benchmarks $(if $(QUICK),quick)

clean:
	rm -rf .venv .venv-lowest .venv-release build dist docs/gallery
