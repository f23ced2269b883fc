"""terminalsAndIcons.xml: a PMU's frame as one terminal, in the form of FMI 3.0 that FMI 2.0.4 takes over."""

from typing import Iterator, Tuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .model import Model, Terminal
from .ports import ports

MEMBERS = ("V_t", "theta_t", "I_t", "phi_t", "P_t", "Q_t", "P_m", "E_f", "frame_valid", "t_frame")
KIND = "pmu-observer.frame"


def members(model: Model, terminal: Terminal) -> Iterator[Tuple[str, str]]:
    """Names in the frame and of the variables; `P_m_out` stands for P_m where that is an input itself."""
    names = {port.variable.name for port in ports(model) if port.causality == terminal.causality}
    for member in MEMBERS:
        for name in (terminal.prefix + member, f"{terminal.prefix}{member}_out"):
            if name in names:
                yield member, name


def terminals_and_icons(model: Model) -> bytes:
    """The file's bytes. Terminals are matched as a bus: what both sides have of a frame is connected."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = SubElement(root, "Terminals")
    for name, terminal in model.terminals.items():
        element = SubElement(terminals, "Terminal", name=name, matchingRule="bus", terminalKind=KIND)
        element.set("description", terminal.description)
        for member, variable in members(model, terminal):
            SubElement(
                element, "TerminalMemberVariable", variableName=variable, memberName=member, variableKind="signal"
            )
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"
