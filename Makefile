# make report     build/report.pdf and build/report.html, with all it needs installed into .venv from requirements.lock
# make test       the tests
# make test-slow  the tests that take longer
# make mutants    one small mistake at a time in the code around the statements: do tests find it? make mutants NUMBER=20 SEED=7: fewer, others
# make lint       style, types, direction of imports
# make docs       build/docs/index.html: the documentation of the library, to be read without a network
# make record     put on record what every statement reached (a build compares with it and never writes it)
# make bench      time the methods that chapter 7 compares, on a machine with nothing else to do; make bench NAME=brdf: only those
#
# Another interpreter: make report PYTHON=python3.12

PYTHON ?= python3
SNAKEMAKE_OPTIONS ?=
BIN := .venv/bin
READY := .venv/ready

unexport PYTHONDONTWRITEBYTECODE PYTHONHOME PYTHONPATH VIRTUAL_ENV
export UV_PYTHON_DOWNLOADS := never
export PYTHONUTF8 := 1

.PHONY: report test test-slow mutants lint docs record bench lock clean
.DELETE_ON_ERROR:

report: $(READY)
	@$(BIN)/snakemake $(SNAKEMAKE_OPTIONS)

test: $(READY)
	@$(BIN)/pytest -n auto --dist loadfile --no-loadscope-reorder

test-slow: $(READY)
	@$(BIN)/pytest -n auto --dist worksteal -m slow

mutants: $(READY)
	@$(BIN)/python tests/mutation/guarded.py $(if $(NUMBER),--number $(NUMBER)) $(if $(SEED),--seed $(SEED))

lint: $(READY)
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check
	@$(BIN)/mypy
	@PYTHONPATH=lib:. $(BIN)/lint-imports --no-cache --no-logo
	@$(BIN)/snakemake --lint

# Pages that Sphinx makes of docstrings are made anew, so that none is left of a name that is gone.
docs: $(READY)
	@rm -rf build/docs build/doctrees docs/reference/api
	@$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -d build/doctrees docs build/docs

record: $(READY)
	@$(BIN)/snakemake $(SNAKEMAKE_OPTIONS) build/ledger.json
	@$(BIN)/python workflow/ledger.py renew build/ledger.json records/ledger.json

bench: $(READY)
	@PYTHONPATH=lib $(BIN)/python -m benchmarks.bench $(NAME)

# The environment: an interpreter that is new enough, uv by its hash, then everything else by its.
$(READY): requirements.lock pyproject.toml
	@sh workflow/environment.sh "$(PYTHON)"
	@touch $@

# Solve anew within pyproject.toml (the lock is good for every supported Python).
lock: $(READY)
	@$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --extra report --extra docs \
	    --generate-hashes --no-header --no-annotate pyproject.toml -o requirements.lock

clean:
	rm -rf build .snakemake
