"""C37.118 in, estimates out, and a page to look at: `python -m scenarios pmu` and `python -m scenarios live`."""
