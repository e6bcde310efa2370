# make demo: from nothing to pictures.   make test: from nothing to green tests.   Both install what is missing.
.PHONY: demo test lint gallery tutorial clean

demo:
	@scripts/setup.sh
	@.venv/bin/python -m sdfprt demo -o out/demo

test:
	@scripts/setup.sh test,dev
	@.venv/bin/python -m pytest -n 2 --dist loadfile

lint:
	@scripts/setup.sh test,dev
	@.venv/bin/ruff check . && .venv/bin/ruff format --check . && .venv/bin/pyright

gallery:
	@scripts/setup.sh
	@.venv/bin/python scripts/gallery.py

tutorial:
	@scripts/setup.sh
	@.venv/bin/python scripts/tutorial.py

clean:
	rm -rf out .pytest_cache .ruff_cache
