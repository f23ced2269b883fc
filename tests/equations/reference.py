"""The paper's continuous equations once more, in plain numpy and complex phasors, for scipy's solve_ivp.

Nothing in here comes from the package under test. Rotor-frame pairs are complex numbers, d + jq:

    j E' = e^{j delta} (x3 + j x4) is the internal voltage, turned by 90 degrees,     I = (E' - V)/(j x')
    y2 sin(x1 - y1) + j y2 cos(x1 - y1) = (V/E') (x3 + j x4)
"""

from typing import Any, Callable, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp


class Machine(NamedTuple):
    """Physical data with x'd = x'q = x1 and no resistance; the paper's constants follow below its eq. (3)."""

    H: float
    D: float  # pu torque per rad/s
    xd: float
    xq: float
    x1: float
    Td: float
    Tq: float
    w0: float

    @property
    def b0(self):
        return self.w0 / (2 * self.H)

    @property
    def a0(self):
        return self.D * self.b0

    @property
    def c1(self):
        return 1 / self.Td

    @property
    def a1(self):
        return self.xd / (self.x1 * self.Td)

    @property
    def b1(self):
        return (self.xd - self.x1) / (self.x1 * self.Td)

    @property
    def a2(self):
        return self.xq / (self.x1 * self.Tq)

    @property
    def b2(self):
        return (self.xq - self.x1) / (self.x1 * self.Tq)


PAPER = Machine(H=23.64, D=2.0, xd=0.146, xq=0.146, x1=0.0608, Td=8.96, Tq=0.31, w0=314.16)
G6 = Machine(H=34.8, D=0.0, xd=0.254, xq=0.241, x1=0.05, Td=7.3, Tq=0.4, w0=2 * np.pi * 60)


class Case(NamedTuple):
    """A machine behind a line at an infinite bus, and its inputs over time."""

    machine: Machine
    start: tuple[float, float, float, float]  # delta, omega, E'd, E'q
    P_m: Callable[[float], float]
    E_f: Callable[[float], float]
    V_inf: complex = 1.0
    x_line: float = 0.0


PAPER_CASE = Case(PAPER, (0.1, 0.2, 0.4, 0.3), lambda t: 0.1, lambda t: 0.1)
"""The paper's single-machine study: the terminal is the infinite bus."""

MOVING_CASE = Case(
    G6,
    start=(0.9, 0.5, 0.3, 0.9),
    P_m=lambda t: 5.0 + 0.5 * np.sin(3 * t),
    E_f=lambda t: 2.0 + 0.3 * np.cos(2 * t),
    V_inf=1.02 * np.exp(0.2j),
    x_line=0.06,
)
"""Nothing stands still: V, theta, P_m and E_f all move, and the machine swings."""


class Seen(NamedTuple):
    """What a PMU and the machine's inputs tell at time t, and what Lemma 2 makes of it."""

    t: float
    V: complex
    I: complex  # noqa: E741 - the paper's name
    P: float
    Q: float
    P_m: float
    E_f: float
    W: complex  # j E'
    ratio: complex  # V/E'


def seen(case: Case, t: float, x) -> Seen:
    delta, _, e1d, e1q = x
    W = np.exp(1j * delta) * (e1d + 1j * e1q)
    E = -1j * W
    I = (E - case.V_inf) / (1j * (case.machine.x1 + case.x_line))  # noqa: E741 - the paper's name
    V = E - 1j * case.machine.x1 * I
    S = V * np.conj(I)
    return Seen(t, V, I, S.real, S.imag, case.P_m(t), case.E_f(t), W, V / E)


def rotor_rates(m: Machine, s: Seen, pair: complex) -> complex:
    """(x3, x4)' of the paper's eq. (1) for any pair in place of (x3, x4): A (x3, x4) + (0, c1 u2)."""
    v = s.ratio * pair
    return complex(-m.a2 * pair.real + m.b2 * v.real, -m.a1 * pair.imag + m.b1 * v.imag + m.c1 * s.E_f)


def homogeneous_rates(m: Machine, s: Seen, pair: complex) -> complex:
    return rotor_rates(m, s, pair) - 1j * m.c1 * s.E_f


def machine_rates(case: Case, t: float, x) -> np.ndarray:
    """The paper's eq. (1) as printed, with the angles and magnitudes of its eq. (2) and (3)."""
    m, s = case.machine, seen(case, t, x)
    x1, x2, x3, x4 = x
    y1, y2 = np.angle(s.V), abs(s.V)
    y5 = (y2 / m.x1) * (x4 * np.sin(x1 - y1) - x3 * np.cos(x1 - y1))
    return np.array(
        [
            x2,
            -m.a0 * x2 + m.b0 * (s.P_m - y5),
            -m.a2 * x3 + m.b2 * y2 * np.sin(x1 - y1),
            -m.a1 * x4 + m.b1 * y2 * np.cos(x1 - y1) + m.c1 * s.E_f,
        ]
    )


