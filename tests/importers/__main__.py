"""python -m tests.importers [--readme]: both kinds of FMU in every importer; a table, printed or put into README.md."""

import argparse
import tempfile
from pathlib import Path

import build_fmu
from fmu_src.runtime import readme

from . import runs


def table(folder: Path) -> str:
    rows = ["| importer | language of the host | native FMU | Python FMU |", "|---|---|---|---|"]
    for importer in runs.IMPORTERS:
        cells = [runs.verdict(importer, folder, kind) for kind in ("native", "python")]
        rows.append(f"| {importer.name} {runs.version(importer)} | {importer.host} | {' | '.join(cells)} |")
    return "\n".join(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--readme", action="store_true", help="write the table into README.md")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name in build_fmu.native_names():
            build_fmu.build(name, folder)
            build_fmu.build_native(name, folder, build_fmu.say)
        text = table(folder)
    if arguments.readme:
        readme.write(build_fmu.ROOT / "README.md", "importers", text)
    else:
        print(text)


if __name__ == "__main__":
    main()
