"""python -m tests.importers [--readme]: both kinds of FMU in every importer; a table, printed or put into README.md."""

import argparse
import tempfile
from pathlib import Path

import build_fmu

from . import runs

BEGIN, END = "<!-- importers: begin -->\n", "<!-- importers: end -->"


def table(folder: Path) -> str:
    rows = ["| importer | language of the host | native FMU | Python FMU |", "|---|---|---|---|"]
    for importer in runs.IMPORTERS:
        cells = [runs.verdict(importer, folder, kind) for kind in ("native", "python")]
        rows.append(f"| {importer.name} {runs.version(importer)} | {importer.host} | {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--readme", action="store_true", help="write the table into README.md")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name in ("SmibPlant", "PmuObserver"):
            build_fmu.build(name, folder)
            build_fmu.build_native(name, folder, build_fmu.say)
        text = table(folder)
    if not arguments.readme:
        print(text)
        return
    readme = build_fmu.README.read_text(encoding="utf-8")
    head, _, rest = readme.partition(BEGIN)
    if END not in rest:
        raise SystemExit(f"{build_fmu.README} has no markers for the table:\n{BEGIN}{END}")
    build_fmu.README.write_text(head + BEGIN + text + END + rest.partition(END)[2], encoding="utf-8")


if __name__ == "__main__":
    main()
