"""The observer FMU over a record: `python -m scenarios observe`."""
