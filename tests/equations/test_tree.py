"""Trees of NamedTuples: what of a state is new after a step."""

from typing import NamedTuple

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.linear import Vector


class State(NamedTuple):
    x: Vector
    number: int
    bank: tuple


BEFORE = State(Vector(1.0, 2.0), 3, (Vector(4.0, 5.0), Vector(6.0, 7.0)))


def test_what_is_shared_has_not_changed():
    after = BEFORE._replace(x=Vector(1.5, 2.5), bank=(BEFORE.bank[0], Vector(6.5, float("nan"))))
    changed = tree.changed(after, BEFORE)
    assert changed[:3] == [1.5, 2.5, 6.5]
    assert changed[3] != changed[3]  # a new value that is not finite is never left out
    assert tree.changed(BEFORE, BEFORE) == []


def test_a_tree_of_new_leaves_has_changed_as_a_whole():
    after = tree.like(BEFORE, [leaf + 0.5 for leaf in tree.leaves(BEFORE)])
    assert tree.changed(after, BEFORE) == tree.leaves(after) == [1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]
