"""Python FMUs share one interpreter: each must run its own code, and survive garbage collections."""

import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import build_fmu

ROOT = Path(build_fmu.__file__).parent


def run(script: str, *arguments: str, cwd: Path = ROOT) -> str:
    """Run a script in a process of its own; a crash fails the test and spares the others."""
    command = [sys.executable, "-c", textwrap.dedent(script), *arguments]
    result = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300, check=False)
    assert result.returncode == 0, result.stderr[-2000:]
    return result.stdout


def test_two_versions_side_by_side(dist, tmp_path):
    """A second version of the package, with another equation, in the same process: each FMU keeps its own."""
    shutil.copytree(ROOT / "fmu_src", tmp_path / "fmu_src", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "build_fmu.py", tmp_path)
    shutil.copy(ROOT / "LICENSE", tmp_path)
    plant = tmp_path / "fmu_src" / "pmu_observer" / "plants" / "smib.py"
    text = plant.read_text()
    changed = text.replace("V_t=xp.sqrt(Vd * Vd + Vq * Vq)", "V_t=42.0")
    assert changed != text
    plant.write_text(changed)
    run("import build_fmu; build_fmu.build('SmibPlant')", cwd=tmp_path)

    output = run(
        """
        import sys
        from pathlib import Path
        from tests.fmu.instance import Instance
        first, second = [Instance(Path(path)).initialise() for path in sys.argv[1:]]
        for k in range(3):
            for instance in (first, second):
                instance.step(k * 0.01, 0.01)
        print(first.get("V_t"), second.get("V_t"))
        """,
        str(dist / "python" / "SmibPlant.fmu"),
        str(tmp_path / "dist" / "python" / "SmibPlant.fmu"),
    )
    assert output.split() == ["[1.0]", "[42.0]"]


def test_3000_instances_and_collections(dist):
    """pythonfmu's binary gives back a reference it does not own, once an instance: a small module dies of it."""
    output = run(
        """
        import gc, sys
        from fmpy import extract, read_model_description
        from fmpy.fmi2 import FMU2Slave
        path = sys.argv[1]
        description, folder = read_model_description(path), extract(path)
        identifier = description.coSimulation.modelIdentifier
        slave = FMU2Slave(guid=description.guid, unzipDirectory=folder, modelIdentifier=identifier, instanceName="x")
        for i in range(3000):
            slave.instantiate()
            slave.fmi2FreeInstance(slave.component)
            if i % 100 == 0:
                gc.collect()
        gc.collect()
        slave.instantiate()
        slave.setupExperiment()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slave.doStep(0.0, 0.01)
        print("alive")
        """,
        str(dist / "python" / "PmuObserver.fmu"),
    )
    assert output.strip() == "alive"


def test_nothing_of_the_fmu_is_named_like_the_project(dist):
    """What is imported from inside an FMU has a hash in its name, so that no installed package can stand in for it."""
    output = run(
        """
        import sys
        from pathlib import Path
        before = set(sys.modules)
        from tests.fmu.instance import Instance
        Instance(Path(sys.argv[1])).initialise()
        print(*sorted({name.split(".")[0] for name in sys.modules if "PmuObserver" in name or "pythonfmu" in name}))
        """,
        str(dist / "python" / "PmuObserver.fmu"),
    )
    names = output.split()
    assert len(names) == 2
    assert all(name.split("_")[-1].isalnum() and len(name.split("_")[-1]) == 32 for name in names)
