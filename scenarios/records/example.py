"""Writes the example of a utility's file, scenarios/data/utility_g6.csv: `python -m scenarios.records.example`.

The independent record of generator 6 (record_g6.csv) as a historian would have exported it: kV line-to-neutral, A,
degrees, MW, UTC to the millisecond, a STAT word, noise of 0.2 % (TVE), half a second of blanks, missing rows, one frame
marked bad. No mechanical power, no field voltage: the observer estimates them.
"""

import csv
from datetime import UTC, datetime, timedelta
from math import sqrt
from pathlib import Path

import numpy as np

from . import standard

DATA = Path(__file__).parent.parent / "data"
V_BASE, S_BASE = 22e3, 100e6
"""V line-line, VA."""

START = datetime(2024, 7, 1, 14, 30, 0, tzinfo=UTC)
TVE = 0.002
NAMES = (
    "Timestamp (UTC)",
    "G6 V1 Mag (kV)",
    "G6 V1 Ang (deg)",
    "G6 I1 Mag (A)",
    "G6 I1 Ang (deg)",
    "G6 P (MW)",
    "G6 Q (Mvar)",
    "G6 Freq (Hz)",
    "G6 STAT",
)


def main() -> None:
    record = standard.read(DATA / "record_g6.csv")
    rng = np.random.default_rng(6)
    noise = rng.standard_normal((4, len(record))) * TVE / sqrt(2)
    V = record.V * (1 + noise[0] + 1j * noise[1])
    I = record.I * (1 + noise[2] + 1j * noise[3])  # noqa: E741 - the paper's name
    S = V * np.conj(I) * S_BASE / 1e6
    f = 60 + np.gradient(np.unwrap(record.theta_t)) * record.rate / (2 * np.pi)
    missing = set(rng.choice(len(record), 12, replace=False).tolist())
    with (DATA / "utility_g6.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(NAMES)
        for k in range(len(record)):
            if k in missing:
                continue
            stamp = (START + timedelta(seconds=round(record.time[k], 3))).isoformat(sep=" ", timespec="milliseconds")
            phasors = [abs(V[k]) * V_BASE / sqrt(3) / 1e3, np.degrees(np.angle(V[k]))]
            phasors += [abs(I[k]) * S_BASE / (sqrt(3) * V_BASE), np.degrees(np.angle(I[k]))]
            cells = [f"{x:.4f}" for x in phasors] + [f"{S[k].real:.3f}", f"{S[k].imag:.3f}", f"{f[k]:.4f}"]
            if 13.0 <= record.time[k] < 13.5:
                cells = [""] * len(cells)
            writer.writerow([stamp.removesuffix("+00:00"), *cells, "0x8000" if k == 300 else "0x0000"])


if __name__ == "__main__":
    main()
