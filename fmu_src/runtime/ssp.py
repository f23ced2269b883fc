"""An SSP 1.0: FMUs, how they are connected, and values to start from, in one file."""

from pathlib import Path
from typing import Dict, NamedTuple, Tuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ..pmu_observer.interface import Real
from .model import Model
from .modeldescription import BASE_UNITS, VERSION, exact
from .package import write_fmu
from .ports import Port, kind_of, ports

NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructure"
SCHEMAS = {"ssc": "Common", "ssd": "Description", "ssv": "ParameterValues"}
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
"""Of libcosim, which takes its step from there."""


class System(NamedTuple):
    """Components by name; the source of every `component.variable` that is connected; and values to start from."""

    name: str
    description: str
    components: Dict[str, Model]
    connections: Dict[str, str]
    outputs: Dict[str, str]
    """What the system shows as its own where it is a part of another one: `component.variable` by its name there."""
    sets: Dict[str, Dict[str, float]]
    """Values of `component.variable` to start from, by the name of the set; the first set is bound."""
    step_size: float
    """s; of the master."""


def build(system: System, fmus: Dict[str, Path], path: Path) -> bool:
    """Write the SSP with the FMU of each component; returns whether the file changed.

    SystemStructure.ssd runs in every importer. container.ssd has connectors of the system itself too, for importers
    that nest systems; ecos and libcosim refuse them. Each set of values is a file as well.
    """
    sources = {name: f"resources/{fmu.name}" for name, fmu in fmus.items()}
    files = {f"resources/{fmu.name}": fmu.read_bytes() for fmu in fmus.values()}
    files["SystemStructure.ssd"] = structure(system._replace(outputs={}), sources)
    files["container.ssd"] = structure(system, sources)
    for name, values in system.sets.items():
        root = parameter_set(system, name, values)
        root.attrib.update({f"xmlns:{prefix}": f"{NAMESPACE}{SCHEMAS[prefix]}" for prefix in ("ssc", "ssv")})
        files[f"resources/{name}.ssv"] = document(root)
    return write_fmu(path, files)


def structure(system: System, sources: Dict[str, str]) -> bytes:
    """The .ssd. An input that is not connected is no connector, and keeps its start value."""
    spaces = {f"xmlns:{prefix}": f"{NAMESPACE}{schema}" for prefix, schema in SCHEMAS.items()}
    spaces["xmlns:osp"] = OSP  # here, because libcosim takes attributes of the annotation for algorithms
    root = Element("ssd:SystemStructureDescription", {**spaces, "version": "1.0", "name": system.name})
    root.set("generationTool", f"pmu-observer {VERSION}")
    top = SubElement(root, "ssd:System", name=system.name, description=system.description)
    if system.outputs:
        connectors = SubElement(top, "ssd:Connectors")
        for name, source in system.outputs.items():
            connector(connectors, name, "output", port_of(system, source))
    elements = SubElement(top, "ssd:Elements")
    for name in system.components:
        component(elements, system, name, sources[name])
    connections = SubElement(top, "ssd:Connections")
    for target, source in system.connections.items():
        (start, start_connector), (end, end_connector) = split(source), split(target)
        ends = {"startElement": start, "startConnector": start_connector, "endElement": end}
        SubElement(connections, "ssd:Connection", ends, endConnector=end_connector)
    for name, source in system.outputs.items():
        start, start_connector = split(source)
        ends = {"startElement": start, "startConnector": start_connector}
        SubElement(connections, "ssd:Connection", ends, endConnector=name)
    units(root, system)
    experiment = SubElement(root, "ssd:DefaultExperiment", startTime="0", stopTime="10")
    annotations = SubElement(experiment, "ssd:Annotations")
    annotation = SubElement(annotations, "ssc:Annotation", type="com.opensimulationplatform")
    algorithm = SubElement(annotation, "osp:Algorithm")
    SubElement(algorithm, "osp:FixedStepAlgorithm", baseStepSize=exact(system.step_size))
    return document(root)


def document(root: Element) -> bytes:
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"


def units(root: Element, system: System) -> None:
    of_ports = [port.variable.specification for model in system.components.values() for port in ports(model)]
    definitions = SubElement(root, "ssd:Units")
    for name in sorted({specification.unit for specification in of_ports if isinstance(specification, Real)}):
        base = {key: str(power) for key, power in BASE_UNITS[name].items()}
        SubElement(SubElement(definitions, "ssc:Unit", name=name), "ssc:BaseUnit", base)


def component(parent: Element, system: System, name: str, source: str) -> None:
    element = SubElement(parent, "ssd:Component", name=name, type="application/x-fmu-sharedlibrary", source=source)
    connectors = SubElement(element, "ssd:Connectors")
    for port in ports(system.components[name]):
        if port.causality == "output" or f"{name}.{port.variable.name}" in system.connections:
            connector(connectors, port.variable.name, port.causality, port)

    bound, values = next(iter(system.sets.items()), ("", {}))
    own = {split(key)[1]: value for key, value in values.items() if split(key)[0] == name}
    if own:
        binding = SubElement(SubElement(element, "ssd:ParameterBindings"), "ssd:ParameterBinding")
        only = system._replace(components={"": system.components[name]})
        SubElement(binding, "ssd:ParameterValues").append(parameter_set(only, bound, own))


def connector(parent: Element, name: str, kind: str, port: Port) -> None:
    element = SubElement(parent, "ssd:Connector", name=name, kind=kind)
    specification = port.variable.specification
    unit = {"unit": specification.unit} if isinstance(specification, Real) else {}
    SubElement(element, f"ssc:{kind_of(specification)}", unit)


def parameter_set(system: System, name: str, values: Dict[str, float]) -> Element:
    root = Element("ssv:ParameterSet", version="1.0", name=name)
    parameters = SubElement(root, "ssv:Parameters")
    for variable, value in values.items():
        specification = port_of(system, variable).variable.specification
        parameter = SubElement(parameters, "ssv:Parameter", name=variable)
        if isinstance(specification, Real):
            SubElement(parameter, "ssv:Real", value=exact(value), unit=specification.unit)
        else:
            SubElement(parameter, f"ssv:{kind_of(specification)}", value=str(int(value)))
    return root


def port_of(system: System, name: str) -> Port:
    """Of `component.variable`; of the variable alone where there is one component without a name."""
    component, variable = ("", name) if "" in system.components else split(name)
    return next(port for port in ports(system.components[component]) if port.variable.name == variable)


def split(name: str) -> Tuple[str, str]:
    """The component and its variable, whose own name may have dots."""
    first, _, variable = name.partition(".")
    return first, variable
