"""One record as other programs would have exported it: a file, and the map that reads it.

Everything is written with Python's own formatting and arithmetic on scalars, none of the code under test.
"""

import cmath
import csv
import math
import struct
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from scenarios.records.standard import StandardRecord

V_BASE = 22e3  # V line-line
S_BASE = 100e6
START = datetime(2024, 7, 1, 10, 0, 0, tzinfo=UTC)
A = cmath.exp(2j * math.pi / 3)


@dataclass
class Frame:
    ns: int  # since 1970
    V: complex  # V line-neutral, RMS, phase A
    I: complex  # A, RMS, out of the generator  # noqa: E741 - the paper's name
    P: float  # W
    Q: float
    P_m: float
    E_f: float


def frames(record: StandardRecord) -> list[Frame]:
    start = int(START.timestamp()) * 10**9
    found = []
    for k in range(len(record)):
        V = float(record.V_t[k]) * cmath.exp(1j * float(record.theta_t[k])) * V_BASE / math.sqrt(3)
        I = float(record.I_t[k]) * cmath.exp(1j * float(record.phi_t[k])) * S_BASE / (math.sqrt(3) * V_BASE)  # noqa: E741 - the paper's name
        S = 3 * V * I.conjugate()
        ns = start + round(k * 10**9 / 60)
        found.append(Frame(ns, V, I, S.real, S.imag, float(record.P_m[k]) * S_BASE, float(record.E_f[k])))
    return found


def deg(z: complex) -> float:
    return math.degrees(cmath.phase(z))


def iso(ns: int, digits: int = 9, middle: str = "T", end: str = "Z") -> str:
    return f"{datetime.fromtimestamp(ns // 10**9, UTC):%Y-%m-%d{middle}%H:%M:%S}.{ns % 10**9:09d}"[: 20 + digits] + end


BASE = 'base = "22 kV line-line"'
V_MAP = 'V = { magnitude = "VM", angle = "VA", unit = ["kV", "deg"], base = "22 kV line-line", is = "line-neutral" }\n'
I_MAP = 'I = { magnitude = "IM", angle = "IA", unit = ["A", "deg"] }\n'
POWERS = 'P = { column = "P", unit = "MW" }\nQ = { column = "Q", unit = "Mvar" }\n'
INPUTS = 'P_m = { column = "PM", unit = "MW" }\nE_f = { column = "EF", unit = "pu" }\n'
ISO = 'time = { column = "T", format = "iso", zone = "UTC" }\n'
MAP = ISO + V_MAP + I_MAP + POWERS + INPUTS

NAMES = ("T", "VM", "VA", "IM", "IA", "P", "Q", "PM", "EF")


def row(f: Frame) -> list:
    """Of NAMES, with all digits."""
    return [iso(f.ns), abs(f.V) / 1e3, deg(f.V), abs(f.I), deg(f.I), f.P / 1e6, f.Q / 1e6, f.P_m / 1e6, f.E_f]


def wide(path: Path, rows: list[list], names=NAMES, separator=",", decimal=".", units=None, **options) -> None:
    def cell(value) -> str:
        return value if isinstance(value, str) else repr(float(value)).replace(".", decimal)

    with path.open("w", newline="", encoding=options.get("encoding", "utf-8")) as file:
        writer = csv.writer(file, delimiter=separator, lineterminator=options.get("lineterminator", "\n"))
        for line in options.get("preamble", []):
            file.write(line + "\n")
        writer.writerow(names)
        if units:
            writer.writerow(units)
        writer.writerows([[cell(value) for value in row] for row in rows])


Export = Callable[[list[Frame], Path], tuple[Path, str]]
EXPORTS: dict[str, Export] = {}


def export(name: str) -> Callable[[Export], Export]:
    def register(function: Export) -> Export:
        EXPORTS[name] = function
        return function

    return register


@export("kV line-neutral, degrees, A, MW, ISO times")
def plain(f, folder):
    wide(folder / "a.csv", [row(x) for x in f])
    return folder / "a.csv", MAP


