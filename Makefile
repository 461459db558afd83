# Everything from a clone with Python 3.11 or newer and make: `make demo`, `make test`.
# Each target makes what it needs in .venv and says so. Windows, or by hand: see README.md, "Install".

VENV := .venv
# the first of these that is new enough; PYTHON=/path/to/python make demo picks another
CANDIDATES := $(PYTHON) python3 python3.14 python3.13 python3.12 python3.11 python
PIP_FLAGS := --quiet --disable-pip-version-check
OUTPUT := demo-output
FUZZ := 3000
# of make soak
HOURS := 0.25
# of make shaken: seeds of last digits, kernels of the linear algebra (SkylakeX, too, where there is AVX-512)
SEEDS := 1 2 3 4 5
CORES := Haswell Zen Nehalem
SHAKEN := tests/geometry/test_loop.py tests/test_cli_verify.py tests/test_cli_recut.py tests/golden \
  tests/geometry/test_kinds_from_the_command_line.py tests/geometry/test_mixed_kinds.py \
  tests/geometry/test_kind_contract.py tests/geometry/test_relaxation.py tests/unit/test_plan.py \
  tests/unit/test_simplest.py tests/unit/test_nominal_depths.py tests/test_shaken.py
# tests that run side by side; each needs about 1 GB
WORKERS := 2
# the matrices are small: threads of the linear algebra only take the processor from the other tests
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1
# compiled files are kept, also where the machine says otherwise: tests begin a third of a minute sooner
export PYTHONDONTWRITEBYTECODE :=

.PHONY: help demo test quick times lint docs fuzz shaken soak freecad freecad-quick bench ci clean

help:
	@echo "make demo    install into $(VENV) and balance the bundled crank; results in $(OUTPUT)/"
	@echo "make test    install the test tools too and run every test"
	@echo "make quick   the tests without the slow ones"
	@echo "make times   measure every test and list the slow ones, which make quick leaves out"
	@echo "make lint    ruff, mypy, import-linter, and the prose of pages, texts and docstrings"
	@echo "make docs    build the documentation's site into docs/_build/html; a warning is an error"
	@echo "make fuzz    damaged files by the thousand for every reader; every layout and seed of random tests"
	@echo "make freecad install FreeCAD where that can be, and try the workbench in it, without a window and in one;"
	@echo "             make freecad-quick tries two kinds of cut, and no meshes"
	@echo "make soak    random jobs, slips, damaged files, changed reports, sessions of the app, kills; HOURS=8 for a night"
	@echo "make shaken  plans with other last digits and other kernels of the linear algebra: the same results"
	@echo "make bench   measure time and memory beside the floor and the naive way, and the time to plan holes"
	@echo "make ci      what the project's checks run: .ci/run"
	@echo "make clean   remove $(VENV), $(OUTPUT)/ and caches"

demo: $(VENV)/.installed
	@echo "==> balancing the bundled motocross crank; results go to $(OUTPUT)/"
	@$(VENV)/bin/autobalance demo -o $(OUTPUT)

test: $(VENV)/.installed-dev
	@script/test-tools
	@echo "==> running every test, $(WORKERS) at a time, then those that measure time, one by one"
	@$(VENV)/bin/python -m pytest -q -n $(WORKERS) --dist worksteal -m "not timing" --durations 20
	@$(VENV)/bin/python -m pytest -q -m timing $$(grep -rl "mark.timing" tests --include='test_*.py')

quick: $(VENV)/.installed-dev
	@echo "==> running the quick tests"
	@$(VENV)/bin/python -m pytest -q -n $(WORKERS) --dist worksteal -m "not slow and not timing"

times: $(VENV)/.installed-dev
	@echo "==> measuring every test; those of a quarter of a second and more go into tests/slow.txt"
	@rm -f .times
	@AUTOBALANCE_TIMES=.times $(VENV)/bin/python -m pytest -q -n $(WORKERS) --dist worksteal -m "not timing"
	@sed 's/\[.*//' .times | awk '$$1 >= 0.25 {print $$2}' | LC_ALL=C sort -u >tests/slow.txt
	@rm .times

lint: $(VENV)/.installed-dev
	@echo "==> ruff check, ruff format --check, mypy --strict, lint-imports, prose"
	@$(VENV)/bin/ruff check .
	@$(VENV)/bin/ruff format --check .
	@$(VENV)/bin/mypy
	@$(VENV)/bin/lint-imports
	@$(VENV)/bin/python script/prose --quiet

docs: $(VENV)/.installed-docs
	@echo "==> building the documentation's site into docs/_build/html"
	@$(VENV)/bin/python -m sphinx -q -W --keep-going -j $(WORKERS) -b html docs docs/_build/html
	@echo "==> open docs/_build/html/index.html"

