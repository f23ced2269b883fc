"""What stands between a machine and its observer in the field: instrument transformers, PMU and network.

    X -> X ((1 + b) e^{j beta} + tve n + gross)    X = V e^{j theta}, I e^{j phi};  b, beta: bias;  E|n|^2 = 1
      -> rounded to steps of magnitude and angle   the angle in (-pi, pi]
      -> lost with the probability `dropout`, else shown after `latency`

P + jQ = V conj(I) of what is left, as in a PMU. P_m and E_f travel with the frame. n is complex and circular, white,
independent for V and I; with u, u' uniform in (0, 1) it is r e^{j alpha}, alpha uniform, with

    gaussian:   r^2 = -ln u                            real and imaginary part normal
    laplace:    r^2 = ln u ln u'                       real and imaginary part Laplace
    student_t:  r^2 = (k - 2)/2 (u^(-2/k) - 1)         bivariate t, k degrees of freedom (Bailey 1994)

A frame is taken at the communication points at or after every multiple of 1/rate. In between the outputs hold, and so
they do where a frame is lost: then `frame_valid` is false. `t_frame` is the time at which the frame that they show was
measured.

The inputs of a step from t to t + h are the values at t, as FMI 2.0 has it, and so its frame is that of t. The frame of
t + h shows as soon as the inputs of t + h are set. Some masters set the inputs of t + h before the step to t + h
(Gauss-Seidel): with `plant.t_frame` connected, the values bring their time along, and both orders give the same frames.
"""

from collections import namedtuple
from math import pi
from typing import Annotated, Any, List, NamedTuple

from . import mrg32k3a, tree
from .angle import unwrap
from .interface import INLINE, Boolean, Enumeration, Integer, Real, Rule, Scalar
from .linear import Complex
from .mrg32k3a import Generator
from .phasors import Frame, is_finite

GAUSSIAN, LAPLACE, STUDENT_T = 1, 2, 3

LONGEST_LATENCY = 32
"""Frames."""

ON_TIME = 1e-2
"""Of a frame's period: a communication point this close before a frame is at it. A clock in whole nanoseconds loses
4e-8 of it a step of 1/60 s (0.9 % in an hour), and one in UTC seconds counts in steps of 2.4e-7 s."""

UNSTAMPED = -1e30
"""s; the start value of `plant.t_frame`: where it is not connected, the values are those of the communication point."""


class Plant(NamedTuple):
    """True values at the terminal. A PMU measures phasors only, so that P and Q are not among them."""

    V_t: Annotated[Scalar, Real("pu", "true terminal voltage magnitude")] = 0.0
    theta_t: Annotated[Scalar, Real("rad", "true angle of the terminal voltage phasor")] = 0.0
    I_t: Annotated[Scalar, Real("pu", "true terminal current magnitude")] = 0.0
    phi_t: Annotated[Scalar, Real("rad", "true angle of the terminal current phasor, generator convention")] = 0.0
    P_m: Annotated[Scalar, Real("pu", "mechanical power")] = 0.0
    E_f: Annotated[Scalar, Real("pu", "field voltage")] = 0.0
    t_frame: Annotated[
        Scalar, Real("s", "time of these values on the simulation's clock; not connected: the communication point")
    ] = UNSTAMPED


class Inputs(NamedTuple):
    plant: Plant = Plant()


def bias(unit, what):
    return Real(unit, f"constant error of the {what}", min=-1.0, max=1.0)


def probability(what):
    return Real("1", f"probability that a frame {what}", min=0.0, max=1.0, tunable=True)


