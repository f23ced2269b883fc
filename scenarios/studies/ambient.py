"""Random machines in ambient operation, for as long as you like: drift, false takeovers, honest standard deviations."""

import argparse

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer.plants import ornstein_uhlenbeck, smib

from ..bench import frames, machines
from ..bench.streams import WANDERING, Streams, numbers

STATES = ("delta", "omega", "e1d", "e1q")

WARM_UP = 15.0
"""s, from the start on, that do not count: in quiet operation a capture may take that long."""

PARTS = 4

VOLTAGE, ANGLE, POWER, TIME = 0.005, 0.02, 0.005, 2.0
"""The infinite bus wanders by 0.5 % and 0.02 rad, P_m by 0.005 pu (standard deviations), each with a memory of 2 s."""


TAKEOVER = 0.05
"""rad: what a frame of a tracked machine turns its estimate by if the bank takes over; else it is a tenth of that."""


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.ambient",
        description=__doc__,
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="3600 is the full study")
    parser.add_argument("--machines", type=int, default=12)
    parser.add_argument("--tve", type=float, default=0.01, help="noise of the phasors, and what is assumed")
    parser.add_argument("--dropouts", type=float, default=0.0, help="share of frames that do not arrive")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--estimated", action="store_true", help="E_f and P_m are estimated, not measured")
    arguments = parser.parse_args()
    source = 2 if arguments.estimated else 1
    plants = machines.random_machines(arguments.machines, arguments.seed)
    truth = machines.simulate(plants, arguments.seconds, inputs=wandering(plants.inputs, arguments), substeps=4)
    true = np.array([truth.delta, truth.omega, truth.e1d, truth.e1q])

    sums, squares = np.zeros((PARTS, len(STATES), arguments.machines)), np.zeros((PARTS, arguments.machines))
    worst, counts = np.zeros((PARTS, arguments.machines)), np.zeros(PARTS)
    takeovers, tracking = 0, np.array(False)

    def count_takeovers(k, state):
        nonlocal takeovers, tracking
        takeovers += int(np.sum(tracking & (abs(state.estimator.turn) > TAKEOVER)))
        tracking = state.estimator.tracking > 0
        return state

    channel = frames.noise(arguments.tve, dropout=arguments.dropouts)
    observed = frames.observe(
        "robust",
        frames.for_seeds(truth),
        frames.arriving(truth, channel, 1, arguments.seed),
        alter=count_takeovers,
        tve=arguments.tve,
        field_voltage=source,
        mechanical_power=source,
    )
    for k, o in enumerate(observed):
        if k * frames.PERIOD < WARM_UP:
            continue
        i = int(PARTS * (k - WARM_UP / frames.PERIOD) / (len(truth.V) - WARM_UP / frames.PERIOD))
        errors = np.array([getattr(o, name)[:, 0] for name in STATES]) - true[:, k + 1]
        deviations = np.array([getattr(o, f"{name}_std")[:, 0] for name in STATES])
        sums[i] += (errors / deviations) ** 2
        e1 = np.hypot(errors[2], errors[3])
        squares[i] += e1**2
        worst[i] = np.maximum(worst[i], e1)
        counts[i] += 1

    title = f"{arguments.machines} machines, {arguments.seconds:g} s, TVE {arguments.tve:.1%}"
    table = Table(title=f"{title}, {arguments.dropouts:.0%} dropouts: normalised error squared, mean over machines")
    for column in ("quarter", *STATES, "|error of (E'd, E'q)| RMS", "worst"):
        table.add_column(column)
    for i in range(PARTS):
        nees = np.mean(sums[i] / counts[i], axis=1)
        rms = np.sqrt(np.mean(squares[i] / counts[i]))
        table.add_row(str(i + 1), *[f"{v:.2f}" for v in nees], f"{rms:.5f}", f"{worst[i].max():.4f}")
    nees = np.mean(np.sum(sums, axis=0) / np.sum(counts), axis=1)
    table.add_row("all", *[f"{v:.2f}" for v in nees], "", "")
    per_machine = np.sum(sums, axis=0) / np.sum(counts)
    table.add_row("least", *[f"{v:.2f}" for v in per_machine.min(1)], "", "")
    table.add_row("most", *[f"{v:.2f}" for v in per_machine.max(1)], "", "")
    console = Console(width=120)
    console.print(table)
    console.print(
        f"takeovers (a frame turns the estimate of a tracked machine by more than {TAKEOVER} rad): {takeovers}"
    )


def wandering(u: smib.Inputs, arguments):
    """The plant's inputs at t: Ornstein-Uhlenbeck at the frames, linear in between."""
    streams = Streams(WANDERING + numbers(arguments.seed, (3, arguments.machines)))
    paths = [np.zeros((3, arguments.machines))]
    for _ in range(round(arguments.seconds / frames.PERIOD) + 1):
        paths.append(ornstein_uhlenbeck.step(paths[-1], frames.PERIOD, TIME, 1.0, streams.normal()))

    def inputs(t, outputs) -> smib.Inputs:
        k, part = divmod(t / frames.PERIOD, 1)
        V, angle, P = paths[int(k)] + part * (paths[int(k) + 1] - paths[int(k)])
        return u._replace(
            V_inf=u.V_inf * (1 + VOLTAGE * V), theta_inf=u.theta_inf + ANGLE * angle, P_m=u.P_m + POWER * P
        )

    return inputs


if __name__ == "__main__":
    main()
