# Two commands do everything on a fresh Debian or Ubuntu machine: `make scene` and `make test`.
# Both set up what they need the first time, and start at once afterwards.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
SEED ?= 7
OUT ?= out
PART ?=

.DEFAULT_GOAL := help
.PHONY: help setup backend scene test slow lint format clean
.DELETE_ON_ERROR:

help: ## Show the targets.
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' Makefile

scene: backend ## Render one labelled scene into out/ (SEED=7, OUT=out).
	$(BIN)/render-scene --seed $(SEED) --out $(OUT)

test: backend ## Pass the tests, on two cores.
	$(BIN)/pytest --numprocesses 2 --dist loadscope

slow: backend ## Pass the longer proofs (PART=2/7: the second seventh of them).
	$(BIN)/pytest --numprocesses 2 --dist loadscope -m slow $(if $(PART),--part $(PART))

lint: $(STAMP) ## Check style, format and types.
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright

format: $(STAMP) ## Mend style and format.
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

setup: $(STAMP) ## Set up the environment .venv.

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "$(PYTHON) is missing or older than Python 3.11; install one, or name one: make PYTHON=python3.12 ..." >&2; exit 2; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
	  || { echo "$(PYTHON) has no venv module; install it (Debian or Ubuntu: apt-get install python3-venv)" >&2; exit 2; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $@

# The backend itself finds a working LLVM and says what to install where there is none. Root may install it right here.
backend: $(STAMP)
	@$(BIN)/python -P -m glassware.render.backend.variant || { \
	  test -z "$$DRJIT_LIBLLVM_PATH" && test "$$(id -u)" = 0 && command -v apt-get >/dev/null || exit 2; \
	  echo "Installing libllvm19 with apt-get" >&2; \
	  apt-get update --quiet && DEBIAN_FRONTEND=noninteractive apt-get install --yes --quiet libllvm19 && \
	  $(BIN)/python -P -m glassware.render.backend.variant; }

clean: ## Remove the environment, caches and out/.
	rm -rf $(VENV) out build dist *.egg-info .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
