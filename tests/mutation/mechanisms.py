"""python -m tests.mutation.mechanisms [NAME ...]: take each mechanism out by hand, and see a test fail.

A mechanism is a place in the sources, what stands there, what is put in its place, and the tests that must notice. The
sources are changed in a copy of the checkout. Exit code 1 if a mutant survives.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import track

ROOT = Path(__file__).parents[2]
PACKAGE = "fmu_src/pmu_observer"
COPIED = ("fmu_src", "scenarios", "tests", "build_fmu.py", "pyproject.toml")


class Mechanism(NamedTuple):
    file: str  # in the package
    there: str
    instead: str
    tests: str  # arguments of pytest


TIME = "tests/equations/test_frame_time.py"
ROBUST = "tests/test_robust.py"
BAD = "tests/equations/test_bad_frames.py"
SHOWS = "tests/test_what_is_wrong_shows.py"

MECHANISMS = {
    "supervision: the bank never takes over": Mechanism(
        "estimators/robust.py",
        "replaces = xp.logical_or(xp.logical_not(tracking), takeover)",
        "replaces = xp.logical_not(tracking)",
        f"{ROBUST} -k wrong_well",
    ),
    "supervision: the rest never ends": Mechanism(
        "estimators/robust.py", "GREATEST_AGE, REST = 0.25, 5.0, 0.75", "GREATEST_AGE, REST = 0.25, 5.0, 1e9", ROBUST
    ),
    "supervision: no rest": Mechanism(
        "estimators/robust.py",
        "awake=xp.where(done, 0.0, 1.0)",
        "awake=xp.where(done, 1.0, 1.0)",
        f"{ROBUST} -k wakes_afresh",
    ),
    "supervision: the old bank goes on after the rest": Mechanism(
        "estimators/robust.py",
        "return Verdict(before._replace(age=age), tracker, 0.0, 0.0, again=xp.where(age >= REST, 1.0, 0.0))",
        "return Verdict(before._replace(age=age, awake=xp.where(age >= REST, 1.0, 0.0)), tracker, 0.0, 0.0, again=0.0)",
        f"{ROBUST} -k 'wrong_well or wakes_afresh'",
    ),
    "supervision: estimates alone take over": Mechanism(
        "estimators/robust.py",
        "ahead = xp.logical_and(captured, tracker_score < -TAKEOVER_LEAD)",
        "ahead = captured",
        f"{ROBUST} -k 'wrong_well or contradict or lead'",
    ),
    "time: a stamp that has not grown is new": Mechanism(
        "gating.py", "t_frame > gate.t_frame + SHORTEST", "t_frame > gate.t_frame - 1.0", TIME
    ),
    "time: dated with the arrival, whatever the stamp": Mechanism(
        "gating.py", "latency = xp.where(stamped, t - t_frame, on_arrival)", "latency = on_arrival", TIME
    ),
    "time: a repeat is new although the rotor turns": Mechanism(
        "gating.py",
        "believed = xp.logical_or(xp.logical_not(turning), gate.unchanged > LONGEST_REPEAT)",
        "believed = gate.unchanged >= 0",
        f"{TIME} {ROBUST}",
    ),
    "time: a repeat is never believed": Mechanism(
        "gating.py",
        "believed = xp.logical_or(xp.logical_not(turning), gate.unchanged > LONGEST_REPEAT)",
        "believed = xp.logical_not(turning)",
        TIME,
    ),
    "time: a believed repeat is no doubt": Mechanism(
        "gating.py",
        "doubtful = xp.logical_and(xp.logical_not(stamped), xp.logical_and(same, turning))",
        "doubtful = gate.held < 0",
        TIME,
    ),
    "time: a repeat is dated with its arrival": Mechanism(
        "gating.py", "on_arrival = xp.where(punctual, xp.maximum(elapsed - period, 0.0), 0.0)", "on_arrival = 0.0", TIME
    ),
    "time: never overdue": Mechanism("gating.py", "waited > OVERDUE * period", "waited > 1e9 * period", TIME),
    "time: the period is not learnt": Mechanism(
        "gating.py",
        "period=xp.where(differs, learnt_period(xp, gate.period, interval), gate.period)",
        "period=0.0",
        TIME,
    ),
    "time: lost frames move the period": Mechanism(
        "gating.py", "return xp.where(period > 0, moved, interval)", "return interval", TIME
    ),
    "time: any clock": Mechanism(
        "gating.py", "return xp.logical_or(p.frame_time != STAMPED, possible)", "return age < 1e300", TIME
    ),
    "gating: no gross errors": Mechanism("gating.py", "GROSS = 25.0", "GROSS = 1e9", ROBUST),
    "gating: gross errors for good": Mechanism(
        "gating.py", "MOST_REJECTED, FORGIVEN = 2", "MOST_REJECTED, FORGIVEN = 1e9", ROBUST
    ),
    "gating: every second frame may be gross": Mechanism(
        "gating.py",
        "MOST_REJECTED, FORGIVEN = 2, 0.25",
        "MOST_REJECTED, FORGIVEN = 2, 9.0",
        f"{ROBUST} tests/fmu/test_wild_frames.py",
    ),
    "gating: no voltage": Mechanism("gating.py", "V > LOWEST_VOLTAGE", "V > -1e9", BAD),
    "gating: contradictions are believed": Mechanism(
        "gating.py", "xp.logical_and(usable, is_consistent(xp, c, s))", "xp.logical_and(usable, V > 0)", BAD
    ),
    "gating: a missing P_m makes the frame useless": Mechanism(
        "gating.py", "xp.logical_or(complete, started)", "complete", TIME
    ),
    "gating: a missing P_m is not marked": Mechanism(
        "gating.py", ", received.complete <= 0)", ", received.complete < 0)", TIME
    ),
    "jump: none": Mechanism("sampling.py", "JUMP = 28.0", "JUMP = 1e9", f"{ROBUST} -k fault"),
    "jump: its noise everywhere": Mechanism("sampling.py", "JUMP = 28.0", "JUMP = 0.0", ROBUST),
    "gap: omega is sure of itself": Mechanism(
        "speed/rotor.py", "drift = unseen * unseen + OMEGA_WALK * OMEGA_WALK * gap", "drift = 0.0", TIME
    ),
    "gap: acceleration goes on for ever": Mechanism(
        "speed/rotor.py", "xp.cond(h > SEEN, with_gap,", "xp.cond(h > 1e9, with_gap,", f"{TIME} {BAD}"
    ),
    "gap: a believed repeat makes sure": Mechanism(
        "prediction.py", "xp.where(state.gate.held > 0, xp.maximum(state.gate.unchanged - h, 0.0), 0.0)", "0.0", TIME
    ),
    "restart: beyond a quarter turn": Mechanism("observer.py", "xp.abs(turn) < pi)", "xp.abs(turn) < pi / 2)", TIME),
    "restart: never": Mechanism("observer.py", "xp.abs(turn) < pi)", "xp.abs(turn) < 1e9)", ROBUST),
    "restart: rejected frames do not count": Mechanism(
        "observer.py",
        "xp.where(state.gate.rejected > 0, span.h, period)",
        "period",
        f"{ROBUST} tests/fmu/test_wild_frames.py",
    ),
    "restart: an estimator that ran away goes on": Mechanism(
        "observer.py", "credible = is_finite(xp, estimate.x, LARGEST_STATE)", "credible = h > -1.0", BAD
    ),
    "speed: a surprise does not widen": Mechanism(
        "speed/kalman.py", "SURPRISE = 25.0", "SURPRISE = 1e9", f"{ROBUST} {TIME}"
    ),
    "speed: the estimator's correction turns the rotor": Mechanism(
        "speed/kalman.py", "delta=moved.delta - estimate.turn", "delta=moved.delta", ROBUST
    ),
    "confidence: deviations do not grow": Mechanism(
        "confidence.py", "return xp.maximum(mean_square, 1.0)", "return 1.0", SHOWS
    ),
    "mismatch: not shown": Mechanism(
        "gating.py", "power_mismatch=xp.where(phi_came,", "power_mismatch=xp.where(V < 0,", SHOWS
    ),
    "noise: none in A": Mechanism("noise.py", "return 2 * s.measured.tve", "return 0 * s.measured.tve", ROBUST),
}


def survives(mechanism: Mechanism) -> bool:
    """Do the tests pass without it? Raises ValueError where the sources have changed."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, copy / name, ignore=shutil.ignore_patterns("__pycache__", "*.png", "*.svg"))
            else:
                shutil.copy(source, copy / name)
        path = copy / PACKAGE / mechanism.file
        text = path.read_text(encoding="utf-8")
        if text.count(mechanism.there) != 1:
            raise ValueError(f"{mechanism.file} has {text.count(mechanism.there)} times: {mechanism.there}")
        path.write_text(text.replace(mechanism.there, mechanism.instead), encoding="utf-8")
        command = f"{sys.executable} -m pytest -q -x -n 0 -p no:cacheprovider {mechanism.tests}"
        return subprocess.run(command, cwd=copy, shell=True, capture_output=True).returncode == 0


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutation.mechanisms",
        description="Take each mechanism out, and see a test fail. Some minutes each where it survives.",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="the beginning of a mechanism's name; default: all")
    names = parser.parse_args().names
    chosen = [name for name in MECHANISMS if not names or name.startswith(tuple(names))]
    if not chosen:
        parser.error(f"no mechanism begins with {' or '.join(names)}; there are: {', '.join(MECHANISMS)}")
    console, survivors = Console(), []
    for name in track(chosen, description="mutants", console=console, transient=True):
        try:
            alive = survives(MECHANISMS[name])
        except ValueError as error:
            console.print(f"STALE     {name}: {error}", highlight=False)
            survivors.append(name)
            continue
        console.print(f"{'SURVIVED' if alive else 'killed'}  {name}", highlight=False)
        survivors += [name] if alive else []
    console.print(f"{len(chosen) - len(survivors)} of {len(chosen)} killed")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
