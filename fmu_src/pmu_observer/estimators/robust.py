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
from typing import Annotated, Any, List, NamedTuple

from .. import noise
from ..angle import Covariance, Estimate, direction_variance, rotor_angle
from ..gaussian import Circle, Gaussian, Transition, Updated, circle_of, predict, transition, turn_variance, update
from ..interface import Integer, Scalar
from ..linear import Vector

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

LEAST_E_F, EXCLUDED = -0.5, -1e6
"""pu: no machine in operation has a lower field voltage; and the log-likelihood of what is no candidate."""

LEAST_EXPONENT = -700.0
"""e to the power of less is not a normal number."""

TAKEOVER_LEAD, TAKEOVER_DISTANCE, TAKEOVER_MAHALANOBIS2 = 25.0, 0.05, 25.0
"""The bank replaces the tracker: it leads by 25 in log-likelihood and is farther off than 0.05 |E'| and than 5 standard
deviations. (Comparing the estimates alone takes over wrongly.)"""


class Parameters(NamedTuple):
    pass


class Outputs(NamedTuple):
    takeovers: Annotated[
        Scalar,
        Integer(
            "how often the bank has replaced the tracking filter since the first capture: it was in a wrong well", min=0
        ),
    ] = 0


class Hypothesis(NamedTuple):
    gaussian: Gaussian
    score: Scalar  # log-likelihood of the bank's window of frames, less that of the best hypothesis


Bank: Any = namedtuple("Bank", [f"hypothesis{k}" for k in range(SIZE)])


class Supervision(NamedTuple):
    """The bank, and the tracker as one more hypothesis of the same window of frames."""

    bank: Any  # Bank
    tracker_score: Scalar
    awake: Scalar  # 1 while the bank follows the frames, 0 while it rests
    age: Scalar  # s, since the bank was started, or since it went to rest


class Verdict(NamedTuple):
    supervision: Supervision
    tracker: Gaussian
    captured: Scalar
    takeover: Scalar
    again: Scalar  # 1 where a new bank is due


class State(NamedTuple):
    tracker: Gaussian  # until capture: the bank's mixture
    tracking: Scalar  # 0 until the first capture, then 1
    takeovers: Scalar
    innovation: Scalar  # the tracker's last, in standard deviations
    turn: Scalar  # rad, see Estimate
    turn_variance: Scalar  # rad^2, likewise
    E_f_walk: Scalar  # pu^2/s, likewise
    calm: Scalar  # s, since the last jump of the network
    supervision: Supervision


LONG_CALM = 1e3
"""s since a jump, at the start."""


def start(xp, p, c, s):
    supervision = started(xp, c, s)
    mixed = mixture(xp, [gaussian for gaussian, _ in supervision.bank], [0.0] * SIZE)
    return State(
        tracker=mixed,
        tracking=0.0,
        takeovers=0.0,
        innovation=0.0,
        turn=0.0,
        turn_variance=0.0,
        E_f_walk=0.0,
        calm=LONG_CALM,
        supervision=supervision,
    )


def started(xp, c, s) -> Supervision:
    return Supervision(fresh(xp, c, s), tracker_score=0.0, awake=1.0, age=0.0)


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
    jumped = nu.re * nu.re + nu.im * nu.im > 0
    calm = xp.where(jumped, 0.0, state.calm + h)
    t = transition(xp, c, interval)
    circle = circle_of(c, s)
    unknown = xp.where(s.measured.E_f_known > 0, 0.0, 1.0)

    walk = WALK_TRACKER * (1 + FORCING * xp.exp(-calm / FORCING_DECAY))
    E_f_walk = unknown * walk * walk
    predicted = predict(xp, t, state.tracker, E_f_walk * h)
    u = update(xp, t, predicted, circle)

    tracking = state.tracking > 0
    verdict = xp.cond(
        state.supervision.awake > 0,
        lambda: supervise(xp, state.supervision, u, tracking, circle, t, h, unknown * WALK_BANK * WALK_BANK),
        lambda: rest(xp, state.supervision, u.gaussian, h),
    )
    supervision = xp.cond(
        xp.logical_or(jumped, verdict.again > 0), lambda: started(xp, c, s), lambda: verdict.supervision
    )

    tracker = verdict.tracker
    old, new = predicted.x, tracker.x
    return State(
        tracker=tracker,
        tracking=xp.where(xp.logical_or(tracking, verdict.captured > 0), 1.0, 0.0),
        takeovers=state.takeovers + verdict.takeover,
        innovation=u.innovation,
        turn=xp.atan2(old.d * new.q - old.q * new.d, old.d * new.d + old.q * new.q),
        turn_variance=xp.where(
            tracking,
            turn_variance(t, state.tracker, predicted),
            direction_variance(predicted.x, predicted.P),
        ),
        E_f_walk=E_f_walk,
        calm=calm,
        supervision=supervision,
    )


