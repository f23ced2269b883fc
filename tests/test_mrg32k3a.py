"""MRG32k3a against what others have published, and the same to the bit on every carrier."""

import numpy as np
import pytest
from casadi import SX, Function, vertcat

from fmu_src.pmu_observer.carriers import arrays, floats, symbols
from fmu_src.pmu_observer.mrg32k3a import M1, Generator, stream, uniform


def draws(xp, generator, count):
    found = []
    for _ in range(count):
        generator, u = uniform(xp, generator)
        found.append(u)
    return found


def test_first_numbers_from_the_seed_12345():
    """In integers as tabulated by Rossetti, "Simulation Modeling and Arena", appendix on random numbers; in doubles as
    L'Ecuyer's own C code (RngStreams, TestU01) prints them."""
    found = draws(floats, Generator(), 5)
    assert [round(u * (M1 + 1)) for u in found] == [545508589, 1368065410, 1327943761, 3546985096, 951893194]
    assert found == [
        0.12701112204657714,
        0.3185275653967945,
        0.3091860155832701,
        0.8258468629271136,
        0.2216299157820229,
    ]


def test_first_numbers_from_another_seed():
    """The table of rosettacode.org, "Pseudo-random numbers/Combined recursive generator MRG32k3a"; it adds 1."""
    generator = Generator(0.0, 0.0, 1234567.0, 0.0, 0.0, 1234567.0)
    found = [round(u * (M1 + 1)) + 1 for u in draws(floats, generator, 5)]
    assert found == [1459213977, 2827710106, 4245671317, 3877608661, 2595287583]


@pytest.mark.parametrize(
    ("number", "state"),
    [
        (0, [12345] * 6),
        (1, [3692455944, 1366884236, 2968912127, 335948734, 4161675175, 475798818]),
        (2, [1015873554, 1310354410, 2249465273, 994084013, 2912484720, 3876682925]),
    ],
)
def test_starts_of_the_streams(number, state):
    """The initial states of g1, g2 and g3 in test2RngStream.res of RngStreams (L'Ecuyer et al. 2002)."""
    assert list(stream(floats, number)) == state


@pytest.mark.parametrize("number", [5, 1000, 2**31 - 1])
def test_the_jump_is_that_many_times_2_to_the_127(number):
    """Against a power of the matrix in Python's own integers."""
    for matrix, m, start in (
        ([[0, 1, 0], [0, 0, 1], [-810728, 1403580, 0]], 4294967087, 0),
        ([[0, 1, 0], [0, 0, 1], [-1370589, 0, 527612]], 4294944443, 3),
    ):
        power, base, exponent = np.identity(3, dtype=object), np.array(matrix, dtype=object), number * 2**127
        while exponent:
            if exponent % 2:
                power = power @ base % m
            base, exponent = base @ base % m, exponent // 2
        expected = power @ np.array([12345] * 3, dtype=object) % m
        assert list(stream(floats, number))[start : start + 3] == list(expected)


def test_carriers_agree_to_the_bit():
    numbers = [0, 1, 77, 123456789, 2**31 - 1]
    one_by_one = np.array([draws(floats, stream(floats, float(n)), 200) for n in numbers])
    together = np.array(draws(arrays, stream(arrays, np.array(numbers, dtype=float)), 200))
    assert np.array_equal(together.T, one_by_one)

    number, state = SX.sym("number"), SX.sym("state", 6)
    start = Function("start", [number], [vertcat(*stream(symbols, number))])
    generator, u = uniform(symbols, Generator(*[state[i] for i in range(6)]))
    step = Function("step", [state], [vertcat(*generator), u])
    for n, expected in zip(numbers, one_by_one, strict=True):
        traced = start(n)
        for value in expected:
            traced, found = step(traced)
            assert float(found) == value


def test_streams_of_neighbouring_numbers_are_independent():
    """Seeds that differ by 1 would not be: each sequence would be the one before plus the same numbers, mod 1."""
    u = np.array(draws(arrays, stream(arrays, np.arange(2000.0)), 10))
    correlation = np.corrcoef(np.vstack([u[:, :-1], np.diff(u, axis=1) % 1]))
    # standard error 1/sqrt(2000) = 0.022; the pairs that overlap by definition (u and its own difference) left out
    between = correlation[:10, :10][~np.eye(10, dtype=bool)]
    assert np.abs(between).max() < 0.1
    assert np.abs(np.var(np.diff(u, axis=1) % 1, axis=1) * 12 - 1).max() < 0.2  # a constant would have variance 0
