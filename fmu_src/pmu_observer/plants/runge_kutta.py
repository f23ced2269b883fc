"""The classical method of order 4 (Kutta 1901), for every plant and every model of one."""

from typing import Any, Callable

from .. import tree


def step(slope: Callable[[Any], Any], x: Any, h) -> Any:
    """x(t + h) of x' = slope(x), with an error of order h^5; x and slope(x) are trees of scalars, or arrays."""

    def moved(k, duration):
        return tree.map(lambda value, rate: value + duration * rate, x, k)

    k1 = slope(x)
    k2 = slope(moved(k1, h / 2))
    k3 = slope(moved(k2, h / 2))
    k4 = slope(moved(k3, h))
    return moved(tree.map(lambda a, b, c, d: (a + 2 * b + 2 * c + d) / 6, k1, k2, k3, k4), h)
