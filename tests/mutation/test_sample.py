"""The sample of mutants: each is a change of one line that Python can still read, in a file that has tests."""

import ast

import pytest

from . import sample


@pytest.fixture(scope="module")
def mutants() -> list[sample.Mutant]:
    return sample.all_mutants(sample.FILES)


def test_every_file_is_changed_and_has_tests(mutants):
    files = {mutant.file for mutant in mutants}
    assert {"gating.py", "observer.py", "prediction.py", "estimators/robust.py", "speed/kalman.py"} <= files
    for file in files:
        for test in sample.TESTS[sample.of_tests(file)]:
            path, _, name = test.partition("::")
            assert not name or f"def {name}(" in (sample.ROOT / path).read_text(encoding="utf-8")


def test_a_mutant_is_a_change_of_one_line(mutants):
    """Every 97th of them, of each operator some."""
    for mutant in mutants[::97]:
        text = (sample.ROOT / sample.PACKAGE / mutant.file).read_text(encoding="utf-8")
        new = sample.changed(mutant, text)
        ast.parse(new)
        differing = [k for k, (a, b) in enumerate(zip(text.splitlines(), new.splitlines(), strict=True), 1) if a != b]
        assert differing == [mutant.line]


def test_outcomes():
    """Of wait statuses: exit code in the high byte, signal in the low one."""
    assert sample.outcome(0) == "survived"
    assert sample.outcome(1 << 8) == "killed"
    assert sample.outcome(24) == "timeout"
