"""A bank of Kalman filters, weighted by likelihood, and the one filter that tracks: for frames with noise.

Lemmas 1 and 2: given the frames, (x3, x4) moves linearly and |(x3, x4)| = sqrt(Y1) is known at once; only its
direction is not, on the half circle E'q > 0. So 24 filters start there and their likelihoods decide: seen through noise
the problem has up to four wells, and no single filter leaves a wrong one. Once one well has won, its mixture becomes
the tracker. The bank, started again and again, is the tracker's supervisor: where its best explains the same window of
frames far better, it takes over.

There is no gain to choose: `tve`, the assumed noise of the phasors, settles everything.
"""

from collections import namedtuple
from math import cos, pi, sin
from typing import Any, List, NamedTuple, Tuple

from .. import noise
from ..angle import Covariance, Estimate, direction_variance, rotor_angle
from ..interface import Scalar
from ..linear import Vector
from . import kalman
from .kalman import Circle, Gaussian, Updated

SIZE = 24
"""Hypotheses; 8 capture a wrong well in 4 % of random machines, 24 in less than 0.1 %."""

WALK_TRACKER, WALK_BANK = 0.1, 0.02
"""pu/sqrt(s): how an estimated E_f changes."""

FORCING, FORCING_DECAY = 20.0, 1.0
"""A jump of the network sets exciters going: WALK_TRACKER is 1 + 20 e^(-t/1 s) times as large t after it."""

SUPERVISED_AGE, GREATEST_AGE, REST = 0.25, 5.0, 0.75
"""s: the end of a supervision once captured, and in any case; the rest before the next one."""

CAPTURE_SPREAD, RIVAL_DISTANCE, RIVAL_LEAD = 0.03, 0.1, 12.5
"""Captured: the mixture's standard deviation is below 0.03 |E'|, and the best hypothesis leads all that are farther
from it than 0.1 |E'| by 12.5 in log-likelihood."""

TAKEOVER_LEAD, TAKEOVER_DISTANCE, TAKEOVER_MAHALANOBIS2 = 25.0, 0.05, 25.0
"""The bank replaces the tracker: it leads by 25 in log-likelihood and is farther off than 0.05 |E'| and than 5 standard
deviations. (Comparing the estimates alone takes over wrongly.)"""


class Parameters(NamedTuple):
    pass


class Outputs(NamedTuple):
    pass


class Hypothesis(NamedTuple):
    gaussian: Gaussian
    score: Scalar  # log-likelihood of the bank's window of frames, less that of the best hypothesis


Bank: Any = namedtuple("Bank", [f"hypothesis{k}" for k in range(SIZE)])


class Supervision(NamedTuple):
    """The bank, and the tracker as one more hypothesis of the same window of frames."""

    bank: Any  # Bank
    tracker_score: Scalar
    age: Scalar  # s, since the start of the bank; negative while it rests


class Verdict(NamedTuple):
    supervision: Supervision
    captured: Scalar
    tracker: Gaussian


class State(NamedTuple):
    tracker: Gaussian  # until capture: the bank's mixture
    tracking: Scalar  # 0 until the first capture, then 1
    innovation: Scalar  # the tracker's last, in standard deviations
    turn: Scalar  # rad, see Estimate
    turn_variance: Scalar  # rad^2, likewise
    gap: Scalar  # s, since the last usable frame
    calm: Scalar  # s, since the last jump of the network
    supervision: Supervision


def start(xp, p, c, s):
    bank = fresh(xp, c, s)
    mixed = mixture(xp, [gaussian for gaussian, _ in bank], [0.0] * SIZE)
    return State(
        tracker=mixed,
        tracking=0.0,
        innovation=0.0,
        turn=0.0,
        turn_variance=0.0,
        gap=0.0,
        calm=1e3,
        supervision=Supervision(bank, tracker_score=0.0, age=0.0),
    )


