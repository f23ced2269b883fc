"""The standard record: what is written is what is read, and a bad frame holds no numbers."""

import numpy as np

from scenarios.records import standard
from scenarios.records.standard import Facts


def test_numbers_of_a_frame_that_is_not_valid_are_not_used(tmp_path):
    text = "time,frame_valid,V_t,theta_t,I_t,phi_t\n0,1,1,0,1,0\n0.02,0,99,9,99,9\n0.04,1,nan,0,1,0\n0.06,1,1,0,1,0\n"
    (tmp_path / "a.csv").write_text(text)
    record = standard.read(tmp_path / "a.csv")
    assert record.frame_valid.tolist() == [True, False, False, True]
    for name in ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t"):
        assert np.isnan(getattr(record, name)).tolist() == [False, True, True, False]
    assert not record.has("P_m") and not record.has("E_f")


def test_what_is_written_is_what_is_read(tmp_path):
    rng = np.random.default_rng(1)
    columns = {name: rng.normal(size=50) for name in standard.VALUES}
    facts = Facts(
        S_base=250.0, rate=50.0, f0=50.0, V_base=15.75, utc_start="2024-07-01T10:00:00.020000000Z", source="a"
    )
    record = standard.assemble({"time": np.arange(50) / 50, **columns}, facts)
    standard.write(record, tmp_path / "a.csv")
    back = standard.read(tmp_path / "a.csv")
    assert back.facts == facts and back.rate == 50.0
    for name in standard.COLUMNS:
        np.testing.assert_allclose(getattr(back, name), getattr(record, name), atol=5.1e-11)
