# Shortcuts; the scripts do the work. `make check` is the one to run while working.
SHELL := /bin/bash
BIN := .venv/bin
LOCK := $(BIN)/uv pip compile setup.py --universal --python-version 3.10 --generate-hashes --no-emit-index-url \
	--no-header --no-annotate --quiet

.PHONY: setup check test run firmware lock clean

setup:
	@source scripts/lib/setup.sh && set_up

# Under a minute: style, types, import contracts, fast tests.
check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo --cache-dir .cache/import-linter
	$(BIN)/python -m pytest -q -m 'not slow and not ros'

test:
	scripts/test.sh

run:
	scripts/start.sh --sim

# The robot's firmware: its own tests, and the image for the Arduino with its size. Tools: deploy/firmware/install-tools.sh
firmware:
	$(MAKE) -C deploy/firmware host check avr

# Writes the locks anew with today's newest versions; the second has to agree with the first.
lock: setup
	$(LOCK) --upgrade --extra sim --extra dev -o requirements.lock
	$(LOCK) --upgrade --extra ros --extra interfaces -c requirements.lock -o requirements-ros.lock

clean:
	$(MAKE) -C deploy/firmware clean
	rm -rf .cache build install log dist *.egg-info .venv-py3*
