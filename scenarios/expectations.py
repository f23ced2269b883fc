"""What a scenario expects, judged on the results of its run."""

from typing import Any, NamedTuple

import numpy as np

from .master import Results
from .plan import Signal, value_text
from .scenario import Expect


class Verdict(NamedTuple):
    name: str
    each: dict[str, Any]
    when: str
    wanted: str
    measured: float
    """The value that decides: the worst of the times that count."""
    unit: str
    holds: bool


def judge(results: Results) -> list[Verdict]:
    """One verdict for each expectation, reference and instance."""
    plan = results.plan
    return [
        verdict(results, expect, signal)
        for expect in plan.scenario.expect
        for reference in expect.references
        for signal in plan.expected(expect, reference)
    ]


def verdict(results: Results, expect: Expect, signal: Signal) -> Verdict:
    scenario = results.plan.scenario
    if expect.at is not None:
        first = last = scenario.index(expect.at)
        when = f"at {float(expect.at):g} s"
    else:
        first = scenario.index(scenario.stop if expect.after is None else expect.after)
        last = scenario.index(expect.until or scenario.stop)
        when = f"{scenario.time(first):g} s to {scenario.time(last):g} s"
    values = results.of(signal)[first : last + 1]

    # NaN compares as false: it never holds
    if expect.below is not None:
        measured = np.abs(values).max()
        wanted, holds = f"|.| < {expect.below:g}", measured < expect.below
    elif expect.above is not None:
        measured = np.abs(values).min()
        wanted, holds = f"|.| > {expect.above:g}", measured > expect.above
    else:
        near, within = expect.near or 0.0, str(expect.within)
        measured = values[np.abs(values - near).argmax()]
        share = abs(near) / 100 if within.endswith("%") else 1.0
        wanted = f"{value_text(near)} ± {within}"
        holds = abs(measured - near) <= share * float(within.removesuffix("%"))
    return Verdict(signal.name, signal.sweep, when, wanted, float(measured), signal.unit, bool(holds))
