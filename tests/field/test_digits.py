"""Numbers to text at once: the digits that Python writes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenarios.records.digits import LARGEST, table_text

LARGE = st.floats(-10 * LARGEST, 10 * LARGEST)
VALUES = st.one_of(st.floats(-1e6, 1e6), st.floats(-1, 1), LARGE, st.just(float("nan")), st.just(float("inf")))


@given(st.lists(st.tuples(VALUES, VALUES), min_size=1, max_size=20), st.integers(0, 10), st.integers(0, 3))
def test_as_python_writes_it(rows, many, few):
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    lines = table_text(columns, [many, few]).decode().splitlines()
    assert len(lines) == len(rows)
    for line, row in zip(lines, rows, strict=True):
        for cell, value, decimals in zip(line.split(","), row, (many, few), strict=True):
            if not np.isfinite(value):
                assert cell == "nan"
                continue
            assert len(cell.partition(".")[2]) == decimals
            # a half may be rounded the other way: scaling rounds too
            assert abs(float(cell) - value) <= 0.5 * 10.0**-decimals + 1e-15 * abs(value) * 4
            assert not cell.lstrip("-").startswith("0") or cell.lstrip("-").startswith("0.") or cell == "0"
