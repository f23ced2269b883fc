"""PmuChannel: its distributions against scipy, what it does to a frame against the definition, and its FMU."""

import math

import numpy as np
import pytest
from casadi import SX, Function, vertcat
from scipy import stats

from fmu_src.pmu_observer import pmu_channel, tree
from fmu_src.pmu_observer.carriers import arrays, floats, symbols
from fmu_src.pmu_observer.pmu_channel import GAUSSIAN, LAPLACE, STUDENT_T, Inputs, Parameters, Plant

from .fmu.instance import DISCARD, OK, Instance

H = 1 / 60
STEADY = Plant(V_t=1.02, theta_t=0.3, I_t=0.8, phi_t=-0.2, P_m=0.5, E_f=1.7)
V, CURRENT = 1.02 * np.exp(0.3j), 0.8 * np.exp(-0.2j)
CLEAN = Parameters(tve=0.0)


def run(p, count, plant=lambda t: STEADY, xp=floats, h=H):
    """The outputs at 0, h, ..., count h, each with the inputs of that time."""
    state, outputs = pmu_channel.start(xp, p, Inputs(plant(0.0)), 0.0)
    found = [outputs]
    for k in range(count):
        state, _ = pmu_channel.step(xp, p, state, Inputs(plant(k * h)), k * h, h)
        found.append(pmu_channel.output(xp, p, state, Inputs(plant((k + 1) * h)), (k + 1) * h))
    return found


def phasors(found):
    """The voltages and the currents of a run, as arrays."""
    V_t, theta_t, I_t, phi_t = (
        np.array([getattr(o.frame, name) for o in found]) for name in found[0].frame._fields[:4]
    )
    return V_t * np.exp(1j * theta_t), I_t * np.exp(1j * phi_t)


def errors(p, seeds=2000, count=24):
    """V-hat/V - 1 and I-hat/I - 1 of many seeds at once, two arrays (frame, seed)."""
    found = run(p._replace(seed=np.arange(float(seeds))), count, xp=arrays)
    voltage, current = phasors(found)
    return voltage / V - 1, current / CURRENT - 1


# Noise ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("noise", "degrees_of_freedom", "component"),
    [
        (GAUSSIAN, 4.0, stats.norm(scale=math.sqrt(1 / 2))),
        (LAPLACE, 4.0, stats.laplace(scale=1 / 2)),
        (STUDENT_T, 3.0, stats.t(3.0, scale=math.sqrt(1 / 6))),
        (STUDENT_T, 10.0, stats.t(10.0, scale=math.sqrt(8 / 20))),
    ],
)
def test_real_and_imaginary_part_are_distributed_as_named(noise, degrees_of_freedom, component):
    """Kolmogorov-Smirnov on 50 000 numbers each; each has a variance of 1/2. The seeds are fixed: it cannot flicker."""
    assert component.var() == pytest.approx(1 / 2)
    for e in errors(Parameters(tve=0.01, noise=noise, degrees_of_freedom=degrees_of_freedom)):
        for part in (np.real(e), np.imag(e)):
            assert stats.kstest(part.ravel() / 0.01, component.cdf).pvalue > 1e-3


@pytest.mark.parametrize(("noise", "variance"), [(GAUSSIAN, 1.0), (LAPLACE, 3.0), (STUDENT_T, 5 / 3)])
@pytest.mark.parametrize("tve", [1e-3, 1e-2])
def test_measured_total_vector_error_is_the_parameter(noise, variance, tve):
    """RMS of |V-hat - V|/|V| within four standard errors; `variance` is that of |n|^2, from E|n|^4 - 1.

    (Gaussian: |n|^2 exponential. Laplace: product of two exponentials. t, 10 degrees: |n|^2 = 0.8 F(2, 10).)
    """
    if noise == STUDENT_T:
        assert variance == pytest.approx(0.8**2 * stats.f(2, 10).var())
    for e in errors(Parameters(tve=tve, noise=noise, degrees_of_freedom=10.0)):
        mean_square = np.mean(np.abs(e) ** 2)
        assert abs(mean_square / tve**2 - 1) < 4 * math.sqrt(variance / e.size)


