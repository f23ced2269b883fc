"""The Cramer-Rao bound, against the whole problem at once: every frame's measurements by the start and all voltages."""

import numpy as np
import pytest

from fmu_src.pmu_observer.machines.two_axis import constants
from scenarios.bench import frames
from scenarios.bench.frames import PERIOD
from scenarios.compare import bound, comparison, model

FRAMES = 12


@pytest.fixture(scope="module")
def truth() -> frames.Truth:
    whole = frames.record(frames.RECORD_G6)
    cut = slice(60, 60 + FRAMES + 1)
    return whole._replace(**{name: getattr(whole, name)[cut] for name in whole._fields[1:]})


def test_the_recursion_is_the_batch(truth):
    """Unknown are x at frame 0 and every V; the Jacobian of all phasors and of the last prediction by differences.

    Both have rounding errors of 1e-10, which count a million times where 12 frames hardly tell one state from another.
    """
    c, n = constants(truth.machine), FRAMES

    def outcome(parameters):
        """What is seen at frames 0 to n - 1, in units of its noise, and x at frame n with V held."""
        V = parameters[4::2] + 1j * parameters[5::2]
        x, seen = parameters[:4], []
        for k in range(n):
            z = complex(*model.h(np, x))
            current = (1j * V[k] - z) / c.x
            for phasor, true in ((V[k], truth.V[k]), (current, truth.I[k])):
                seen += [phasor.real / abs(true), phasor.imag / abs(true)]
            last = k == n - 1
            mean = V[k] if last else (V[k] + V[k + 1]) / 2
            u = model.Inputs(truth.P_m[k], truth.E_f[k], abs(mean), np.angle(mean))
            x = np.array(model.f(np, c, x, u, PERIOD))
        return np.sqrt(2) * np.array(seen), x

    # a trajectory of the equations themselves, so that both linearise at the same place
    x, rows = bound.state(truth, 0), []
    for k in range(n + 1):
        rows.append(x)
        mean = (truth.V[k] + truth.V[min(k + 1, n)]) / 2
        x = np.array(model.f(np, c, x, model.Inputs(truth.P_m[k], truth.E_f[k], abs(mean), np.angle(mean)), PERIOD))
    delta, omega, e1d, e1q = np.array(rows).T
    z = np.array([complex(*model.h(np, row)) for row in rows])
    own = truth._replace(delta=delta, omega=omega, e1d=e1d, e1q=e1q, I=(1j * truth.V - z) / c.x)

    at = np.concatenate([bound.state(own, 0), np.stack([own.V[:n].real, own.V[:n].imag], axis=1).ravel()])
    steps = 1e-5 * np.eye(len(at))
    both = [(outcome(at + step), outcome(at - step)) for step in steps]
    seen = np.array([(up[0] - down[0]) / 2e-5 for up, down in both]).T
    ahead = np.array([(up[1] - down[1]) / 2e-5 for up, down in both]).T
    covariance = ahead @ np.linalg.inv(seen.T @ seen) @ ahead.T
    np.testing.assert_allclose(bound.bounds(own)[-1], np.sqrt(np.diag(covariance)), rtol=1e-3)


def test_information_grows(truth):
    """One frame does not tell the states; 12 tell each better than the first ones that do."""
    found = bound.bounds(truth)
    assert np.all(np.isinf(found[0]))
    assert np.all(np.isfinite(found[-1]))
    assert np.all(found[-1] < found[4])


def test_quiet_times_leave_out_the_fault():
    """From 10 s to 10.1 s, and 0.5 s after either; the swings that follow are no events."""
    truth = comparison.smib_fault()
    t = PERIOD * np.arange(1, len(truth.V))
    expected = (t > 5 - 1e-9) & ((t < 10 - 1e-9) | (t > 10.6 - 1e-9))
    differing = t[bound.quiet(truth) != expected]
    assert len(differing) <= 2, differing  # the frames at the limits
