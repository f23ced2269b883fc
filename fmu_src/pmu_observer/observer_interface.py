"""The interface of the observer: PMU frames and the machine's inputs in, x-hat and how sure it is out."""

from collections import namedtuple
from typing import Annotated, Any, Dict, List, NamedTuple

from .estimators import ESTIMATORS
from .interface import INLINE, Boolean, Enumeration, Integer, Real, Rule, Scalar
from .machines import MACHINE_MODELS
from .machines.data import Machine, on_system_base
from .phasors import Frame
from .speed import SPEED_OBSERVERS
from .terminal import Transformer, transformer_on_system_base

WAITING, CAPTURING, TRACKING, HOLDING = 0, 1, 2, 3
"""Values of status."""

INPUTS, PHASORS = 1, 2
"""Items of power_source."""

ARRIVAL, STAMPED = 1, 2
"""Items of frame_time."""

MEASURED, ESTIMATED = 1, 2
"""Items of field_voltage and mechanical_power."""


def number(name: str, items: Dict[str, Any]) -> int:
    """Of an item of an enumeration, as FMI counts them."""
    return 1 + list(items).index(name)


class Inputs(NamedTuple):
    frame: Annotated[Frame, INLINE] = Frame()
    P_m: Annotated[Scalar, Real("pu", "mechanical power; not used where it is estimated")] = 0.0
    E_f: Annotated[
        Scalar, Real("pu", "field voltage (open circuit: E_f = 1 gives V = 1); not used where it is estimated")
    ] = 0.0
    frame_valid: Annotated[Scalar, Boolean("the frame is not marked invalid; else it is not taken")] = 1.0
    t_frame: Annotated[
        Scalar,
        Real("s", "time at which the frame was measured, on the simulation's clock; used where frame_time is stamped"),
    ] = 0.0


def of_each(kind: str, modules: Dict[str, Any]):
    """A tree with one branch a module, named like it: its Parameters or its Outputs, with their defaults."""
    return namedtuple(kind, modules)(*[getattr(module, kind)() for module in modules.values()])


class Parameters(NamedTuple):
    machine: Annotated[Machine, INLINE] = Machine(D=0.0)
    transformer: Annotated[Transformer, INLINE] = Transformer()
    S_base: Annotated[Scalar, Real("MVA", "base of the frames and of P_m", min=1e-6, max=1e6, nominal=100.0)] = 100.0
    S_n: Annotated[
        Scalar, Real("MVA", "base of the parameters of machine and transformer", min=1e-6, max=1e6, nominal=100.0)
    ] = 100.0
    machine_model: Annotated[
        Scalar,
        Enumeration(
            "MachineModel", "model of the machine; all but two_axis: with the estimator robust", tuple(MACHINE_MODELS)
        ),
    ] = number("two_axis", MACHINE_MODELS)
    estimator: Annotated[Scalar, Enumeration("Estimator", "estimator of E'd and E'q", tuple(ESTIMATORS))] = number(
        "robust", ESTIMATORS
    )
    tve: Annotated[
        Scalar,
        Real(
            "1",
            "assumed noise of the phasors: total vector error, RMS; rather too large than too small; "
            "0: estimated from the frames",
            min=0.0,
            max=0.2,
            nominal=0.01,
        ),
    ] = 0.01
    power_source: Annotated[
        Scalar,
        Enumeration("PowerSource", "P and Q from the inputs P_t, Q_t or from the phasors", ("inputs", "phasors")),
    ] = INPUTS
    frame_time: Annotated[
        Scalar,
        Enumeration(
            "FrameTime",
            "a frame is taken when it differs from the last one, and dated with the communication point; "
            "or it is taken when t_frame has grown, and dated with that",
            ("arrival", "stamped"),
        ),
    ] = ARRIVAL
    frame_period: Annotated[
        Scalar,
        Real(
            "s",
            "time between PMU frames: after 1.5 of it without a frame, status is 3; 0: learnt from the frames",
            min=0.0,
            max=10.0,
        ),
    ] = 0.0
    field_voltage: Annotated[
        Scalar,
        Enumeration(
            "FieldVoltage", "E_f from its input, or estimated (by the estimator robust)", ("measured", "estimated")
        ),
    ] = MEASURED
    speed_observer: Annotated[
        Scalar,
        Enumeration(
            "SpeedObserver",
            "I&I, I&I with a0 and b0 estimated, or a Kalman filter with its gain from tve",
            tuple(SPEED_OBSERVERS),
        ),
    ] = number("kalman", SPEED_OBSERVERS)
    mechanical_power: Annotated[
        Scalar,
        Enumeration(
            "MechanicalPower", "P_m from its input, or estimated by the speed observer", ("measured", "estimated")
        ),
    ] = MEASURED
    k_speed: Annotated[Scalar, Real("1/s", "gain of the I&I speed observer", min=0.0, max=1e4, tunable=True)] = 80.0
    speed: Annotated[Any, INLINE] = of_each("Parameters", SPEED_OBSERVERS)
    estimators: Annotated[Any, INLINE] = of_each("Parameters", ESTIMATORS)