class Parameters(NamedTuple):
    rate: Annotated[Scalar, Real("1/s", "frames per second", min=0.1, max=1e3, nominal=60.0)] = 60.0
    tve: Annotated[
        Scalar, Real("1", "noise: RMS of the total vector error that it makes", min=0.0, max=1.0, tunable=True)
    ] = 0.01
    noise: Annotated[
        Scalar, Enumeration("NoiseDistribution", "distribution of the noise", ("gaussian", "laplace", "student_t"))
    ] = GAUSSIAN
    degrees_of_freedom: Annotated[Scalar, Real("1", "of student_t noise", min=2.1, max=1e3)] = 4.0
    V_magnitude_bias: Annotated[Scalar, bias("1", "voltage magnitude, relative")] = 0.0
    V_angle_bias: Annotated[Scalar, bias("rad", "voltage angle")] = 0.0
    I_magnitude_bias: Annotated[Scalar, bias("1", "current magnitude, relative")] = 0.0
    I_angle_bias: Annotated[Scalar, bias("rad", "current angle")] = 0.0
    magnitude_step: Annotated[Scalar, Real("pu", "resolution of the magnitudes; 0: exact", min=0.0, max=1.0)] = 0.0
    angle_step: Annotated[
        Scalar, Real("rad", "resolution of the angles (IEEE C37.118 integers: 1e-4); 0: exact", min=0.0, max=1.0)
    ] = 0.0
    latency: Annotated[
        Scalar, Real("s", "from measurement to output, rounded up to whole frames; at most 32", min=0.0)
    ] = 0.0
    dropout: Annotated[Scalar, probability("is lost")] = 0.0
    gross_error_probability: Annotated[Scalar, probability("has a gross error in V or I")] = 0.0
    gross_error: Annotated[
        Scalar, Real("1", "size of a gross error, relative to the phasor; its direction is random", min=0.0, max=10.0)
    ] = 0.2
    seed: Annotated[
        Scalar, Integer("number of the random stream; the same seed repeats every frame", min=0, max=2**31 - 1)
    ] = 0


class Outputs(NamedTuple):
    frame: Annotated[Frame, INLINE] = Frame()
    P_m: Annotated[Scalar, Real("pu", "mechanical power")] = 0.0
    E_f: Annotated[Scalar, Real("pu", "field voltage (open circuit: E_f = 1 gives V = 1)")] = 0.0
    frame_valid: Annotated[
        Scalar, Boolean("the last frame has come; if it is lost or the first is on its way, the outputs hold")
    ] = 0.0
    t_frame: Annotated[
        Scalar, Real("s", "time at which the frame now shown was measured, on the simulation's clock")
    ] = 0.0


class Packet(NamedTuple):
    """A frame on its way, of what a PMU sends."""

    V: Scalar  # pu
    theta: Scalar  # rad
    I: Scalar  # pu  # noqa: E741 - the paper's name
    phi: Scalar  # rad
    P_m: Scalar  # pu
    E_f: Scalar  # pu
    valid: Scalar  # 1, or 0 where a frame is missing
    time: Scalar  # s, of the measurement


Network: Any = namedtuple("Network", [f"packet{place}" for place in range(LONGEST_LATENCY)])
"""The packets on their way, the next one to arrive first."""


class State(NamedTuple):
    count: Scalar  # number of the last frame that was taken: its time times the rate
    generator: Generator  # of the next one's random numbers
    network: Any  # Network
    shown: Packet  # the values of the last frame that came, and whether there was one since


def rules(xp, p: Parameters, inputs: Inputs) -> List[Rule]:
    """What must hold of parameters that are each in range."""
    message = "latency = {latency} is not allowed with rate = {rate}; it must be at most 32 frames, in [0, 32/rate] s"
    return [Rule(delay(xp, p) <= LONGEST_LATENCY, message)]


def delay(xp, p: Parameters):
    """The latency in whole frames."""
    return -xp.floor(-p.latency * p.rate + ON_TIME)


def start(xp, p: Parameters, inputs: Inputs, t):
    """State and outputs at time t, where the first frame is due; while it is on its way, its values are shown."""
    generator, time = mrg32k3a.stream(xp, p.seed), time_of(xp, inputs, t)
    _, packet = measured(xp, p, generator, inputs, time)
    missing = packet._replace(valid=0.0)
    state = State(frame_number(xp, p, time) - 1, generator, Network(*[missing] * LONGEST_LATENCY), missing)
    return state, output(xp, p, state, inputs, t)


def step(xp, p: Parameters, state: State, inputs: Inputs, t, h):
    """From t, where the frame that is due is taken, to t + h."""
    state = taken(xp, p, state, inputs, t)
    return state, outputs(xp, state)


def output(xp, p: Parameters, state: State, inputs: Inputs, t) -> Outputs:
    """The frame of time t, if one is due, shows the inputs; reading it takes no random numbers from those to come."""
    return outputs(xp, taken(xp, p, state, inputs, t))


def taken(xp, p: Parameters, state: State, inputs: Inputs, t) -> State:
    """With the frame of time t, if that is another one than the last."""
    time = time_of(xp, inputs, t)
    count = frame_number(xp, p, time)

    def with_frame():
        generator, packet = measured(xp, p, state.generator, inputs, time)
        return sent(xp, p, state._replace(count=count, generator=generator), packet)

    return xp.cond(count != state.count, with_frame, lambda: state)