def test_noise_is_white_circular_and_independent():
    e = errors(Parameters(tve=1.0))
    limit = 4.5 / math.sqrt(e[0].size)  # standard errors of a correlation; of a dozen, the largest

    def correlated(a, b):
        return abs(np.mean(a * b)) / 0.5

    for one in e:
        assert correlated(np.real(one), np.imag(one)) < limit
        for part in (np.real(one), np.imag(one)):
            assert correlated(part[1:], part[:-1]) < limit
            assert correlated(part[:, 1:], part[:, :-1]) < limit  # neighbouring seeds
            assert abs(np.mean(part)) / math.sqrt(0.5) < limit
    assert max(correlated(f(e[0]), f(e[1])) for f in (np.real, np.imag)) < limit


# What is done to a frame ----------------------------------------------------------------------------------------------


def test_without_any_error_the_frame_is_the_truth():
    outputs = run(CLEAN, 3)[-1]
    S = V * np.conj(CURRENT)
    expected = [1.02, 0.3, 0.8, -0.2, S.real, S.imag, 0.5, 1.7, 1.0, 3 * H]
    assert tree.leaves(outputs) == pytest.approx(expected, abs=1e-15)


def test_power_is_that_of_the_noisy_phasors():
    found = run(Parameters(tve=0.05), 50)
    voltage, current = phasors(found)
    S = voltage * np.conj(current)
    assert [o.frame.P_t for o in found] == pytest.approx(list(np.real(S)), abs=1e-14)
    assert [o.frame.Q_t for o in found] == pytest.approx(list(np.imag(S)), abs=1e-14)
    assert np.std(np.real(S)) > 0.01


def test_bias():
    p = CLEAN._replace(V_magnitude_bias=0.01, V_angle_bias=0.02, I_magnitude_bias=-0.03, I_angle_bias=-0.04)
    outputs = run(p, 1)[-1].frame
    assert outputs[:4] == pytest.approx((1.02 * 1.01, 0.32, 0.8 * 0.97, -0.24), abs=1e-15)


def test_resolution():
    p = Parameters(tve=0.02, magnitude_step=1 / 1024, angle_step=1e-4)
    exact, coarse = run(p._replace(magnitude_step=0.0, angle_step=0.0), 200), run(p, 200)
    for name, step in (("V_t", 1 / 1024), ("I_t", 1 / 1024), ("theta_t", 1e-4), ("phi_t", 1e-4)):
        a = np.array([getattr(o.frame, name) for o in exact])
        b = np.array([getattr(o.frame, name) for o in coarse])
        assert np.abs(b / step - np.round(b / step)).max() < 1e-9
        assert 0.4 * step < np.abs(b - a).max() <= step / 2 * (1 + 1e-9)


def test_angles_are_wrapped():
    for true in (3.1, 3.2, -3.2, 100.0):
        outputs = run(CLEAN, 0, lambda t, true=true: STEADY._replace(theta_t=true))[0]
        assert abs(outputs.frame.theta_t) <= math.pi
        assert np.exp(1j * outputs.frame.theta_t) == pytest.approx(np.exp(1j * true), abs=1e-13)


def test_gross_errors():
    """Their number is binomial; each is 20 % of V or of I, in a random direction."""
    e = np.abs(np.array(errors(CLEAN._replace(gross_error_probability=0.02, gross_error=0.2))))
    hit = e > 0.1
    assert e[hit] == pytest.approx(0.2, abs=1e-12)
    assert e[~hit].max() < 1e-12
    assert not np.any(hit[0] & hit[1])
    for share in hit:
        assert stats.binomtest(int(share.sum()), share.size, 0.01).pvalue > 1e-3
    e = np.array(errors(CLEAN._replace(gross_error_probability=1.0), seeds=500))
    assert stats.kstest(np.angle(e[np.abs(e) > 0.1]), stats.uniform(-math.pi, 2 * math.pi).cdf).pvalue > 1e-3


# Time -----------------------------------------------------------------------------------------------------------------


def ramp(t):
    """Every frame differs: theta_t = t, P_m = 10 t."""
    return STEADY._replace(theta_t=t, P_m=10 * t)


@pytest.mark.parametrize(("latency", "frames"), [(0.0, 0), (1e-3, 1), (1 / 60, 1), (0.05, 3), (32 / 60, 32)])
def test_latency_in_whole_frames(latency, frames):
    found = run(CLEAN._replace(latency=latency), 50, ramp)
    assert [o.frame_valid for o in found] == [0.0] * frames + [1.0] * (51 - frames)
    shown = [max(0, k - frames) * H for k in range(51)]
    assert [o.frame.theta_t for o in found] == pytest.approx(shown, abs=1e-12)
    assert [o.P_m for o in found] == pytest.approx([10 * t for t in shown], abs=1e-12)
    assert [o.t_frame for o in found] == pytest.approx(shown, abs=1e-12)