class Observer(NamedTuple):
    """An observer as an ordinary differential equation: its start, and rates(seen, machine's state, own state)."""

    start: Any
    rates: Callable[[Seen, np.ndarray, np.ndarray], Any]


class Solution(NamedTuple):
    t: np.ndarray
    machine: np.ndarray  # (4, n)
    observer: np.ndarray  # (own states, n)


NO_OBSERVER = Observer([], lambda s, x, z: [])


def solve(case: Case, times, observer: Observer = NO_OBSERVER, method: str = "DOP853", rtol: float = 1e-10) -> Solution:
    """Machine and observer as one system of equations, so that the observer sees the machine without any error."""

    def rates(t, z):
        return np.concatenate([machine_rates(case, t, z[:4]), observer.rates(seen(case, t, z[:4]), z[:4], z[4:])])

    start = np.concatenate([case.start, observer.start])
    result = solve_ivp(rates, (times[0], times[-1]), start, method=method, t_eval=times, rtol=rtol, atol=1e-13)
    assert result.success, result.message
    return Solution(result.t, result.y[:4], result.y[4:])


def pairs(z) -> np.ndarray:
    """Neighbouring reals as complex numbers: (d, q, d, q, ...) -> (d + jq, ...)."""
    return np.asarray(z)[0::2] + 1j * np.asarray(z)[1::2]


def reals(*numbers) -> list[float]:
    return [part for number in numbers for part in (number.real, number.imag)]


# Lemma 3: xi and the two columns of Phi, six states --------------------------------------------------------------


GPEBO_START = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]


def gpebo_rates(m: Machine, s: Seen, z):
    xi, Phi1, Phi2 = pairs(z)
    return reals(rotor_rates(m, s, xi), homogeneous_rates(m, s, Phi1), homogeneous_rates(m, s, Phi2))


def regression(s: Seen, z) -> np.ndarray:
    """(psi, y_E), from |xi + Phi theta|^2 = |W|^2."""
    xi, Phi1, Phi2 = pairs(z)

    def inner(a, b):
        return (a * np.conj(b)).real

    psi = [2 * inner(Phi1, xi), 2 * inner(Phi2, xi), 2 * inner(Phi1, Phi2), abs(Phi1) ** 2, abs(Phi2) ** 2]
    return np.array([*psi, abs(s.W) ** 2 - abs(xi) ** 2])


def gpebo_pair(z, theta) -> complex:
    xi, Phi1, Phi2 = pairs(z)
    return xi + Phi1 * theta[0] + Phi2 * theta[1]


# Estimators ------------------------------------------------------------------------------------------------------


def open_loop(m: Machine) -> Observer:
    return Observer([0.0, 0.0], lambda s, x, z: reals(rotor_rates(m, s, complex(*z))))


def gradient(m: Machine, Gamma: float) -> Observer:
    def rates(s, x, z):
        pair = complex(*z)
        return reals(Gamma * (abs(s.W) ** 2 - abs(pair) ** 2) * pair + rotor_rates(m, s, pair))

    return Observer([0.0, 0.0], rates)


def joint_gradient(case: Case, Gamma: float, k: float) -> Observer:
    """States x1, x2, x3, x4; the gradient of the cost is taken by hand in complex numbers."""
    m = case.machine

    def rates(s, x, z):
        x1, x2, pair = z[0], z[1], complex(z[2], z[3])
        off = s.W - np.exp(1j * x1) * pair
        dJ_dx1 = -(off * np.conj(1j * np.exp(1j * x1) * pair)).real
        dJ_dpair = -2 * (abs(s.W) ** 2 - abs(pair) ** 2) * pair - np.exp(-1j * x1) * off
        swing = -m.a0 * x2 + m.b0 * (s.P_m - s.P)
        return [x2 - Gamma * dJ_dx1, swing - k * Gamma * dJ_dx1, *reals(rotor_rates(m, s, pair) - Gamma * dJ_dpair)]

    first = seen(case, 0.0, case.start)
    return Observer([np.angle(first.W / 1j), 0.0, 0.0, 0.0], rates)


def overparameterised(m: Machine, Gamma: float) -> Observer:
    """GPEBO's six states, then Theta."""

    def rates(s, x, z):
        *psi, y_E = regression(s, z[:6])
        return [*gpebo_rates(m, s, z[:6]), *(-Gamma * np.array(psi) * (np.dot(psi, z[6:]) - y_E))]

    return Observer([*GPEBO_START, 0.0, 0.0, 0.0, 0.0, 0.0], rates)


DREM_THETA = slice(30, 32)
DREM_INT_DELTA2 = 32