def deviation(unit, of, known_to):
    return Real(unit, f"standard deviation of {of}; 0: not known (only {known_to} knows it) or measured", min=0.0)


class Outputs(NamedTuple):
    delta: Annotated[Scalar, Real("rad", "rotor angle in the frame of theta_t less shift, unwrapped")] = 0.0
    load_angle: Annotated[
        Scalar, Real("rad", "delta less the angle of the voltage at the machine's terminal, in (-pi, pi]")
    ] = 0.0
    omega: Annotated[Scalar, Real("rad/s", "deviation from synchronous speed")] = 0.0
    e1d: Annotated[Scalar, Real("pu", "E'd, d-axis transient voltage")] = 0.0
    e1q: Annotated[Scalar, Real("pu", "E'q, q-axis transient voltage")] = 0.0
    e2d: Annotated[Scalar, Real("pu", "E''d, d-axis subtransient voltage; 0 where the machine model has none")] = 0.0
    e2q: Annotated[Scalar, Real("pu", "E''q, q-axis subtransient voltage; 0 where the machine model has none")] = 0.0
    E_f_hat: Annotated[Scalar, Real("pu", "field voltage: measured or estimated, see field_voltage")] = 0.0
    P_m_hat: Annotated[Scalar, Real("pu", "mechanical power: measured or estimated, see mechanical_power")] = 0.0
    delta_std: Annotated[Scalar, deviation("rad", "delta", "speed_observer kalman")] = 0.0
    omega_std: Annotated[Scalar, deviation("rad/s", "omega", "speed_observer kalman")] = 0.0
    e1d_std: Annotated[Scalar, deviation("pu", "E'd", "estimator robust")] = 0.0
    e1q_std: Annotated[Scalar, deviation("pu", "E'q", "estimator robust")] = 0.0
    e2d_std: Annotated[Scalar, deviation("pu", "E''d", "estimator robust")] = 0.0
    e2q_std: Annotated[Scalar, deviation("pu", "E''q", "estimator robust")] = 0.0
    E_f_std: Annotated[Scalar, deviation("pu", "E_f", "estimator robust")] = 0.0
    P_m_std: Annotated[Scalar, deviation("pu", "P_m", "speed_observer kalman")] = 0.0
    innovation: Annotated[
        Scalar,
        Real("1", "|E'|^2 of the last frame less its prediction, in standard deviations; estimator robust, else 0"),
    ] = 0.0
    angle_innovation: Annotated[
        Scalar,
        Real(
            "1",
            "angle of E' of the last frame less the rotor's prediction, in standard deviations: "
            "wrong P_m, D, H, sign or unit of the angles; speed_observer kalman, else 0",
        ),
    ] = 0.0
    power_mismatch: Annotated[
        Scalar, Real("1", "|P + jQ - V conj(I)|/|V I| of the last frame: what it says twice, and not the same", min=0.0)
    ] = 0.0
    status: Annotated[
        Scalar,
        Integer(
            "0 waiting for a first usable frame, 1 capturing (no reliable estimate yet), 2 tracking, "
            "3 holding (no frame, or none to believe: prediction; or P_m or E_f is missing, and is the last one)",
            min=0,
            max=3,
        ),
    ] = WAITING
    speed: Annotated[Any, INLINE] = of_each("Outputs", SPEED_OBSERVERS)
    estimators: Annotated[Any, INLINE] = of_each("Outputs", ESTIMATORS)


def system_base(p: Parameters) -> Machine:
    return on_system_base(p.machine, p.S_n, p.S_base)


def system_transformer(p: Parameters) -> Transformer:
    return transformer_on_system_base(p.transformer, p.S_n, p.S_base)


def rules_of_machine(xp, machine_model, machine: Machine) -> List[Rule]:
    """Those of the selected model."""
    return [
        rule._replace(holds=xp.logical_or(machine_model != number(name, MACHINE_MODELS), rule.holds))
        for name, model in MACHINE_MODELS.items()
        for rule in model.rules(xp, machine)
    ]


def rules(xp, p: Parameters, inputs: Inputs) -> List[Rule]:
    """What must hold of parameters that are each in range."""
    one_unknown = xp.logical_or(p.speed_observer != number("adaptive", SPEED_OBSERVERS), p.mechanical_power == MEASURED)
    has_field = xp.logical_or(p.field_voltage == MEASURED, p.estimator == number("robust", ESTIMATORS))
    two_axis, robust = number("two_axis", MACHINE_MODELS), number("robust", ESTIMATORS)
    return [
        *rules_of_machine(xp, p.machine_model, p.machine),
        Rule(
            xp.logical_or(p.machine_model == two_axis, p.estimator == robust),
            "machine_model = {machine_model} is not allowed with estimator = {estimator}; the paper's estimators are "
            "of two_axis (1), robust (6) works with any",
        ),
        Rule(
            one_unknown,
            "mechanical_power = 2 (estimated) is not allowed with speed_observer = 2 (adaptive); use 1",
        ),
        Rule(
            has_field,
            "field_voltage = 2 (estimated) is not allowed with estimator = {estimator}; only robust (6) estimates it",
        ),
    ]
