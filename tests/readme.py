"""What runs of the tests write into README.md."""

import build_fmu


def write(name: str, text: str) -> None:
    """Replace what is between the markers of that name. Exits with a message where there are none."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->"
    content = build_fmu.README.read_text(encoding="utf-8")
    head, _, rest = content.partition(begin)
    if end not in rest:
        raise SystemExit(f"{build_fmu.README} has no markers for the {name}:\n{begin}{end}")
    build_fmu.README.write_text(head + begin + text + end + rest.partition(end)[2], encoding="utf-8")
