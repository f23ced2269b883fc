"""Any base, reporting rate and operating point, then half a second of wild frames, through the Python FMU."""

from math import inf, isfinite, nan, pi

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.plants import smib

from .instance import FRAME, OK, Instance

TVE = 0.003
TRACKING = 2

wild_number = st.sampled_from([nan, inf, -inf, 0.0, 1e-300, 1e-3, -1.0, 1e3, -1e8, 1e300]) | st.floats(-10, 10)
wild_frame = st.one_of(
    st.fixed_dictionaries({}, optional=dict.fromkeys((*FRAME, "P_m", "E_f"), wild_number)),
    st.just(dict.fromkeys(FRAME, 0.0)),
    st.just({"frame_valid": False}),
    st.floats(-pi, pi).map(lambda angle: {"theta_t": angle}),
)


def frame(rng, outputs: smib.Outputs, P_m: float, up: float) -> dict[str, float]:
    """What a PMU reports, with the currents and powers in pu of the system's base."""
    f, (a, b, c, d) = outputs.frame, rng.normal(0, TVE / np.sqrt(2), 4)
    V = f.V_t * np.exp(1j * f.theta_t) * (1 + a + 1j * b)
    I = up * f.I_t * np.exp(1j * f.phi_t) * (1 + c + 1j * d)  # noqa: E741 - the paper's name
    S = V * np.conj(I)
    values = map(float, (abs(V), np.angle(V), abs(I), np.angle(I), S.real, S.imag))
    return {**dict(zip(FRAME, values, strict=True)), "P_m": up * P_m, "E_f": outputs.E_f_start}


@given(
    rate=st.floats(10, 200),
    up=st.floats(-2, 2).map(lambda exponent: 10**exponent),
    P_m=st.floats(-7.0, 7.0),
    V_t=st.floats(0.95, 1.08),  # Q from -1.7 pu on: leading, too
    sources=st.tuples(st.sampled_from([1, 2]), st.sampled_from([1, 2])),
    wild=st.lists(wild_frame, min_size=5, max_size=30),
    seed=st.integers(0, 1000),
)
@settings(max_examples=12, derandomize=True)  # the noise may, rarely, take a machine longer
def test_the_observer_recovers(dist, rate, up, P_m, V_t, sources, wild, seed):
    """No step fails, no output is ever NaN, and once the frames are good again it finds back by itself."""
    h, rng = 1 / rate, np.random.default_rng(seed)
    m = ieee39_g6()._replace(D=0.05)
    p = smib.Parameters(machine=m, x_line=0.03, start_mode=smib.P_M_V_T, V_t_start=V_t)
    field_voltage, mechanical_power = sources
    observer = Instance(
        dist / "python" / "PmuObserver.fmu",
        "observer",
        **m._asdict(),
        S_base=100.0,
        S_n=100.0 * up,
        tve=TVE,
        field_voltage=field_voltage,
        mechanical_power=mechanical_power,
    )
    u = smib.Inputs(P_m=P_m)
    state, outputs = smib.start(floats, p, u, 0.0)
    u = u._replace(E_f=outputs.E_f_start, theta_inf=0.1)  # and it swings
    before, after = round(2 * rate), round(3 * rate) + 60
    observer.initialise(**frame(rng, outputs, P_m, up))
    for k in range(before + len(wild) + after):
        good = frame(rng, outputs, P_m, up)
        spoilt = wild[k - before] if before <= k < before + len(wild) else {}
        observer.set(**{**good, "frame_valid": True, **spoilt})
        assert observer.step(k * h, h) == OK
        assert all(isfinite(value) for value in observer.outputs())
        steps = int(h / 2e-3) + 1
        for i in range(steps):
            state, outputs = smib.step(floats, p, state, u, k * h + i * h / steps, h / steps)
    delta, omega, e1d, e1q, status = observer.get("delta", "omega", "e1d", "e1q", "status")
    observer.free()
    assert not observer.messages
    assert status == TRACKING
    assert abs(np.exp(1j * (delta - outputs.delta)) - 1) < 0.05
    assert abs(omega - outputs.omega) < 0.5
    assert np.hypot(e1d - outputs.e1d, e1q - outputs.e1q) < 0.05
