"""FMPy, from Python: the reference that the others are compared with."""

from pathlib import Path

from ..fmu.instance import OK, Instance
from .case import FRAME, OBSERVER, PLANT, RESULTS, STARTS, STEPS, H, main


def run(folder: Path) -> dict[str, float]:
    plant = Instance(folder / PLANT, "plant").initialise()
    observer = Instance(folder / OBSERVER, "observer")
    observer.initialise(**STARTS, **dict(zip(FRAME, plant.get(*FRAME), strict=True)))
    for k in range(STEPS):
        observer.set(**dict(zip(FRAME, plant.get(*FRAME), strict=True)))
        assert plant.step(k * H, H) == OK
        assert observer.step(k * H, H) == OK
    instances = {"plant": plant, "observer": observer}
    results = {f"{name}.{v}": instances[name].get(v)[0] for name, names in RESULTS.items() for v in names}
    plant.free()
    observer.free()
    return results


if __name__ == "__main__":
    main(run)
