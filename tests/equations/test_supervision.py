"""The rules of the estimator robust, on both sides of their boundaries, with a frame that moves nothing."""

from math import cos, exp, pi, sin
from types import SimpleNamespace

import numpy as np
import pytest

from fmu_src.pmu_observer import noise, observer
from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.estimators import robust
from fmu_src.pmu_observer.estimators.robust import Bank, Hypothesis, Scored, Supervision
from fmu_src.pmu_observer.gaussian import Gaussian, Updated, circle_of
from fmu_src.pmu_observer.linear import Complex, Vector
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.phasors import Frame, measurement, signals
from fmu_src.pmu_observer.sampling import Jump, interval
from fmu_src.pmu_observer.transition import transition

G6 = ieee39_g6()
C = observer.constants_of("robust", "two_axis", observer.Parameters(machine=G6))
V, I = 1.03 * np.exp(0.3j), 6.4 * np.exp(0.1j)  # noqa: E741 - the paper's name
S = V * np.conj(I)
FRAME = Frame(1.03, 0.3, 6.4, 0.1, float(S.real), float(S.imag))
SIGNALS = signals(floats, C, measurement(floats, FRAME, 6.5, 2.2, False)._replace(tve=0.002, E_f_known=0.0))
STILL = transition(floats, C, SIGNALS, SIGNALS, 0.0, Jump(Complex(0.0, 0.0), 0.0, 0.0), 0.0)
CIRCLE = circle_of(SIGNALS)
R, H = CIRCLE.Y1**0.5, 1 / 60


def on_circle(angle, p=0.0, E_f=2.2):
    """A Gaussian at that direction, pu and rad, known but for p pu^2 across it."""
    d, q = cos(angle), sin(angle)
    return Gaussian((R * d, R * q, E_f), (p * q * q, -p * d * q, 0.0, p * d * d, 0.0, 0.0))


# The bank ---------------------------------------------------------------------------------------------------------


def scored(x, score):
    return Scored(on_circle(0.0), Vector(*x), score, score)


@pytest.mark.parametrize("best", range(3))
def test_the_winner_leads_those_that_are_far_from_it(best):
    x = Vector(0.6, 0.8)
    others = [scored((0.6 + 0.0995, 0.8), -1.0), scored((0.6, 0.8 - 0.1005), -7.0), scored((-0.6, 0.8), -9.0)]
    bank = [*others[:best], scored(x, 2.0), *others[best:]]
    assert robust.winner(floats, tuple(bank)) == (2.0, 9.0)


def test_without_a_rival():
    bank = scored((0.6, 0.8), -3.0), scored((0.61, 0.8), -4.0)
    assert robust.winner(floats, bank) == (-3.0, -3.0 - robust.EXCLUDED)


def test_the_mixture_has_the_banks_mean_and_covariance():
    rng, bank, scores = np.random.default_rng(1), [], [-0.5, 0.0, -2.0, -1e5]
    for score in scores:
        root = rng.normal(size=(3, 3))
        P = root @ root.T
        bank.append(Hypothesis(Gaussian(tuple(rng.normal(size=3)), tuple(P[np.triu_indices(3)])), score))
    found = robust.mixture(floats, tuple(bank))
    weights = np.exp(np.maximum(scores, -700.0)) / np.sum(np.exp(scores))
    x = np.array([item.gaussian.x for item in bank])
    P = np.array([item.gaussian.P for item in bank])
    mean = weights @ x
    apart = (x - mean)[:, :, None] * (x - mean)[:, None, :]
    np.testing.assert_allclose(found.x, mean, rtol=1e-12)
    expected = weights @ P + np.einsum("k,kij->ij", weights, apart)[np.triu_indices(3)]
    np.testing.assert_allclose(found.P, expected, rtol=1e-12)


