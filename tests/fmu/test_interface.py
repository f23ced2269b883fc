"""The FMUs as an importer sees them: files, variables, units. The contract of names is written out, not computed."""

import re
import zipfile

import pytest
from casadi import SX, jacobian_sparsity, vertcat
from fmpy import read_model_description
from fmpy.validation import validate_fmu

import build_fmu
from fmu_src.pmu_observer import tree
from fmu_src.pmu_observer.carriers import symbols

FRAME = ["V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t"]
MACHINE = ["H", "D", "xd", "xd1", "xq", "xq1", "Td10", "Tq10", "Ra", "omega_s"]
STATES = ["delta", "load_angle", "omega", "e1d", "e1q"]

CONTRACT = {
    "PmuObserver": {
        "input": [*FRAME, "P_m", "E_f", "frame_valid"],
        "parameter": [
            *MACHINE,
            *("estimator", "drem.gamma", "drem.d2", "drem.d3", "drem.d4", "drem.d5"),
            *("overparameterised.Gamma", "gradient.Gamma", "k_speed", "frame_period", "power_source"),
            *("tve", "S_base", "S_n", "field_voltage", "mechanical_power", "speed_observer"),
        ],
        "output": [
            *STATES,
            *("drem.theta1", "drem.theta2", "drem.Delta", "drem.int_Delta2", "status"),
            *(f"overparameterised.Theta{i}" for i in range(1, 6)),
            *("delta_std", "omega_std", "e1d_std", "e1q_std", "innovation"),
            *("E_f_hat", "P_m_hat", "E_f_std", "P_m_std"),
        ],
    },
    "SmibPlant": {
        "input": ["P_m", "E_f", "V_inf", "theta_inf", "f_inf"],
        "parameter": [
            *MACHINE,
            *("x_line", "delta_start", "omega_start", "e1d_start", "e1q_start", "start_mode", "V_t_start"),
            *("t_fault", "t_clear", "x_fault"),
        ],
        "output": [*FRAME, *STATES],
    },
    "Ieee39Plant": {
        "input": [],
        "parameter": [
            *("governors", "pss", "salient", "load_sigma", "load_tau", "seed"),
            *("step_bus", "step_P", "step_Q", "t_step", "t_step_end", "fault_bus", "x_fault", "t_fault", "t_clear"),
            *("trip_from", "trip_to", "t_trip"),
        ],
        "output": [
            *(f"G{k}.{name}" for k in range(1, 11) for name in (*FRAME, *STATES, "P_m", "E_f")),
            *(f"bus{n}.{name}" for n in range(1, 40) for name in ("V", "theta")),
        ],
    },
    "PmuChannel": {
        "input": [f"plant.{name}" for name in ("V_t", "theta_t", "I_t", "phi_t", "P_m", "E_f", "t_frame")],
        "parameter": [
            *("rate", "tve", "noise", "degrees_of_freedom", "magnitude_step", "angle_step", "latency", "dropout"),
            *("V_magnitude_bias", "V_angle_bias", "I_magnitude_bias", "I_angle_bias"),
            *("gross_error_probability", "gross_error", "seed"),
        ],
        "output": [*FRAME, "P_m", "E_f", "frame_valid", "t_frame"],
    },
}


@pytest.mark.parametrize("name", CONTRACT)
def test_fmpy_finds_no_problem(dist, name):
    assert validate_fmu(str(dist / "python" / f"{name}.fmu")) == []


@pytest.mark.parametrize("name", CONTRACT)
def test_names_of_the_contract(dist, name):
    description = read_model_description(dist / "python" / f"{name}.fmu")
    for causality, names in CONTRACT[name].items():
        declared = {v.name for v in description.modelVariables if v.causality == causality}
        assert set(names) <= declared


@pytest.mark.parametrize("name", CONTRACT)
def test_every_real_has_a_unit_or_is_a_number(dist, name):
    description = read_model_description(dist / "python" / f"{name}.fmu")
    assert all(v.unit for v in description.modelVariables if v.type == "Real")
    without = {v.name for v in description.modelVariables if v.type == "Real" and v.unit == "1"}
    numbers = {"drem.Delta", "tve", "innovation", "load_sigma", "degrees_of_freedom", "V_magnitude_bias"}
    numbers |= {
        "I_magnitude_bias",
        "dropout",
        "gross_error_probability",
        "gross_error",
        "S10",
        "S12",
        "angle_innovation",
        "power_mismatch",
        "tap",
    }
    assert {name for name in without if not name.startswith("overparameterised.")} <= numbers


