"""An SSP 1.0: FMUs, how they are connected, and values to start from, in one file."""

from pathlib import Path
from typing import Dict, NamedTuple, Tuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .model import Model
from .modeldescription import VERSION, exact
from .package import write_fmu
from .ports import kind_of, ports

NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructure"
SCHEMAS = {"ssc": "Common", "ssd": "Description", "ssv": "ParameterValues"}


class System(NamedTuple):
    """Components by name; the source of every `component.variable` that is connected; and values to start from."""

    name: str
    description: str
    components: Dict[str, Model]
    connections: Dict[str, str]
    starts: Dict[str, float]


def build(system: System, fmus: Dict[str, Path], path: Path) -> bool:
    """Write the SSP with the FMU of each component; returns whether the file changed."""
    files = {f"resources/{fmu.name}": fmu.read_bytes() for fmu in fmus.values()}
    files["SystemStructure.ssd"] = structure(system, {name: f"resources/{fmu.name}" for name, fmu in fmus.items()})
    return write_fmu(path, files)


def structure(system: System, sources: Dict[str, str]) -> bytes:
    """SystemStructure.ssd. An input that is not connected is no connector, and keeps its start value."""
    spaces = {f"xmlns:{prefix}": f"{NAMESPACE}{schema}" for prefix, schema in SCHEMAS.items()}
    root = Element("ssd:SystemStructureDescription", {**spaces, "version": "1.0", "name": system.name})
    root.set("generationTool", f"pmu-observer {VERSION}")
    top = SubElement(root, "ssd:System", name=system.name, description=system.description)
    elements = SubElement(top, "ssd:Elements")
    for name in system.components:
        component(elements, system, name, sources[name])
    connections = SubElement(top, "ssd:Connections")
    for ends in system.connections.items():
        (end, end_connector), (start, start_connector) = map(split, ends)
        connection = {"startElement": start, "startConnector": start_connector}
        SubElement(connections, "ssd:Connection", connection, endElement=end, endConnector=end_connector)
    SubElement(root, "ssd:DefaultExperiment", startTime="0", stopTime="10")
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"


def component(parent: Element, system: System, name: str, source: str) -> None:
    element = SubElement(parent, "ssd:Component", name=name, type="application/x-fmu-sharedlibrary", source=source)
    connectors = SubElement(element, "ssd:Connectors")
    for port in ports(system.components[name]):
        if port.causality == "output" or f"{name}.{port.variable.name}" in system.connections:
            connector = SubElement(connectors, "ssd:Connector", name=port.variable.name, kind=port.causality)
            SubElement(connector, f"ssc:{kind_of(port.variable.specification)}")

    starts = {split(start)[1]: value for start, value in system.starts.items() if split(start)[0] == name}
    if starts:
        binding = SubElement(SubElement(element, "ssd:ParameterBindings"), "ssd:ParameterBinding")
        values = SubElement(binding, "ssd:ParameterValues")
        parameters = SubElement(SubElement(values, "ssv:ParameterSet", version="1.0", name="start"), "ssv:Parameters")
        for variable, value in starts.items():
            SubElement(SubElement(parameters, "ssv:Parameter", name=variable), "ssv:Real", value=exact(value))


def split(name: str) -> Tuple[str, str]:
    """The component and its variable, whose own name may have dots."""
    first, _, variable = name.partition(".")
    return first, variable
