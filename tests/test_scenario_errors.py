"""Each mistake in a scenario file has a message that names it and says what to do."""

import pytest

from scenarios import loader, master, study
from scenarios.errors import ScenarioError

GOOD = """
title = "A good one"
step = "1/60"
stop = 1.0

[inputs]
P_m = 0.1
E_f = 0.1

[parameters]
H = 23.64

[fmu.plant]
model = "SmibPlant"
parameters = { start_mode = "states" }
inputs = { V_inf = 1.0 }

[fmu.observer]
model = "PmuObserver"
each.gamma = [1e15, 1e16]
parameters = { drem.gamma = "{gamma}" }

[csv.record]
file = "record.csv"
time = "t [s]"
columns = { V_t = "V [pu]", omega = "2*pi*60*(omega - 1) [rad/s]" }

[connect]
observer = "plant"

[error]
e1d = "observer.e1d - plant.e1d"

[[change]]
at = 0.5
set = { P_m = 0.2 }

[[figure]]
name = "all"
title = "All"
panel = [{ curves = ["plant.delta", "observer.delta"] }]

[[expect]]
error = "e1d"
each.gamma = 1e15
at = 1.0
below = 1.0
"""
RECORD = "# a comment\nt,V,omega\n0,1,1\n1,1,1\n"