def test_a_lost_frame_is_flagged_and_the_last_one_held():
    found = run(CLEAN._replace(dropout=0.3), 200, ramp)
    last = 0.0
    for k, outputs in enumerate(found):
        last = k * H if outputs.frame_valid else last
        assert outputs.t_frame == pytest.approx(last, abs=1e-12)
        assert outputs.frame.theta_t == pytest.approx(math.remainder(last, 2 * math.pi), abs=1e-12)
    assert 30 < sum(o.frame_valid == 0 for o in found) < 90


def test_dropout_rate():
    found = run(Parameters(dropout=0.1, seed=np.arange(2000.0)), 24, xp=arrays)
    lost = np.array([o.frame_valid == 0 for o in found])
    assert stats.binomtest(int(lost.sum()), lost.size, 0.1).pvalue > 1e-3


def test_a_frame_comes_at_every_multiple_of_its_period_and_the_outputs_hold_in_between():
    """60 frames/s and steps of 1 ms: the first communication point at or after k/60 s."""
    found = run(CLEAN, 1000, ramp, h=1e-3)
    for k, outputs in enumerate(found):
        taken = math.ceil(math.floor(k * 60 / 1000 + 1e-9) * 1000 / 60 - 1e-9) / 1000
        assert outputs.frame.theta_t == pytest.approx(taken, abs=1e-12)
        assert outputs.t_frame == pytest.approx(taken, abs=1e-12)
        assert outputs.frame_valid == 1


@pytest.mark.parametrize("begin", [-3600.0, 0.0, 3600.0, 1.7e9])
@pytest.mark.parametrize("rate", [10.0, 25.0, 30.0, 50.0, 60.0, 120.0])
def test_every_step_of_a_frames_period_brings_a_frame(rate, begin):
    """Of a master that adds up its steps, also in UTC seconds, where a double counts in steps of 2.4e-7 s."""
    p, h, t = CLEAN._replace(rate=rate), 1 / rate, begin
    state, _ = pmu_channel.start(floats, p, Inputs(STEADY), t)
    for k in range(500):
        state, outputs = pmu_channel.step(floats, p, state, Inputs(STEADY._replace(P_m=float(k))), t, h)
        assert (outputs.P_m, outputs.t_frame) == (k, t)
        t += h


@pytest.mark.parametrize("rate", [10.0, 25.0, 30.0, 50.0, 60.0, 120.0])
def test_every_step_brings_a_frame_on_a_clock_in_whole_nanoseconds(rate):
    """libcosim's, for 20 minutes: its steps of 16 666 666 ns fall behind a period of 1/60 s by 48 us by then."""
    p, h = CLEAN._replace(rate=rate), math.floor(1e9 / rate)
    state, _ = pmu_channel.start(floats, p, Inputs(STEADY), 0.0)
    for k in (*range(500), *range(round(1200 * rate), round(1200 * rate) + 50)):
        state, outputs = pmu_channel.step(floats, p, state, Inputs(STEADY._replace(P_m=float(k))), k * h / 1e9, h / 1e9)
        assert outputs.P_m == k


# Random numbers -------------------------------------------------------------------------------------------------------

EVERYTHING = Parameters(
    tve=0.01,
    noise=LAPLACE,
    magnitude_step=1e-5,
    angle_step=1e-4,
    latency=0.04,
    dropout=0.1,
    gross_error_probability=0.1,
)


def test_a_seed_repeats_and_another_differs():
    first = run(EVERYTHING._replace(seed=3), 40)
    assert run(EVERYTHING._replace(seed=3), 40) == first
    assert phasors(run(EVERYTHING._replace(seed=4), 40))[0] != pytest.approx(phasors(first)[0])


def test_losses_and_gross_errors_leave_the_noise_of_the_other_frames_alone():
    p = Parameters(tve=0.01, seed=5)
    clean, bad = run(p, 200), run(p._replace(dropout=0.2, gross_error_probability=0.2), 200)
    same = [a == b for a, b in zip(clean, bad, strict=True)]
    assert 0.5 < np.mean(same) < 0.8  # 0.8 * 0.8 = 0.64