@pytest.mark.parametrize("E_f_known", [0.0, 1.0])
def test_the_bank_starts_on_half_the_circle(E_f_known):
    """(k + 1/2) pi/24 with the deviation of a uniform direction, and that of the radius; E_f keeps E'q at rest."""
    s = SIGNALS._replace(measured=SIGNALS.measured._replace(E_f_known=E_f_known))
    _, variance = noise.of_Y1(s)
    F = V + 1j * G6.xd1 * I
    for k, (gaussian, score) in enumerate(robust.fresh(floats, C, s)):
        e = np.exp(1j * pi * (k + 0.5) / 24)
        f = abs(F) * e
        assert score == 0 and (gaussian.x[0], gaussian.x[1]) == pytest.approx((f.real, f.imag), rel=1e-9)
        along, across = np.array([e.real, e.imag]), np.array([-e.imag, e.real])
        P = variance / (4 * abs(F) ** 2) * np.outer(along, along)
        P = P + abs(F) ** 2 * (pi / 24) ** 2 / 12 * np.outer(across, across)
        dd, dq, df, qq, qf, ff = gaussian.P
        np.testing.assert_allclose([dd, dq, qq], [P[0, 0], P[0, 1], P[1, 1]], rtol=1e-9, atol=1e-15)
        assert (df, qf, ff) == (0.0, 0.0, 1.0 - E_f_known)
        # the rotor of that hypothesis, j F = e^{j delta} f, sees the current I_d + j I_q = j I e^{-j delta}
        I_d = (1j * I * np.exp(-1j * np.angle(1j * F / f))).real
        at_rest = min(max(f.imag + (G6.xd - G6.xd1) * I_d, 0.0), 3.0)
        assert gaussian.x[2] == pytest.approx(2.2 if E_f_known else at_rest, rel=1e-9)


# Supervision ------------------------------------------------------------------------------------------------------

RIGHT, WRONG = 1.06, pi - 1.06


def supervise(tracker=WRONG, score=-50.0, tracking=True, age=1.0, lead=50.0, p=1e-8, E_f=2.2, rival_E_f=2.2, P=1e-6):
    """One hypothesis at RIGHT that leads all others, which are far, and a tracker."""
    bank = Bank(
        Hypothesis(on_circle(RIGHT, p, E_f), 0.0),
        *[Hypothesis(on_circle(RIGHT + 0.2 + 0.02 * k, p, rival_E_f), -lead) for k in range(robust.SIZE - 1)],
    )
    # the tracker explains the frame as well as the bank's best
    r = CIRCLE.Y1 - R * R - p
    u = Updated(on_circle(tracker, P), r, CIRCLE.R + 2 * p * p)
    before = Supervision(bank, score, 1.0, age)
    return robust.supervise(floats, C, before, u, tracking, CIRCLE, STILL, H, 0.0)


def at(verdict):
    x = verdict.tracker.x
    return pytest.approx(np.arctan2(x[1], x[0]), abs=1e-6)


def test_the_bank_takes_over():
    v = supervise()
    assert (v.captured, v.takeover, v.again) == (1.0, 1.0, 1.0) and at(v) == RIGHT
    assert v.supervision.tracker_score == pytest.approx(-50.0, abs=1e-6)


@pytest.mark.parametrize(("score", "takeover"), [(-24.9, 0.0), (-25.1, 1.0)])
def test_it_must_lead_by_25(score, takeover):
    v = supervise(score=score)
    assert (v.captured, v.takeover, v.again) == (1.0, takeover, takeover)
    assert at(v) == (RIGHT if takeover else WRONG)


@pytest.mark.parametrize(("distance", "takeover"), [(0.0495, 0.0), (0.0505, 1.0)])
def test_it_must_be_farther_off_than_5_percent(distance, takeover):
    assert supervise(tracker=RIGHT + 2 * np.arcsin(distance / 2)).takeover == takeover