MISTAKES = {
    # units
    "unit of a column": (
        'V_t = "V [pu]"',
        'V_t = "V"',
        'csv.record.V_t: the unit of "V" is missing; write it behind in brackets: "V [pu]"',
    ),
    "unit of an error": (
        '"observer.e1d - plant.e1d"',
        '"observer.e1d / plant.e1d"',
        'error.e1d: the unit of "observer.e1d / plant.e1d" is missing',
    ),
    "two units in a sum": (
        '"observer.e1d - plant.e1d"',
        '"observer.e1d - plant.delta"',
        'error.e1d: "observer.e1d - plant.delta" adds pu and rad; convert one of them',
    ),
    "wrong unit": (
        '"observer.e1d - plant.e1d"',
        '"observer.e1d - plant.e1d [rad]"',
        "is in pu, not in rad; write [pu], or convert",
    ),
    "units of a connection": (
        'observer = "plant"',
        '"observer.theta_t" = "plant.omega"',
        "plant.omega is in rad/s, observer.theta_t in rad; convert one of them",
    ),
    "time of a record": ('"t [s]"', '"t [ms]"', 'csv.record: time is in ms; convert it to seconds: "t/1000 [s]"'),
    # connections
    "unknown source": (
        'observer = "plant"',
        'observer = "plnt"',
        'connect "observer" = "plnt": there is no FMU or CSV "plnt"; did you mean "plant"? known: plant,',
    ),
    "unknown target": (
        'observer = "plant"',
        'obs = "plant"',
        'connect "obs" = "plant": there is no FMU or CSV "obs"',
    ),
    "unknown input": (
        'observer = "plant"',
        'observer.V_T = "plant.V_t"',
        'observer has no input "V_T"; did you mean "V_t"? known: V_t, theta_t',
    ),
    "unknown output": (
        'observer = "plant"',
        'observer.V_t = "plant.V"',
        'plant has no output "V"; known: V_t, theta_t',
    ),
    "nothing behind a prefix": (
        'observer = "plant"',
        '"observer.plant.*" = "plant"',
        "no output of plant has the name of an input of observer; connect one by one",
    ),
    "loop": (
        'observer = "plant"',
        'channel.plant = { V_t = "channel.V_t" }\n[fmu.channel]\nmodel = "PmuChannel"',
        "connect: channel <- channel: each shows its inputs at once, and none is first; connect",
    ),
    "half a name": (
        'observer = "plant"',
        'observer.V_t = "plant"',
        '"plant" is not the name of a variable; write "component.variable"',
    ),
    "nothing in common": (
        'observer = "plant"',
        'plant = "observer"',
        "no output of observer has the name of an input of plant; connect one by one",
    ),
    "connected twice": (
        'observer = "plant"',
        'observer = "plant"\n"observer.V_t" = "record.V_t"',
        "observer.V_t is connected already; remove one connection",
    ),
    "connected and given": (
        "inputs = { V_inf = 1.0 }",
        'inputs = { V_inf = 1.0, E_f = 1.0 }\n[connect.plant]\nE_f = "plant.E_f_start"',
        "fmu.plant.inputs: E_f is connected; remove it here or in [connect]",
    ),
    "several instances": (
        'observer = "plant"',
        'observer = "plant"\n"plant.E_f" = "observer.e1q"',
        "2 instances of observer belong to one with no each; give both components the same each",
    ),
    # names and values
    "unknown model": ('"SmibPlant"', '"SmibPlnt"', 'no model "SmibPlnt"; did you mean "SmibPlant"?'),
    "unknown key": ('step = "1/60"', 'stepp = "1/60"', 'stepp is not known; did you mean "step"?'),
    "unknown key of a table": ("below = 1.0", "belo = 1.0", 'expect.0.belo is not known; did you mean "below"?'),
    "missing key": ("stop = 1.0\n", "", "stop is missing; add it"),
    "unknown parameter": (
        "drem.gamma",
        "drem.gama",
        'no parameter "drem.gama"; did you mean "drem.gamma"?',
    ),
    "unknown shared parameter": ("H = 23.64", "h = 23.64", 'parameters: "h" is no parameter of any FMU'),
    "unknown shared input": ("P_m = 0.1", "Pm = 0.1", 'inputs: "Pm" is no input of any FMU; did you mean "P_m"?'),
    "item of an enumeration": (
        '"states"',
        '"state"',
        "start_mode = 'state' is not allowed; did you mean \"states\"? known: states, P_m_E_f, P_m_V_t",
    ),
    "text for a number": ("H = 23.64", 'H = "23.64"', "H = '23.64' is not allowed; write a number of s"),
    "list for a number": ("H = 23.64", "H = [1, 2]", "parameters.H = [1, 2]: write a number"),
    "value of a sweep": ('"{gamma}"', '"{gama}"', '"{gama}" asks for what is not in each; did you mean'),
    "empty sweep": ("[1e15, 1e16]", "[]", "fmu.observer.each.gamma = []"),
    "name with a blank": ("[fmu.plant]", '[fmu."the plant"]', '"the plant" cannot be a name in an expression'),
    "unknown error": ('error = "e1d"', 'error = "e1q"', 'expect: there is no error "e1q"; did you mean "e1d"?'),
    "value in an expression": (
        '"observer.e1d - plant.e1d"',
        '"observer.e1d - plant.{which} [pu]"',
        'error.e1d: "observer.e1d - plant.{which} [pu]" asks for what is not in each',
    ),
    "facet": (
        'title = "All"',
        'title = "All"\nfacet = "unit"',
        'figure all: facet = "unit" is in no each; sweep it, or',
    ),
    "no table of rows": ("each.gamma = [1e15, 1e16]", 'rows = "rows.csv"', "fmu.observer.rows: there is no file"),
    "unknown instance": (
        "each.gamma = 1e15",
        "each.gamma = 1e17",
        "no instance with gamma = 1e17; known: gamma = 1e15",
    ),
    "unknown curve": (
        '"plant.delta"',
        '"plant.delt"',
        'figure all: plant has no variable "delt"; did you mean',
    ),
    "expression as a curve": ('"plant.delta"', '"2*plant.delta"', '"2*plant.delta" is not a name; name it in [error]'),
    "band of no curve": (
        '"observer.delta"] }',
        '"observer.delta"], band = { observer.delt = "observer.delta_std" } }',
        'figure.0.panel.0: band: "observer.delt" is not among the curves; did you mean "observer.delta"?',
    ),
    "not an expression": ("observer.e1d - plant.e1d", "observer.e1d -", "error.e1d = 'observer.e1d -': this is not an"),
    "not arithmetic": ("observer.e1d - plant.e1d", "open(1)", '"open(1)" is not allowed in an expression'),
    "fixed parameter": (
        "set = { P_m = 0.2 }",
        "set = { H = 1.0 }",
        "change at 0.5 s: plant.H is a fixed parameter; only inputs and tunable parameters can change",
    ),
    "change of a connected input": (
        "set = { P_m = 0.2 }",
        "set = { V_t = 0.2 }",
        "change at 0.5 s: observer.V_t is connected; change what feeds it",
    ),
    # times
    "step of zero": ('step = "1/60"', "step = 0", "step = 0 s does not divide stop = 1 s; choose a step above 0 s"),
    "negative step": ('step = "1/60"', "step = -0.1", "step = -0.1: a time must not be negative"),
    "step that does not fit": (
        'step = "1/60"',
        "step = 0.3",
        "choose a step above 0 s and a stop that is a whole",
    ),
    "step in words": ('step = "1/60"', 'step = "1 ms"', 'write seconds as a number, or as a fraction: "1/60"'),
    "time after the end": (
        "at = 1.0",
        "at = 2.0",
        "expect.at = 2 s is after the end of the run; lower it, or",
    ),
    # expectations
    "two limits": ("below = 1.0", "below = 1.0\nabove = 0.1", "expect.0: give exactly one of below, above, near"),
    "near what": ("below = 1.0", "near = 1.0", "near and within go together"),
    "within what": ("below = 1.0", 'near = 1.0\nwithin = "a bit"', "write a number, or per cent of what is near"),
    # files
    "no TOML": ("[inputs]", "[inputs", "test.toml is not TOML"),
    "no record": ('"record.csv"', '"recrd.csv"', "there is no file"),
    "unknown column": ('"V [pu]"', '"Vt [pu]"', 'csv.record: V_t needs a column "Vt" of record.csv; '),
}