def fresh(xp, c, s):
    """The bank at its start: directions (k + 1/2) pi/24, with the standard deviation of a uniform one over pi/24.

    E_f, if it is to be estimated: what keeps E'q at rest, with a standard deviation of 1 pu.
    """
    known = s.measured.E_f_known > 0
    _, R = noise.of_Y1(c, s)
    r = xp.sqrt(s.Y1)
    radial = R / (4 * s.Y1)
    tangential = s.Y1 * (pi / SIZE) * (pi / SIZE) / 12
    hypotheses = []
    for k in range(SIZE):
        d, q = cos((k + 0.5) * pi / SIZE), sin((k + 0.5) * pi / SIZE)
        x = Vector(r * d, r * q)
        at_rest = xp.minimum(xp.maximum(-(s.A.qd * x.d + s.A.qq * x.q) / c.c1, 0.0), 3.0)
        P = Covariance(
            dd=radial * d * d + tangential * q * q,
            dq=(radial - tangential) * d * q,
            qq=radial * q * q + tangential * d * d,
            ff=xp.where(known, 0.0, 1.0),
        )
        hypotheses.append(Hypothesis(Gaussian(x, xp.where(known, s.measured.E_f, at_rest), P), 0.0))
    return Bank(*hypotheses)


def step(xp, p, c, state, interval):
    s, h, nu = interval.after, interval.h, interval.jump.nu
    gap = xp.where(s.measured.held > 0, state.gap + h, 0.0)
    jumped = nu.re * nu.re + nu.im * nu.im > 0
    calm = xp.where(jumped, 0.0, state.calm + h)
    t = kalman.transition(xp, c, interval, s.measured.E_f_known, gap)
    unknown = xp.where(s.measured.E_f_known > 0, 0.0, h)

    walk = WALK_TRACKER * (1 + FORCING * xp.exp(-calm / FORCING_DECAY))
    predicted = kalman.predict(xp, t, state.tracker, unknown * walk * walk)
    circle = kalman.circle(c, s)
    (u,) = updated(xp, t, [predicted], circle)

    before = state.supervision
    before = before._replace(tracker_score=before.tracker_score + u.log_likelihood, age=before.age + h)
    tracking = state.tracking > 0
    verdict = xp.cond(
        before.age > 0,
        lambda: supervise(xp, before, u.gaussian, tracking, circle, t, unknown * WALK_BANK * WALK_BANK),
        lambda: Verdict(before, 0.0, u.gaussian),
    )
    wakes = xp.logical_and(verdict.supervision.age >= 0, before.age <= 0)
    supervision = xp.cond(
        xp.logical_or(jumped, xp.logical_or(wakes, verdict.supervision.age == 0)),
        lambda: Supervision(fresh(xp, c, s), 0.0, 0.0),
        lambda: verdict.supervision,
    )

    tracker = verdict.tracker
    old, new = predicted.x, tracker.x
    return State(
        tracker=tracker,
        tracking=xp.where(xp.logical_or(tracking, verdict.captured > 0), 1.0, 0.0),
        innovation=u.innovation,
        turn=xp.atan2(old.d * new.q - old.q * new.d, old.d * new.d + old.q * new.q),
        turn_variance=xp.where(
            tracking,
            kalman.turn_variance(t, state.tracker, predicted),
            direction_variance(predicted.x, predicted.P),
        ),
        gap=gap,
        calm=calm,
        supervision=supervision,
    )


def updated(xp, t, predicted: List[Gaussian], circle: Circle) -> Tuple[Updated, ...]:
    """Each with the frame, if it is one."""
    return xp.cond(
        circle.held > 0,
        lambda: tuple(Updated(gaussian, 0.0, 0.0) for gaussian in predicted),
        lambda: tuple(kalman.update(xp, t, gaussian, circle) for gaussian in predicted),
    )


