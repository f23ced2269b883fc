"""The comparison: every estimator on the same frames, over TVEs and noise seeds."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..bench import frames, machines
from ..bench import smib_fault as the_fault
from . import batch, runs, tuning


def smib_fault() -> frames.Truth:
    return machines.simulate(the_fault.plant(the_fault.fault()), 20.0)


class Judged(NamedTuple):
    """What the estimators are judged on; 20 s."""

    title: str
    truth: Callable[[], frames.Truth]
    captured_by: float = 20.0
    """s; capture is what comes before."""


JUDGED = {
    "record_g6": Judged("Record of generator 6", lambda: frames.record(frames.RECORD_G6)),
    "record_g6_6th_order": Judged(
        "Record of generator 6 of the 6th order", lambda: frames.record(frames.RECORD_G6_6TH_ORDER)
    ),
    "smib_fault": Judged("Fault of 100 ms at generator 6", smib_fault, captured_by=10.0),
}

TVES = (0.0003, 0.001, 0.003, 0.01, 0.03)
SHOWN = [1, 3]
"""Of them, those in the table: 0.1 % and 1 %."""

STEADY_FROM = 5.0
"""s"""

RIGHT, CLOSE = 0.1, 0.01
"""pu; captured: the error of (E'd, E'q) stays below RIGHT, and the estimator says so; settled: below CLOSE."""

TUNING_SEEDS = 3

SEED, TUNING_SEED = 1, 2
"""Of the two records' noise."""

PEERS = {"EKF": batch.ekf_step, "UKF": batch.ukf_step}

A_QUARTER_TURN = -np.pi / 2
"""rad; the bad start is a flat start with the rotor this much away from the voltage."""


class Summary(NamedTuple):
    """Of one estimator; arrays over TVES."""

    name: str
    start: str
    delta: np.ndarray  # rad, RMS error from STEADY_FROM on
    omega: np.ndarray  # rad/s
    e1: np.ndarray  # pu, of |error of (E'd, E'q)|
    captured: np.ndarray  # s, the median over the seeds; nan: never
    settled: np.ndarray  # s, likewise
    share: np.ndarray  # of the seeds that are captured in the end
    course: np.ndarray  # pu, median error of (E'd, E'q), one row a frame


class Comparison(NamedTuple):
    title: str
    t: np.ndarray  # s
    summaries: list[Summary]
    tunings: dict[str, tuple[np.ndarray, np.ndarray]]
    """By peer: q_omega, q_d, q_q, and the standard deviation of the flat start, for each of TVES."""


def compare(name: str, seeds: int, progress: Callable[[float], None]) -> Comparison:
    """Run all on JUDGED[name]; `progress` is told the share of the work that is done."""
    title, make_truth, captured_by = JUDGED[name]
    truth = make_truth()
    t = frames.PERIOD * np.arange(1, len(truth.V))
    judged = runs.noisy(truth, TVES, seeds, SEED)
    to_tune_on = runs.noisy(tuning.record_to_tune_on(), TVES, TUNING_SEEDS, TUNING_SEED)
    done = Work(progress, len(t) * (ROBUST + 3 * OTHER + 2 * PEER + 6 * GRID))

    def summary_of(name: str, start: str, e: runs.Errors) -> Summary:
        return summary(name, start, t, e, captured_by)

    cases = {"robust": (1, 1), "robust, no P_m": (2, 1), "robust, no P_m, no E_f": (2, 2)}
    power, field = (np.array(items)[:, None, None] for items in zip(*cases.values(), strict=True))
    e = runs.run_observer("robust", judged, done.of(ROBUST), mechanical_power=power, field_voltage=field)
    summaries = [summary_of(name, "none", part(e, i)) for i, name in enumerate(cases)]

    tunings = {}
    for name, step in PEERS.items():
        tunings[name] = q, P_flat = tuning.tuned(step, to_tune_on, done.of(GRID))
        x = np.stack([runs.good_start(judged), runs.flat_start(judged), runs.flat_start(judged, A_QUARTER_TURN)])
        P = np.stack(np.broadcast_arrays(tuning.P_GOOD, P_flat, P_flat))[..., None]
        e = runs.run_peer(step, judged, x, tuning.P_of(P), q, done.of(PEER))
        summaries += [summary_of(name, start, part(e, i)) for i, start in enumerate(("good", "flat", "bad"))]
        summaries.append(in_hindsight(name, step, judged, t, done.of(GRID)))
    for name in ("gradient", "drem", "open_loop"):
        summaries.append(summary_of(name, "none", runs.run_observer(name, judged, done.of(OTHER))))
    return Comparison(title, t, summaries, tunings)


