"""The FMUs in other people's importers, one a file; `python -m tests.importers` runs them all and makes the table."""
