# Needs python3 (3.10 to 3.14) and make; everything else is installed into .venv by pip.
PYTHON ?= python3
ifeq ($(OS),Windows_NT)
BIN := .venv/Scripts
else
BIN := .venv/bin
endif
QUADRANTS := $(subst .venv,.venv-quadrants,$(BIN))

.PHONY: demo test test-quadrants media numbers docs docs-draft clean

# Run the main job and print where its movie, plots and summary are.
demo: .venv/run-ready
	$(BIN)/python -m tisph run configs/couette.yaml --overwrite

# Run the tests, without the slow ones (those: $(BIN)/python -m pytest -m slow). Many start programs, which
# would compile all modules anew where Python is told to keep none.
test: export PYTHONDONTWRITEBYTECODE =
test: .venv/test-ready
	$(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder

# With Quadrants in the place of Taichi, in an environment of its own: tests that start it anew for each case and
# never use two programs at once.
CORE := tests/runtime/test_runtime.py tests/numerics/test_operators.py tests/schemes/test_corner_singularities.py \
	tests/rheology/test_laws_in_kernels.py

test-quadrants: .venv-quadrants/ready
	$(QUADRANTS)/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile --no-loadscope-reorder $(CORE)

# Make the pictures and movies that README.md shows.
media: .venv/run-ready
	$(BIN)/python media/make.py

# Compare numbers of the documents with the runs from which they come.
numbers: .venv/test-ready
	$(BIN)/python docs/_numbers.py

# Make the documentation as a site in site/; a dead link is an error, and so is a page that a browser shows badly.
docs: .venv/docs-ready
	$(BIN)/python docs/_site.py
	$(BIN)/python docs/_look.py

# The same from gallery runs that are cut short, in a few minutes: does everything build, and look as it should?
docs-draft: export GALLERY = draft
docs-draft: docs

.venv/run-ready: pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	$(BIN)/python -c "import pathlib; pathlib.Path('$@').touch()"

.venv/test-ready: .venv/run-ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[test]"
	$(BIN)/python -c "import pathlib; pathlib.Path('$@').touch()"

# All packages of the other environment serve here, too, but for Taichi, which Python is told not to find.
SHARED := import site, sys; sys.modules[\"taichi\"] = None; site.addsitedir({other!r})
.venv-quadrants/ready: .venv/test-ready
	$(PYTHON) -m venv --without-pip .venv-quadrants
	$(QUADRANTS)/python -c "import pathlib, sysconfig; own = sysconfig.get_path('purelib'); \
	other = own.replace('.venv-quadrants', '.venv'); pathlib.Path(own, 'shared.pth').write_text(f'$(SHARED)')"
	$(QUADRANTS)/python -m pip install --quiet --disable-pip-version-check "quadrants>=1.3,<2"
	$(QUADRANTS)/python -c "import pathlib; pathlib.Path('$@').touch()"

.venv/docs-ready: .venv/run-ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[docs]"
	$(BIN)/python -c "import pathlib; pathlib.Path('$@').touch()"

clean:
	$(PYTHON) -c "import shutil; [shutil.rmtree(d, ignore_errors=True) for d in ('.venv', '.venv-quadrants', 'runs', 'site')]"
