"""Bad arguments of legal calls: the status, a message that names the thing, and nothing is changed."""

from ctypes import c_char_p, c_double, c_int, c_uint, c_void_p, pointer
from math import inf, nan

import pytest
from fmpy.fmi2 import fmi2CoSimulation, fmi2ModelExchange

from ..fmu.instance import DISCARD, ERROR, OK, Instance

H = 1 / 60


@pytest.fixture(scope="module", params=["PmuObserver", "SmibPlant"])
def loaded(request, native_dist):
    instance = Instance(native_dist / "native" / f"{request.param}.fmu", "a 100 % sure name")
    yield instance
    instance.free()


@pytest.fixture
def instance(loaded):
    assert loaded.call("fmi2Reset") == OK
    loaded.messages.clear()
    return loaded


def values(instance):
    """Every Real and Integer, by the getters, after the initialization."""
    return instance.get(*instance.variables)


def set_status(instance, name, value):
    variable = instance.variables[name]
    real = variable.type == "Real"
    array = (c_double * 1)(value) if real else (c_int * 1)(value)
    return instance.call("fmi2SetReal" if real else "fmi2SetInteger", (c_uint * 1)(variable.valueReference), 1, array)


BAD_PARAMETERS = [
    ("H", -1.0, ["H = -1", "[0.01, 10000] s"]),
    ("H", nan, ["H = nan"]),
    ("Td10", 0.0, ["Td10 = 0", "[0.01, 1000] s"]),
    ("xd", inf, ["xd = inf"]),
    ("Ra", -1e-9, ["Ra = -1e-09", "[0, 1] pu"]),
]


@pytest.mark.parametrize(("name", "value", "words"), BAD_PARAMETERS)
def test_a_parameter_out_of_range_is_discarded(instance, name, value, words):
    before = instance.variables[name].start
    assert set_status(instance, name, value) == DISCARD
    assert all(word in instance.messages[-1] for word in words), instance.messages
    instance.initialise()
    assert instance.get(name) == [float(before)]


def test_an_enumeration_out_of_range_is_discarded(instance):
    name = next(name for name, variable in instance.variables.items() if variable.declaredType)
    for value in (0, -1, 99, 2**31 - 1, -(2**31)):
        assert set_status(instance, name, value) == DISCARD
        assert f"{name} = {value} is not allowed" in instance.messages[-1]
    instance.initialise()
    assert instance.get(name) == [int(instance.variables[name].start)]


def test_one_bad_value_of_several_sets_none(instance):
    references = (c_uint * 2)(*[instance.variables[name].valueReference for name in ("D", "H")])
    assert instance.call("fmi2SetReal", references, 2, (c_double * 2)(0.0, -1.0)) == DISCARD
    instance.initialise()
    assert instance.get("D", "H") == [float(instance.variables[name].start) for name in ("D", "H")]


def test_parameters_that_do_not_go_together(instance):
    """The initialization fails, can be put right, and then goes on."""
    instance.set(xd1=0.2, xq1=0.3)
    instance.slave.setupExperiment()
    instance.slave.enterInitializationMode()
    assert instance.call("fmi2ExitInitializationMode") == ERROR
    assert "xd1 = 0.2 is not allowed; it must be in (0, xd = 0.146] pu" in instance.messages
    assert "xq1 = 0.3 is not allowed; it must be in (0, xq = 0.146] pu" in instance.messages
    reference, value = (c_uint * 1)(instance.variables["delta"].valueReference), (c_double * 1)(123.0)
    assert instance.call("fmi2GetReal", reference, 1, value) == ERROR
    assert instance.get("xd1") == [0.2]
    instance.set(xd1=0.1, xq1=0.1)
    assert instance.call("fmi2ExitInitializationMode") == OK
    assert instance.step(0.0, H) == OK


@pytest.mark.parametrize("function", ["fmi2GetReal", "fmi2GetInteger", "fmi2SetReal", "fmi2SetInteger"])
def test_value_references(instance, function):
    """Unknown ones, and those of another type; fmi2GetReal and fmi2SetReal take any variable."""
    instance.initialise()
    other = [] if "Real" in function else [instance.variables["delta"].valueReference]
    array = (c_double * 1)() if "Real" in function else (c_int * 1)()
    for reference in (*other, len(instance.variables), 2**31, 2**32 - 1):
        assert instance.call(function, (c_uint * 1)(reference), 1, array) == ERROR
        assert f"value reference {reference}" in instance.messages[-1]


