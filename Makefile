# Needs Python 3.11 or newer, make and a C compiler; everything else goes into .venv.
PYTHON ?= python3
WORKERS ?= 2
DATA ?= $(or $(BRUSHGRIP_DATA),../shared/measured)

BIN := .venv/bin
STAMP := .venv/.installed
PYTEST := $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder

TRAINING := fem1 fem4_ident piros2_ident piros4
HELD_OUT := fem3 fem5 piros1 piros7
STEEL := fem1,fem3,fem4_ident,fem5
EMERY := piros1,piros2_ident,piros4,piros7

.PHONY: demo test test-all mutants gate measured clean
.DELETE_ON_ERROR:

demo: $(STAMP)
	$(BIN)/brushgrip demo --out demo_output

# In minutes: everything but the campaigns at full size, generated C compiled without optimisation.
test: $(STAMP)
	$(PYTEST) -m "not long"

# Everything, with branch coverage, generated C compiled as for a target.
test-all: $(STAMP)
	BRUSHGRIP_TEST_OPTIMISATION=-O2 $(PYTEST) --cov
	$(MAKE) mutants

mutants: $(STAMP)
	$(BIN)/python tests/mutants/run.py --jobs $(WORKERS)

gate: $(STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

measured: $(STAMP)
	$(BIN)/brushgrip diagnose $(TRAINING:%=$(DATA)/%.mat) \
		$(HELD_OUT:%=--holdout $(DATA)/%.mat) --ground steel=$(STEEL) --ground emery=$(EMERY) \
		--out measured_output

clean:
	rm -rf .venv build dist demo_output measured_output htmlcov .coverage .coverage.* \
		.benchmarks .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and \
		"brushgrip needs Python 3.11 or newer, this is " + sys.version.split()[0] + \
		"; name another with make PYTHON=...")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	@touch $@
