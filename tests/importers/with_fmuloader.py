"""fmuloader, from Python: it binds every function of FMI 2.0, those of model exchange too."""

from pathlib import Path

from fmpy import read_model_description
from fmuloader.fmi2 import Fmi2Slave, Fmi2Status, Fmi2Type

from .case import CONNECTIONS, FMUS, INTEGERS, REALS, RESULTS, STEPS, H, main, of, split


def load(path: Path, name: str) -> tuple[Fmi2Slave, dict[str, int]]:
    description = read_model_description(path)
    slave = Fmi2Slave(path, model_identifier=path.stem)
    slave.instantiate(name, Fmi2Type.CO_SIMULATION, guid=str(description.guid))
    return slave, {v.name: v.valueReference for v in description.modelVariables}


def run(folder: Path) -> dict[str, float]:
    slaves, references = {}, {}
    for name, fmu in FMUS.items():
        slaves[name], references[name] = load(folder / fmu, name)

    def referred(name: str, variables) -> list[int]:
        return [references[name][variable] for variable in variables]

    def exchange() -> None:
        values = {t: slaves[c].get_real(referred(c, [v]))[0] for t, (c, v) in sources.items()}
        for name, slave in slaves.items():
            own = of(name, values)
            slave.set_real(referred(name, own), list(own.values()))

    sources = {target: split(source) for target, source in CONNECTIONS.items()}
    for name, slave in slaves.items():
        reals, integers = of(name, REALS), of(name, INTEGERS)
        slave.set_real(referred(name, reals), list(reals.values()))
        slave.set_integer(referred(name, integers), list(integers.values()))
        slave.setup_experiment(start_time=0.0)
        slave.enter_initialization_mode()
    for _ in slaves:
        exchange()
    for slave in slaves.values():
        slave.exit_initialization_mode()
    for k in range(STEPS):
        exchange()
        for slave in slaves.values():
            assert slave.do_step(k * H, H) == Fmi2Status.OK
    results = {}
    for name, names in RESULTS.items():
        values = slaves[name].get_real(referred(name, names))
        results |= {f"{name}.{variable}": value for variable, value in zip(names, values, strict=True)}
    for slave in slaves.values():
        slave.terminate()
        slave.free_instance()
    return results


if __name__ == "__main__":
    main(run)