def test_there_are_no_strings_and_no_booleans(instance):
    instance.initialise()
    reference = (c_uint * 1)(0)
    assert instance.call("fmi2GetString", reference, 1, (c_char_p * 1)()) == ERROR
    assert instance.call("fmi2SetString", reference, 1, (c_char_p * 1)(b"x")) == ERROR
    assert instance.call("fmi2GetBoolean", reference, 1, (c_int * 1)()) == ERROR
    assert instance.call("fmi2SetBoolean", reference, 1, (c_int * 1)()) == ERROR


def test_null_pointers(instance):
    instance.initialise()
    reference, value = (c_uint * 1)(0), (c_double * 1)()
    state = instance.slave.getFMUState()
    calls = [
        ("fmi2GetReal", None, 1, value),
        ("fmi2GetReal", reference, 1, None),
        ("fmi2SetReal", None, 1, value),
        ("fmi2SetReal", reference, 1, None),
        ("fmi2SetDebugLogging", 1, 1, None),
        ("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)(None)),
        ("fmi2GetFMUstate", None),
        ("fmi2SetFMUstate", None),
        ("fmi2SerializedFMUstateSize", None, None),
        ("fmi2SerializedFMUstateSize", state, None),
        ("fmi2SerializeFMUstate", state, None, 0),
        ("fmi2DeSerializeFMUstate", None, 0, None),
        ("fmi2DeSerializeFMUstate", b"x", 1, None),
        ("fmi2GetRealStatus", 2, None),
        ("fmi2GetStringStatus", 1, None),
    ]
    for function, *arguments in calls:
        assert instance.call(function, *arguments) == ERROR, function
        assert instance.messages[-1] == f"{function}: a pointer is NULL"
    assert instance.call("fmi2FreeFMUstate", None) == OK  # the standard: nothing to free
    instance.slave.freeFMUState(state)
    component, instance.slave.component = instance.slave.component, None
    assert instance.call("fmi2DoStep", 0.0, H, 1) == ERROR
    assert instance.call("fmi2Reset") == ERROR
    instance.slave.component = component
    assert instance.step(0.0, H) == OK


@pytest.mark.parametrize(
    ("time", "h", "words"),
    [
        (0.0, 0.0, "communicationStepSize = 0 s"),
        (0.0, -H, "communicationStepSize = -"),
        (0.0, nan, "communicationStepSize = nan s"),
        (0.0, inf, "communicationStepSize = inf s"),
        (H, H, "the last step ended at 0 s"),
        (-H, H, "the last step ended at 0 s"),
        (nan, H, "currentCommunicationPoint = nan s"),
        (0.0, 2.5, "stopTime = 2 s"),
        (0.02 * H, H, "the last step ended at 0 s"),
    ],
)
def test_steps_that_are_not_allowed(instance, time, h, words):
    instance.slave.setupExperiment(startTime=0.0, stopTime=2.0)
    instance.slave.enterInitializationMode()
    instance.slave.exitInitializationMode()
    before = values(instance)
    assert instance.step(time, h) == ERROR
    assert words in instance.messages[-1]
    assert values(instance) == before
    assert instance.step(0.0, H) == OK


@pytest.mark.parametrize("begin", [-1.0, 0.0, 1.7e9])
def test_time_stamps_may_be_rounded(instance, begin):
    """A master that adds up its steps is off by some ulps; it reaches stopTime nevertheless."""
    instance.slave.setupExperiment(startTime=begin, stopTime=begin + 2.0)
    instance.slave.enterInitializationMode()
    instance.slave.exitInitializationMode()
    time = begin
    while time < begin + 2.0 - H / 2:
        assert instance.step(time, H) == OK
        assert instance.step(time, H) == ERROR
        assert instance.step(time + 2 * H, H) == ERROR
        time += H
    assert time != begin + 2.0
    assert instance.step(time, H) == ERROR


def test_a_clock_in_whole_nanoseconds(instance):
    """As libcosim's: the last step of 2 s ends 40 ns late."""
    instance.slave.setupExperiment(startTime=0.0, stopTime=2.0)
    instance.slave.enterInitializationMode()
    instance.slave.exitInitializationMode()
    for k in range(120):
        assert instance.step(k * 16_666_667e-9, 16_666_667e-9) == OK
    assert instance.step(120 * 16_666_667e-9, H) == ERROR


@pytest.mark.parametrize(
    ("start", "stop", "words"),
    [(nan, None, "startTime = nan"), (inf, None, "startTime = inf"), (1.0, 0.5, "stopTime = 0.5"), (0, nan, "nan")],
)
def test_experiments_that_are_not_allowed(instance, start, stop, words):
    defined = stop is not None
    assert instance.call("fmi2SetupExperiment", 0, 0.0, start, int(defined), stop or 0.0) == ERROR
    assert words in instance.messages[-1]
    assert instance.initialise(5.0).step(5.0, H) == OK


def test_the_plant_refuses_a_step_that_would_hang_the_host(native_dist):
    plant = Instance(native_dist / "native" / "SmibPlant.fmu").initialise()
    assert plant.step(0.0, 1e9) == DISCARD
    assert "communicationStepSize = 1000000000 s is not allowed; it must be in (0, " in plant.messages[-1]
    plant.free()


def test_an_input_out_of_its_range(native_dist):
    plant = Instance(native_dist / "native" / "SmibPlant.fmu").initialise(f_inf=50.0)
    assert plant.step(0.0, H) == OK
    plant.set(f_inf=-1.0)
    assert plant.step(H, H) == DISCARD
    assert "f_inf = -1 is not allowed; it must be in [0, inf] Hz" in plant.messages[-1]
    plant.free()


def test_log_categories(instance):
    """Those of modelDescription.xml, and no others; what is switched off is silent."""
    with open(f"{instance.folder}/modelDescription.xml", encoding="utf-8") as file:
        text = file.read()
    names = [part.split('"')[1] for part in text.split("<Category ")[1:]]
    categories = (c_char_p * len(names))(*[name.encode() for name in names])
    assert instance.call("fmi2SetDebugLogging", 1, len(names), categories) == OK
    assert instance.call("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)(b"logNothing")) == ERROR
    assert "logNothing" in instance.messages[-1]
    said = len(instance.messages)
    assert instance.call("fmi2SetDebugLogging", 0, 0, None) == OK
    assert instance.call("fmi2Terminate") == ERROR
    assert len(instance.messages) == said
    assert instance.call("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)(b"logStatusError")) == OK
    assert instance.call("fmi2Terminate") == ERROR
    assert set_status(instance, "H", -1.0) == DISCARD
    assert len(instance.messages) == said + 1
    assert instance.call("fmi2SetDebugLogging", 1, 0, None) == OK


def test_what_cannot_be_instantiated(instance):
    slave, callbacks = instance.slave, pointer(instance.callbacks)
    guid = instance.description.guid.encode()

    def instantiate(**changed):
        good = {"name": b"x", "kind": fmi2CoSimulation, "guid": guid, "uri": None, "functions": callbacks}
        made = slave.fmi2Instantiate(*{**good, **changed}.values(), 0, 0)
        if made:
            slave.fmi2FreeInstance(made)
        return bool(made)

    assert not instantiate(guid=b"{00000000-0000-0000-0000-000000000000}")
    assert "guid = {00000000" in instance.messages[-1] and instance.description.guid in instance.messages[-1]
    assert not instantiate(guid=None)
    assert not instantiate(kind=fmi2ModelExchange)
    assert "co-simulation only" in instance.messages[-1]
    assert not instantiate(name=None)
    assert not instantiate(name=b"")
    assert "has no name" in instance.messages[-1]
    assert not instantiate(functions=None)
    # the model needs no resources: any location is as good as none
    for uri in (
        None,
        b"",
        b"file:///nowhere",
        b"file:/C:/a%20b",
        b"http://%",
        b"\xff\xfe",
        b"file://" + b"a" * 100_000,
    ):
        assert instantiate(uri=uri), uri


def test_reset_is_a_new_instance(instance):
    instance.set(D=1.0)
    instance.initialise(P_m=0.3)
    assert instance.step(0.0, H) == OK
    assert instance.call("fmi2Reset") == OK
    instance.initialise()
    again = values(instance)
    fresh = Instance(instance.path).initialise()
    assert values(fresh) == again
    fresh.free()


def test_free_of_nothing(instance):
    instance.slave.fmi2FreeInstance(c_void_p())
