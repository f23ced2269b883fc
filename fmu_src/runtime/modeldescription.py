"""modelDescription.xml of a model, from its annotated trees (FMI 2.0.x, co-simulation)."""

from math import pi
from typing import List, Tuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ..pmu_observer.interface import Boolean, Enumeration, Real
from .dependencies import at_start, in_step_mode
from .model import Model
from .ports import Port, ports

VERSION = "0.1.0"

BASE_UNITS = {
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "s": {"s": 1},
    "s/rad": {"s": 1, "rad": -1},
    "1/s": {"s": -1},
    "Hz": {"s": -1},
    "MVA": {"kg": 1, "m": 2, "s": -3, "factor": 1000000},
    "pu": {},
    "1": {},
}
"""Exponents of the SI base units, and a factor."""

DISPLAY_UNITS = {"rad": ("deg", 180 / pi), "rad/s": ("Hz", 1 / (2 * pi))}
"""What people read instead: its name, and how many of it the unit is."""


def model_description(model: Model, guid: str, capabilities: dict, source_files: Tuple[str, ...] = ()) -> bytes:
    """The file's bytes. `capabilities` are further attributes of the CoSimulation element, as the runtime has them."""
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model.name,
        guid=guid,
        description=model.description,
        author="The pmu-observer authors",
        version=VERSION,
        copyright="Copyright (c) 2026 The pmu-observer authors",
        license="MIT",
        generationTool=f"pmu-observer {VERSION}",
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    co_simulation = SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        **capabilities,
    )
    if source_files:
        files = SubElement(co_simulation, "SourceFiles")
        for name in source_files:
            SubElement(files, "File", name=name)
    all_ports = ports(model)
    unit_definitions(root, all_ports)
    type_definitions(root, all_ports)
    log_categories(root)
    SubElement(
        root, "DefaultExperiment", startTime="0", stopTime=f"{model.stop_time:g}", stepSize=exact(model.step_size)
    )
    model_variables = SubElement(root, "ModelVariables")
    for reference, port in enumerate(all_ports):
        scalar_variable(model_variables, reference, port)
    model_structure(root, model, all_ports)
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"


def exact(value: float) -> str:
    """17 digits where they are needed: the text reads back as the same number."""
    return repr(float(value)).removesuffix(".0")


def unit_definitions(root: Element, all_ports: List[Port]) -> None:
    units = {port.variable.specification.unit for port in all_ports if isinstance(port.variable.specification, Real)}
    definitions = SubElement(root, "UnitDefinitions")
    for name in sorted(units):
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(unit, "BaseUnit", {base: str(power) for base, power in BASE_UNITS[name].items()})
        if name in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[name]
            SubElement(unit, "DisplayUnit", name=display, factor=exact(factor))


def type_definitions(root: Element, all_ports: List[Port]) -> None:
    types = {
        port.variable.specification.type_name: port.variable.specification
        for port in all_ports
        if isinstance(port.variable.specification, Enumeration)
    }
    if not types:
        return  # the schema allows no empty list
    definitions = SubElement(root, "TypeDefinitions")
    for name, specification in types.items():
        enumeration = SubElement(SubElement(definitions, "SimpleType", name=name), "Enumeration")
        for number, item in enumerate(specification.items, 1):
            SubElement(enumeration, "Item", name=item, value=str(number))


def log_categories(root: Element) -> None:
    categories = SubElement(root, "LogCategories")
    for name in ("logStatusDiscard", "logStatusError", "logAll"):
        SubElement(categories, "Category", name=name)


def scalar_variable(parent: Element, reference: int, port: Port) -> None:
    (name, specification, start), causality, variability = port
    element = SubElement(
        parent,
        "ScalarVariable",
        name=name,
        valueReference=str(reference),
        description=specification.description,
        causality=causality,
        variability=variability,
    )
    attributes = {}
    if isinstance(specification, Enumeration):
        attributes["declaredType"] = specification.type_name
    elif not isinstance(specification, Boolean):
        number = exact if isinstance(specification, Real) else str
        if isinstance(specification, Real):
            attributes["unit"] = specification.unit
            if specification.unit in DISPLAY_UNITS:
                attributes["displayUnit"] = DISPLAY_UNITS[specification.unit][0]
        limits = {"min": specification.min, "max": specification.max}
        attributes.update({key: number(limit) for key, limit in limits.items() if limit is not None})
        if isinstance(specification, Real) and specification.nominal != 1.0:
            attributes["nominal"] = exact(specification.nominal)
    if causality == "output":
        element.set("initial", "calculated")
    else:
        if causality == "parameter":
            element.set("initial", "exact")
        if isinstance(specification, Boolean):
            attributes["start"] = "1" if start else "0"  # some importers read no "true"
        else:
            attributes["start"] = exact(start)
    SubElement(element, type(specification).__name__, attributes)


def model_structure(root: Element, model: Model, all_ports: List[Port]) -> None:
    """What each output depends on: on inputs of its own instant in step mode, on inputs and parameters at the start."""
    structure = SubElement(root, "ModelStructure")
    outputs = [index for index, port in enumerate(all_ports, 1) if port.causality == "output"]
    for element, found in (("Outputs", in_step_mode(model)), ("InitialUnknowns", at_start(model))):
        unknowns = SubElement(structure, element)
        for index, places in zip(outputs, found):
            indices = " ".join(str(place + 1) for place in places)
            SubElement(unknowns, "Unknown", index=str(index), dependencies=indices)