def drem(m: Machine, gamma: float, d=(2.0, 4.0, 6.0, 8.0)) -> Observer:
    """GPEBO's six states, four filtered rows of (psi, y_E), theta, and the integral of Delta^2."""

    def rates(s, x, z):
        row = regression(s, z[:6])
        filtered = z[6:30].reshape(4, 6)
        Delta, calY1, calY2 = mixed(np.vstack([row, filtered]))
        theta = z[DREM_THETA]
        adapt = -gamma * Delta * (Delta * theta - np.array([calY1, calY2]))
        return [*gpebo_rates(m, s, z[:6]), *(np.array(d)[:, None] * (row - filtered)).ravel(), *adapt, Delta**2]

    return Observer([*GPEBO_START, *[0.0] * 27], rates)


def mixed(rows) -> tuple[float, float, float]:
    """det Psi, and det Psi with its first or second column replaced by Y_E, from the 5x6 matrix [Psi, Y_E]."""
    Psi, Y_E = rows[:, :5], rows[:, 5]
    first, second = Psi.copy(), Psi.copy()
    first[:, 0] = Y_E
    second[:, 1] = Y_E
    return np.linalg.det(Psi), np.linalg.det(first), np.linalg.det(second)


# Angle and speed -------------------------------------------------------------------------------------------------


def estimated_angle(s: Seen, x, pair: complex) -> float:
    """x1 from e^{j x1} pair = W, continued from the true angle; zero is taken along q, where E_f drives it."""
    along = pair if pair != 0 else 1j
    return x[0] + np.angle(complex(x[2], x[3]) / along)


def with_speed(case: Case, estimator: Observer, pair_of, k: float) -> Observer:
    """An estimator and, as one more state, z of x2 = z + k x1 on the angle that it estimates; x2 starts from zero."""
    m = case.machine

    def angle(s, x, own):
        return estimated_angle(s, x, pair_of(own))

    def rates(s, x, z):
        own = z[:-1]
        x2 = z[-1] + k * angle(s, x, own)
        return [*estimator.rates(s, x, own), -(m.a0 + k) * x2 + m.b0 * (s.P_m - s.P)]

    first = seen(case, 0.0, case.start)
    z0 = -k * angle(first, np.array(case.start), np.array(estimator.start))
    return Observer([*estimator.start, z0], rates)


def speed_known(case: Case, k: float) -> Observer:
    """z of x2 = z + k x1 on the true angle."""
    m = case.machine

    def rates(s, x, z):
        return [-(m.a0 + k) * (z[0] + k * x[0]) + m.b0 * (s.P_m - s.P)]

    return Observer([-k * case.start[0]], rates)


def speed_unknown(case: Case, k: float, P_m: float) -> Observer:
    """z and n of x2 = z + k1 x1, d = n + k2 x1 = b0 Pm on the true angle, both poles at -(a0 + k)/2."""
    m = case.machine
    k2 = ((m.a0 + k) / 2) ** 2

    def rates(s, x, z):
        x2, d = z[0] + k * x[0], z[1] + k2 * x[0]
        return [-(m.a0 + k) * x2 - m.b0 * s.P + d, -k2 * x2]

    return Observer([-k * case.start[0], m.b0 * P_m - k2 * case.start[0]], rates)


def speed_adaptive(case: Case, k: float, a0: float, b0: float, gamma: float, lam: float, mu: float) -> Observer:
    """States z; g, f2 of p F[x1] and p^2 F[x1]; h1, h2 of F[u1 - y5]; the second regression (3); a0, b0."""

    def rates(s, x, state):
        z, g, f2, h1, h2, z_mu, phi1_mu, phi2_mu, a0, b0 = state
        x2 = z + k * x[0]
        f1 = lam * (x[0] - g)  # lam/(p + lam) p [x1]
        regression = np.array([lam * (f1 - f2), -f2, h2])
        Psi = np.array([regression[1:], [phi1_mu, phi2_mu]])
        calY = np.array([regression[0], z_mu])
        Delta = np.linalg.det(Psi)
        adapt = gamma * Delta * (adjugate(Psi) @ calY - Delta * np.array([a0, b0]))
        return [
            -(a0 + k) * x2 + b0 * (s.P_m - s.P),
            lam * (x[0] - g),
            lam * (f1 - f2),
            lam * (s.P_m - s.P - h1),
            lam * (h1 - h2),
            *(mu * (regression - np.array([z_mu, phi1_mu, phi2_mu]))),
            *adapt,
        ]

    x1 = case.start[0]
    return Observer([-k * x1, x1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, a0, b0], rates)


def adjugate(M) -> np.ndarray:
    return np.array([[M[1, 1], -M[0, 1]], [-M[1, 0], M[0, 0]]])
