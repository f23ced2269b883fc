"""The fit finds the data with which the project's SMIB plant made a fault record, from a data sheet that is wrong."""

import numpy as np

from fmu_src.pmu_observer.carriers import arrays
from fmu_src.pmu_observer.machines.data import ieee39_g6
from fmu_src.pmu_observer.plants import smib
from scenarios.calibration import fit, model, parameters, prepare

WRONG = {"xd": 0.9, "xd1": 1.15, "xq": 1.12, "xq1": 0.88, "Td10": 1.1, "Tq10": 0.85, "H": 1.1}


def test_wrong_data_are_corrected():
    m = ieee39_g6()
    p = smib.Parameters(
        machine=m, x_line=0.03, start_mode=smib.P_M_V_T, V_t_start=1.05, t_fault=2.005, t_clear=2.105, x_fault=0.03
    )
    u = smib.Inputs(P_m=6.5)
    _, out = smib.start(arrays, p, u, 0.0)
    u = u._replace(E_f=out.E_f_start)
    state, out = smib.start(arrays, p, u, 0.0)
    rows = [out.frame]
    for k in range(480):
        for i in range(8):
            state, out = smib.step(arrays, p, state, u, k / 60 + i / 480, 1 / 480)
        rows.append(out.frame)
    f = np.array(rows, dtype=float)
    tve, rng = 0.003, np.random.default_rng(1)
    n = (rng.standard_normal((2, len(f))) + 1j * rng.standard_normal((2, len(f)))) / np.sqrt(2)
    V, I = f[:, 0] * np.exp(1j * f[:, 1]), f[:, 2] * np.exp(1j * f[:, 3])  # noqa: E741 - the paper's name
    every = np.ones(len(f))
    record = prepare.prepare(
        prepare.Record(np.arange(len(f)) / 60, V * (1 + tve * n[0]), I * (1 + tve * n[1]), u.E_f * every, 6.5 * every)
    )
    assert abs(record.tve / tve - 1) < 0.15
    right = model.Machine(m.H, m.D, m.xd, m.xd1, m.xq, m.xq1, m.Td10, m.Tq10, m.Ra, m.omega_s)
    sheet = right._replace(**{name: factor * getattr(right, name) for name, factor in WRONG.items()})
    names = parameters.NAMES["two_axis"]
    problem = fit.Problem("two_axis", parameters.free("two_axis", sheet, names, 0.15), (record,), None, record.tve)
    found = fit.fit(problem)
    deviation = np.sqrt(np.diag(found.covariance))
    for i, (name, factor) in enumerate((n, WRONG[n]) for n in names if n in WRONG):
        assert abs(found.u[i] + np.log(factor)) < 3.5 * deviation[i], name  # 3.5 sigma: one in 2000 a parameter
    assert deviation[names.index("xd1")] < 0.05 and deviation[names.index("H")] < 0.05
    counted = 2 * record.good.sum()
    assert abs(np.sum(found.residuals[0] ** 2) / counted - 1) < 0.15  # 3 sigma of chi-square is 0.14