@pytest.mark.parametrize(("standard_deviations", "takeover"), [(4.9, 0.0), (5.1, 1.0)])
def test_it_must_be_farther_off_than_5_standard_deviations(standard_deviations, takeover):
    """Of both: one is along the tracker's circle, one along the mixture's, at nearly the same direction."""
    distance = 0.06 * R
    variance = (distance / standard_deviations) ** 2
    turned = 2 * np.arcsin(0.03)
    # across the direction half way, so that it is along the difference
    d, q = cos(RIGHT + turned / 2), sin(RIGHT + turned / 2)
    P = variance * np.array([q * q, -d * q, d * d]) + [1e-12, 0.0, 1e-12]
    tracker, mixed = on_circle(RIGHT + turned), on_circle(RIGHT)
    tracker = tracker._replace(P=(0.4 * P[0], 0.4 * P[1], 0.0, 0.4 * P[2], 0.0, 0.0))
    mixed = mixed._replace(P=(0.6 * P[0], 0.6 * P[1], 0.0, 0.6 * P[2], 0.0, 0.0))
    t = SimpleNamespace(C=((1.0, 0.0), (0.0, 1.0)))
    assert robust.contradict(floats, C, t, tracker, mixed, R * R) == bool(takeover)  # pyright: ignore


@pytest.mark.parametrize(("lead", "alone"), [(12.4, 0.0), (12.6, 1.0)])
def test_one_well_is_left_when_its_best_leads_by_12_and_a_half(lead, alone):
    assert supervise(lead=lead).captured == alone
    first = supervise(lead=lead, tracking=False)
    assert (first.captured, first.takeover, first.again) == (alone, 0.0, 0.0)
    assert at(first) == pytest.approx(RIGHT, abs=1e-4)  # until then the mixture is shown


@pytest.mark.parametrize(("share", "captured"), [(0.0295, 1.0), (0.0305, 0.0)])
def test_captured_when_the_mixture_is_narrow(share, captured):
    p = share**2 * CIRCLE.Y1
    assert supervise(p=p).captured == captured


def test_the_mirrored_solution_is_no_candidate():
    """Its field voltage is negative: the others win, although it explains the frames better."""
    v = supervise(E_f=-0.51, lead=30.0)
    assert v.takeover == 0 and supervise(E_f=-0.49, lead=30.0).takeover == 1
    v = supervise(E_f=-0.51, lead=1.0, rival_E_f=2.2, tracking=False)
    x = v.tracker.x
    assert np.arctan2(x[1], x[0]) > RIGHT + 0.2
    scores = [item.score for item in v.supervision.bank]
    assert scores[0] == pytest.approx(1.0, abs=1e-6) and max(scores[1:]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("age", "captured", "tracking", "awake", "left", "again"),
    [
        (0.2505 - H, True, True, 0.0, 0.0, 0.0),  # captured for longer than 0.25 s: to rest
        (0.2495 - H, True, True, 1.0, 0.2495, 0.0),
        (4.9995 - H, False, True, 1.0, 4.9995, 0.0),
        (5.0005 - H, False, True, 1.0, 5.0005, 1.0),  # in any case after 5 s
        (5.0005 - H, False, False, 1.0, 5.0005, 0.0),  # but not before the first capture
    ],
)
def test_what_the_bank_does_next(age, captured, tracking, awake, left, again):
    v = supervise(tracker=RIGHT, score=0.0, age=age, tracking=tracking, lead=50.0 if captured else 1.0)
    assert (v.supervision.awake, v.again) == (awake, again)
    assert v.supervision.age == pytest.approx(left, abs=1e-12)


@pytest.mark.parametrize(("age", "again"), [(0.7495 - H, 0.0), (0.7505 - H, 1.0)])
def test_a_rest_ends_after_750_ms(age, again):
    before = Supervision((), -3.0, 0.0, age)
    v = robust.rest(floats, before, on_circle(RIGHT), H)
    assert (v.captured, v.takeover, v.again) == (0.0, 0.0, again)
    assert v.tracker == on_circle(RIGHT) and v.supervision == before._replace(age=age + H)


# A step -----------------------------------------------------------------------------------------------------------

STATE = robust.start(floats, robust.Parameters(), C, SIGNALS)


def jumping(nu=3.0):
    """An interval with a jump of nu, or without."""
    return interval(floats, C, SIGNALS, SIGNALS, H)._replace(jump=Jump(Complex(0.0, nu), 0.0, 0.0))


