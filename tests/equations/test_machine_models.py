"""Every machine model's linear, time-varying form against its nonlinear equations, and those against ANDES."""

from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.carriers import arrays, floats
from fmu_src.pmu_observer.interface import broken, variables
from fmu_src.pmu_observer.linear import Complex, Vector
from fmu_src.pmu_observer.machines import MACHINE_MODELS, axes, data
from fmu_src.pmu_observer.machines.saturation import exponential, quadratic

from ..records import GENROU_RECORDS, genrou_record

MODELS: dict[str, Any] = MACHINE_MODELS


def number(low, high):
    return st.floats(low, high)


@st.composite
def machines(draw, name):
    """Data that the model's rules allow, pu on the machine's own base; x''d != x''q, x'd != x'q where it has them."""
    xl = draw(number(0.05, 0.2))
    xd2, xq2 = xl + draw(number(0.02, 0.15)), xl + draw(number(0.02, 0.15))
    xd1, xq1 = max(xd2, xq2) + draw(number(0.01, 0.2)), max(xd2, xq2) + draw(number(0.01, 0.4))
    S10 = draw(number(0.0, 0.2))
    machine = data.Machine(
        H=draw(number(2, 8)), D=0.0, omega_s=2 * pi * 60, xd=xd1 + draw(number(0.3, 1.8)), xd1=xd1,
        xq=max(xq1, xd1) + draw(number(0.1, 1.5)), xq1=xq1,
        Td10=draw(number(3, 10)), Tq10=draw(number(0.3, 2)), Ra=draw(number(0, 0.02)),
        xd2=xd2, xq2=xq2, xl=xl, Td20=draw(number(0.02, 0.06)), Tq20=draw(number(0.03, 0.1)),
        S10=S10, S12=S10 + draw(number(0.0, 0.5)), Kis=draw(number(0.0, 0.1)) if name == "gentpj" else 0.0,
    )  # fmt: skip
    assert not broken(MODELS[name].rules(floats, machine), {v.name: v.start for v in variables(machine)})
    return machine


class Operation(NamedTuple):
    """A machine in any state, the currents that flow, and what a PMU sees of it (behind Ra)."""

    x: Any
    i: Vector
    v: Vector
    S: float
    delta: float

    @property
    def phasors(self):
        turn = -1j * np.exp(1j * self.delta)
        return turn * complex(*self.v), turn * complex(*self.i)


def operate(name, m, x, i, delta) -> Operation:
    """Where S and the stator depend on each other (gentpj), by iteration."""
    model, S = MODELS[name], 0.0
    v = Vector(0.0, 0.0)
    for _ in range(60):
        E, X_d, X_q = model.stator(floats, m, x, S)
        v = Vector(E.d + X_q * i.q, E.q - X_d * i.d)
        S = model.saturation(floats, m, v, i)
    return Operation(x, i, v, S, delta)


def linear(name, m, o: Operation):
    """The model's linear form at a frame, from the phasors alone; and j F/e^{j delta}, (f_d, f_q)."""
    model, (V, I) = MODELS[name], o.phasors  # noqa: E741 - the paper's name
    Q = (V * np.conj(I)).imag
    S = model.seen(floats, m, abs(V), abs(I), Q).S
    F = V + 1j * model.reactance(floats, m, S) * I
    kappa = -1j * I / F
    form = axes.form(model.axes(floats, m, S), model.axes(floats, m, S + 1), Complex(kappa.real, kappa.imag))
    return form, 1j * F * np.exp(-1j * o.delta)


def states(name, m, o: Operation, x):
    """The states of the linear form, in its order, of windings x or of their rates."""
    e1, e2 = MODELS[name].voltages(floats, m, x, o.i, o.S)
    by_name = {"e1d": e1.d, "e1q": e1.q, "e2d": e2.d, "e2q": e2.q}
    return np.array([by_name[state] for state in MODELS[name].STATES])


