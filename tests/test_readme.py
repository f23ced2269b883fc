"""The README says what the code does: its tables are generated, its commands are the ones that CI runs."""

import re
import shutil
from pathlib import Path

import pytest

import build_fmu
from fmu_src.runtime import readme
from scenarios import readme as results


def test_interface_tables_are_up_to_date(tmp_path):
    """Else: python build_fmu.py --readme."""
    copy = Path(shutil.copy(build_fmu.INTERFACES, tmp_path))
    assert not readme.update(copy, [model for _, model in build_fmu.all_models().values()])


def test_the_first_two_sh_blocks_are_one_command_each():
    """The first runs the main job, the second the tests; .ci/run takes the second from here."""
    blocks = re.findall(
        r"^```sh\n(.*?)^```$", (build_fmu.ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
    main_job, tests = blocks[:2]
    assert main_job.count("\n") == tests.count("\n") == 1
    assert "python -m scenarios run" in main_job
    assert "python -m pytest" in tests


@pytest.mark.parametrize(
    ("sweeps", "text"),
    [
        ([{}], ""),
        ([{"unit": unit} for unit in range(1, 11)], "unit = 1 to 10"),
        ([{"gamma": 1e15}, {"gamma": 1e16}, {"gamma": 1e15}], "gamma = 1e15, 1e16"),
        ([{"seed": seed, "E_f": E_f} for seed in (1, 2) for E_f in ("known", "not")], "seed = 1, 2; E_f = known, not"),
        ([{"seed": 1, "E_f": "known"}, {"seed": 2, "E_f": "not"}], "seed = 1, E_f = known<br>seed = 2, E_f = not"),
        ([{"seed": 1}, {}], "seed = 1<br>"),
    ],
)
def test_sweeps_in_the_table_of_results(sweeps, text):
    assert results.sweeps_text(sweeps) == text
