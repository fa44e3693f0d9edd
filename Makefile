# Footwork: `make demo`, `make test`, `make bench`, `make mutants`. Needs git, make and Python 3.11 (bpy 4.5) or 3.13 (bpy 5.2).
# A pythonX.Y on the path may be pyenv's launcher with no such version behind it: ask it, then look where pyenv keeps them.
find_python = $(firstword $(shell for p in $$(command -v python$(1)) $$HOME/.pyenv/versions/$(1)*/bin/python$(1); do \
	$$p -c 'import ensurepip' 2>/dev/null && echo $$p; done))
PY311 := $(call find_python,3.11)
PY313 := $(call find_python,3.13)
PYTHON ?= $(or $(PY311),$(PY313),python3)
VENV := .venv
PY := $(VENV)/bin/python
BPY := $(shell $(PYTHON) -c 'import sys; print({(3, 11): "bpy==4.5.15", (3, 13): "bpy==5.2.3"}.get(sys.version_info[:2], ""))')
OTHER_BPY := $(if $(PY311),4.2.23 4.5.15 5.0.1) $(if $(PY313),5.2.3)
TORCH ?= $(if $(filter bpy==4.5.15,$(BPY)),torch==2.13.0)

export OMP_NUM_THREADS ?= 2
export PIP_DISABLE_PIP_VERSION_CHECK = 1

.PHONY: help venv demo test lint test-core test-blender zip bench mutants fuzz fuzz-short clean

help:
	@echo "make demo     starter motion, an example recording and a bake from nothing: out/demo.blend, out/demo.mp4, out/demo.png"
	@echo "make test     lint, types, all tests, and the extension in every Blender that can be had"
	@echo "make bench    speed and memory, side by side with the alternatives"
	@echo "make mutants  how many small faults the tests of each package notice; MUTANTS=\"rig --all\" and the like"
	@echo "make fuzz     100,000 changed files through every reader; FUZZ=\"--count 5000 --seed 7\" and the like"
	@echo "make zip      the extension, dist/footwork-VERSION.zip"
	@echo "make venv     the development tools alone; make lint, make test-core: parts of make test"

$(VENV)/.runtime: pyproject.toml
	@test -n "$(BPY)" || { echo "Footwork's make needs Python 3.11 or 3.13; found $$($(PYTHON) --version). Set PYTHON=..."; exit 2; }
	@echo "Fetching Blender as a Python module into $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
	@$(VENV)/bin/pip install -qq -e . $(BPY)
	@touch $@

$(VENV)/.dev: $(VENV)/.runtime
	@echo "Fetching what the tests need into $(VENV) ..."
	@$(VENV)/bin/pip install -qq -e ".[dev]" $(TORCH)
	@touch $@

venv: $(VENV)/.dev

demo: $(VENV)/.runtime
	@timeout -k 5 900 $(PY) tools/demo.py --output out

lint: $(VENV)/.dev
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/pyright
	$(VENV)/bin/pyright -p tools/pyright_blender.json --pythonpath $(PY)

test-core: $(VENV)/.dev
	timeout -k 5 1500 $(PY) -m pytest tests --ignore=tests/blender --hypothesis-profile=ci

zip: $(VENV)/.runtime
	$(PY) tools/build_extension.py

# kept, though only a step on the way
.PRECIOUS: $(VENV)-%/.ready

# One virtual environment for each Blender; numpy 1 for 4.2, which its wheel does not pin.
$(VENV)-%/.ready:
	@echo "Fetching Blender $* into $(VENV)-$* ..."
	@$(if $(filter 5.2%,$*),$(PY313),$(PY311)) -m venv $(VENV)-$*
	@$(VENV)-$*/bin/pip install -qq bpy==$* pytest $(if $(filter 4.2%,$*),"numpy<2")
	@touch $@

# Exports have a process of their own: Blender 4.2's glTF add-on now and then crashes in one that has loaded many files.
test-blender-%: $(VENV)-%/.ready zip
	timeout -k 5 600 $(VENV)-$*/bin/python tests/blender/run.py --ignore=tests/blender/test_exports.py
	timeout -k 5 300 $(VENV)-$*/bin/python tests/blender/run.py -k test_exports

test-blender: $(foreach version,$(OTHER_BPY),test-blender-$(version))

test: lint test-core fuzz-short test-blender

# A quarter of an hour: files changed in every way, through every reader. tools/fuzz.py --help says what FUZZ can be.
fuzz: $(VENV)/.dev
	timeout -k 5 7200 $(PY) -W ignore tools/fuzz.py $(FUZZ)

fuzz-short: $(VENV)/.dev
	timeout -k 5 600 $(PY) -W ignore tools/fuzz.py --count 6000

bench: $(VENV)/.dev
	timeout -k 5 3000 $(PY) tools/bench.py

# Half an hour on two cores of their own for a sample of every package; see tools/mutants.py --help for what MUTANTS can say.
mutants: $(VENV)/.dev
	timeout -k 5 14400 $(PY) tools/mutants.py $(MUTANTS)

clean:
	rm -rf out dist build *.egg-info .pytest_cache .ruff_cache .hypothesis
