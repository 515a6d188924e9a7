# Commands for someone who has just cloned this: `make demo`, `make reproduce`, `make test`.
SHELL := /bin/bash
BIN := $(CURDIR)/.venv/bin
export PATH := $(BIN):$(PATH)
export DVC_NO_ANALYTICS := 1
export PYTHONHASHSEED := 0

.PHONY: help packages warm environment demo reproduce paper status test lint types unit slow smoke table2 table3 paper-numerical docs clean

help:
	@echo "make reproduce   environment, then every stage through DVC, to tables, figures and report.html;"
	@echo "                 PROFILE=smoke puts that scale (smoke, quick or paper) into conf/bench.yaml first;"
	@echo "                 NETWORKS=default trains those that come with the project, too"
	@echo "make environment the environment alone; PYTHON=/path names a CPython 3.11, TORCH=cuda takes PyTorch's build for a card"
	@echo "make demo        one robot solves, plans and grasps with the networks that come with the project: a film, a page"
	@echo "make paper       all of the paper at its scale, unattended, two tasks at a time; prints what it will take"
	@echo "                 first and goes on where it was stopped; HOURS=24 is the longest task that it runs"
	@echo "make status      what of that an edit has made stale"
	@echo "make test        environment, then lint, types and tests"
	@echo "make smoke       every stage at toy scale without DVC, minutes"
	@echo "make slow        tests that take minutes, some in a browser (chromium) and of the documentation"
	@echo "make table2      the paper's Table II from the raw rows on disk, in seconds; make table3 likewise"
	@echo "make paper-numerical  numerical solvers on 200,000 poses of five robots, hours; resumable"
	@echo "make docs        the documentation as pages that open from disk: site/index.html"
	@echo "make clean       remove results and caches; .venv stays"

packages:
	@PYTHON="$(PYTHON)" TORCH="$(TORCH)" .ci/environment

warm: packages
	@python -m pipeline warm

environment: packages warm

reproduce: environment
	@python -m pipeline dvc $(if $(PROFILE),profile=$(PROFILE)) $(if $(NETWORKS),networks=$(NETWORKS)) >/dev/null
	@python -m pipeline reproduce
	@python -m pipeline paths

demo: environment
	@python -m pipeline demo $(ARGS)

paper: environment
	@python -m pipeline paper $(if $(HOURS),hours=$(HOURS)) $(ARGS)

status: environment
	@python -m pipeline code
	@dvc status

# What checks the text of the code needs no kernels: it keeps one core busy while they are compiled.
test: packages
	@$(MAKE) --no-print-directory --output-sync=target -j2 types lint warm
	@$(MAKE) --no-print-directory unit

lint: packages
	ruff check .
	ruff format --check .
	lint-imports --no-cache --no-logo

types: packages
	mypy

unit: environment
	pytest --durations=10

slow: environment
	-python -m pip install -q --disable-pip-version-check --no-build-isolation -c requirements.lock -e '.[browser,docs]'
	@command -v chromium >/dev/null || echo "there is no chromium (Debian: apt-get install chromium): tests in a browser are skipped" >&2
	pytest -m slow

smoke: environment
	python -m pipeline all profile=smoke robots=[panda,nico]

table2 table3:
	@python -m pipeline table $@

paper-numerical: environment
	python -m pipeline benchmark profile=paper numerical=[lm,pinocchio,placo,trac_ik,bio_ik,pytorch_kinematics]
	python -m pipeline table table2 profile=paper

docs: environment
	python -m pip install -q --disable-pip-version-check --no-build-isolation -c requirements.lock -e '.[docs]'
	python docs/architecture.py
	NO_MKDOCS_2_WARNING=1 mkdocs build --strict
	@echo $(CURDIR)/site/index.html

clean:
	rm -rf site results/smoke results/quick .dvc/cache .dvc/tmp .mypy_cache .ruff_cache .pytest_cache .hypothesis
