"""The README says what the code does: its tables are generated, its commands are the ones that CI runs."""

import re
import shutil
from pathlib import Path

import build_fmu
from fmu_src.runtime import readme


def test_interface_tables_are_up_to_date(tmp_path):
    """Else: python build_fmu.py --readme."""
    copy = Path(shutil.copy(build_fmu.README, tmp_path))
    assert not readme.update(copy, [model for _, model in build_fmu.all_models().values()])


def test_the_first_two_sh_blocks_are_one_command_each():
    """The first runs the main job, the second the tests; .ci/run takes the second from here."""
    blocks = re.findall(r"^```sh\n(.*?)^```$", build_fmu.README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    main_job, tests = blocks[:2]
    assert main_job.count("\n") == tests.count("\n") == 1
    assert "python -m scenarios run" in main_job
    assert "python -m pytest" in tests
