"""Studies of the robust estimator under noise: many seeds or machines at once, on the numpy carrier.

Each module is a command that prints a table: python -m scenarios.studies.noise --help
"""