def load(folder, text, record=RECORD):
    (folder / "test.toml").write_text(text)
    (folder / "record.csv").write_text(record)
    return loader.load(str(folder / "test.toml"))


def test_the_good_one_is_good(tmp_path):
    with study.prepared(load(tmp_path, GOOD)) as plan:
        master.run(plan)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_in_a_scenario(mistake, tmp_path):
    right, wrong, message = MISTAKES[mistake]
    assert right in GOOD
    with pytest.raises(ScenarioError) as error, study.prepared(load(tmp_path, GOOD.replace(right, wrong))):
        pass
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("record", "message"),
    [
        ("t,V,omega\n0,1,1\n0,1,1\n", "csv.record: the times of record.csv do not increase; sort its rows"),
        ("t,V,omega\n0,1,one\n", "is not a table of numbers separated by commas"),
        ("t,V,omega\n0,1\n", "is not a table of numbers separated by commas"),
        ("", "is not a table of numbers separated by commas"),
        (
            "t,V,omega\n0,1,1\n0.5,1,1\n",
            "record.csv holds 0 s to 0.5 s; the run is from 0 s to 1 s: change stop",
        ),
    ],
)
def test_mistake_in_a_record(record, message, tmp_path):
    with pytest.raises(ScenarioError) as error, study.prepared(load(tmp_path, GOOD, record)) as plan:
        master.run(plan)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("H = 23.64", "H = -1.0", "plant: H = -1 is not allowed; it must be in [0.01, 10000] s"),
        ('drem.gamma = "{gamma}"', "k_speed = nan", "k_speed = nan is not allowed"),
        ("set = { P_m = 0.2 }", "set = { observer.k_speed = -1.0 }", "k_speed = -1 is not allowed"),
        ('start_mode = "states"', 'start_mode = "P_m_V_t"', "x_line"),
    ],
)
@pytest.mark.parametrize("kind", study.KINDS)
@pytest.mark.usefixtures("native_dist")
def test_value_that_an_fmu_refuses(kind, right, wrong, message, tmp_path):
    """The FMU knows its ranges: its message becomes the scenario's."""
    assert right in GOOD
    scenario = load(tmp_path, GOOD.replace(right, wrong))
    with study.prepared(scenario, kind) as plan, pytest.raises(ScenarioError) as error:
        master.run(plan)
    assert message in str(error.value)
