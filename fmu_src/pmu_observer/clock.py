"""The simulation's clock: seconds in a double, from a start that may be negative, 0, or UTC (1.7e9 s)."""

NEVER = 1e30
"""s; the start value of the time of an event that does not happen: it has not passed at any time in use."""

RESOLUTION = 1e-9
"""s, of the clock near 0."""

EPSILON = 2.0**-52
"""Of the clock far from 0, relative: at 1.7e9 s doubles are 2.4e-7 s apart."""


def resolution(xp, t):
    """s; two times this close are one, for a master that adds up its steps."""
    return RESOLUTION + 4 * EPSILON * xp.abs(t)