def part(e: runs.Errors, i: int) -> runs.Errors:
    return runs.Errors(*[values[:, i] for values in e])


def in_hindsight(name: str, step, judged: runs.Frames, t, progress: Callable[[], None]) -> Summary:
    """What no user has: for each of delta, omega and (E'd, E'q) the best of the grid on the record that is judged.

    For the TVEs of the table only.
    """
    shown = judged._replace(tve=judged.tve[SHOWN, :], V=judged.V[:, SHOWN, :], I=judged.I[:, SHOWN, :])
    few = shown._replace(V=shown.V[..., :TUNING_SEEDS], I=shown.I[..., :TUNING_SEEDS])
    over_grid = tuning.over_grid(step, few, progress)
    best = np.argmin(np.stack([over_grid.delta, over_grid.omega, over_grid.e1]), axis=1)
    q = tuning.GRID[best][:, :, None, :]
    e = runs.run_peer(step, shown, runs.good_start(shown), tuning.P_of(tuning.P_GOOD), q, progress)
    by_delta, by_omega, by_e1 = (summary(name, "hindsight", t, part(e, i), t[-1]) for i in range(3))
    best = by_e1._replace(delta=by_delta.delta, omega=by_omega.omega)
    return best._replace(**{name: at_shown(getattr(best, name)) for name in best._fields[2:]})


def at_shown(values):
    """With nan for the other TVEs."""
    spread = np.full((*values.shape[:-1], len(TVES)), np.nan)
    spread[..., SHOWN] = values
    return spread


def summary(name: str, start: str, t, e: runs.Errors, captured_by: float) -> Summary:
    steady, early = t > STEADY_FROM - 1e-9, t < captured_by + 1e-9
    said = np.maximum.accumulate(e.tracking, axis=0) > 0
    captured, settled = (since(t[early], (said & (e.e1 < limit))[early]) for limit in (RIGHT, CLOSE))
    return Summary(
        name,
        start,
        *[np.sqrt(np.mean(v[steady] ** 2, axis=(0, -1))) for v in (e.delta, e.omega, e.e1)],
        captured=median(captured),
        settled=median(settled),
        share=np.isfinite(captured).mean(axis=-1),
        course=np.median(e.e1, axis=-1),
    )


def since(t, holds):
    """The time from which on it holds to the end, s; inf: not at the end."""
    first = len(t) - np.argmax(~holds[::-1], axis=0)
    first = np.where(holds.all(axis=0), 0, first)
    return np.append(t, np.inf)[first]


def median(times):
    """Over the seeds; nan where it is inf."""
    found = np.median(times, axis=-1)
    return np.where(np.isfinite(found), found, np.nan)


ROBUST, OTHER, PEER, GRID = 10.0, 1.0, 3.0, 1.0
"""Relative time of one frame."""


class Work:
    """Turns what has been done into a share of all."""

    def __init__(self, progress: Callable[[float], None], total: float):
        self.progress, self.total, self.done = progress, total, 0.0

    def of(self, amount: float) -> Callable[[], None]:
        def tick() -> None:
            self.done += amount
            self.progress(min(self.done / self.total, 1.0))

        return tick
