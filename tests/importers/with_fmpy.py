"""FMPy, from Python: the reference that the others are compared with."""

from pathlib import Path

from ..fmu.instance import OK, Instance
from .case import CONNECTIONS, FMUS, INTEGERS, REALS, RESULTS, STEPS, H, main, of, split


def run(folder: Path) -> dict[str, float]:
    instances = {name: Instance(folder / fmu, name) for name, fmu in FMUS.items()}

    def exchange() -> None:
        values = {target: instances[c].get(name)[0] for target, (c, name) in sources.items()}
        for name, instance in instances.items():
            instance.set(**{target.replace(".", "__"): value for target, value in of(name, values).items()})

    sources = {target: split(source) for target, source in CONNECTIONS.items()}
    for name, instance in instances.items():
        instance.set(**of(name, {**REALS, **INTEGERS}))
        instance.slave.setupExperiment(startTime=0.0)
        instance.slave.enterInitializationMode()
    for _ in instances:
        exchange()
    for instance in instances.values():
        instance.slave.exitInitializationMode()
    for k in range(STEPS):
        exchange()
        for instance in instances.values():
            assert instance.step(k * H, H) == OK
    results = {f"{name}.{v}": instances[name].get(v)[0] for name, names in RESULTS.items() for v in names}
    for instance in instances.values():
        instance.free()
    return results


if __name__ == "__main__":
    main(run)