@pytest.mark.parametrize("noise", [GAUSSIAN, LAPLACE, STUDENT_T])
def test_carriers_agree(noise):
    """CasADi to the bit, having the same libm; numpy has its own sin and log, a few ulp off where no step rounds."""
    p = EVERYTHING._replace(noise=noise, seed=9, degrees_of_freedom=3.0)
    expected = run(p, 100, ramp)
    assert values(traced(p, 100, ramp)) == values(expected)
    p = p._replace(magnitude_step=0.0, angle_step=0.0)
    found = run(p._replace(seed=np.array([2.0, 9.0])), 100, ramp, arrays)
    one = [tree.map(lambda x: float(np.broadcast_to(x, 2)[1]), outputs) for outputs in found]
    assert np.abs(np.array(values(one)) - np.array(values(run(p, 100, ramp)))).max() < 1e-12


def values(found):
    return [[float(leaf) for leaf in tree.leaves(outputs)] for outputs in found]


def traced(p, count, plant):
    """`run` with the functions that CasADi makes of start and step."""

    def symbol(shape):
        return tree.like(shape, [SX.sym(name) for name in tree.names(shape)])

    def vector(branch):
        return SX(vertcat(*tree.leaves(branch)))

    def numbers(branch):
        return [float(leaf) for leaf in tree.leaves(branch)]

    parameters, inputs, t, h = symbol(p), symbol(Inputs()), SX.sym("t"), SX.sym("h")
    state, outputs = pmu_channel.start(symbols, parameters, inputs, t)
    start = Function("start", [vector(parameters), vector(inputs), t], [vector(state), vector(outputs)])
    state = symbol(state)
    after, _ = pmu_channel.step(symbols, parameters, state, inputs, t, h)
    shown = pmu_channel.output(symbols, parameters, state, inputs, t)
    step = Function("step", [vector(parameters), vector(state), vector(inputs), t, h], [vector(after)])
    output = Function("output", [vector(parameters), vector(state), vector(inputs), t], [vector(shown)])
    state, outputs = start(numbers(p), numbers(plant(0.0)), 0.0)
    found = [outputs]
    for k in range(count):
        state = step(numbers(p), state, numbers(plant(k * H)), k * H, H)
        found.append(output(numbers(p), state, numbers(plant((k + 1) * H)), (k + 1) * H))
    return [tuple(outputs.full().ravel()) for outputs in found]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_cannot_be_measured(value):
    def plant(t):
        return STEADY._replace(E_f=value if 0.05 < t < 0.1 else 1.7, P_m=t)

    found = run(CLEAN, 12, plant)
    assert [o.frame_valid for o in found] == [1.0] * 4 + [0.0] * 2 + [1.0] * 7
    assert all(math.isfinite(leaf) for o in found for leaf in tree.leaves(o))
    first = run(CLEAN, 0, lambda t: STEADY._replace(V_t=value))[0]
    assert tree.leaves(first) == [0.0] * 10


# Inputs and outputs of one instant, in any order of a master --------------------------------------------------------


def moving(t):
    """A plant that says what time its values are of."""
    return ramp(t)._replace(t_frame=t)


def test_a_frame_read_after_its_inputs_were_set_shows_them_however_often():
    """Every read gives the same noise, and takes none from the frames to come."""
    p = Parameters(tve=0.05, seed=4)
    state, _ = pmu_channel.start(floats, p, Inputs(ramp(0.0)), 0.0)
    once = pmu_channel.output(floats, p, state, Inputs(ramp(0.0)), 0.0)
    assert pmu_channel.output(floats, p, state, Inputs(ramp(0.0)), 0.0) == once
    other = pmu_channel.output(floats, p, state, Inputs(STEADY._replace(V_t=2 * STEADY.V_t)), 0.0)
    assert other.frame.V_t == pytest.approx(2 * once.frame.V_t, rel=1e-15)
    state, after = pmu_channel.step(floats, p, state, Inputs(ramp(0.0)), 0.0, H)
    assert after == once  # the step took the frame as it was read
    assert pmu_channel.output(floats, p, state, Inputs(ramp(H)), H).frame.V_t != pytest.approx(once.frame.V_t)