@export("semicolons, decimal commas, a units row, Windows line ends, cp1252")
def semicolons(f, folder):
    units = ["UTC", "kV", "°", "A", "°", "MW", "Mvar", "MW", "pu"]
    options = {"units": units, "encoding": "cp1252", "lineterminator": "\r\n"}
    wide(folder / "a.csv", [row(x) for x in f], separator=";", decimal=",", **options)
    bare = 'V = { magnitude = "VM", angle = "VA", base = "22 kV line-line", is = "line-neutral" }\n'
    bare += 'I = { magnitude = "IM", angle = "IA" }\nP = { column = "P" }\nQ = { column = "Q" }\n'
    return folder / "a.csv", ISO + bare + 'P_m = { column = "PM" }\nE_f = { column = "EF" }\n'


@export("tabs, kV line-line, rad, kA, kW")
def tabs(f, folder):
    rows = [
        [
            iso(x.ns, 9, " ", ""),
            abs(x.V) * 3**0.5 / 1000.0,
            cmath.phase(x.V),
            abs(x.I) / 1000.0,
            cmath.phase(x.I),
            x.P / 1000.0,
            x.Q / 1000.0,
            x.P_m / 1000.0,
            x.E_f,
        ]
        for x in f
    ]
    wide(folder / "a.txt", rows, separator="\t")
    text = MAP.replace('["kV", "deg"]', '["kV", "rad"]').replace('["A", "deg"]', '["kA", "rad"]')
    text = text.replace("line-neutral", "line-line").replace('"MW"', '"kW"').replace('"Mvar"', '"kvar"')
    return folder / "a.txt", text


@export("peak values, V, base line-neutral")
def peaks(f, folder):
    rows = [[iso(x.ns), abs(x.V) * 2**0.5, deg(x.V), abs(x.I) * 2**0.5, deg(x.I), *row(x)[5:]] for x in f]
    wide(folder / "a.csv", rows)
    text = MAP.replace('"kV", "deg"]', '"V", "deg"], value = "peak"').replace(
        '"A", "deg"]', '"A", "deg"], value = "peak"'
    )
    return folder / "a.csv", text.replace("22 kV line-line", f"{V_BASE / 3**0.5!r} V line-neutral")


@export("real and imaginary parts")
def rectangular(f, folder):
    rows = [[iso(x.ns), x.V.real, x.V.imag, x.I.real, x.I.imag, *row(x)[5:]] for x in f]
    wide(folder / "a.csv", rows, names=("T", "VR", "VI", "IR", "II", *NAMES[5:]))
    text = f'V = {{ real = "VR", imaginary = "VI", unit = "V", {BASE}, is = "line-neutral" }}\n'
    return folder / "a.csv", ISO + text + 'I = { real = "IR", imaginary = "II", unit = "A" }\n' + POWERS + INPUTS


def three(z: complex) -> list[complex]:
    """Phases with the positive sequence z, and some of the others."""
    zero, negative = 0.02 * z, 0.03 * z
    return [zero + z + negative, zero + z / A + negative * A, zero + z * A + negative / A]


def three_phases(f, folder, phases: Callable, kind: str):
    names = [f"V{p}{part}" for p in "ABC" for part in ("m", "a")] + [
        f"I{p}{part}" for p in "ABC" for part in ("m", "a")
    ]
    rows = []
    for x in f:
        cells = [c for z in phases(x.V) for c in (abs(z) / 1e3, deg(z))]
        cells += [c for z in three(x.I) for c in (abs(z), deg(z))]
        rows.append([iso(x.ns), *cells, *row(x)[5:]])
    wide(folder / "a.csv", rows, names=("T", *names, *NAMES[5:]))
    text = f'V = {{ magnitude = ["VAm", "VBm", "VCm"], angle = ["VAa", "VBa", "VCa"], unit = ["kV", "deg"], {BASE}, '
    text += f'is = "{kind}" }}\nI = {{ magnitude = ["IAm", "IBm", "ICm"], angle = ["IAa", "IBa", "ICa"], '
    return folder / "a.csv", ISO + text + 'unit = ["A", "deg"] }\n' + POWERS + INPUTS


@export("three phases with unbalance")
def phases(f, folder):
    return three_phases(f, folder, three, "line-neutral")


