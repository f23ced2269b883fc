"""Checks of the phasors: sizes, angles, directions, and whether P and Q agree with them."""

from collections.abc import Iterator
from math import degrees, pi, sqrt

import numpy as np

from ..angles import AngleRange
from ..findings import NONSENSE, Finding
from .case import Case, first, near


def voltage(case: Case) -> Iterator[Finding]:
    """median |V| in .85 .. 1.15 pu."""
    size = case.median(case.record.V_t)
    machine, base = case.machine, case.record.facts.V_base
    if machine and machine.V_n and base and abs(base / machine.V_n - 1) > 0.01:
        measured = f"V is on {base:g} kV, the machine's V_n is {machine.V_n:g} kV"
        yield Finding("voltage", NONSENSE, measured, ("V base",))
    if 0.85 < size < 1.15:
        return
    in_machine = case.median(case.record.I_t)
    causes = first(
        (near(size, sqrt(3), 0.12), "line on neutral base"),
        (near(size, 1 / sqrt(3), 0.12), "neutral on line base"),
        (near(size, sqrt(2), 0.12), "V peak"),
        (near(size, 1 / sqrt(2), 0.12), "V rms"),
        (near(size, 1e3, 0.15), "V in V"),
        (near(size, 1e-3, 0.15), "V in kV"),
        (near(size, 1e3 * sqrt(3), 0.15), "V in V"),
        (near(size, 1e-3 / sqrt(3), 0.15), "V in kV"),
        (near(size, 100.0, 0.15), "V per cent"),
        (0.85 < in_machine < 1.15, "V and I exchanged"),
    )
    yield Finding("voltage", NONSENSE, f"median |V| is {size:.4g} pu; it is 0.85 to 1.15", (*causes, "V base"))


def current(case: Case) -> Iterator[Finding]:
    """|V||I| of .03 .. 1.3 of the rating."""
    if case.rating is None:
        return
    r = case.record
    share = case.median(r.V_t * r.I_t) / case.rating
    if 0.03 < share < 1.3 or not np.isfinite(share):
        return
    by_voltage = not 0.85 < case.median(r.V_t) < 1.15
    if by_voltage:
        return  # said already
    rating = case.rating
    causes = first(
        (30 < share < 1300, "I in A"),
        (3e-5 < share < 1.3e-3, "I in kA"),
        (any(0.03 < share * f < 1.3 for f in (rating, 1 / rating)) and not near(rating, 1, 0.2), "I base"),
        (share < 0.03, "offline"),
        (1.3 < share < 2.3, "I peak"),
        (1.3 < share < 2.3, "I phase to phase"),
    )
    yield Finding("current", NONSENSE, f"|V||I| is {share:.3g} of the machine's S_n; it is 0.03 to 1.3", causes)


def angle_unit(case: Case) -> Iterator[Finding]:
    """Angles beyond a turn that jump by more than 6.5 are no rad; within +-pi they are no degrees."""
    angles = case.angles or AngleRange().widened([case.record.theta_t, case.record.phi_t])
    if angles.largest > 2 * pi and angles.jump > 6.5 and angles.jump / 2 / pi % 1 > 1e-3:
        measured = f"angles go to {angles.largest:.4g} and jump by {angles.jump:.4g} as rad"
        yield Finding("angle unit", NONSENSE, measured, ("degrees",))
    elif 0.5 < degrees(angles.largest) < pi + 1e-3 and degrees(angles.jump) > pi:
        measured = (
            f"angles stay within +-{degrees(angles.largest):.4g} as degrees, and jump by {degrees(angles.jump):.3g}"
        )
        yield Finding("angle unit", NONSENSE, measured, ("radians",))


def speed(case: Case) -> Iterator[Finding]:
    """The speed of theta: against 2 pi (f - f0), and below 1 Hz."""
    r, (mean, slope) = case.record, case.speed
    if case.machine and r.f0 and not near(case.machine["omega_s"], 2 * pi * r.f0, 0.01):
        measured = f"omega_s is {case.machine['omega_s']:.5g} rad/s, the record's is {2 * pi * r.f0:.5g}"
        yield Finding("speed", NONSENSE, measured, ("omega_s", "frequency"))
    if r.f0 and r.has("f"):
        f = case.median(r.f)
        if abs(f) < 5:
            yield Finding("speed", NONSENSE, f"f is {f:.3g} Hz", ("f deviation",))
            return
        if abs(f - r.f0) > 5:
            yield Finding("speed", NONSENSE, f"f is {f:.4g} Hz, the nominal frequency {r.f0:g}", ("frequency",))
            return
    if abs(mean) > 2 * pi:
        measured = f"theta turns at {mean / 2 / pi:.3g} Hz against the nominal frequency"
        causes = first((9 < abs(mean) / 2 / pi < 11, "frequency"), (True, "degrees"), (True, "time unit"))
        yield Finding("speed", NONSENSE, measured, causes)
    if np.isfinite(slope) and abs(slope - 1) > 0.5:
        causes = first(
            (abs(slope + 1) < 0.5, "conjugate"),
            (abs(slope) > 5, "degrees"),
            (abs(slope) < 0.2, "radians"),
            (abs(slope) < 0.2, "held"),
        )
        measured = f"the speed of theta is {slope:.3g} times what f says"
        yield Finding("speed", NONSENSE, measured, causes or ("time unit", "degrees"))


