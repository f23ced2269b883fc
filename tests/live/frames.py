"""Configurations and data to test with."""

import cmath
from itertools import product

from scenarios.live.c37118 import (
    CONFIG_2,
    CONFIG_3,
    Analog,
    Configuration,
    Data,
    Digital,
    Measurement,
    Phasor,
    Stamp,
    Station,
)

NAMES = tuple(f"BREAKER {k}" for k in range(16))
SOC = 1_700_000_000


def station(name: str, idcode: int, third: bool, polar=False, phasors=True, frequency=True, analogs=True) -> Station:
    """Two voltages, a current, two analogs and a digital word. Floats in CFG-3 come scaled (Table 11: 1 and 0)."""
    scaled = third and not phasors
    return Station(
        name,
        idcode,
        (
            Phasor("VA", False, 1.5 if scaled or not third else 1.0, 0.1 if scaled else 0.0, 4 if third else 1),
            Phasor("V1", False, 2.5 if scaled or not third else 1.0),
            Phasor("I1", True, 0.05 if scaled or not third else 1.0),
        ),
        (
            Analog("P", 0, 2.0, 3.0) if third and not analogs else Analog("P", 0 if third else 1),
            Analog("Q", 0, -1.0) if third and not analogs else Analog("Q", 0 if third else 2, 1.0 if third else -7.0),
        ),
        (Digital(NAMES, 0x0003, 0x00FF),),
        polar=polar,
        phasors_float=phasors,
        frequency_float=frequency,
        analogs_float=analogs,
        nominal_frequency=60 if idcode % 2 else 50,
        changes=idcode,
    )


def configuration(kind: int = CONFIG_2, **format_) -> Configuration:
    stations = tuple(station(f"STATION {k}", 100 + k, kind == CONFIG_3, **format_) for k in (1, 2, 3))
    return Configuration(7, stations, 60, 16_777_215, kind, Stamp(SOC, 5, 0x05))


FORMATS = [
    dict(zip(("polar", "phasors", "frequency", "analogs"), choice, strict=True))
    for choice in product((False, True), repeat=4)
]


def data(configuration: Configuration, number: int = 0) -> Data:
    """Data frame `number` of a stream from SOC on; its values differ from station to station and frame to frame."""
    seconds, rest = divmod(number, configuration.rate)
    measurements = tuple(
        Measurement(
            0x0000,
            tuple(
                cmath.rect(size * (1 + 0.01 * k), angle + 0.01 * number + k)
                for size, angle in ((12_000.0, 0.5), (13_800.0, -2.0), (900.0, 3.0))
            ),
            s.nominal_frequency + 0.012 * (k + 1),
            -0.25 * (k + 1),
            (100.0 + number + k, -37.0),
            (0x1234 + k,),
        )
        for k, s in enumerate(configuration.stations)
    )
    fraction = rest * configuration.time_base // configuration.rate
    return Data(configuration.idcode, Stamp(SOC + seconds, fraction), measurements)
