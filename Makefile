# Needs python3 (3.10 to 3.13) and make; everything else is installed into .venv by pip.
PYTHON ?= python3
ifeq ($(OS),Windows_NT)
BIN := .venv/Scripts
else
BIN := .venv/bin
endif

.PHONY: demo test media docs clean

# Run the main job and print where its movie, plots and summary are.
demo: .venv/run-ready
	$(BIN)/python -m tisph run configs/couette.yaml --overwrite

# Run the tests, without the ones that take minutes (those: $(BIN)/python -m pytest -m slow). Many start programs, which
# would compile all modules anew where Python is told to keep none.
test: export PYTHONDONTWRITEBYTECODE =
test: .venv/test-ready
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder

# Make the pictures and movies that README.md shows.
media: .venv/run-ready
	$(BIN)/python media/make.py

# Make the documentation as a site in site/; a dead link is an error.
docs: .venv/docs-ready
	$(BIN)/python -m mkdocs build --strict

.venv/run-ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	$(BIN)/python -c "import pathlib; pathlib.Path('$@').touch()"

.venv/test-ready: .venv/run-ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[test]"
	$(BIN)/python -c "import pathlib; pathlib.Path('$@').touch()"

.venv/docs-ready: .venv/run-ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[docs]"
	$(BIN)/python -c "import pathlib; pathlib.Path('$@').touch()"

clean:
	$(PYTHON) -c "import shutil; [shutil.rmtree(d, ignore_errors=True) for d in ('.venv', 'runs', 'site')]"
