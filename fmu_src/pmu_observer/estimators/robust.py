"""A bank of Kalman filters, weighted by likelihood, and the one filter that tracks: for frames with noise.

Lemmas 1 and 2, for any machine model (see `machines.axes`): given the frames, the machine's states z move linearly,
and of f, the rotor's view of the measured voltage F, |f| = sqrt(Y1) is known at once; only its direction is not, on the
half circle f_q > 0. So 24 filters start there and their likelihoods decide: seen through noise the problem has up to
four wells, and no single filter leaves a wrong one. Once one well has won, its mixture becomes the tracker. The bank,
started again and again, is the tracker's supervisor: where its best explains the same window of frames far better, it
takes over.

There is no gain to choose: `tve`, the assumed noise of the phasors, settles everything.
"""

from collections import namedtuple
from math import cos, pi, sin
from typing import Annotated, Any, NamedTuple, Tuple

from .. import noise
from ..angle import Covariance, Estimate, direction_variance, rotor_angle
from ..gaussian import (
    Circle,
    Gaussian,
    Updated,
    circle_of,
    flux,
    flux_covariance,
    innovation,
    log_likelihood,
    predict,
    turn_variance,
    update,
)
from ..interface import Integer, Scalar
from ..linear import Vector
from ..matrix import apply, dot, outer, product, transposed
from ..transition import Transition

SIZE = 24
"""Hypotheses; 8 capture a wrong well in 4 % of random machines, 24 in less than 0.1 %."""

WALK_TRACKER, WALK_BANK = 0.1, 0.02
"""pu/sqrt(s): how an estimated E_f changes."""

FORCING, FORCING_DECAY = 20.0, 1.0
"""A jump of the network sets exciters going: WALK_TRACKER is 1 + 20 e^(-t/1 s) times as large t after it."""

SUPERVISED_AGE, GREATEST_AGE, REST = 0.25, 5.0, 0.75
"""s: the end of a supervision once captured, and in any case; the rest before the next one."""

CAPTURE_SPREAD, RIVAL_DISTANCE, RIVAL_LEAD = 0.03, 0.1, 12.5
"""Captured: the mixture's standard deviation is below 0.03 |F|, and the best hypothesis leads all that are farther
from it than 0.1 |F| by 12.5 in log-likelihood."""

LEAST_E_F, EXCLUDED = -0.5, -1e6
"""pu: no machine in operation has a lower field voltage; and the log-likelihood of what is no candidate."""

LEAST_EXPONENT = -700.0
"""e to the power of less is not a normal number."""

TAKEOVER_LEAD, TAKEOVER_DISTANCE, TAKEOVER_MAHALANOBIS2 = 25.0, 0.05, 25.0
"""The bank replaces the tracker: it leads by 25 in log-likelihood and is farther off than 0.05 |F| and than 5 standard
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

DIRECTIONS = tuple([Vector(cos((k + 0.5) * pi / SIZE), sin((k + 0.5) * pi / SIZE)) for k in range(SIZE)])


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
    flux: Vector  # the tracker's f, pu,
    covariance: Covariance  # and its covariance
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
    mixed = mixture(xp, supervision.bank)
    C = s.form.C
    return State(
        tracker=mixed,
        flux=flux(c, C, mixed.x),
        covariance=flux_covariance(c, C, mixed),
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


class First(NamedTuple):
    """What a frame says of the bank's start."""

    r: Scalar  # pu, |f|
    radial: Scalar  # pu^2, its variance
    rest: Any  # z = rest f while the damper windings are at rest
    field: Any  # E_f = field z while E'q is at rest
    E_f: Scalar  # pu, measured
    E_f_known: Scalar


def fresh(xp, c, s):
    """The bank at its start: directions (k + 1/2) pi/24, with the standard deviation of a uniform one over pi/24.

    Damper windings are at rest but for OFF_REST. E_f, if it is to be estimated: what keeps E'q at rest, with a standard
    deviation of 1 pu.
    """
    form, (_, R) = s.form, noise.of_Y1(s)
    field = tuple([-a / form.e[-1] for a in form.A[-1]])
    common = First(xp.sqrt(s.Y1), R / (4 * s.Y1), form.rest, field, s.measured.E_f, s.measured.E_f_known)
    stator = 0, c.model.D_STATES

    def hypothesis(direction: Vector, first: First) -> Hypothesis:
        d, q = direction
        z = apply(first.rest, (first.r * d, first.r * q))
        known = first.E_f_known > 0
        at_rest = xp.minimum(xp.maximum(dot(first.field, z), 0.0), HIGHEST_E_F)
        tangential = first.r * first.r * (pi / SIZE) * (pi / SIZE) / 12
        across = tangential - first.radial
        P = (
            (first.radial + across * q * q, -across * d * q),
            (-across * d * q, first.radial + across * d * d),
        )
        of_z = product(product(first.rest, P), transposed(first.rest))
        n, covariance = len(z), []
        for i in range(n):
            for j in range(i, n):
                covariance.append(of_z[i][j] + (OFF_REST * OFF_REST if i == j and i not in stator else 0.0))
            covariance.append(0.0)
        covariance.append(xp.where(known, 0.0, 1.0))
        return Hypothesis(Gaussian((*z, xp.where(known, first.E_f, at_rest)), tuple(covariance)), 0.0)

    return Bank(*xp.map(hypothesis, DIRECTIONS, common))