fuzz: $(VENV)/.installed-dev
	@echo "==> damaged, changed and invented files for every reader; AUTOBALANCE_FUZZ=$(FUZZ) of each kind"
	@AUTOBALANCE_FUZZ=$(FUZZ) $(VENV)/bin/python -m pytest -q tests/unit/test_solid_stl.py tests/unit/test_job_fuzz.py tests/geometry/test_solid_formats.py tests/geometry/test_solid_fuzz.py tests/test_cli_fuzz.py -k "damaged or any_bytes or changed or words or says or every_kind or run"
	@echo "==> every layout, fineness and seed, of which the tests take a few"
	@AUTOBALANCE_FUZZ=60 $(VENV)/bin/python -m pytest -q -n $(WORKERS) --dist worksteal $$(grep -rl "tests.sweeps" tests --include='test_*.py')

soak: $(VENV)/.installed-dev
	@echo "==> random cases for $(HOURS) hours; what falls is kept in tests/soak/corpus and tried by make test"
	@$(VENV)/bin/python -m tests.soak --hours $(HOURS)

shaken: $(VENV)/.installed-dev
	@for seed in $(SEEDS); do \
	  echo "==> plans and frames with last digits of seed $$seed"; \
	  AUTOBALANCE_SHAKEN=$$seed $(VENV)/bin/python -m pytest -q -n $(WORKERS) -m "not timing" $(SHAKEN) || exit 1; \
	done
	@for core in $(CORES); do \
	  echo "==> linear algebra for $$core"; \
	  OPENBLAS_CORETYPE=$$core $(VENV)/bin/python -m pytest -q -n $(WORKERS) -m "not timing" $(SHAKEN) || exit 1; \
	done

bench: $(VENV)/.installed-dev
	@echo "==> measuring how long the program takes to begin"
	@$(VENV)/bin/python benchmarks/start_up.py
	@echo "==> measuring time and memory of the main job"
	@$(VENV)/bin/python benchmarks/main_job.py
	@echo "==> comparing inspect and balance with the floor, and with the last landed ratios"
	@$(VENV)/bin/python benchmarks/against_floor.py
	@echo "==> the same from 0.1 to 3 million triangles of one crank"
	@$(VENV)/bin/python benchmarks/against_floor.py --growth --repeat 1
	@echo "==> measuring the time to plan holes"
	@$(VENV)/bin/python benchmarks/planning.py
	@echo "==> measuring recognition beside weld and build"
	@$(VENV)/bin/python benchmarks/recognition.py
	@echo "==> measuring inspect and balance on real and drawn cranks; AUTOBALANCE_CRANKS=FOLDER adds yours"
	@$(VENV)/bin/python benchmarks/real_cranks.py

freecad-quick: export AUTOBALANCE_QUICK := 1
freecad-quick: freecad

freecad: $(VENV)/.installed-dev
	@script/freecad
	@echo "==> the FreeCAD workbench, in three processes: import, every kind of cut, spreadsheet, save, reopen, refusals,"
	@echo "    and in a window that nobody sees; its picture is $(OUTPUT)/freecad.png"
	@script/freecad-checks $(OUTPUT)

ci:
	@bash .ci/run

clean:
	rm -rf $(VENV) $(OUTPUT) build dist docs/_build docs/_generated .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache

$(VENV)/bin/python:
	@found=; for each in $(CANDIDATES); do \
	  if "$$each" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; then found=$$each; break; fi; \
	done; \
	if [ -z "$$found" ]; then echo "autobalance needs Python 3.11 or newer; found none of: $(CANDIDATES)" >&2; exit 1; fi; \
	echo "==> making a virtual environment in $(VENV) with $$($$found --version)"; \
	"$$found" -m venv $(VENV) || { rm -rf $(VENV); \
	  echo "this Python has no venv; on Debian and Ubuntu: apt install python3-venv" >&2; exit 1; }

$(VENV)/.installed: pyproject.toml | $(VENV)/bin/python
	@echo "==> installing autobalance and its libraries into $(VENV)"
	@$(VENV)/bin/python -m pip install $(PIP_FLAGS) --editable .
	@$(VENV)/bin/python -m compileall -q autobalance # as pip does for all but editable packages
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(VENV)/bin/python
	@echo "==> installing autobalance, its libraries and the test tools into $(VENV)"
	@$(VENV)/bin/python -m pip install $(PIP_FLAGS) --editable ".[dev]"
	@$(VENV)/bin/python -m compileall -q autobalance
	@touch $(VENV)/.installed $@

$(VENV)/.installed-docs: pyproject.toml $(VENV)/.installed-dev
	@echo "==> installing what builds the documentation into $(VENV)"
	@$(VENV)/bin/python -m pip install $(PIP_FLAGS) --editable ".[docs]"
	@touch $@
