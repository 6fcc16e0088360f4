# Everything a user or a developer runs. A machine needs Python >= 3.11, make and a POSIX shell; all else goes into .venv.
# Another interpreter: make demo PYTHON=python3.13. Other wheels than binary ones: make demo PIP_FLAGS=.

.SUFFIXES:
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
SHELL := /bin/sh

PYTHON ?=
PIP_FLAGS ?= --only-binary=:all:
PYTEST_FLAGS ?=
LOCK_FLAGS ?=
UV_VERSION = 0.13.8
CYCLONEDX_VERSION = 11.12.0

VENV := .venv
BIN := $(VENV)/bin
LOCKED := $(VENV)/.locked
READY := $(VENV)/.ready
PIP := $(BIN)/python -m pip --disable-pip-version-check --no-input --quiet
# One pip uses one processor, so two of them install half each; the lock names all packages, so none needs another's.
INSTALL := $(PIP) install --no-compile --no-deps --require-hashes $(PIP_FLAGS) -r

# What a shell set up for something else (ROS 2, a user-wide pip) must not bring in.
unexport PYTHONPATH PYTHONHOME PIP_USER PIP_TARGET PIP_PREFIX PIP_REQUIRE_VIRTUALENV
# Without bytecode on disk each command of a test compiles all sources again, which takes four times its own time.
unexport PYTHONDONTWRITEBYTECODE
# The pyright that requirements.lock pins, and no word about newer ones.
unexport PYRIGHT_PYTHON_FORCE_VERSION PYRIGHT_PYTHON_PYLANCE_VERSION
export PYRIGHT_PYTHON_IGNORE_WARNINGS := 1

# The scripts of a virtual environment hold its path: a copied or moved project makes its own.
ifneq ($(shell cat $(LOCKED) 2>/dev/null),$(CURDIR))
MOVED := moved
endif

.PHONY: help
help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1 | \2/p' Makefile | awk -F'|' '{ printf "%-18s%s\n", $$1, $$2 }'

.PHONY: demo
demo: $(READY) ## see it work: log in, models and report out
	@$(BIN)/erclutch demo

.PHONY: venv
venv: $(READY) ## only set up .venv

# --- checks -----------------------------------------------------------------------------------------------------------

.PHONY: test
test: $(READY) ## the fast tests
	@$(BIN)/python -m pytest -n auto --dist loadgroup -m "not slow" $(PYTEST_FLAGS)

# Loops at 1 kHz trip where a processor is busy for 21 ms: the other tests run beside them and give way.
.PHONY: test-slow
test-slow: $(READY) ## the slow tests
	@$(BIN)/python -m tests.support.beside_timed slow $(PYTEST_FLAGS)

.PHONY: test-all
test-all: $(READY) ## all tests
	@$(BIN)/python -m tests.support.beside_timed "" $(PYTEST_FLAGS)

.PHONY: lint
lint: $(READY) ## style and format
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .

.PHONY: format
format: $(READY) ## put style and format right
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

.PHONY: types
types: $(READY) ## types
	@$(BIN)/pyright --pythonpath $(BIN)/python

.PHONY: arrows
arrows: $(READY) ## which module may import which
	@$(BIN)/lint-imports --no-cache --no-logo

.PHONY: docs
docs: $(READY) ## the documentation site, into build/docs
	@rm -rf build/docs docs/_pictures
	@$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet -d build/doctrees -b html docs build/docs
	@echo "build/docs/index.html"

.PHONY: check
check: lint types arrows docs test-all ## lint, types, arrows, documentation and all tests

# Not in CI: each of these takes as long as the fast tests, or longer. Before a release they are run once.
.PHONY: mutate
mutate: $(READY) ## how many small defects the tests of a room see (other samples: MUTATE_FLAGS="--seed 2 --count 20")
	@$(BIN)/python studies/mutate.py $(MUTATE_FLAGS)

.PHONY: figures
figures: $(READY) ## figures that pages cite, printed again; says what moved (one of them: FIGURES=damper)
	@$(BIN)/python studies/figures.py $(FIGURES)

.PHONY: attack
attack: $(READY) ## what a hostile hour finds, in twenty minutes, as a table (parts: ATTACK="races bombs")
	@$(BIN)/python studies/attack.py $(ATTACK)

# What the tests below need of the tools; of what erclutch needs, all is installed at its oldest or newest.
TEST_TOOLS = pytest pytest-xdist hypothesis fmpy onnxruntime hatchling openpyxl mujoco crepes mapie