def time_of(xp, inputs: Inputs, t):
    """When the values of the inputs were measured. s"""
    stamp = inputs.plant.t_frame
    return xp.where(xp.abs(stamp) < -UNSTAMPED / 2, stamp, t)  # false for NaN too


def frame_number(xp, p: Parameters, t):
    return xp.floor(t * p.rate + ON_TIME)


def measured(xp, p: Parameters, generator: Generator, inputs: Inputs, time):
    """The frame that the PMU sends. Every frame takes ten random numbers, so that no parameter changes which."""
    u = []
    for _ in range(10):
        generator, number = mrg32k3a.uniform(xp, generator)
        u.append(number)
    values = inputs.plant._replace(t_frame=0.0)
    finite = is_finite(xp, tree.leaves(values))  # what is not finite cannot be measured
    true = tree.map(lambda value: xp.where(finite, value, 0.0), values)

    gross = xp.where(u[7] < p.gross_error_probability, p.gross_error, 0.0)
    error = from_polar(xp, gross, u[9])
    in_V, in_I = xp.where(u[8] < 0.5, 1.0, 0.0), xp.where(u[8] < 0.5, 0.0, 1.0)

    def phasor(magnitude, angle, magnitude_bias, angle_bias, n: Complex, share):
        re = (1 + magnitude_bias) * xp.cos(angle_bias) + p.tve * n.re + share * error.re
        im = (1 + magnitude_bias) * xp.sin(angle_bias) + p.tve * n.im + share * error.im
        magnitude = magnitude * xp.sqrt(re * re + im * im)
        angle = unwrap(xp, angle + xp.atan2(im, re), 0.0)
        return rounded(xp, magnitude, p.magnitude_step), rounded(xp, angle, p.angle_step)

    V, theta = phasor(true.V_t, true.theta_t, p.V_magnitude_bias, p.V_angle_bias, noise(xp, p, *u[0:3]), in_V)
    I, phi = phasor(true.I_t, true.phi_t, p.I_magnitude_bias, p.I_angle_bias, noise(xp, p, *u[3:6]), in_I)  # noqa: E741 - the paper's name
    valid = xp.where(xp.logical_and(finite, u[6] >= p.dropout), 1.0, 0.0)
    return generator, Packet(V, theta, I, phi, true.P_m, true.E_f, valid, time)


def noise(xp, p: Parameters, u1, u2, u3) -> Complex:
    """Complex noise with E|n|^2 = 1 from three numbers in (0, 1)."""
    exponential = -xp.log(u1)
    k = p.degrees_of_freedom
    student = (k - 2) / 2 * xp.expm1(2 / k * exponential)
    r = xp.sqrt(
        xp.where(p.noise == STUDENT_T, student, xp.where(p.noise == LAPLACE, -exponential * xp.log(u2), exponential))
    )
    return from_polar(xp, r, u3)


def from_polar(xp, r, u) -> Complex:
    """r at a random angle in (-pi, pi)."""
    angle = 2 * pi * (u - 0.5)  # CasADi would merge 2 pi u with the factor in u, and round differently
    return Complex(r * xp.cos(angle), r * xp.sin(angle))


def rounded(xp, value, step):
    """To the nearest multiple of `step`, if it is not 0."""
    size = xp.where(step > 0, step, 1.0)
    return xp.where(step > 0, size * xp.floor(value / size + 0.5), value)


def sent(xp, p: Parameters, state: State, packet: Packet) -> State:
    """One frame's time: a packet enters the network, and what arrives is shown."""
    wait, queue = delay(xp, p), state.network
    arrived = xp.cond(wait == 0, lambda: packet, lambda: queue[0])
    moved = [
        xp.cond(wait == place + 1, lambda: packet, lambda following=following: following)
        for place, following in enumerate((*queue[1:], queue[-1]))
    ]
    held = state.shown._replace(valid=0.0)
    shown = xp.cond(arrived.valid > 0, lambda: arrived, lambda: held)
    return state._replace(network=Network(*moved), shown=shown)


def outputs(xp, state: State) -> Outputs:
    V, theta, I, phi, P_m, E_f, valid, time = state.shown  # noqa: E741 - the paper's name
    S, lag = V * I, theta - phi
    return Outputs(Frame(V, theta, I, phi, S * xp.cos(lag), S * xp.sin(lag)), P_m, E_f, valid, time)