@pytest.mark.parametrize("h", [H, 1e-3, 0.01, 0.04])
@pytest.mark.parametrize("latency", [0.0, 0.05])
def test_jacobi_and_gauss_seidel_give_the_same_frames(h, latency):
    """At t_frame the plant had the values of the frame, whether they came with the step that begins or ends there."""
    p = CLEAN._replace(latency=latency)
    state = before = pmu_channel.start(floats, p, Inputs(moving(0.0)), 0.0)[0]
    frames = set(), set()
    for k in range(300):
        state, jacobi = pmu_channel.step(floats, p, state, Inputs(moving(k * h)), k * h, h)
        before, gauss_seidel = pmu_channel.step(floats, p, before, Inputs(moving((k + 1) * h)), k * h, h)
        for outputs, found in zip((jacobi, gauss_seidel), frames, strict=True):
            assert outputs.P_m == pytest.approx(10 * outputs.t_frame, abs=1e-12)
            found.add(round(outputs.t_frame, 9))
        assert gauss_seidel.t_frame >= jacobi.t_frame
    jacobi, gauss_seidel = ({t for t in found if t > h} for found in frames)  # the first one is that of 0, or of h
    assert gauss_seidel >= jacobi
    assert len(gauss_seidel - jacobi) <= 1  # the last one, which is at the end of the last step


def test_a_stamp_that_is_not_finite_is_none():
    for stamp in (math.nan, math.inf, -math.inf, pmu_channel.UNSTAMPED):
        outputs = run(CLEAN, 3, lambda t, stamp=stamp: ramp(t)._replace(t_frame=stamp))[-1]
        assert (outputs.t_frame, outputs.P_m, outputs.frame_valid) == (3 * H, 10 * 3 * H, 1.0)


# The FMU --------------------------------------------------------------------------------------------------------------

NAMES = [f"plant.{name}" for name in STEADY._fields[:-1]]
VALID, T_FRAME = -2, -1  # places among the outputs


def feed(instance, plant):
    instance.set(**{name.replace(".", "__"): value for name, value in zip(NAMES, plant, strict=False)})


def steps(instance, first, last):
    found = []
    for k in range(first, last):
        assert instance.step(k * H, H) == OK
        feed(instance, ramp((k + 1) * H))
        found.append(instance.outputs())
    return found


@pytest.fixture
def channel(dist):
    instance = Instance(dist / "python" / "PmuChannel.fmu", **EVERYTHING._replace(seed=11)._asdict())
    yield instance
    instance.free()


def test_the_fmu_shows_a_frame_at_initialisation_and_is_the_equations(channel):
    feed(channel, ramp(0.0))
    channel.initialise()
    found = [channel.outputs(), *steps(channel, 0, 60)]
    assert found == values(run(EVERYTHING._replace(seed=11), 60, ramp))
    assert abs(found[0][0] - 1.02) < 0.3 and found[0][VALID] == 0  # a frame, the first on its way


def test_rolling_back_repeats_to_the_bit(channel):
    feed(channel, ramp(0.0))
    channel.initialise()
    steps(channel, 0, 20)
    state = channel.slave.getFMUState()
    once = steps(channel, 20, 60)
    channel.slave.setFMUState(state)
    assert steps(channel, 20, 60) == once


def test_a_gap_made_by_the_tunable_dropout(dist):
    channel = Instance(dist / "python" / "PmuChannel.fmu", tve=0.0)
    feed(channel, ramp(0.0))
    channel.initialise()
    valid = []
    for dropout in (0.0, 1.0, 0.0):
        channel.set(dropout=dropout)
        valid += [row[VALID] for row in steps(channel, len(valid), len(valid) + 5)]
    assert valid == [1] * 5 + [0] * 5 + [1] * 5
    channel.free()


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ({"latency": 0.6}, "latency = 0.6 is not allowed with rate = 60; it must be at most 32 frames"),
        ({"dropout": 1.5}, "dropout = 1.5 is not allowed; it must be in [0, 1]"),
        ({"noise": 4}, "noise = 4 is not allowed; it must be in gaussian (1), laplace (2), student_t (3)"),
    ],
)
def test_parameters_out_of_range_are_named(dist, start, message):
    channel = Instance(dist / "python" / "PmuChannel.fmu", **start).initialise()
    assert channel.step(0.0, H) == DISCARD
    assert message in channel.messages[0]
    channel.free()
