"""Checks of a record against its machine, and of the machine's own data."""

from collections.abc import Iterator
from itertools import pairwise
from math import degrees, sqrt

import numpy as np

from ...machines.table import Machine
from ..findings import DOUBTFUL, NONSENSE, Finding
from .case import Case, first, near


def mechanical(case: Case) -> Iterator[Finding]:
    """P_m/P in .85 .. 1.2; in .95 .. 1.07 where nothing else is said."""
    r = case.record
    rating = case.rating or 1.0
    P = case.median(r.P_t)
    if not r.has("P_m") or abs(P) < 0.02 * rating:
        return
    ratio = case.median(r.P_m) / P
    if 0.95 < ratio < 1.07 or case.reported_power:
        return
    measured = f"P_m is {ratio:.3g} times P"
    if 0.85 < ratio < 1.2:
        yield Finding("P_m", DOUBTFUL, measured, ("P_m scale", "I ratio"))
        return
    S_base = r.S_base
    causes = first(
        (ratio < 0, "P_m sign"),
        (near(ratio, S_base, 0.1), "P_m in MW"),
        (near(ratio, 1e3, 0.1) or near(ratio, 1e-3, 0.1), "P_m in kW"),
        (near(ratio, 1 / rating, 0.1) or near(ratio, rating, 0.1), "P_m base"),
        (near(ratio, 100 / rating, 0.1) or near(ratio, 100, 0.1), "P_m per cent"),
        (True, "P_m scale"),
        (0.6 < ratio < 1.6, "I ratio"),
    )
    yield Finding("P_m", NONSENSE, measured, causes)


def load_angle(case: Case) -> Iterator[Finding]:
    """arg(V + (Ra + j xq) I) - theta in 5 .. 85 deg, at more than 0.4 of the rating."""
    if case.machine is None or case.rating is None or case.reported_power:
        return
    r = case.record
    per_rating = np.real(r.V * np.conj(r.I)) / case.rating
    if case.median(per_rating) < 0.03:
        return
    angle = degrees(case.median(np.angle(axis(case) * np.conj(r.V))))
    least = 5.0 if case.median(per_rating) > 0.4 else 0.1
    if least < angle < 85:
        return
    measured = f"the load angle by V + j xq I is {angle:.3g} deg; it is {least:g} to 85"
    yield Finding("load angle", NONSENSE, measured, ("reactances on another base", "machine", "load all"))


def axis(case: Case) -> np.ndarray:
    """V + (Ra + j xq) I: the direction of the q axis in steady state."""
    assert case.machine is not None and case.rating is not None
    m = case.machine
    return case.record.V + (m.parameters.get("Ra", 0.0) + 1j * m["xq"]) / case.rating * case.record.I  # type: ignore[operator]


def steady_field(case: Case) -> np.ndarray:
    """E_f of the steady state: Vq + Ra Iq + xd Id, and what saturates, S(|V + j xl I|) pu."""
    assert case.machine is not None and case.rating is not None
    m, r = case.machine, case.record
    q = axis(case) / np.abs(axis(case))
    I_dq = r.I / case.rating * np.conj(q)
    V_dq = r.V * np.conj(q)
    linear = np.real(V_dq) - m["xd"] * np.imag(I_dq)
    if "S10" not in m.parameters:
        return linear
    flux = np.abs(r.V + 1j * m.parameters.get("xl", 0.0) / case.rating * r.I)  # type: ignore[operator]
    return linear + saturation(flux, m["S10"], float(m.parameters.get("S12", 0.0)))


def saturation(flux: np.ndarray, S10: float, S12: float) -> np.ndarray:
    """Field current beyond the air-gap line, pu: B (flux - A)^2 through S10 at 1.0 and 1.2 S12 at 1.2."""
    if S10 <= 0 or S12 <= 0:
        return np.zeros_like(flux)
    a = sqrt(1.2 * S12 / S10)
    A = 1 - 0.2 / (a - 1) if a > 1 else 0.0
    return S10 / (1 - A) ** 2 * np.maximum(flux - A, 0) ** 2


def field_voltage(case: Case) -> Iterator[Finding]:
    """E_f against that of the steady state in .8 .. 1.25."""
    r = case.record
    if case.machine is None or not r.has("E_f") or case.reported_power:
        return
    with np.errstate(all="ignore"):
        ratio = case.median(r.E_f / steady_field(case))
    if 0.8 < ratio < 1.25:
        return
    causes = first(
        (ratio < 0, "E_f sign"),
        (ratio > 5, "E_f in volts"),
        (0.2 < ratio < 0.8, "E_f base at rated load"),
        (1.25 < ratio < 1.8 and "S10" not in case.machine.parameters, "saturation"),
        (True, "E_f scale"),
        (True, "reactances on another base"),
    )
    measured = f"E_f is {ratio:.3g} times that of the steady state; it is 0.8 to 1.25"
    yield Finding("E_f", NONSENSE, measured, causes)


def machine_data(case: Case) -> Iterator[Finding]:
    """The machine's own data against what machines have, per unit on their own base."""
    if case.machine is not None:
        yield from data(case.machine)


RANGES = {
    "H": (0.5, 15.0),
    "xd": (0.3, 5.0),
    "xq": (0.15, 5.0),
    "xd1": (0.03, 0.9),
    "Td10": (0.8, 20.0),
    "omega_s": (300.0, 390.0),
}
"""Of machines of a power station, turbo and hydro, pu on their own base; a value outside is doubtful."""

MOST_D = 10.0
"""pu torque per pu speed."""


def data(m: Machine) -> Iterator[Finding]:
    out = [f"{n} = {m[n]:g}" for n, (low, high) in RANGES.items() if n in m.parameters and not low <= m[n] <= high]
    if out:
        causes = ("reactances on another base", "machine data")
        yield Finding("machine", DOUBTFUL, f"{m.unit}: {', '.join(out)}", causes)
    D = float(m.parameters.get("D", 0.0)) * m["omega_s"]
    if D > MOST_D:
        yield Finding("machine", NONSENSE, f"{m.unit}: D is {D:.3g} pu torque per pu speed", ("D in pu",))
    order = [name for name in ("xl", "xd2", "xd1", "xd") if name in m.parameters]
    wrong = [f"{a} >= {b}" for a, b in pairwise(order) if m[a] >= m[b]]
    if "xq1" in m.parameters and m["xq1"] > m["xq"]:
        wrong.append("xq1 > xq")
    if wrong:
        yield Finding("machine", NONSENSE, f"{m.unit}: {', '.join(wrong)}", ("machine data",))