@export("three line-line phasors")
def lines(f, folder):
    def between(z):
        a, b, c = three(z)
        return [a - b, b - c, c - a]

    return three_phases(f, folder, between, "AB")


@export("one line-line phasor")
def one_line(f, folder):
    rows = [[iso(x.ns), abs(z) / 1e3, deg(z), *row(x)[3:]] for x in f for z in [x.V - x.V / A]]
    wide(folder / "a.csv", rows)
    return folder / "a.csv", MAP.replace('"line-neutral"', '"AB"')


@export("load convention")
def load_convention(f, folder):
    rows = [[*row(x)[:3], abs(x.I), deg(-x.I), -x.P / 1e6, -x.Q / 1e6, x.P_m / 1e6, x.E_f] for x in f]
    wide(folder / "a.csv", rows)
    text = MAP.replace('["A", "deg"]', '["A", "deg"], direction = "into the generator"')
    text = text.replace('unit = "MW" }\nQ', 'unit = "MW", direction = "into the generator" }\nQ')
    return folder / "a.csv", text.replace('"Mvar"', '"Mvar", direction = "into the generator"')


@export("angles counted clockwise")
def clockwise(f, folder):
    wide(folder / "a.csv", [[*row(x)[:2], -deg(x.V), abs(x.I), -deg(x.I), *row(x)[5:]] for x in f])
    text = MAP.replace('"line-neutral" }', '"line-neutral", conjugate = true }')
    return folder / "a.csv", text.replace('["A", "deg"] }', '["A", "deg"], conjugate = true }')


@export("an angle shift")
def shifted(f, folder):
    wide(folder / "a.csv", [[*row(x)[:2], deg(x.V) + 30, abs(x.I), deg(x.I) + 30, *row(x)[5:]] for x in f])
    text = MAP.replace('"line-neutral" }', '"line-neutral", shift = "-30 deg" }')
    return folder / "a.csv", text.replace('["A", "deg"] }', '["A", "deg"], shift = "-30 deg" }')


@export("pu on another base, per cent, field volts")
def per_unit(f, folder):
    base_I = 1000e6 / (3**0.5 * V_BASE)
    rows = [
        [
            iso(x.ns),
            100 * abs(x.V) * 3**0.5 / V_BASE,
            deg(x.V),
            abs(x.I) / base_I,
            deg(x.I),
            x.P / 1000000000.0,
            x.Q / 1000000000.0,
            x.P_m / 1000000000.0,
            92 * x.E_f,
        ]
        for x in f
    ]
    wide(folder / "a.csv", rows)
    text = ISO + 'V = { magnitude = "VM", angle = "VA", unit = ["%", "deg"] }\n'
    text += 'I = { magnitude = "IM", angle = "IA", unit = ["pu", "deg"], base = "1000 MVA" }\n'
    text += "".join(
        f'{n} = {{ column = "{c}", unit = "pu", base = "1000 MVA" }}\n'
        for n, c in (("P", "P"), ("Q", "Q"), ("P_m", "PM"))
    )
    return folder / "a.csv", text + 'E_f = { column = "EF", unit = "V", base = "92 V" }\n'


@export("no P, no Q: from the phasors")
def phasors_only(f, folder):
    wide(folder / "a.csv", [row(x)[:5] + row(x)[7:] for x in f], names=NAMES[:5] + NAMES[7:])
    return folder / "a.csv", ISO + V_MAP + I_MAP + INPUTS


def with_times(f, folder, name: str, stamp: Callable[[int], list], time: str):
    rows = [[*stamp(x.ns), *row(x)[1:]] for x in f]
    names = [f"T{i}" for i in range(len(rows[0]) - len(NAMES) + 1)]
    wide(folder / "a.csv", rows, names=(*names, *NAMES[1:]))
    return folder / "a.csv", f"time = {{ {time} }}\n" + MAP.removeprefix(ISO)


