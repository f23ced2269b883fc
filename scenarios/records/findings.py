"""What checks find: how grave it is, what was measured, the likely mistakes, and the lines that mend them."""

from dataclasses import dataclass

NONSENSE, DOUBTFUL = "nonsense", "doubtful"
"""Of a finding: no right record has it; or a right one may."""


@dataclass(frozen=True)
class Cause:
    """A mistake, and the line of the map (or of machines.csv) that mends it."""

    name: str
    mends: str


@dataclass(frozen=True)
class Finding:
    check: str
    grade: str
    measured: str
    causes: tuple[str, ...]
    """Names in CAUSES, the likeliest first."""

    @property
    def lines(self) -> list[str]:
        """`cause: what mends it`."""
        return [f"{CAUSES[cause].name}: {CAUSES[cause].mends}" for cause in self.causes]


CAUSES: dict[str, Cause] = {
    "neutral on line base": Cause("V is line-to-neutral, taken for line-line", 'V: is = "line-neutral"'),
    "line on neutral base": Cause("V is line-line, taken for line-to-neutral", 'V: is = "line-line"'),
    "V in kV": Cause("V is in kV, taken for V", 'V: unit = ["kV", ...]'),
    "V in V": Cause("V is in V, taken for kV", 'V: unit = ["V", ...]'),
    "V peak": Cause("V is a peak value, taken for RMS", 'V: value = "peak"'),
    "V rms": Cause("V is an RMS value, taken for peak", 'V: value = "rms"'),
    "V base": Cause("the base of V is not the machine's", 'V: base = "... kV line-line"'),
    "V per cent": Cause("V is in %, taken for pu", 'V: unit = ["%", ...]'),
    "I in kA": Cause("I is in kA, taken for A", 'I: unit = ["kA", ...]'),
    "I in A": Cause("I is in A, taken for kA", 'I: unit = ["A", ...]'),
    "I peak": Cause("I is a peak value, taken for RMS", 'I: value = "peak"'),
    "I base": Cause("I is in pu of another base", 'I: base = "... MVA"'),
    "I ratio": Cause(
        "the current transformer's ratio is not the one in the file", "I: correct the scale at its source"
    ),
    "I phase to phase": Cause("I is off by sqrt 3: delta windings, or line-line V with phase power", "I, V: is, base"),
    "V and I exchanged": Cause("the columns of V and I are exchanged", "V, I: magnitude and angle"),
    "theta and phi exchanged": Cause("the angles of V and I are exchanged", "V, I: angle"),
    "degrees": Cause("angles are in degrees, taken for rad", 'V, I: unit = [..., "deg"]'),
    "radians": Cause("angles are in rad, taken for degrees", 'V, I: unit = [..., "rad"]'),
    "conjugate": Cause("angles are counted the other way round", "V, I: conjugate = true"),
    "V in another unit of angle": Cause("the angle of V alone is in another unit", "V: unit"),
    "load I": Cause("I flows into the generator", 'I: direction = "into the generator"'),
    "load P Q": Cause("P and Q are those into the generator", 'P, Q: direction = "into the generator"'),
    "load all": Cause("I, P and Q are those into the generator", 'I, P, Q: direction = "into the generator"'),
    "Q sign": Cause("Q has the sign of the load convention", 'Q: direction = "into the generator"'),
    "P sign": Cause("P has the sign of the load convention", 'P: direction = "into the generator"'),
    "P and Q exchanged": Cause("the columns of P and Q are exchanged", "P, Q: column"),
    "30 degrees": Cause("one phasor is line-line, or on the other side of the transformer", 'V: is = "AB", or shift'),
    "120 degrees": Cause("V and I are of different phases", "V, I: angle and magnitude of one phase, or shift"),
    "shift": Cause("V and I are shifted against each other", "V or I: shift"),
    "P in MW": Cause("P and Q are off by 1000: kW, MW", "P, Q: unit"),
    "P base": Cause("P and Q are in pu of another base", 'P, Q: base = "... MVA"'),
    "P per phase": Cause("P and Q are those of one phase", "P, Q: the sum of three phases"),
    "P_m in MW": Cause("P_m is in MW, taken for pu", 'P_m: unit = "MW"'),
    "P_m in kW": Cause("P_m is off by 1000: kW, MW", "P_m: unit"),
    "P_m base": Cause("P_m is in pu of another base", 'P_m: base = "... MVA"'),
    "P_m sign": Cause("P_m is negative", "P_m: column"),
    "P_m scale": Cause("P_m is scaled wrongly, or not that of this machine", "P_m: column, unit; or leave it out"),
    "P_m per cent": Cause("P_m is in %, of the rating or taken for pu", 'P_m: unit = "%", base = "... MVA"'),
    "E_f in volts": Cause("E_f is in volts or amperes, taken for pu", 'E_f: unit = "V", base = "... V"'),
    "E_f base at rated load": Cause("E_f = 1 is at rated load, not at no load", "E_f: base, the value at no load"),
    "E_f scale": Cause("E_f is scaled wrongly", "E_f: base; or leave it out, and let it be estimated"),
    "saturation": Cause("the machine saturates, and its S10 and S12 are not given", "machines.csv: S10, S12"),
    "E_f sign": Cause("E_f is negative", "E_f: column"),
    "reactances on another base": Cause("reactances are on another base than S_n", "machines.csv: S_n, xd, xq"),
    "machine": Cause("the data are not of this machine", "--unit, machines.csv"),
    "omega_s": Cause("the machine's synchronous speed is not the record's", "machines.csv: omega_s; or frequency"),
    "frequency": Cause("the nominal frequency is not the record's", "frequency = 50 (or 60)"),
    "f deviation": Cause("f is the deviation from nominal", "f: deviation = true"),
    "rate": Cause("the frame rate is not the file's", "rate"),
    "time unit": Cause("the times are in another unit", 'time: unit = "ms"'),
    "time off raster": Cause("stamps are those of arrival, or cut off", "time: column, or a better one; see t_frame"),
    "repeated": Cause("stamps stand twice: two sources in one file, or a clock set back", "time: zone; one source"),
    "backward": Cause("times go back: rows are not sorted, or local time at the end of summer", 'time: zone = "UTC"'),
    "lost": Cause("frames are lost", "nothing: they are held; the standard deviations grow"),
    "held": Cause("a stream that was held, or sampled faster than its frames come", "rate, or another export"),
    "offline": Cause("the machine was off line, or these are not its phasors", "V, I: columns"),
    "D in pu": Cause("D is per pu speed, or the FMU's default: PSS/E's D is divided by omega_s", "machines.csv: D"),
    "machine data": Cause("a value is out of what machines have", "machines.csv"),
}
