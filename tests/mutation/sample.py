"""python -m tests.mutation.sample [FILE ...]: random changes of the observer, and does a test notice?

Every mutant is one change that cosmic-ray's operators make (another arithmetic or comparison operator, a number one
more or less, a negation) at a random place of the observer's files. It runs against the short list of tests of its
file, fastest first, in a process of its own that starts with the libraries already loaded. The tests of every list are
run without a mutant first. Exit code 1 if fewer than --least of the mutants are killed.
"""

import argparse
import contextlib
import importlib
import json
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import pytest
from cosmic_ray import mutating, plugins
from cosmic_ray.ast import ast_nodes, get_ast_from_path
from rich.console import Console
from rich.progress import Progress

from .mechanisms import COPIED, PACKAGE, ROOT

FILES = ("gating.py", "observer.py", "prediction.py", "estimators/*.py", "speed/*.py")

PAIRS = [(a, b) for group in (("Add", "Sub", "Mul", "Div"), ("Lt", "LtE", "Gt", "GtE")) for a in group for b in group]
OPERATORS = [
    *[f"core/ReplaceBinaryOperator_{a}_{b}" for a, b in PAIRS[:16] if a != b],
    *[f"core/ReplaceComparisonOperator_{a}_{b}" for a, b in PAIRS[16:] if a != b],
    "core/ReplaceComparisonOperator_Eq_NotEq",
    "core/ReplaceComparisonOperator_NotEq_Eq",
    "core/ReplaceUnaryOperator_Delete_USub",
    "core/ReplaceUnaryOperator_Delete_Not",
    "core/AddNot",
    "core/NumberReplacer",
]
"""Not among them: operators that raise on floats (shifts, bits). Any test kills these; they would swell the score."""

EQUATIONS, ROBUST = "tests/equations/test_", "tests/test_robust.py::test_"
TIME, BAD = f"{EQUATIONS}frame_time.py::test_", f"{EQUATIONS}bad_frames.py::test_"
NOISY = [
    f"{ROBUST}{name}"
    for name in (
        "single_bad_frames_are_held_over_and_flagged",
        "record_g6",
        "a_fault_does_not_shake_the_rotor",
        "standard_deviations_are_honest",
        "random_machines_are_captured",
        "random_angles_leave_no_alias_in_the_speed",
        "a_gap_is_survived",
    )
]
TESTS = {
    "gating.py": [
        f"{EQUATIONS}gating.py",
        f"{TIME}what_is_not_used_may_be_missing",
        f"{TIME}a_missing_machine_input_is_the_last_one_and_marked",
        f"{TIME}frames_out_of_order_change_nothing",
        f"{TIME}no_frame_for_longer_than_one_and_a_half_periods",
        f"{TIME}the_frame_period_is_learnt",
        f"{TIME}a_stamp_of_another_clock_is_no_frame",
        f"{TIME}nor_does_it_with_any_speed_observer",
        f"{BAD}an_idle_machine_is_usable",
        *NOISY,
        f"{TIME}a_clock_step_heals_although_the_frames_stay_the_same",
        "tests/test_what_is_wrong_shows.py::test_it_shows",
    ],
    "observer.py": [
        f"{EQUATIONS}steps.py",
        f"{EQUATIONS}proposition_2.py",
        f"{TIME}nor_does_it_with_any_speed_observer",
        f"{TIME}what_is_not_used_may_be_missing",
        f"{TIME}up_to_nearly_half_a_turn_a_frame",
        *NOISY,
        "tests/test_what_is_wrong_shows.py",
    ],
    "prediction.py": [
        f"{EQUATIONS}prediction.py",
        f"{EQUATIONS}proposition_2.py",
        f"{TIME}a_latency_costs_the_prediction_over_it_and_no_more",
        f"{TIME}nor_does_it_with_any_speed_observer",
        *NOISY,
        "tests/test_what_is_wrong_shows.py",
    ],
    "estimators/robust.py": [
        f"{EQUATIONS}supervision.py",
        f"{ROBUST}the_bank_rests_and_wakes_afresh",
        *NOISY,
        f"{ROBUST}a_wrong_well_is_left",
        f"{ROBUST}record_g6_without_field_voltage",
    ],
    "estimators": [
        f"{EQUATIONS}mixing.py",
        f"{EQUATIONS}third_order.py",
        f"{EQUATIONS}estimators.py",
        f"{EQUATIONS}proposition_2.py",
        f"{EQUATIONS}ranges.py",
    ],
    "speed": [
        f"{EQUATIONS}rotor.py",
        f"{EQUATIONS}speed_filter.py",
        f"{ROBUST}motion_is_the_matrix_exponential",
        f"{ROBUST}speed_filter_is_a_dense_kalman_filter",
        f"{EQUATIONS}speed.py",
        f"{EQUATIONS}proposition_2.py",
        f"{TIME}no_frame_for_longer_than_one_and_a_half_periods",
        *NOISY,
    ],
}
"""By file, or by its folder."""

LIBRARIES = (
    "casadi",
    "fmpy",
    "hypothesis",
    "matplotlib.pyplot",
    "numpy",
    "pydantic",
    "scipy.integrate",
    "scipy.linalg",
)
"""What the tests import: loaded once."""

LIMIT = 300
"""s of CPU time; the tests take a tenth of it, and a mutant that takes longer is killed by that."""


class Mutant(NamedTuple):
    file: str  # in the package
    operator: str
    occurrence: int  # of the operator in the file
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line} {self.operator.removeprefix('core/')} {self.occurrence}"


