"""A machine as an SSP 1.0 parameter set (.ssv), which SSP tools give to the FMU, and as FMPy's --start-values."""

from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fmu_src.pmu_observer.machines import MACHINE_MODELS

from .table import Machine

NAMESPACE = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
COMMON = "http://ssp-standard.org/SSP1/SystemStructureCommon"

NUMBERS = {name: number for number, name in enumerate(MACHINE_MODELS, 1)}
"""Items of the FMU's enumeration machine_model: FMPy takes their numbers."""


def parameter_set(machine: Machine) -> bytes:
    """The .ssv file; numbers with all their digits."""
    root = Element("ssv:ParameterSet", {"xmlns:ssv": NAMESPACE, "xmlns:ssc": COMMON, "version": "1.0"})
    root.set("name", machine.unit)
    parameters = SubElement(root, "ssv:Parameters")
    for name, value in machine.parameters.items():
        parameter = SubElement(parameters, "ssv:Parameter", name=name)
        if isinstance(value, str):
            SubElement(parameter, "ssv:Enumeration", value=value)
        else:
            SubElement(parameter, "ssv:Real", value=repr(value))
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"


def write(machine: Machine, path: Path) -> None:
    path.write_bytes(parameter_set(machine))


def start_values(machine: Machine) -> str:
    """`H 3.48 D 0.0 ...`: what stands behind `fmpy simulate PmuObserver.fmu --start-values`."""
    values = [(n, str(NUMBERS[v]) if isinstance(v, str) else repr(v)) for n, v in machine.parameters.items()]
    return " ".join(f"{name} {value}" for name, value in values)