def assert_forms_agree(name, m, o: Operation, E_f):
    """1e-12 of the largest term: the same sums of a dozen products in two orders."""
    form, f = linear(name, m, o)
    z, rates = states(name, m, o, o.x), states(name, m, o, MODELS[name].rates(floats, m, o.x, o.i, o.S, E_f))
    field = E_f - (MODELS[name].field_of_saturation(floats, m.S10, m.S12, o.x.e1q) if name == "gensal" else 0.0)
    terms = np.array(form.A) @ z, np.array(form.e) * field
    scale = np.abs(np.array(form.A)) @ np.abs(z) + np.abs(terms[1]) + 1
    np.testing.assert_array_less(abs(sum(terms) - rates), 1e-12 * scale.max())
    of_stator = np.array(form.C) @ z[[0, MODELS[name].D_STATES]]
    np.testing.assert_allclose(of_stator, [f.real, f.imag], atol=1e-12)
    if not MODELS[name].SALIENT:
        assert form.C == ((1, 0), (0, 1)) or np.allclose(form.C, np.eye(2), atol=0)


@pytest.mark.parametrize("name", MODELS)
@given(data=st.data())
@settings(max_examples=60)
def test_the_linear_form_is_exact_in_any_state(name, data):
    m = data.draw(machines(name))
    x = MODELS[name].Windings(*[data.draw(number(0.2, 1.2)) for _ in MODELS[name].Windings._fields])
    i = Vector(data.draw(number(-0.5, 1)), data.draw(number(0.0, 1)))
    assert_forms_agree(name, m, operate(name, m, x, i, data.draw(number(-3, 3))), data.draw(number(0, 4)))


TYPICAL = data.Machine(
    6.175, 0.0, 1.8, 0.3, 1.7, 0.55, 8.0, 0.4, 0.0025, 2 * pi * 60, 0.25, 0.28, 0.2, 0.03, 0.05, 0.1, 0.4
)  # fmt: skip
"""Kundur's, with x''q and saturation; pu on its own base."""

HYDRO = TYPICAL._replace(xd=1.1, xq=0.7, xq1=0.69, Td10=5.0)


@pytest.mark.parametrize("name", MODELS)
def test_the_linear_form_is_exact_along_a_trajectory(name):
    """The machine swings behind x = 0.4 pu at 1 pu, in which a fault to 0.3 pu lasts from 0.1 s to 0.2 s."""
    m, model = TYPICAL._replace(Kis=0.05 if name == "gentpj" else 0.0), MODELS[name]
    windings = model.Windings

    def operation(t, y):
        x, V = windings(*y[2:]), 0.3 if 0.1 <= t < 0.2 else 1.0
        S, i, v = 0.0, Vector(0.0, 0.0), Vector(0.0, 0.0)
        for _ in range(40):
            E, X_d, X_q = model.stator(floats, m, x, S)
            X = [[-m.Ra, X_q + 0.4], [-(X_d + 0.4), -m.Ra]]
            i = Vector(*np.linalg.solve(X, [V * np.sin(y[0]) - E.d, V * np.cos(y[0]) - E.q]))
            v = Vector(E.d + X_q * i.q, E.q - X_d * i.d)
            S = model.saturation(floats, m, v, i)
        return Operation(x, i, v, S, y[0])

    def rates(t, y):
        o = operation(t, y)
        torque = o.v.d * o.i.d + o.v.q * o.i.q
        return [y[1], m.omega_s / (2 * m.H) * (0.8 - torque), *model.rates(floats, m, o.x, o.i, o.S, 2.0)]

    y = [
        0.8,
        0.0,
        *[{"e1d": 0.4, "e1q": 0.9, "psi_kd": 0.8, "psi_kq": 0.5, "e2d": 0.4, "e2q": 0.8}[n] for n in windings._fields],
    ]
    swing = 0.0
    for span in ((0.0, 0.1), (0.1, 0.2), (0.2, 1.0)):
        solution = solve_ivp(rates, span, y, rtol=1e-6, max_step=0.02)
        for t, row in zip(solution.t[:-1], solution.y.T[:-1], strict=True):
            assert_forms_agree(name, m, operation(t, row), 2.0)
        y, swing = solution.y[:, -1], max(swing, np.max(abs(solution.y[1])))
    assert swing > 1.0  # rad/s