def all_mutants(patterns) -> list[Mutant]:
    """Every mutant of the files, in a fixed order."""
    found = []
    for file in (path for pattern in patterns for path in sorted((ROOT / PACKAGE).glob(pattern))):
        nodes = list(ast_nodes(get_ast_from_path(file)))
        for name in OPERATORS:
            operator = plugins.get_operator(name)()
            places = [place for node in nodes for place in operator.mutation_positions(node)]
            relative = file.relative_to(ROOT / PACKAGE).as_posix()
            found += [Mutant(relative, name, k, start[0]) for k, (start, _) in enumerate(places)]
    return found


def of_tests(file: str) -> str:
    """The key of its list in TESTS."""
    return file if file in TESTS else file.partition("/")[0]


def changed(mutant: Mutant, text: str) -> str:
    """The file's text with the mutant in it."""
    new = mutating.mutate_code(text, plugins.get_operator(mutant.operator)(), mutant.occurrence)
    assert new is not None, f"there is no {mutant}"
    return new


def copy_of_the_checkout(folder: Path) -> None:
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "*.png", "*.svg"))
        else:
            shutil.copy(ROOT / name, folder / name)


def started(folder: Path, file: str, text: str) -> int:
    """The process that tests that text in place of the file, in a copy of the checkout."""
    (folder / PACKAGE / file).write_text(text, encoding="utf-8")
    child = os.fork()
    if child == 0:
        in_child(folder, TESTS[of_tests(file)])
    return child


def outcome(status: int) -> str:
    """`survived`, `killed` by a test, or `timeout`, from the status that a process ended with."""
    if os.WIFSIGNALED(status):
        return "timeout" if os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL) else "killed"
    return "survived" if os.WEXITSTATUS(status) == 0 else "killed"


def in_child(folder: Path, tests: list[str]) -> None:
    """Run the tests there, and end with pytest's exit code."""
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT + 10))
    code = 1
    try:
        os.chdir(folder)
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, 1)
        os.dup2(silence, 2)
        for name in [
            name for name in sys.modules if name.split(".")[0] in ("fmu_src", "scenarios", "tests", "build_fmu")
        ]:
            del sys.modules[name]
        sys.path[:] = [str(folder), *[entry for entry in sys.path if Path(entry or ".").resolve() != ROOT]]
        sys.dont_write_bytecode = True
        code = int(pytest.main(["-q", "-x", "-n", "0", "-p", "no:cacheprovider", *tests]))
    except BaseException:
        code = 1
    finally:
        os._exit(code)


def run(mutants: list[Mutant], workers: int, console: Console) -> dict[Mutant, str]:
    """What becomes of each. Raises RuntimeError if the tests fail without any mutant."""
    for name in LIBRARIES:
        importlib.import_module(name)
    files = {of_tests(mutant.file): mutant.file for mutant in mutants}.values()
    waiting: list[tuple[str, Mutant | None]] = [*((file, None) for file in files), *((m.file, m) for m in mutants)]
    running: dict[int, tuple[Path, str, Mutant | None]] = {}
    found = {}
    with contextlib.ExitStack() as stack:
        free = [Path(stack.enter_context(tempfile.TemporaryDirectory())).resolve() for _ in range(workers)]
        for folder in free:
            copy_of_the_checkout(folder)
        texts = {mutant.file: (free[0] / PACKAGE / mutant.file).read_text(encoding="utf-8") for mutant in mutants}
        progress = stack.enter_context(Progress(console=console, transient=True, auto_refresh=False))
        task = progress.add_task("mutants", total=len(waiting))
        while waiting or running:
            while waiting and free:
                (file, mutant), folder = waiting.pop(0), free.pop()
                child = started(folder, file, changed(mutant, texts[file]) if mutant else texts[file])
                running[child] = folder, file, mutant
            child, status = os.wait()
            folder, file, mutant = running.pop(child)
            (folder / PACKAGE / file).write_text(texts[file], encoding="utf-8")
            free.append(folder)
            result = outcome(status)
            if mutant is None and result != "survived":
                raise RuntimeError(f"the tests of {file} fail without a mutant: {' '.join(TESTS[of_tests(file)])}")
            if mutant is not None:
                found[mutant] = result
                if result == "survived":
                    console.print(f"survived  {mutant}", highlight=False)
            progress.advance(task)
            progress.refresh()
    return found


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutation.sample",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    about = f"in {PACKAGE}, as a pattern (default: {' '.join(FILES)})"
    parser.add_argument("files", nargs="*", metavar="FILE", default=FILES, help=about)
    parser.add_argument("--mutants", type=int, default=300, help="how many, drawn at random (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default: %(default)s)")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="at once (default: %(default)s)")
    parser.add_argument("--least", type=float, default=0.85, help="share to be killed (default: %(default)s)")
    parser.add_argument("--out", type=Path, help="write the outcome of every mutant into this JSON file")
    arguments = parser.parse_args()
    possible = all_mutants(arguments.files)
    if not possible:
        parser.error(f"there is nothing to change in {' '.join(arguments.files)}; give files of {PACKAGE}")
    mutants = random.Random(arguments.seed).sample(possible, min(arguments.mutants, len(possible)))
    console = Console()
    try:
        found = run(mutants, arguments.workers, console)
    except RuntimeError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    survivors = [mutant for mutant, result in found.items() if result == "survived"]
    share = 1 - len(survivors) / len(found)
    console.print(
        f"{len(found) - len(survivors)} of {len(found)} killed ({share:.1%}), "
        f"{list(found.values()).count('timeout')} of them by time; "
        f"drawn from {len(possible)} with seed {arguments.seed}"
    )
    if arguments.out:
        rows = [{**mutant._asdict(), "outcome": result} for mutant, result in found.items()]
        arguments.out.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return 0 if share >= arguments.least else 1


if __name__ == "__main__":
    sys.exit(main())