def step(span, **values):
    return robust.step(floats, robust.Parameters(), C, STATE._replace(**values), span)


@pytest.mark.parametrize(("calm", "nu"), [(1.0, 0.0), (0.2, 0.0), (1.0, 3.0), (1.0, -3.0)])
def test_a_jump_sets_the_exciter_going(calm, nu):
    after = step(jumping(nu), calm=calm)
    assert after.calm == pytest.approx(0.0 if nu else calm + H, rel=1e-12)
    assert after.E_f_walk == pytest.approx((0.1 * (1 + 20 * exp(-after.calm / 1.0))) ** 2, rel=1e-12)


def test_a_measured_field_voltage_does_not_walk():
    s = SIGNALS._replace(measured=SIGNALS.measured._replace(E_f_known=1.0))
    first = robust.start(floats, robust.Parameters(), C, s)
    after = robust.step(floats, robust.Parameters(), C, first, interval(floats, C, s, s, H))
    assert after.E_f_walk == 0 and after.tracker.x[2] == pytest.approx(2.2, rel=1e-12)


def test_a_jump_starts_the_bank_again():
    old = STATE.supervision._replace(age=2.0, tracker_score=-7.0)
    assert step(jumping(), supervision=old).supervision == robust.started(floats, C, SIGNALS)
    assert step(jumping(0.0), supervision=old).supervision.age == pytest.approx(2.0 + H)


def test_while_the_bank_rests_it_does_not_move():
    resting = STATE.supervision._replace(awake=0.0, age=0.3)
    after = step(jumping(0.0), supervision=resting, tracking=1.0, takeovers=2.0)
    assert after.supervision == resting._replace(age=0.3 + H)
    assert (after.tracking, after.takeovers) == (1.0, 2.0)
    awake = step(jumping(0.0), supervision=resting._replace(age=0.75), tracking=1.0)
    assert awake.supervision == robust.started(floats, C, SIGNALS)


def test_the_turn_is_what_the_frame_corrects():
    """With a tracker off by 0.3 rad whose covariance says so, along and across."""
    tracker = on_circle(0.8)._replace(P=(4e-3, 3e-3, 0.0, 4e-3, 0.0, 0.0))
    tracker = tracker._replace(x=(1.1 * tracker.x[0], tracker.x[1], 2.2))
    resting = STATE.supervision._replace(awake=0.0, age=0.3)
    after = step(interval(floats, C, SIGNALS, SIGNALS, 1e-9), tracker=tracker, supervision=resting, tracking=1.0)
    before, now = complex(*tracker.x[:2]), complex(*after.tracker.x[:2])
    assert abs(np.angle(now / before)) > 1e-3
    assert after.turn == pytest.approx(np.angle(now / before), abs=1e-7)
    assert after.flux == pytest.approx((now.real, now.imag), rel=1e-12)
    assert after.turn_variance == pytest.approx(0.0, abs=1e-9)  # nothing moves in 1 ns
    capturing = step(interval(floats, C, SIGNALS, SIGNALS, 1e-9), tracker=tracker, supervision=resting)
    gradient = np.array([-before.imag, before.real]) / abs(before) ** 2
    across = gradient @ np.array([[4e-3, 3e-3], [3e-3, 4e-3]]) @ gradient
    assert capturing.turn_variance == pytest.approx(across, rel=1e-6)


def test_what_it_says_of_itself():
    state = STATE._replace(innovation=1.5, turn=0.1, turn_variance=0.2, E_f_walk=0.3, tracking=1.0, takeovers=4.0)
    e = robust.estimate(floats, state, SIGNALS, 0.0)
    assert (e.innovation, e.turn, e.turn_variance, e.E_f_walk, e.capturing) == (1.5, 0.1, 0.2, 0.3, 0.0)
    assert (e.x, e.covariance, e.gaussian, e.E_f) == (state.flux, state.covariance, state.tracker, state.tracker.x[2])
    assert robust.estimate(floats, STATE, SIGNALS, 0.0).capturing == 1.0
    assert robust.outputs(floats, state).takeovers == 4.0