@pytest.mark.parametrize("name", MODELS)
@given(data=st.data())
@settings(max_examples=30)
def test_steady_state(name, data):
    """The rotor angle, E_f and windings at rest for any V and I: nothing moves, and the stator gives V again."""
    m, model = data.draw(machines(name)), MODELS[name]
    V, I = complex(data.draw(number(0.9, 1.1)), 0.0), complex(data.draw(number(0.1, 1)), data.draw(number(-0.6, 0.3)))  # noqa: E741 - the paper's name
    S = model.saturation(floats, m, Vector(0.0, V.real), Vector(-I.imag, I.real))
    delta = np.angle(V + 1j * model.at_rest(floats, m, S).X_q * I)
    v, i = [Vector((1j * z * np.exp(-1j * delta)).real, (1j * z * np.exp(-1j * delta)).imag) for z in (V, I)]
    S = model.saturation(floats, m, v, i)
    field = model.at_rest(floats, m, S)
    E_f = field.gain * (v.q + field.X_d * i.d)
    x = model.windings_at_rest(floats, m, v, i, S)
    assert model.rates(floats, m, x, i, S, E_f) == pytest.approx([0.0] * len(x), abs=1e-11)
    E, X_d, X_q = model.stator(floats, m, x, S)
    assert (E.d + X_q * i.q, E.q - X_d * i.d) == pytest.approx(v, abs=1e-12)
    # the damper windings are at rest: z = f - drop i
    form, f = linear(name, m, Operation(x, i, v, S, delta))
    np.testing.assert_allclose(
        np.array(form.rest) @ [f.real, f.imag], states(name, m, Operation(x, i, v, S, delta), x), atol=1e-12
    )


@pytest.mark.parametrize("name", MODELS)
def test_noise_columns_are_the_derivatives_of_the_linear_form(name):
    """by_d, by_q, by_S and CX against differences of A(t) z and C(t) z: kappa and S are moved by 1e-6."""
    m, model = TYPICAL._replace(Kis=0.0), MODELS[name]
    S, kappa, f = 0.2, 0.7 - 0.3j, np.array([0.5, 0.9])

    def form(S, kappa):
        return axes.form(model.axes(floats, m, S), model.axes(floats, m, S + 1), Complex(kappa.real, kappa.imag))

    base = form(S, kappa)
    z = np.array(base.rest) @ f
    for step in (1e-6, 1e-6j):
        moved = form(S, kappa + step)
        di = step * complex(*f)
        stator = (0, model.D_STATES)
        df = (np.array(moved.C) - np.array(base.C)) @ z[list(stator)]
        np.testing.assert_allclose(df, np.array(base.CX) @ [di.real, di.imag], atol=1e-11)
        dz = (np.array(moved.A) - np.array(base.A)) @ z
        np.testing.assert_allclose(dz, np.array(base.by_d) * di.real + np.array(base.by_q) * di.imag, rtol=0, atol=1e-9)
    if name not in ("gentpj", "two_axis"):  # there X depends on S, or z moves against f
        dz = (np.array(form(S + 1e-6, kappa).A) - np.array(base.A)) @ z
        np.testing.assert_allclose(dz, np.array(base.by_S) @ f * 1e-6, rtol=1e-9, atol=1e-12)


# Saturation ----------------------------------------------------------------------------------------------------------


@given(number(0.01, 0.3), number(0.0, 0.6), number(0.3, 1.5))
def test_saturation(S10, more, psi):
    """Through the data's two points; the quadratic one as printed, B (psi - A)^2/psi; slopes against differences."""
    S12 = S10 + more
    for curve in (quadratic, exponential):
        assert pytest.approx(S10, abs=1e-12) == curve(floats, S10, S12, 1.0).S
        assert pytest.approx(S12, abs=1e-12) == curve(floats, S10, S12, 1.2).S
        assert curve(floats, 0.0, 0.0, psi) == (0.0, 0.0)
        above, below = curve(floats, S10, S12, psi + 1e-6).S, curve(floats, S10, S12, psi - 1e-6).S
        assert curve(floats, S10, S12, psi).slope == pytest.approx((above - below) / 2e-6, abs=2e-5)
    a = sqrt(1.2 * S12 / S10)
    A = 1 - 0.2 / (a - 1)
    B = S10 / (1 - A) ** 2
    printed = B * (psi - A) ** 2 / psi if psi > A else 0.0
    assert pytest.approx(printed, abs=1e-9) == quadratic(floats, S10, S12, psi).S


