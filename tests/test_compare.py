"""The comparison: its filters are FilterPy's, its model is the machine's, and its table says what the numbers say."""

import json
from io import StringIO

import numpy as np
import pytest
from rich.console import Console
from scipy.integrate import solve_ivp

from fmu_src.pmu_observer.carriers import floats
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.machines.two_axis import constants
from scenarios.bench import frames
from scenarios.compare import batch, comparison, filterpy_filters, model, report, runs, tuning

C = constants(ieee39_g6())
U = model.Inputs(6.5, 2.2, 1.05, 0.1)
X = np.array([0.87, 0.3, 0.55, 1.02])
H = frames.PERIOD


def test_model_is_the_paper_s():
    """Against scipy on eq. (1)-(3) of the paper in its own terms; RK4 with h = 1/60 s and a2 = 12/s is good to 1e-5."""

    def paper(t, x):
        y1, y2, x_ = U.theta, U.V, C.x
        y5 = y2 / x_ * (x[3] * np.sin(x[0] - y1) - x[2] * np.cos(x[0] - y1))
        return [
            x[1],
            -C.a0 * x[1] + C.b0 * (U.P_m - y5),
            -C.a2 * x[2] + C.b2 * y2 * np.sin(x[0] - y1),
            -C.a1 * x[3] + C.b1 * y2 * np.cos(x[0] - y1) + C.c1 * U.E_f,
        ]

    exact = solve_ivp(paper, (0, H), X, rtol=1e-12, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(model.f(floats, C, X.tolist(), U, H), exact, atol=1e-5)


def test_jacobians_are_derivatives():
    """Central differences; F has A at the start of the step: good to h^2/2 dA/dt = 4e-7."""
    steps, h = 1e-6 * np.eye(4), 1e-4
    F = [(np.array(model.f(np, C, X + e, U, h)) - model.f(np, C, X - e, U, h)) / 2e-6 for e in steps]
    np.testing.assert_allclose(model.f_jacobian(C, X, U, h), np.transpose(F), atol=1e-6)
    dh = [(np.array(model.h(np, X + e)) - model.h(np, X - e)) / 2e-6 for e in steps]
    np.testing.assert_allclose(model.h_jacobian(X), np.transpose(dh), atol=1e-9)


@pytest.fixture(scope="module")
def noisy() -> runs.Frames:
    truth = frames.record(frames.RECORD_G6)
    first = 90  # 1.5 s, with the load step
    cut = truth._replace(**{name: getattr(truth, name)[:first] for name in truth._fields[1:]})
    return runs.noisy(cut, (0.001, 0.01), 2, 5)


@pytest.mark.parametrize(
    ("step", "filter_"), [(batch.ekf_step, filterpy_filters.Ekf), (batch.ukf_step, filterpy_filters.Ukf)]
)
def test_batch_is_filterpy(step, filter_, noisy):
    """The same arithmetic in another order: 1e-9 after 89 frames, for every TVE, seed and tuning of the batch."""
    q = tuning.GRID[[0, -1]][:, None, None, :]
    x0, P0 = runs.flat_start(noisy), tuning.P_of(0.1)
    together = runs.run_peer(step, noisy, x0, P0, q, lambda: None)
    truth = noisy.truth
    z, size2 = model.measured(C, noisy.V, noisy.I)
    for tuned, tve, seed in np.ndindex(2, 2, 2):
        Q = runs.process_noise(tuning.GRID[[0, -1][tuned]], noisy.tve[tve, 0])
        one = filter_(C, x0[tve, seed], P0, Q)
        u = [
            model.Inputs(P_m, E_f, abs(V), float(np.angle(V)))
            for P_m, E_f, V in zip(truth.P_m, truth.E_f, noisy.V[:, tve, seed], strict=True)
        ]
        for k in range(len(u) - 2):
            R = np.eye(2) * noisy.tve[tve, 0] ** 2 * size2[k + 1, tve, seed] / 2
            seen = z[k + 1, tve, seed]
            one.step(model.mean(u[k], u[k + 1]), H, np.array([seen.real, seen.imag]), R)
        ahead = model.f(np, C, one.x, u[-2], H)
        assert ahead[1] - truth.omega[-1] == pytest.approx(together.omega[-1, tuned, tve, seed], abs=1e-9)
        e1 = np.hypot(ahead[2] - truth.e1d[-1], ahead[3] - truth.e1q[-1])
        assert e1 == pytest.approx(together.e1[-1, tuned, tve, seed], abs=1e-9)


def test_the_observer_gets_the_peers_frames(noisy):
    """At a TVE of 0.1 % both are right to a few times the noise after 1 s, on frames that only they share."""
    ours = runs.run_observer("robust", noisy, lambda: None)
    peer = runs.run_peer(
        batch.ekf_step, noisy, runs.good_start(noisy), tuning.P_of(tuning.P_GOOD), tuning.GRID[60], lambda: None
    )
    for e in (ours, peer):
        assert e.e1.shape == (89, 2, 2)
        assert e.e1[60:, 0].max() < 0.005


def test_since():
    t = np.arange(1.0, 5.0)
    holds = np.array([[1, 0, 0, 1], [1, 1, 0, 0], [1, 0, 1, 1], [1, 1, 1, 0]], bool)
    np.testing.assert_array_equal(comparison.since(t, holds), [1.0, 4.0, 3.0, np.inf])


def summary(name, start, error, captured):
    n = len(comparison.TVES)
    values = [np.full(n, value) for value in (error, error, error, captured, captured, 1.0)]
    return comparison.Summary(name, start, *values, course=np.full((3, n), error))


def test_the_table_says_who_wins(tmp_path):
    found = comparison.Comparison(
        "A record",
        t=np.arange(1.0, 4.0),
        summaries=[
            summary("robust", "none", 2e-3, 0.1),
            summary("EKF", "good", 1e-3, 0.0),
            summary("EKF", "flat", 4e-3, 0.5),
            summary("UKF", "bad", 1.0, np.nan),
        ],
        tunings={"EKF": (tuning.GRID[:5][:, None, :], np.ones(5))},
    )
    costs = {"robust": 2e-4, "EKF": 1e-4, "UKF": 3e-4}
    by_quantity = {v.quantity: v for v in report.verdicts(found, costs)}
    assert by_quantity["RMS of delta, TVE 1.0%"].winner == "EKF, good"
    assert by_quantity["RMS of delta, TVE 1.0%"].ratio == pytest.approx(2.0)
    assert by_quantity["below 0.1 pu, flat start, TVE 0.1%"].winner == "robust"
    assert by_quantity["below 0.1 pu, bad start, TVE 0.1%"].of == "none ever"
    assert by_quantity["one step in Python"].winner == "EKF"

    console = Console(width=100, file=StringIO(), record=True)
    report.print_table(console, found, costs, 100)
    report.print_verdicts(console, report.verdicts(found, costs))
    report.print_costs(console, costs)
    text = console.export_text()
    assert "…" not in text
    assert "*1" in next(line for line in text.splitlines() if line.startswith("EKF, good"))

    report.write(found, costs, 100, tmp_path)
    assert json.loads((tmp_path / "summary.json").read_text())["verdicts"][0]["winner"] == "EKF, good"
    assert len((tmp_path / "table.csv").read_text().splitlines()) == 2 + 4 * len(comparison.TVES)
    assert {path.name for path in tmp_path.glob("*.png")} == {"capture.png", "steady.png"}
