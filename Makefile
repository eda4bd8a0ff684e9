# Needs Python 3.11 or newer, make and a C compiler; everything else goes into .venv.
PYTHON ?= python3
WORKERS ?= 2
DATA ?= $(or $(BRUSHGRIP_DATA),../shared/measured)

BIN := .venv/bin
QUICK := .venv/.quick
ALL := .venv/.all
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
PYTEST := $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal

# pip compiles no module beforehand, so the first process that imports one keeps its bytecode for all others.
unexport PYTHONDONTWRITEBYTECODE

TRAINING := fem1 fem4_ident piros2_ident piros4
HELD_OUT := fem3 fem5 piros1 piros7
STEEL := fem1,fem3,fem4_ident,fem5
EMERY := piros1,piros2_ident,piros4,piros7

.PHONY: demo test test-all mutants attack gate docs live measured clean
.DELETE_ON_ERROR:

demo: $(QUICK)
	$(BIN)/brushgrip demo --out demo_output

# In minutes, with few dependencies: everything but the campaigns at full size, generated C compiled without optimisation.
test: $(QUICK)
	$(PYTEST) -m "not long"

# Everything, with branch coverage, generated C compiled as for a target.
test-all: $(ALL)
	BRUSHGRIP_TEST_OPTIMISATION=-O2 $(PYTEST) --cov
	$(MAKE) mutants

# PATTERN selects them by file or text.
mutants: $(ALL)
	$(BIN)/python tests/mutants/run.py --jobs $(WORKERS) '$(PATTERN)'

# Each class for so long [s], or INPUTS=1000000 of each however long that takes; exit status 1 if anything failed.
SECONDS ?= 60
attack: $(ALL)
	-@$(PIP) -e '.[attack]' 2>/dev/null
	BRUSHGRIP_TEST_OPTIMISATION=-O2 nice $(BIN)/python -m tests.attack.run $(if $(INPUTS),--inputs $(INPUTS),--seconds $(SECONDS)) $(CLASSES)

gate: $(ALL)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	MYPYPATH=examples $(BIN)/mypy --explicit-package-bases benchmarks/*.py
	$(BIN)/lint-imports

# The documentation site, in docs/_build; a warning is an error, every page of the gallery runs.
docs: $(ALL)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[docs]'
	$(BIN)/python -m sphinx -q -W --keep-going docs docs/_build

# The page of a live estimation in the browser, on an embedded recording in real time, with the model that the demo finds.
live: demo_output/model.json
	$(PIP) -e '.[live]'
	$(BIN)/brushgrip live examples/recordings/holdout_d.csv --rig examples/recordings/rig.toml --model $<

demo_output/model.json: | $(QUICK)
	$(MAKE) demo

measured: $(QUICK)
	$(BIN)/brushgrip diagnose $(TRAINING:%=$(DATA)/%.mat) \
		$(HELD_OUT:%=--holdout $(DATA)/%.mat) --ground steel=$(STEEL) --ground emery=$(EMERY) \
		--out measured_output

clean:
	rm -rf .venv attack_findings build dist docs/_build docs/gallery demo_output measured_output htmlcov .coverage .coverage.* \
		.benchmarks .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(QUICK): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and \
		"brushgrip needs Python 3.11 or newer, this is " + sys.version.split()[0] + \
		"; name another with make PYTHON=...")'
	$(PYTHON) -m venv .venv
	$(PIP) -e '.[test]'
	@touch $@

$(ALL): $(QUICK)
	$(PIP) -e '.[dev]'
	@touch $@
