# `make demo` and `make test` do all their own set-up, on Linux and macOS, with git, make and Python 3.11 to 3.13.

VENV    := .venv
BIN     := $(VENV)/bin
# The newest Python that we test with; override with `make PYTHON=/path/to/python demo`.
PYTHON  := $(shell for p in python3.13 python3.12 python3.11 python3 python; do \
             "$$p" -c 'import sys, venv, ensurepip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' >/dev/null 2>&1 && { echo "$$p"; break; }; done)
SOURCES := rfcompass planners urdf
CHECKED := $(SOURCES) tests benchmarks examples

.PHONY: demo test fast check bench results clean
.DEFAULT_GOAL := demo

demo: $(VENV)/.core  ## write a small synthetic trace and survey it
	$(BIN)/python examples/00_survey_a_sweep.py
	@echo "next: source $(BIN)/activate, then rfcompass survey runs/00_survey/trace, or rfcompass fetch table_leg_3"

test: check  ## everything that CI runs
	$(BIN)/pytest --cov --cov-report=term

fast: check  ## the everyday subset
	$(BIN)/pytest -m "not slow"

check: $(VENV)/.test
	$(BIN)/ruff format --check $(CHECKED)
	$(BIN)/ruff check $(CHECKED)
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.test  ## our timings beside the peers'
	$(BIN)/rfcompass bench

RESULTS := measured-survey measured-proximity measured-target wrong-comparisons tag-polarisation resolution accuracy grasp-trials fetches path-ratio fusebot-localisation pile-tags map-quality searches search-confirm search-levels search-tags search-kernels search-classes

results: $(VENV)/.test  ## the README's tables, in many hours; needs RFCOMPASS_MEASURED_DATA
	rm -rf runs/results && mkdir -p runs/results
	set -e; export RFCOMPASS_ACCURACY_RUN=runs/results/accuracy RFCOMPASS_PILE_SCENES=runs/piles; for name in $(RESULTS); do \
	    OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(BIN)/rfcompass study run $$name --workers 2 --out runs/results/$$name; done
	OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 $(BIN)/rfcompass bench --json > runs/results/bench.json
	$(BIN)/python docs/write_results.py runs/results

$(VENV)/.python:
	@test -n "$(PYTHON)" || { echo "rfcompass needs Python 3.11, 3.12 or 3.13 with venv and pip" >&2; exit 1; }
	@echo "making an environment in $(VENV); the first time this takes two or three minutes"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -qq --disable-pip-version-check --upgrade pip
	@touch $@

$(VENV)/.core: $(VENV)/.python pyproject.toml constraints.txt
	$(BIN)/python -m pip install -qq --disable-pip-version-check --constraint constraints.txt --editable .
	@touch $@

$(VENV)/.test: $(VENV)/.core
	$(BIN)/python -m pip install -qq --disable-pip-version-check --constraint constraints.txt --editable '.[test,robots,piles,llrp,dask]'
	@touch $@

clean:
	rm -rf $(VENV) build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis .coverage htmlcov
