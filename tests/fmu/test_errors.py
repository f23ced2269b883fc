"""Bad input: what the slave says, and that it survives. The Python kind can only log, and discard the step."""

import math

import pytest

from .instance import DISCARD, FRAME, OK, STATES, Instance

H = 1 / 60
GOOD = {"V_t": 1.0, "theta_t": 0.1, "I_t": 0.5, "phi_t": 0.0, "P_t": 0.4975, "Q_t": 0.0499, "P_m": 0.5, "E_f": 1.0}
WAITING, HOLDING = 0, 3


@pytest.fixture
def observer(dist):
    instance = Instance(dist / "python" / "PmuObserver.fmu", "observer", estimator=1)
    yield instance
    instance.free()


@pytest.fixture
def plant(dist):
    instance = Instance(dist / "python" / "SmibPlant.fmu", "plant")
    yield instance
    instance.free()


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        ({"H": -1.0}, ["H = -1", "[0.01, 10000] s"]),
        ({"H": math.nan}, ["H = nan", "[0.01, 10000] s"]),
        ({"Td10": 0.0}, ["Td10 = 0", "[0.01, 1000] s"]),
        ({"estimator": 99}, ["estimator = 99", "drem (1)"]),
        ({"xd1": 0.2}, ["xd1 = 0.2", "xd = 0.146"]),
        ({"drem__gamma": math.inf}, ["drem.gamma = inf"]),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_a_bad_parameter_is_named_and_no_step_is_done(observer, bad, words):
    observer.set(**bad)
    observer.initialise(**GOOD)
    assert all(word in observer.messages[0] for word in words), observer.messages
    assert observer.step(0.0, H) == DISCARD
    assert all(word in observer.messages[-1] for word in words), observer.messages


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        ({"start_mode": 2}, ["P_m = 50", "no equilibrium"]),
        ({"start_mode": 3}, ["x_line = 0", "start_mode = 3"]),
        ({"t_fault": 2.0, "t_clear": 1.0}, ["t_clear = 1", "t_fault = 2"]),
    ],
    ids=["no equilibrium", "no line", "fault cleared before it begins"],
)
def test_parameters_that_do_not_go_together(plant, bad, words):
    plant.set(**bad)
    plant.initialise(P_m=50.0)
    assert all(word in plant.messages[0] for word in words), plant.messages
    assert plant.step(0.0, H) == DISCARD


def test_a_bad_input_of_the_plant_fails_the_step_and_the_state_before_it_leads_on(plant):
    plant.initialise()
    before, state = plant.outputs(), plant.slave.getFMUState()
    plant.set(V_inf=math.nan)
    assert plant.step(0.0, H) == DISCARD
    assert "V_inf = nan" in plant.messages[-1]
    assert plant.outputs() == before
    assert plant.step(0.0, H) == DISCARD
    assert "after a step that failed" in plant.messages[-1]
    plant.slave.setFMUState(state)
    assert plant.step(0.0, H) == OK


def test_outputs_that_a_bad_input_leaves_without_a_value_stay_as_they_are(plant):
    plant.initialise()
    before = plant.outputs()
    plant.set(V_inf=math.nan)
    assert plant.outputs() == before
    assert "the outputs are not calculated" in plant.messages[-1] and "V_inf = nan" in plant.messages[-1]
    plant.set(V_inf=1.0)
    assert plant.step(0.0, H) == OK


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
@pytest.mark.parametrize("name", [name for name in GOOD if name != "phi_t"])  # which is not used, with P_t and Q_t
def test_a_bad_frame_is_held_over_and_flagged(observer, name, bad):
    observer.initialise(**GOOD)
    assert observer.step(0.0, H) == OK
    observer.set(**{name: bad})
    assert observer.step(H, H) == OK
    assert observer.get("status") == [HOLDING]
    assert all(math.isfinite(value) for value in observer.outputs())
    observer.set(**GOOD)
    assert observer.step(2 * H, H) == OK
    assert observer.get("status") != [HOLDING]


@pytest.mark.parametrize("bad", [{"V_t": 0.0}, {"V_t": -1.0}, {"I_t": 50.0}, {"V_t": 1e-9, "P_t": 1e8}])
def test_a_frame_without_voltage_or_that_contradicts_itself_is_held_over(observer, bad):
    observer.initialise(**GOOD)
    observer.step(0.0, H)
    observer.set(**bad)
    assert observer.step(H, H) == OK
    assert observer.get("status") == [HOLDING]


def test_no_frame_yet(observer):
    """As under a master without an initial exchange: all inputs are zero."""
    observer.initialise()
    assert observer.step(0.0, H) == OK
    assert observer.get("status", *STATES) == [WAITING, 0, 0, 0, 0, 0]
    observer.set(**GOOD)
    assert observer.step(H, H) == OK
    assert observer.get("status") != [WAITING]


