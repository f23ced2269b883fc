"""What goes with every FMU of both kinds: documentation, terminals, an icon; valid and complete."""

import csv
import re
import zipfile
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import matplotlib.image
import pytest
from fmpy import read_model_description
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue] - it has no types

import build_fmu
from fmu_src.pmu_observer.interface import Enumeration
from fmu_src.runtime.ports import ports

from .instance import OK, Instance

SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
EVERY = [("python", name) for name in build_fmu.all_models()] + [("native", name) for name in build_fmu.native_names()]


@pytest.fixture(params=EVERY, ids="-".join)
def fmu(request):
    kind, name = request.param
    folder = request.getfixturevalue("dist" if kind == "python" else "native_dist")
    with zipfile.ZipFile(folder / kind / f"{name}.fmu") as content:
        yield kind, name, content


class Page(HTMLParser):
    """Fails on tags that do not match."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "line", "rect", "!doctype"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_the_documentation_names_every_variable_choice_and_limit(fmu):
    _, name, content = fmu
    model = build_fmu.all_models()[name][1]
    page = Page(content.read("documentation/index.html").decode())
    assert model.about and model.limits
    assert model.about in page.text and all(limit in page.text for limit in model.limits)
    for port in ports(model):
        variable = port.variable
        if not re.search(r"\d", variable.name):  # those that differ in a number are shown together
            assert variable.name in page.text, variable.name
        if isinstance(variable.specification, Enumeration):
            assert all(f"{item} ({n})" in page.text for n, item in enumerate(variable.specification.items, 1))


def test_terminals_are_valid_and_plug_into_each_other(fmu):
    """The schema is FMI 3.0's, which 2.0.4 refers to; every member is a variable, and units agree across terminals."""
    content = fmu[2]
    text = content.read("terminalsAndIcons/terminalsAndIcons.xml")
    schema = etree.XMLSchema(file=str(SCHEMAS / "fmi3TerminalsAndIcons.xsd"))
    schema.assertValid(etree.fromstring(text))
    units = {"V_t": "pu", "theta_t": "rad", "I_t": "pu", "phi_t": "rad", "P_t": "pu", "Q_t": "pu"}
    units |= {"P_m": "pu", "E_f": "pu", "frame_valid": None, "t_frame": "s"}
    variables = {v.name: v for v in read_model_description(BytesIO(whole(content))).modelVariables}
    for terminal in ElementTree.fromstring(text).iter("Terminal"):
        members = {m.attrib["memberName"]: m.attrib["variableName"] for m in terminal.iter("TerminalMemberVariable")}
        assert {"V_t", "theta_t", "I_t", "phi_t", "P_m", "E_f", "t_frame"} <= set(members)
        assert {member: variables[variable].unit for member, variable in members.items()} == {
            m: units[m] for m in members
        }
        assert len({variables[variable].causality for variable in members.values()}) == 1


def whole(content: zipfile.ZipFile) -> bytes:
    return Path(str(content.filename)).read_bytes()


def test_the_icon_is_an_image(fmu):
    image = matplotlib.image.imread(BytesIO(fmu[2].read("model.png")), format="png")
    assert image.shape == (96, 96, 4)
    assert 0.05 < (image[..., 3] > 0.5).mean() < 0.3  # lines on nothing


def test_units_are_shown_as_people_read_them(fmu):
    variables = {v.name: v for v in read_model_description(BytesIO(whole(fmu[2]))).modelVariables}
    for v in variables.values():
        assert v.displayUnit == {"rad": "deg", "rad/s": "Hz"}.get(str(v.unit)), v.name


def test_the_build_description(fmu):
    kind, name, content = fmu
    if kind == "python":
        pytest.skip("a Python FMU has no C sources")
    text = content.read("sources/buildDescription.xml")
    etree.XMLSchema(file=str(SCHEMAS / "fmi3BuildDescription.xsd")).assertValid(etree.fromstring(text))
    files = [element.get("name") for element in ElementTree.fromstring(text).iter("SourceFile")]
    assert files and all(f"sources/{file}" in content.namelist() for file in files)
    assert ElementTree.fromstring(text)[0].get("modelIdentifier") == name


def test_the_reference_results_are_what_the_fmu_gives(fmu):
    """From the zip, step by step; nine digits are in the file."""
    _, name, content = fmu
    rows = {}
    for end in ("in", "out"):
        place = f"extra/pmu-observer.reference/{name}_{end}.csv"
        if place in content.namelist():
            rows[end] = list(csv.DictReader(content.read(place).decode().splitlines()))
    instance = Instance(Path(str(content.filename)))

    def feed(k: int) -> None:
        values = {n: float(v) for n, v in rows["in"][k].items() if n != "time"} if "in" in rows else {}
        reals = [instance.variables[n].valueReference for n in values]
        instance.slave.setReal(reals, list(values.values()))

    instance.slave.setupExperiment(startTime=0.0)
    instance.slave.enterInitializationMode()
    feed(0)
    instance.slave.exitInitializationMode()
    times = [float(row["time"]) for row in rows["out"]]
    step = {"SmibPlant": 1e-3}.get(name, 1 / 60)
    for k, row in enumerate(rows["out"]):
        assert times[k] == pytest.approx(k * step, rel=1e-8)
        names = [n for n in row if n != "time"]
        found = instance.slave.getReal([instance.variables[n].valueReference for n in names])
        assert found == pytest.approx([float(row[n]) for n in names], rel=1e-6, abs=1e-8), k
        if k + 1 < len(times):
            feed(k)
            assert instance.step(k * step, step) == OK
    instance.free()
