"""What goes with either kind of FMU beside its description: documentation, terminals, an icon, reference results."""

from typing import Dict

from .documentation import index_html
from .icon import png
from .model import Model
from .reference import reference_results
from .terminals import terminals_and_icons


def companions(model: Model) -> Dict[str, bytes]:
    """The bytes of the files, by their place in the FMU."""
    return {
        "model.png": png(),
        "documentation/index.html": index_html(model),
        "terminalsAndIcons/terminalsAndIcons.xml": terminals_and_icons(model),
        **reference_results(model),
    }