# ANDES ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GENROU_RECORDS)
def test_genrou_is_that_of_andes(name):
    """Subtransient voltages, S, field current and terminal voltage to the digits of the file."""
    r = genrou_record(name)
    m, model = r.machine, MODELS["genrou"]
    x = model.Windings(r["e1d"], r["e1q"], r["psi_kd"], r["psi_kq"])
    i, e2 = Vector(r["Id"], r["Iq"]), model.subtransient(m, x)
    np.testing.assert_allclose([e2.d, e2.q], [r["e2d"], r["e2q"]], atol=2e-9)
    v = Vector(e2.d + m.xd2 * i.q, e2.q - m.xd2 * i.d)
    S = model.saturation(arrays, m, v, i)
    np.testing.assert_allclose(S, r["Se"], atol=1e-7)
    rates = model.rates(arrays, m, x, i, S, r["E_f"])
    np.testing.assert_allclose(r["E_f"] - m.Td10 * rates.e1q, r["XadIfd"], atol=1e-7)  # XadIfd = E_f - T'd0 E'q'
    phasor = -1j * np.exp(1j * r["delta"]) * (v.d - m.Ra * i.d + 1j * (v.q - m.Ra * i.q))
    np.testing.assert_allclose(phasor, r["V_t"] * np.exp(1j * r["theta_t"]), atol=5e-9)


@pytest.mark.parametrize("name", GENROU_RECORDS)
def test_genrou_driven_by_the_frames_follows_andes(name):
    """V, theta, E_f and P_m of the record drive the machine for 20 s: delta within 3e-5 rad, with a fault 6e-5 rad.

    Between frames by splines of degree 5, never across an event, at which they are extrapolated by 0.3 or 0.7 of an
    interval. Into and out of the fault ANDES's own step, 1/1200 s of the trapezoidal rule, leaves more than that.
    """
    r = genrou_record(name)
    m, model = r.machine, MODELS["genrou"]
    signals = np.array([r["V_t"], r["theta_t"], r["E_f"], r["P_m"]])
    first = np.array([r[n][0] for n in ("delta", "speed", "e1d", "e1q", "psi_kd", "psi_kq")])
    y, worst = first, 0.0
    times = [0.0, *r.events, 20.0]
    for start, end in zip(times, times[1:], strict=False):
        inside = (r["time"] >= start - 1e-9) & (r["time"] <= end + 1e-9)
        spline = make_interp_spline(r["time"][inside], signals[:, inside].T, k=5)

        def rates(t, y, spline=spline):
            V, theta, E_f, P_m = spline(t)
            x = model.Windings(*y[2:])
            e2 = model.subtransient(m, x)
            d, q = V * np.sin(y[0] - theta) - e2.d, V * np.cos(y[0] - theta) - e2.q
            determinant = m.Ra**2 + m.xd2**2
            i = Vector((-m.Ra * d - m.xd2 * q) / determinant, (m.xd2 * d - m.Ra * q) / determinant)
            torque = e2.d * i.d + e2.q * i.q
            S = quadratic(floats, m.S10, m.S12, float(np.hypot(*e2))).S
            return np.array([m.omega_s * (y[1] - 1), (P_m - torque) / (2 * m.H), *model.rates(floats, m, x, i, S, E_f)])

        at = r["time"][inside]
        solution = solve_ivp(
            rates, (start, end), y, t_eval=at, method="DOP853", rtol=1e-9, atol=1e-10, dense_output=True
        )
        worst = max(worst, float(np.max(abs(solution.y[0] - r["delta"][inside]))))
        y = solution.sol(end)
    assert worst < (6e-5 if "fault" in name else 3e-5)


def test_bases():
    """Every reactance and Kis scale by S_base/S_n, H and D against it, times and saturation not at all."""
    own = tree.map(lambda v: v + 0.1, TYPICAL)
    found = data.on_system_base(own, 900.0, 100.0)
    for variable, before, after in zip(variables(own), own, found, strict=True):
        unit = getattr(variable.specification, "unit", "")
        factor = {"pu": 1 / 9, "s/rad": 9.0}.get(unit, 9.0 if variable.name == "H" else 1.0)
        assert after == pytest.approx(before * factor, rel=1e-14), variable.name