TIMES = {
    "epoch": (lambda ns: [f"{ns // 10**9}.{ns % 10**9 // 1000:06d}"], 'column = "T0", format = "epoch"'),
    "epoch in ms": (lambda ns: [f"{ns / 1e6:.3f}"], 'column = "T0", format = "epoch", unit = "ms"'),
    "SOC and FRACSEC": (
        lambda ns: [str(ns // 10**9), str((7 << 24) + round(ns % 10**9 * 16777215 / 1e9))],
        'format = "soc", soc = "T0", fracsec = "T1", time_base = 16777215',
    ),
    "seconds from a start": (
        lambda ns: [f"{(ns - int(START.timestamp()) * 10**9) / 1e9:.7f}"],
        'column = "T0", format = "seconds", start = "2024-07-01T10:00:00Z"',
    ),
    "local time": (
        lambda ns: [iso(ns + 7200 * 10**9, 6, " ", "")],
        'column = "T0", format = "iso", zone = "Europe/Berlin"',
    ),
    "ISO with an offset": (lambda ns: [iso(ns - 5 * 3600 * 10**9, 6, "T", "-05:00")], 'column = "T0", format = "iso"'),
    "date and time in two columns, ms": (
        lambda ns: iso(ns, 3, " ", "").split(),
        'column = ["T0", "T1"], format = "iso"',
    ),
    "German dates": (
        lambda ns: [
            f"{START + timedelta(microseconds=ns // 1000 - int(START.timestamp()) * 10**6):%d.%m.%Y %H:%M:%S.%f}"
        ],
        'column = "T0", format = "%d.%m.%Y %H:%M:%S.%f"',
    ),
    "rounded to ms": (lambda ns: [iso(round(ns / 1e6) * 10**6, 3)], 'column = "T0", format = "iso"'),
    "cut off at ms": (lambda ns: [iso(ns, 3)], 'column = "T0", format = "iso"'),
}
for time_name, (stamp, text) in TIMES.items():
    export(f"times: {time_name}")(
        lambda f, folder, stamp=stamp, text=text, name=time_name: with_times(f, folder, name, stamp, text)
    )


KEYS = {
    "VM": "PPA:1",
    "VA": "PPA:2",
    "IM": "PPA:3",
    "IA": "PPA:4",
    "P": "PPA:5",
    "Q": "PPA:6",
    "PM": "PPA:7",
    "EF": "PPA:8",
}


def with_keys(text: str) -> str:
    for name, key in KEYS.items():
        text = text.replace(f'"{name}"', f'"{key}"')
    return text.removeprefix(ISO)


@export("openPDC's CsvExporter")
def csv_exporter(f, folder):
    rows = [
        [iso(x.ns, 7, " ", ""), KEYS[name], value] for x in f for name, value in zip(NAMES[1:], row(x)[1:], strict=True)
    ]
    wide(folder / "a.csv", rows, names=("Timestamp", "ID", "Value"))
    return folder / "a.csv", with_keys(MAP)


@export("openPDC's CsvOutputAdapter")
def csv_output_adapter(f, folder):
    guid = "8F3C6D5E-0000-0000-0000-00000000000"
    rows = [
        [guid + KEYS[name][-1], KEYS[name], iso(x.ns, 7, " ", ""), value]
        for x in f
        for name, value in zip(NAMES[1:], row(x)[1:], strict=True)
    ]
    wide(folder / "a.csv", rows, names=("Signal ID", "Measurement Key", "Timestamp", "Value"))
    return folder / "a.csv", with_keys(MAP)


@export("IEEE/ISO-NE's three header rows")
def iso_ne(f, folder):
    zero = int(START.timestamp()) * 10**9
    rows = [[f"{(x.ns - zero) / 1e9:.6f}", *row(x)[1:]] for x in f]
    names = ["Time", "Sub:1:Ln:2:VM", "Sub:1:Ln:2:VA", "Sub:1:Ln:2:IM", "Sub:1:Ln:2:IA", "P", "Q", "PM", "EF"]
    path = folder / "a.csv"
    with path.open("w") as file:
        file.write("Base time 2024-07-01 10:00:00\n")
        for line in (
            names,
            ["T", "VM", "VA", "IM", "IA", "P", "Q", "P", "D"],
            ["sec", "KV", "DEG", "AMP", "DEG", "MW", "MVAR", "MW", "PU"],
            *rows,
        ):
            file.write(",".join(map(str, line)) + "\n")
    text = (
        'V = { magnitude = "Sub:1:Ln:2:VM", angle = "Sub:1:Ln:2:VA", base = "22 kV line-line", is = "line-neutral" }\n'
    )
    text += 'I = { magnitude = "Sub:1:Ln:2:IM", angle = "Sub:1:Ln:2:IA" }\n'
    return path, text + 'P = { column = "P" }\nQ = { column = "Q" }\nP_m = { column = "PM" }\nE_f = { column = "EF" }\n'


def cfg(f, kind: str, scales: list[float]) -> str:
    units = ["kV", "deg", "A", "deg", "MW", "Mvar", "MW", "pu"]
    lines = ["G6,pmu,2013", "8,8A,0D"]
    for i, (name, unit, scale) in enumerate(zip(NAMES[1:], units, scales, strict=True), 1):
        lines.append(f"{i},{name},,,{unit},{scale!r},0,0,-2147483647,2147483647,1,1,P")
    stamp = START.strftime("%d/%m/%Y,%H:%M:%S.%f")
    lines += ["60", "1", f"60,{len(f)}", stamp, stamp, kind, "1", "0,0", "0,0"]
    return "\n".join(lines) + "\n"


@export("COMTRADE, ASCII")
def comtrade_ascii(f, folder):
    """Whole numbers of 1e-7 of the unit."""
    (folder / "a.cfg").write_text(cfg(f, "ASCII", [1e-9] * 8))
    with (folder / "a.dat").open("w") as file:
        for i, x in enumerate(f, 1):
            counts = ",".join(str(round(value / 1e-9)) for value in row(x)[1:])
            file.write(f"{i},{round((i - 1) * 1e6 / 60)},{counts}\n")
    return folder / "a.cfg", MAP.removeprefix(ISO)


@export("COMTRADE, FLOAT32")
def comtrade_float32(f, folder):
    (folder / "a.cfg").write_text(cfg(f, "FLOAT32", [1.0] * 8))
    with (folder / "a.dat").open("wb") as file:
        for i, x in enumerate(f, 1):
            file.write(struct.pack("<II8f", i, round((i - 1) * 1e6 / 60), *row(x)[1:]))
    return folder / "a.cfg", MAP.removeprefix(ISO)


@export("PhasorPoint's names, rad")
def phasor_point(f, folder):
    names = ("ts", "v_g6_va1_m", "v_g6_va1_a", "i_g6_ia1_m", "i_g6_ia1_a", "PM (MW)", "EF [pu]")
    rows = [
        [iso(x.ns, 6, " ", ""), abs(x.V), cmath.phase(x.V), abs(x.I), cmath.phase(x.I), x.P_m / 1e6, x.E_f] for x in f
    ]
    wide(folder / "a.csv", rows, names=names)
    text = 'time = { column = "ts", format = "iso", zone = "UTC" }\n'
    text += (
        f'V = {{ magnitude = "v_g6_va1_m", angle = "v_g6_va1_a", unit = ["V", "rad"], {BASE}, is = "line-neutral" }}\n'
    )
    text += 'I = { magnitude = "i_g6_ia1_m", angle = "i_g6_ia1_a", unit = ["A", "rad"] }\n'
    return folder / "a.csv", text + 'P_m = { column = "PM (MW)" }\nE_f = { column = "EF [pu]" }\n'


@export("quoted names with commas, a preamble, angles beyond 360 degrees")
def quoted(f, folder):
    names = ("Time, UTC", "V, kV", "ang V", "I, A", "ang I", "P", "Q", "PM", "EF")
    rows = [
        [*row(x)[:2], deg(x.V) + 360 * (i // 7), abs(x.I), deg(x.I) - 360 * (i // 5), *row(x)[5:]]
        for i, x in enumerate(f)
    ]
    wide(folder / "a.csv", rows, names=names, preamble=["# exported by a historian", "Station 7", ""])
    text = MAP
    for ours, name in zip(NAMES[:5], names[:5], strict=True):
        text = text.replace(f'"{ours}"', f'"{name}"')
    return folder / "a.csv", text