@pytest.mark.parametrize(
    ("time", "h", "word"),
    [
        (H, -H, "communicationStepSize = -0.0166"),
        (H, 0.0, "communicationStepSize = 0 s"),
        (H, math.nan, "communicationStepSize = nan"),
        (H, math.inf, "communicationStepSize = inf"),
        (0.0, H, "where the last step ended"),
        (5.0, H, "where the last step ended"),
        (math.nan, H, "where the last step ended"),
    ],
)
def test_a_step_that_cannot_be_done_is_discarded(observer, time, h, word):
    observer.initialise(**GOOD)
    observer.step(0.0, H)
    assert observer.step(time, h) == DISCARD
    assert word in observer.messages[-1]
    assert observer.step(H, H) == OK


def test_stop_time(observer):
    """A last step may end 1 % of it later, for a master that counts in nanoseconds."""
    observer.slave.setupExperiment(startTime=0.0, stopTime=2 * H)
    observer.slave.enterInitializationMode()
    observer.slave.exitInitializationMode()
    assert observer.step(0.0, H) == OK
    assert observer.step(H, 1.02 * H) == DISCARD
    assert f"stopTime = {2 * H:.12g} s" in observer.messages[-1]
    assert observer.step(H, 1.001 * H) == OK
    assert observer.step(2.001 * H, H) == DISCARD


@pytest.mark.parametrize(
    ("start", "stop", "words"),
    [(math.nan, None, "startTime = nan"), (math.inf, None, "startTime = inf"), (1.0, 0.5, "stopTime = 0.5")],
)
def test_experiments_that_are_not_allowed(observer, start, stop, words):
    observer.slave.setupExperiment(startTime=start, stopTime=stop)
    assert words in observer.messages[-1]
    observer.initialise(time=5.0, **GOOD)
    assert observer.step(5.0, H) == OK


def test_an_experiment_set_up_in_step_mode_does_not_move_the_clock(observer):
    observer.initialise(**GOOD)
    observer.slave.setupExperiment(startTime=7.0)
    assert "fmi2SetupExperiment is not allowed while the slave is in step mode" in observer.messages[-1]
    assert observer.step(7.0, H) == DISCARD
    assert observer.step(0.0, H) == OK


def test_the_state_of_an_instance_that_was_refused(dist, observer):
    """Set on a healthy one, it makes that one refuse its steps, as the other does; the state before leads on."""
    refused = Instance(dist / "python" / "PmuObserver.fmu", "refused", H=-1.0).initialise(**GOOD)
    blob = refused.slave.serializeFMUState(refused.slave.getFMUState())
    refused.free()
    observer.initialise(**GOOD)
    before = observer.slave.getFMUState()
    observer.slave.setFMUState(observer.slave.deserializeFMUState(blob))
    assert observer.step(0.0, H) == DISCARD
    observer.slave.setFMUState(before)
    assert observer.step(0.0, H) == OK


def test_parameters_are_put_right_in_initialization_mode(observer):
    observer.set(xd1=0.2)
    observer.initialise(**GOOD)
    assert observer.step(0.0, H) == DISCARD
    observer.set(xd1=0.05)
    observer.slave.exitInitializationMode()
    assert observer.step(0.0, H) == OK


def test_steps_outside_step_mode(observer):
    assert observer.step(0.0, H) == DISCARD
    assert "fmi2DoStep is not allowed while the slave is instantiated" in observer.messages[-1]
    observer.initialise(**GOOD)
    observer.slave.terminate()
    assert observer.step(0.0, H) == DISCARD
    assert "terminated" in observer.messages[-1]


def test_what_may_not_be_set(observer):
    observer.initialise(**GOOD)
    for name in ("H", "delta"):
        before = observer.get(name)
        observer.set(**{name: 3.0})
        assert f"{name} (" in observer.messages[-1] and "cannot be set" in observer.messages[-1]
        assert observer.get(name) == before


def test_a_tunable_parameter_changes_during_the_run_within_its_range(observer):
    observer.initialise(**GOOD)
    observer.set(k_speed=2.0)
    assert (observer.get("k_speed"), observer.messages) == ([2.0], [])
    observer.set(k_speed=-2.0)
    assert observer.get("k_speed") == [2.0]
    assert "k_speed = -2 is not allowed, and ignored; it must be in [0, 10000] 1/s" in observer.messages[-1]


def test_unknown_value_references(observer):
    observer.slave.setReal([10_000], [1.0])
    assert "no Real variable with value reference 10000" in observer.messages[-1]
    delta = observer.variables["delta"].valueReference
    assert observer.slave.getInteger([delta]) == [0]
    assert f"no Integer variable with value reference {delta}" in observer.messages[-1]


def test_percent_signs_reach_c_hosts_doubled(observer):
    """The message is a printf format there."""
    observer.initialise(**{**GOOD, "V_t": math.nan})
    assert all("%" not in message.replace("%%", "") for message in observer.messages)


def test_frame_of_the_right_names():
    assert set(FRAME) < set(GOOD)