def rest(xp, before: Supervision, tracker: Gaussian, h) -> Verdict:
    """The bank stays as it is, and nothing is concluded from it; after REST, a new one is due."""
    age = before.age + h
    return Verdict(before._replace(age=age), tracker, 0.0, 0.0, again=xp.where(age >= REST, 1.0, 0.0))


def supervise(xp, before: Supervision, u: Updated, tracking, circle: Circle, t: Transition, h, walk) -> Verdict:
    """The bank over the interval; is one well left, does the bank replace the tracker, and what does it do next?"""
    tracker, age = u.gaussian, before.age + h
    updates = [update(xp, t, predict(xp, t, gaussian, walk * h), circle) for gaussian, _ in before.bank]
    bank = [updated.gaussian for updated in updates]
    likelihoods = [score + updated.log_likelihood for (_, score), updated in zip(before.bank, updates)]
    # (x, E_f) -> (-x, -E_f) is a solution too, and its E_f is below LEAST_E_F
    scores = [xp.where(gaussian.E_f < LEAST_E_F, EXCLUDED, score) for gaussian, score in zip(bank, likelihoods)]
    best, lead = winner(xp, bank, scores)
    tracker_score = before.tracker_score + u.log_likelihood - best
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

    done = xp.logical_and(captured, age > SUPERVISED_AGE)
    again = xp.logical_or(takeover, xp.logical_and(tracking, age >= GREATEST_AGE))
    return Verdict(
        Supervision(
            Bank(*[Hypothesis(gaussian, score - best) for gaussian, score in zip(bank, likelihoods)]),
            tracker_score=tracker_score,
            awake=xp.where(done, 0.0, 1.0),
            age=xp.where(done, 0.0, age),
        ),
        tracker=xp.cond(replaces, lambda: mixed, lambda: tracker),
        captured=xp.where(captured, 1.0, 0.0),
        takeover=xp.where(takeover, 1.0, 0.0),
        again=xp.where(again, 1.0, 0.0),
    )


def winner(xp, bank: List[Gaussian], scores):
    """The best score, and its lead over all hypotheses that are farther than 0.1 |x| from the best one."""
    best, ((d, q), _, _) = scores[0], bank[0]
    for score, ((own_d, own_q), _, _) in zip(scores[1:], bank[1:]):
        better = score > best
        best, d, q = xp.where(better, score, best), xp.where(better, own_d, d), xp.where(better, own_q, q)
    near2 = RIVAL_DISTANCE * RIVAL_DISTANCE * (d * d + q * q)
    rival = EXCLUDED
    for score, ((own_d, own_q), _, _) in zip(scores, bank):
        away_d, away_q = own_d - d, own_q - q
        far = away_d * away_d + away_q * away_q > near2
        rival = xp.where(far, xp.maximum(rival, score), rival)
    return best, best - rival


def mixture(xp, bank: List[Gaussian], scores) -> Gaussian:
    """Mean and covariance of the bank, each hypothesis with the weight e^score; the best score is 0."""
    weights = [xp.exp(xp.maximum(score, LEAST_EXPONENT)) for score in scores]
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
    return Estimate(
        delta=rotor_angle(xp, s, x, near).delta,
        x=x,
        covariance=P,
        E_f=E_f,
        E_f_walk=state.E_f_walk,
        innovation=state.innovation,
        capturing=1 - state.tracking,
        turn=state.turn,
        turn_variance=state.turn_variance,
    )


def outputs(xp, state):
    return Outputs(state.takeovers)
