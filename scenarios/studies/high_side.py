"""A PMU on the high side of the step-up transformer: the errors with the transformer right, wrong, and forgotten.

Record of generator 6 (record_g6.csv, from another simulator), seen through x_T = 0.0143 pu (100 MVA), tap 1.025, Yd11.
The error of delta is the mean over 5 to 20 s (a wrong transformer biases it) and the RMS about the truth.
"""

import argparse
from math import degrees, pi

import numpy as np
from rich.console import Console
from rich.table import Table

from fmu_src.pmu_observer import observer
from fmu_src.pmu_observer.carriers import arrays
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.phasors import Frame
from fmu_src.pmu_observer.terminal import Transformer

from .. import loader
from ..records import standard

STEADY_FROM = 5.0
"""s"""

RIGHT = Transformer(x_T=0.0143, r_T=0.0, tap=1.025, shift=pi / 6)

CASES: dict[str, Transformer | None] = {
    "at the terminal": None,
    "high side, transformer right": RIGHT,
    "x_T + 10 %": RIGHT._replace(x_T=1.1 * RIGHT.x_T),
    "x_T - 10 %": RIGHT._replace(x_T=0.9 * RIGHT.x_T),
    "tap + 2.5 %": RIGHT._replace(tap=1.025 * RIGHT.tap),
    "no transformer but its shift": Transformer(shift=RIGHT.shift),
}
"""What the observer is told; None: the PMU is at the terminal."""


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m scenarios.studies.high_side",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--tve", type=float, default=0.002, help="noise of the phasors (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=20, help="noise seeds (default: %(default)s)")
    parser.add_argument("--estimated", action="store_true", help="E_f and P_m are estimated, not measured")
    chosen = parser.parse_args()
    errors, innovation = study(chosen.tve, chosen.seeds, chosen.estimated)
    title = f"TVE {chosen.tve:.1%}, {chosen.seeds} seeds, E_f and P_m {'estimated' if chosen.estimated else 'measured'}"
    table = Table("the observer is told", title=title)
    for name in ("delta, mean [deg]", "delta, RMS [deg]", "E'd, RMS [pu]", "E'q, RMS [pu]", "innovation, RMS"):
        table.add_column(name, justify="right")
    for i, name in enumerate(CASES):
        e = errors[:, :, i]
        rms = np.sqrt(np.mean(e**2, axis=(1, 2)))
        mean, size = degrees(np.mean(e[0])), degrees(rms[0])
        quiet = float(np.sqrt(np.mean(innovation[:, i] ** 2)))
        table.add_row(name, f"{mean:.3f}", f"{size:.3f}", f"{rms[1]:.5f}", f"{rms[2]:.5f}", f"{quiet:.2f}")
    Console(width=120).print(table)


def study(tve: float, seeds: int, estimated: bool) -> tuple[np.ndarray, np.ndarray]:
    """Errors (delta, E'd, E'q) x frames x cases x seeds, and innovations, from STEADY_FROM on."""
    record = standard.read(loader.FOLDER / "data" / "record_g6.csv")
    truth = np.genfromtxt(loader.FOLDER / "data" / "record_g6.csv", delimiter=",", names=True)
    told = [case or Transformer() for case in CASES.values()]
    transformer = Transformer(*[np.array(values)[:, None] for values in zip(*told, strict=True)])
    source = 2 if estimated else 1
    p = observer.Parameters(
        machine=ieee39_g6(), transformer=transformer, tve=tve, field_voltage=source, mechanical_power=source
    )
    turn = np.exp(1j * RIGHT.shift)
    high = np.array([case is not None for case in CASES.values()])[:, None]
    V_h = turn / RIGHT.tap * (record.V - 1j * RIGHT.x_T * record.I)
    I_h = RIGHT.tap * turn * record.I
    rng = np.random.default_rng(1)
    found, innovations, state = [], [], None
    for k in range(len(record)):
        noise = rng.standard_normal((4, 1, seeds)) * tve / np.sqrt(2)  # the same in every case
        V = np.where(high, V_h[k], record.V[k]) * (1 + noise[0] + 1j * noise[1])
        I = np.where(high, I_h[k], record.I[k]) * (1 + noise[2] + 1j * noise[3])  # noqa: E741 - the paper's name
        S = V * np.conj(I)
        frame = Frame(np.abs(V), np.angle(V), np.abs(I), np.angle(I), np.real(S), np.imag(S))
        ones = np.ones_like(frame.V_t)
        inputs = observer.Inputs(frame, record.P_m[k] * ones, record.E_f[k] * ones)
        if state is None:
            state, _ = observer.start("robust", arrays, p, inputs, 0.0)
        state, out = observer.step("robust", arrays, p, state, inputs, k / 60, 1 / 60)
        if k / 60 >= STEADY_FROM and k + 1 < len(record):
            true = [truth[name][k + 1] for name in ("delta", "e1d", "e1q")]  # the outputs are at the end of the step
            angle = np.angle(np.exp(1j * (out.delta - true[0])))
            found.append([angle, out.e1d - true[1], out.e1q - true[2]])
            innovations.append(out.innovation)
    return np.moveaxis(np.array(found), 0, 1), np.array(innovations)


if __name__ == "__main__":
    main()