# An old package that calls what a new one has deprecated is none of our faults: such a warning is no error here.
.PHONY: test-oldest test-newest
test-oldest: RESOLUTION = lowest-direct
test-oldest: ## the fast tests with the oldest packages that pyproject.toml allows
test-newest: RESOLUTION = highest
test-newest: ## the fast tests with the newest packages that there are
test-oldest test-newest: $(READY) .venv-lock/bin/uv
	@.venv-lock/bin/uv --no-config venv --quiet --clear --python $(BIN)/python .venv-$@
	@mkdir -p build
	@.venv-lock/bin/uv --no-config pip compile --quiet --python .venv-$@/bin/python $(PIP_FLAGS) --all-extras \
	  --resolution $(RESOLUTION) --no-emit-index-url --output-file build/$@.txt pyproject.toml
	@.venv-lock/bin/uv --no-config pip install --quiet --python .venv-$@/bin/python $(PIP_FLAGS) -r build/$@.txt $(TEST_TOOLS)
	@.venv-lock/bin/uv --no-config pip install --quiet --python .venv-$@/bin/python --no-deps --no-build-isolation --editable .
	@.venv-$@/bin/python -m pytest -n auto --dist loadgroup -m "not slow" -W default::DeprecationWarning \
	  $(PYTEST_FLAGS) $(TESTS)

.PHONY: hooks
hooks: $(READY) ## run the checks at each git commit
	@$(BIN)/pre-commit install

# --- set-up -----------------------------------------------------------------------------------------------------------

.PHONY: moved
moved:

$(LOCKED): requirements.lock $(MOVED)
	@found=; if [ -n "$(PYTHON)" ]; then set -- "$(PYTHON)"; \
	else set -- python3 python3.14 python3.13 python3.12 python3.11 python; fi; \
	for python; do \
	  "$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && found=$$python && break; \
	done; \
	if [ -z "$$found" ]; then \
	  echo "erclutch needs Python 3.11 or newer, and none of these is: $$*." >&2; \
	  echo "Install one, or name it: make demo PYTHON=/path/to/python3.12" >&2; exit 1; \
	fi; \
	if ! "$$found" -c 'import ensurepip, venv' 2>/dev/null; then \
	  echo "$$found has no venv module. Install it (Debian, Ubuntu: apt install python3-venv), then run make again." >&2; \
	  exit 1; \
	fi; \
	echo "Setting up $(VENV) with $$("$$found" -V) (once, two or three minutes) ..." >&2; \
	"$$found" -m venv --clear $(VENV)
	@awk '/^[^ #]/ { n++ } { print > ("$(VENV)/half-" n % 2) }' requirements.lock
	@$(INSTALL) $(VENV)/half-0 & $(INSTALL) $(VENV)/half-1; second=$$?; wait $$! && exit $$second
	@printf '%s\n' "$(CURDIR)" > $@

$(READY): $(LOCKED) pyproject.toml src/erclutch/_version.py
	@$(PIP) install --no-deps --no-build-isolation --no-index --editable .
	@touch $@

# uv resolves for all systems and Python versions at once.
.venv-lock/bin/uv: $(READY) Makefile
	@$(BIN)/python -m venv --clear .venv-lock
	@.venv-lock/bin/python -m pip --disable-pip-version-check --no-input --quiet install uv==$(UV_VERSION)

.PHONY: lock
lock: .venv-lock/bin/uv ## requirements.lock anew from pyproject.toml (newest of all: LOCK_FLAGS=--upgrade)
	@.venv-lock/bin/uv --no-config pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest \
	  --generate-hashes --no-emit-index-url --no-emit-find-links --custom-compile-command "make lock" \
	  $(LOCK_FLAGS) --group dev --output-file requirements.lock pyproject.toml
	@! grep -nE '://|^--' requirements.lock || { echo "requirements.lock must name no address." >&2; exit 1; }

# --- what is handed on ------------------------------------------------------------------------------------------------

# Files of the commit alone, and its time: another folder, day or umask makes the same bytes.
.PHONY: dist
dist: $(READY) ## wheel and sdist of the last commit, into dist: one commit, the same bytes
	@rm -rf dist build/dist
	@mkdir -p build/dist
	@git archive HEAD | tar -x -C build/dist
	@python="$$(cd $(BIN) && pwd)/python"; epoch=$$(git log -1 --format=%ct); cd build/dist && \
	  SOURCE_DATE_EPOCH=$$epoch "$$python" -m hatchling build -d "$(CURDIR)/dist"
	@cd dist && sha256sum *

.PHONY: sbom
sbom: $(READY) ## sbom.cdx.json: packages that erclutch runs on, with versions and licences
	@$(PIP) install --upgrade --target build/cyclonedx "cyclonedx-python-lib[json-validation]==$(CYCLONEDX_VERSION)"
	@$(BIN)/python studies/sbom.py

.PHONY: clean
clean: ## remove .venv and all caches (runs and reports stay)
	@rm -rf $(VENV) .venv-lock .venv-test-oldest .venv-test-newest build dist .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	@find src tests -name __pycache__ -type d -prune -exec rm -rf {} +