def supervise(xp, before: Supervision, tracker: Gaussian, tracking, circle: Circle, t, walk) -> Verdict:
    """The bank over the interval; is one well left, does the bank replace the tracker, and what does it do next?"""
    updates = updated(xp, t, [kalman.predict(xp, t, gaussian, walk) for gaussian, _ in before.bank], circle)
    bank = [u.gaussian for u in updates]
    likelihoods = [score + u.log_likelihood for (_, score), u in zip(before.bank, updates)]
    # (x, E_f) -> (-x, -E_f) is a solution too, and E_f > -0.5 excludes it
    scores = [xp.where(gaussian.E_f < -0.5, -1e6, score) for gaussian, score in zip(bank, likelihoods)]
    best, lead = winner(xp, bank, scores)
    tracker_score = before.tracker_score - best
    alone = lead > RIVAL_LEAD
    mixed = xp.cond(
        xp.logical_or(xp.logical_not(tracking), alone),
        lambda: mixture(xp, bank, [score - best for score in scores]),
        lambda: tracker,  # nothing comes of the bank yet
    )

    captured = xp.logical_and(alone, mixed.P.dd + mixed.P.qq < CAPTURE_SPREAD * CAPTURE_SPREAD * circle.Y1)
    ahead = xp.logical_and(captured, tracker_score < -TAKEOVER_LEAD)
    takeover = xp.logical_and(tracking, xp.logical_and(ahead, contradict(xp, tracker, mixed, circle.Y1)))
    replaces = xp.logical_or(xp.logical_not(tracking), takeover)

    done = xp.logical_and(captured, before.age > SUPERVISED_AGE)
    again = xp.logical_or(takeover, xp.logical_and(tracking, before.age >= GREATEST_AGE))
    return Verdict(
        Supervision(
            Bank(*[Hypothesis(gaussian, score - best) for gaussian, score in zip(bank, likelihoods)]),
            tracker_score=xp.where(takeover, 0.0, tracker_score),
            age=xp.where(again, 0.0, xp.where(done, -REST, before.age)),
        ),
        captured=xp.where(captured, 1.0, 0.0),
        tracker=xp.cond(replaces, lambda: mixed, lambda: tracker),
    )


def winner(xp, bank: List[Gaussian], scores):
    """The best score, and its lead over all hypotheses that are farther than 0.1 |x| from the best one."""
    best, ((d, q), _, _) = scores[0], bank[0]
    for score, ((own_d, own_q), _, _) in zip(scores[1:], bank[1:]):
        better = score > best
        best, d, q = xp.where(better, score, best), xp.where(better, own_d, d), xp.where(better, own_q, q)
    near2 = RIVAL_DISTANCE * RIVAL_DISTANCE * (d * d + q * q)
    rival = -1e6
    for score, ((own_d, own_q), _, _) in zip(scores, bank):
        away_d, away_q = own_d - d, own_q - q
        far = away_d * away_d + away_q * away_q > near2
        rival = xp.where(far, xp.maximum(rival, score), rival)
    return best, best - rival


def mixture(xp, bank: List[Gaussian], scores) -> Gaussian:
    """Mean and covariance of the bank, each hypothesis with the weight e^score; the best score is 0."""
    weights = [xp.exp(xp.maximum(score, -700.0)) for score in scores]
    total = sum(weights)
    mean_d = sum(w * v.x.d for w, v in zip(weights, bank)) / total
    mean_q = sum(w * v.x.q for w, v in zip(weights, bank)) / total
    mean_f = sum(w * v.E_f for w, v in zip(weights, bank)) / total
    dd = dq = qq = df = qf = ff = 0.0
    for w, v in zip(weights, bank):
        d, q, f, P = v.x.d - mean_d, v.x.q - mean_q, v.E_f - mean_f, v.P
        dd = dd + w * (P.dd + d * d)
        dq = dq + w * (P.dq + d * q)
        qq = qq + w * (P.qq + q * q)
        df = df + w * (P.df + d * f)
        qf = qf + w * (P.qf + q * f)
        ff = ff + w * (P.ff + f * f)
    return Gaussian(Vector(mean_d, mean_q), mean_f, Covariance(*[v / total for v in (dd, dq, qq, df, qf, ff)]))


def contradict(xp, tracker: Gaussian, mixed: Gaussian, Y1):
    """The two are far apart, and not within what their covariances allow for."""
    d, q = tracker.x.d - mixed.x.d, tracker.x.q - mixed.x.q
    P, M = tracker.P, mixed.P
    dd, dq, qq = P.dd + M.dd, P.dq + M.dq, P.qq + M.qq
    apart2 = qq * d * d - 2 * dq * d * q + dd * q * q  # Mahalanobis distance squared, times the determinant
    far = d * d + q * q > TAKEOVER_DISTANCE * TAKEOVER_DISTANCE * Y1
    return xp.logical_and(far, apart2 > TAKEOVER_MAHALANOBIS2 * (dd * qq - dq * dq))


def estimate(xp, state, s, near):
    x, E_f, P = state.tracker
    delta = rotor_angle(xp, s, x, near).delta
    return Estimate(delta, x, P, E_f, state.innovation, 1 - state.tracking, state.turn, state.turn_variance)


def outputs(xp, state):
    return Outputs()