def power(case: Case) -> Iterator[Finding]:
    """The complex ratio of P + jQ to V I*: its size and its angle."""
    ratio, r = case.ratio, case.record
    if not np.isfinite(ratio):
        return
    size, turn = abs(ratio), degrees(np.angle(ratio))
    S, VI = r.P_t + 1j * r.Q_t, r.V * np.conj(r.I)
    fits = {name: case._median_ratio(part, VI) for name, part in variants(S).items()}
    with np.errstate(all="ignore"):
        spread = {name: case.median(np.abs(part / VI - fits[name])) for name, part in variants(S).items()}
    if abs(size - 1) < 0.06 and abs(turn) < 6 and spread["right"] < 0.2:
        return
    named = size_causes(size, case) if spread["right"] < 0.2 * size else ()
    flips = [
        name
        for name in ("conjugate", "Q sign", "P and Q exchanged", "P sign")
        if abs(fits[name] - abs(fits[name])) < 0.06 * abs(fits[name]) and spread[name] < 0.1 * abs(fits[name])
    ]
    measured = f"(P + jQ)/(V I*) is {size:.3g} at {turn:.0f} deg"
    if spread["right"] > 0.2 * size and not flips:
        measured += f", spread by {spread['right'] / size:.0%}"
        yield Finding("power", NONSENSE, measured, ("degrees", "radians", "V in another unit of angle"))
        return
    if abs(turn) < 6:
        yield Finding("power", NONSENSE, measured, named or ("I ratio",))
        return
    causes: tuple[str, ...] = ()
    if abs(abs(turn) - 180) < 6:
        causes = ("load I", "load P Q") if case.median(r.P_t) > 0 else ("load P Q", "load I")
    elif "conjugate" in flips or "Q sign" in flips:
        causes = conjugates(case)
    elif flips:
        causes = tuple(flips)
    if not causes or abs(abs(turn) - 30) < 3:
        causes += first(
            (abs(abs(turn) - 30) < 6, "30 degrees"),
            (abs(abs(turn) - 150) < 6, "30 degrees"),
            (min(abs(abs(turn) - 120), abs(abs(turn) - 60)) < 6, "120 degrees"),
        )
    yield Finding("power", NONSENSE, measured, (causes or ("shift",)) + (named if abs(size - 1) > 0.06 else ()))


def variants(S: np.ndarray) -> dict[str, np.ndarray]:
    """P + jQ as it would be without a mistake."""
    return {
        "right": S,
        "conjugate": np.conj(S),
        "Q sign": np.conj(S),
        "P sign": -np.conj(S),
        "P and Q exchanged": np.imag(S) + 1j * np.real(S),
    }


def conjugates(case: Case) -> tuple[str, ...]:
    """P - jQ fits: Q's sign, the angles of both, or theta and phi exchanged. What else there is decides."""
    r, (_, slope) = case.record, case.speed
    if np.isfinite(slope):
        if slope < 0:
            return ("conjugate", "Q sign", "theta and phi exchanged")
        order = ["Q sign", "theta and phi exchanged"]
    else:
        order = ["Q sign", "conjugate", "theta and phi exchanged"]
    # the angle of a current moves more than that of a voltage
    moves = [float(np.nanstd(np.diff(np.angle(z[1:] * np.conj(z[:-1]))))) for z in (r.V, r.I)]
    if moves[0] > 1.5 * moves[1]:
        order.insert(0, order.pop(order.index("theta and phi exchanged")))
    return tuple(order)


def size_causes(size: float, case: Case) -> tuple[str, ...]:
    rating = case.rating or np.nan
    return first(
        (near(size, 1 / sqrt(3)) or near(size, sqrt(3)), "I phase to phase"),
        (near(size, 1 / 3), "P per phase"),
        (near(size, 1 / sqrt(2)) or near(size, 0.5), "I peak"),
        (near(size, sqrt(2)), "V rms"),
        (near(size, 1e3, 0.1) or near(size, 1e-3, 0.1), "P in MW"),
        (near(size, 1 / rating) or near(size, rating) or near(size, 1 / case.record.S_base), "P base"),
        (near(size, case.record.S_base), "P base"),
        (near(size, 1e3, 0.1), "I in kA"),
        (near(size, 1e-3, 0.1), "I in A"),
    )


def sign(case: Case) -> Iterator[Finding]:
    """A generator generates."""
    r = case.record
    P, by_phasors = case.median(r.P_t), case.median(np.real(r.V * np.conj(r.I)))
    rating = case.rating or case.median(np.abs(r.V_t * r.I_t))
    if max(P, by_phasors) < -0.02 * rating:
        measured = f"P is {P:.3g} pu: this machine takes power (a pump does)"
        yield Finding("sign", NONSENSE, measured, ("load all", "30 degrees", "120 degrees"))