OFF_REST, HIGHEST_E_F = 0.05, 3.0
"""pu; of the states that the stator does not see, at the start; and the highest field voltage to start from."""


def step(xp, p, c, state, interval):
    s, h, nu, t = interval.after, interval.h, interval.jump.nu, interval.flow
    jumped = nu.re * nu.re + nu.im * nu.im > 0
    calm = xp.where(jumped, 0.0, state.calm + h)
    circle = circle_of(s)
    unknown = xp.where(s.measured.E_f_known > 0, 0.0, 1.0)

    walk = WALK_TRACKER * (1 + FORCING * xp.exp(-calm / FORCING_DECAY))
    E_f_walk = unknown * walk * walk
    predicted = predict(xp, c, t, state.tracker, E_f_walk * h)
    u = update(xp, c, t, predicted, circle)

    tracking = state.tracking > 0
    verdict = xp.cond(
        state.supervision.awake > 0,
        lambda: supervise(xp, c, state.supervision, u, tracking, circle, t, h, unknown * WALK_BANK * WALK_BANK),
        lambda: rest(xp, state.supervision, u.gaussian, h),
    )
    supervision = xp.cond(
        xp.logical_or(jumped, verdict.again > 0), lambda: started(xp, c, s), lambda: verdict.supervision
    )

    tracker = verdict.tracker
    old, new = flux(c, t.C, predicted.x), flux(c, t.C, tracker.x)
    return State(
        tracker=tracker,
        flux=new,
        covariance=flux_covariance(c, t.C, tracker),
        tracking=xp.where(xp.logical_or(tracking, verdict.captured > 0), 1.0, 0.0),
        takeovers=state.takeovers + verdict.takeover,
        innovation=innovation(xp, u),
        turn=xp.atan2(old.d * new.q - old.q * new.d, old.d * new.d + old.q * new.q),
        turn_variance=xp.where(
            tracking,
            turn_variance(c, t, state.tracker, predicted),
            direction_variance(old, flux_covariance(c, t.C, predicted)),
        ),
        E_f_walk=E_f_walk,
        calm=calm,
        supervision=supervision,
    )


def rest(xp, before: Supervision, tracker: Gaussian, h) -> Verdict:
    """The bank stays as it is, and nothing is concluded from it; after REST, a new one is due."""
    age = before.age + h
    return Verdict(before._replace(age=age), tracker, 0.0, 0.0, again=xp.where(age >= REST, 1.0, 0.0))


class Frame(NamedTuple):
    """What an interval and the frame that ends it do to every hypothesis."""

    transition: Transition
    circle: Circle
    walk: Scalar  # pu^2, the variance that E_f gains


class Scored(NamedTuple):
    """A hypothesis with the frame."""

    gaussian: Gaussian
    flux: Vector  # pu
    score: Scalar  # log-likelihood of the window
    ranked: Scalar  # the same, or EXCLUDED


