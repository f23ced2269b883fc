"""The progress bar of whatever takes longer than PATIENCE."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

PATIENCE = 2.0
"""s; what takes longer shows how far it is."""


@contextmanager
def progress_bar(console: Console) -> Iterator[Callable[[float], None]]:
    """A function of the share that is done, in 0 .. 1; a bar shows once PATIENCE is over, and goes at the end."""
    columns = (TextColumn("{task.percentage:3.0f} %"), BarColumn(), TimeRemainingColumn())
    start = perf_counter()
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0, visible=False)

        def progress(done: float) -> None:
            bar.update(task, completed=done, visible=perf_counter() - start > PATIENCE)

        yield progress
