# Two commands do everything on a fresh Debian or Ubuntu machine: `make scene` and `make test`.
# Each sets up what it needs the first time, and starts at once afterwards: `make scene` what a picture needs,
# `make test` the rest. A set-up that was stopped goes on when the command is given again.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PICTURES := $(VENV)/.pictures
EVERYTHING := $(VENV)/.installed
# Address of an index of packages with builds of torch for processors alone, for machines without CUDA.
TORCH_INDEX ?=
export TORCH_INDEX
SEED ?= 7
OUT ?= out
PART ?=

.DEFAULT_GOAL := help
.PHONY: help python setup backend scene test slow lint format clean
.DELETE_ON_ERROR:
.NOTPARALLEL:

help: ## Show the targets.
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' Makefile

scene: backend ## Render one labelled scene into out/ (SEED=7, OUT=out).
	$(BIN)/render-scene --seed $(SEED) --out $(OUT)

test: $(EVERYTHING) backend ## Pass the tests, on two cores.
	$(BIN)/pytest --numprocesses 2 --dist loadscope

slow: $(EVERYTHING) backend ## Pass the longer proofs (PART=2/7: the second seventh of them).
	$(BIN)/pytest --numprocesses 2 --dist loadscope -m slow $(if $(PART),--part $(PART))

lint: $(EVERYTHING) ## Check style, format and types.
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright

format: $(EVERYTHING) ## Mend style and format.
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

setup: $(EVERYTHING) ## Set up the whole environment .venv: pictures, networks, clusters, tests.

python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "$(PYTHON) is missing or older than Python 3.11; install one, or name one: make PYTHON=python3.12 ..." >&2; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
	  || { echo "$(PYTHON) has no venv module; install it (Debian or Ubuntu: apt-get install python3-venv)" >&2; exit 2; }

$(PICTURES): pyproject.toml constraints.txt | python
	@$(PYTHON) .ci/set_up.py pictures

$(EVERYTHING): pyproject.toml constraints.txt | python
	@$(PYTHON) .ci/set_up.py everything

# The backend itself finds a working LLVM and says what to install where there is none. Root may install it right here.
backend: $(PICTURES)
	@$(BIN)/python -P -m glassware.render.backend.variant || { \
	  test -z "$$DRJIT_LIBLLVM_PATH" && test "$$(id -u)" = 0 && command -v apt-get >/dev/null || exit 2; \
	  echo "Installing libllvm19 with apt-get" >&2; \
	  apt-get update --quiet && DEBIAN_FRONTEND=noninteractive apt-get install --yes --quiet libllvm19 && \
	  $(BIN)/python -P -m glassware.render.backend.variant; }

clean: ## Remove the environment, caches and out/.
	rm -rf $(VENV) out build dist .ci/packages/*.egg-info .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