def supervise(xp, c, before: Supervision, u: Updated, tracking, circle: Circle, t: Transition, h, walk) -> Verdict:
    """The bank over the interval; is one well left, does the bank replace the tracker, and what does it do next?"""
    tracker, age = u.gaussian, before.age + h

    def moved(hypothesis: Hypothesis, frame: Frame) -> Updated:
        t = frame.transition
        return update(xp, c, t, predict(xp, c, t, hypothesis.gaussian, frame.walk), frame.circle)

    def scored(item: Tuple[Any, Updated], C) -> Scored:
        score, updated = item
        own = score + log_likelihood(xp, updated)
        # (z, E_f) -> (-z, -E_f) is a solution too, and its E_f is below LEAST_E_F
        x = updated.gaussian.x
        return Scored(updated.gaussian, flux(c, C, x), own, xp.where(x[-1] < LEAST_E_F, EXCLUDED, own))

    updates = xp.map(moved, before.bank, Frame(t, circle, walk * h))
    bank = xp.map(scored, tuple([(item.score, updated) for item, updated in zip(before.bank, updates)]), t.C)
    best, lead = winner(xp, bank)
    tracker_score = before.tracker_score + log_likelihood(xp, u) - best
    alone = lead > RIVAL_LEAD
    mixed = xp.cond(
        xp.logical_or(xp.logical_not(tracking), alone),
        lambda: mixture(xp, tuple([Hypothesis(b.gaussian, b.ranked - best) for b in bank])),
        lambda: tracker,  # nothing comes of the bank yet
    )

    of_mixed = flux_covariance(c, t.C, mixed)
    captured = xp.logical_and(alone, of_mixed.dd + of_mixed.qq < CAPTURE_SPREAD * CAPTURE_SPREAD * circle.Y1)
    ahead = xp.logical_and(captured, tracker_score < -TAKEOVER_LEAD)
    takeover = xp.logical_and(tracking, xp.logical_and(ahead, contradict(xp, c, t, tracker, mixed, circle.Y1)))
    replaces = xp.logical_or(xp.logical_not(tracking), takeover)

    done = xp.logical_and(captured, age > SUPERVISED_AGE)
    again = xp.logical_or(takeover, xp.logical_and(tracking, age >= GREATEST_AGE))
    return Verdict(
        Supervision(
            Bank(*[Hypothesis(b.gaussian, b.score - best) for b in bank]),
            tracker_score=tracker_score,
            awake=xp.where(done, 0.0, 1.0),
            age=xp.where(done, 0.0, age),
        ),
        tracker=xp.cond(replaces, lambda: mixed, lambda: tracker),
        captured=xp.where(captured, 1.0, 0.0),
        takeover=xp.where(takeover, 1.0, 0.0),
        again=xp.where(again, 1.0, 0.0),
    )


class Best(NamedTuple):
    score: Scalar
    flux: Vector


def winner(xp, bank):
    """The best score, and its lead over all hypotheses that are farther than 0.1 |f| from the best one."""

    def better_of(best: Best, item: Scored, _) -> Best:
        better = item.ranked > best.score
        d, q = [xp.where(better, new, old) for new, old in zip(item.flux, best.flux)]
        return Best(xp.where(better, item.ranked, best.score), Vector(d, q))

    def best_rival(rival, item: Scored, best: Vector):
        d, q = item.flux.d - best.d, item.flux.q - best.q
        far = d * d + q * q > RIVAL_DISTANCE * RIVAL_DISTANCE * (best.d * best.d + best.q * best.q)
        return xp.where(far, xp.maximum(rival, item.ranked), rival)

    best = xp.fold(better_of, Best(bank[0].ranked, bank[0].flux), bank[1:])
    return best.score, best.score - xp.fold(best_rival, EXCLUDED, bank, best.flux)


def mixture(xp, bank) -> Gaussian:
    """Mean and covariance of the bank, each hypothesis with the weight e^score; the best score is 0."""
    size = len(bank[0].gaussian.x)
    weights = xp.map(lambda item, _: xp.exp(xp.maximum(item.score, LEAST_EXPONENT)), bank)
    weighted = tuple(zip(weights, [item.gaussian for item in bank]))

    def summed(sums, item, _):
        weight, (x, _P) = item
        total, of_x = sums
        return total + weight, tuple([s + weight * y for s, y in zip(of_x, x)])

    def spread(sums, item, mean):
        weight, (x, P) = item
        return tuple([s + weight * (p + o) for s, p, o in zip(sums, P, outer([y - m for y, m in zip(x, mean)]))])

    total, of_x = xp.fold(summed, (0.0, (0.0,) * size), weighted)
    mean = tuple([s / total for s in of_x])
    P = xp.fold(spread, (0.0,) * (size * (size + 1) // 2), weighted, mean)
    return Gaussian(mean, tuple([s / total for s in P]))


def contradict(xp, c, t: Transition, tracker: Gaussian, mixed: Gaussian, Y1):
    """The two are far apart, and not within what their covariances allow for."""
    one, other = flux(c, t.C, tracker.x), flux(c, t.C, mixed.x)
    d, q = one.d - other.d, one.q - other.q
    P, M = flux_covariance(c, t.C, tracker), flux_covariance(c, t.C, mixed)
    dd, dq, qq = P.dd + M.dd, P.dq + M.dq, P.qq + M.qq
    apart2 = qq * d * d - 2 * dq * d * q + dd * q * q  # Mahalanobis distance squared, times the determinant
    far = d * d + q * q > TAKEOVER_DISTANCE * TAKEOVER_DISTANCE * Y1
    return xp.logical_and(far, apart2 > TAKEOVER_MAHALANOBIS2 * (dd * qq - dq * dq))


def estimate(xp, state, s, near):
    return Estimate(
        delta=rotor_angle(xp, s, state.flux, near).delta,
        x=state.flux,
        covariance=state.covariance,
        gaussian=state.tracker,
        E_f=state.tracker.x[-1],
        E_f_walk=state.E_f_walk,
        innovation=state.innovation,
        capturing=1 - state.tracking,
        turn=state.turn,
        turn_variance=state.turn_variance,
    )


def outputs(xp, state):
    return Outputs(state.takeovers)