@pytest.mark.parametrize("name", CONTRACT)
def test_every_variable_is_described(dist, name):
    description = read_model_description(dist / "python" / f"{name}.fmu")
    assert [v.name for v in description.modelVariables if not v.description] == []


def dependencies(unknowns):
    """Names by the name of the unknown."""
    return {unknown.variable.name: {v.name for v in unknown.dependencies} for unknown in unknowns}


@pytest.mark.parametrize("name", CONTRACT)
def test_structure(dist, name):
    """Every output has dependencies, on inputs of its own instant and at the start."""
    description = read_model_description(dist / "python" / f"{name}.fmu")
    outputs = {v.name for v in description.modelVariables if v.causality == "output"}
    direct = dependencies(description.outputs)
    assert set(direct) == set(dependencies(description.initialUnknowns)) == outputs
    if name == "PmuChannel":
        assert all(names == set(CONTRACT[name]["input"]) for names in direct.values())
    elif name == "SmibPlant":
        expected = {output: set() for output in outputs} | {"P_m_out": {"P_m"}, "E_f_out": {"E_f"}}
        assert direct == expected | {output: {"V_inf", "theta_inf"} for output in (*FRAME, "load_angle")}
    else:
        assert not any(direct.values())


@pytest.mark.parametrize("name", build_fmu.native_names())
def test_dependencies_at_the_start_are_those_that_casadi_finds(dist, name):
    """In the Jacobian of start, which knows no conditions; a parameter that chooses the program is for all of them."""
    description = read_model_description(dist / "python" / f"{name}.fmu")
    model = build_fmu.all_models()[name][1]
    knowns = [v.name for v in description.modelVariables if v.causality in ("input", "parameter")]
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    expected = {output: {model.selector, model.variant} - {""} for output in outputs}
    for program in model.programs.values():
        shape = (model.inputs, model.parameters)
        inputs, parameters = tree.like(shape, [SX.sym(known) for known in knowns])
        _, found = program.start(symbols, parameters, inputs, SX.sym("t"))
        sparsity = SX(vertcat(*tree.leaves(found)))
        depends = jacobian_sparsity(sparsity, vertcat(*tree.leaves((inputs, parameters))))
        for row, column in zip(depends.row(), depends.get_col(), strict=True):
            expected[outputs[row]].add(knowns[column])
    declared = dependencies(description.initialUnknowns)
    assert all(declared[output] >= names for output, names in expected.items())
    if name == "SmibPlant":  # and nothing beyond what they are made of
        assert declared["omega"] == {"omega_start", "start_mode", "start_mode_number", "f_inf", "omega_s"}
        assert declared["E_f_start"] - declared["omega"] <= {*MACHINE, "P_m", "E_f", "V_inf", "x_line", "V_t_start"}
        assert declared["t_frame"] == set()


def test_inputs_of_the_observer_are_discrete(dist):
    """Else `fmpy simulate --input-file` interpolates between frames."""
    description = read_model_description(dist / "python" / "PmuObserver.fmu")
    assert {v.variability for v in description.modelVariables if v.causality == "input"} == {"discrete"}


def test_the_estimator_enumeration_starts_as_agreed(dist):
    description = read_model_description(dist / "python" / "PmuObserver.fmu")
    estimator = next(v for v in description.modelVariables if v.name == "estimator")
    assert estimator.declaredType
    items = [item.name for item in estimator.declaredType.items]
    assert items[:5] == ["drem", "overparameterised", "gradient", "joint_gradient", "open_loop"]


@pytest.mark.parametrize("name", CONTRACT)
def test_start_values_read_back_as_the_same_number(dist, name):
    """17 digits: 1/60 has no shorter decimal form."""
    with zipfile.ZipFile(dist / "python" / f"{name}.fmu") as fmu:
        xml = fmu.read("modelDescription.xml").decode()
    step_size = re.search(r'stepSize="([^"]*)"', xml)
    assert step_size and float(step_size[1]) == (1e-3 if name == "SmibPlant" else 1 / 60)


@pytest.mark.parametrize("name", CONTRACT)
def test_licences_travel_with_the_fmu(dist, name):
    with zipfile.ZipFile(dist / "python" / f"{name}.fmu") as fmu:
        assert b"MIT License" in fmu.read("documentation/licenses/license.txt")
        assert fmu.read("documentation/licenses/pythonfmu.txt")
