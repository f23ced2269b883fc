"""What every reader gives: named columns, in blocks that fit into memory."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np


@dataclass(frozen=True)
class Block:
    """Some rows of a file: numbers as float64 (nan where a cell is no number), texts as bytes ('S')."""

    columns: Mapping[str, np.ndarray]
    done: float
    """Share of the file that has been read, 0 .. 1."""
    broken: int = 0
    """Rows that could not be read, and are left out."""

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))


class Table(Protocol):
    """An open file. `units` are those that the file itself states, by column."""

    @property
    def names(self) -> Sequence[str]: ...

    @property
    def units(self) -> Mapping[str, str]: ...

    @property
    def hints(self) -> "Hints": ...

    def blocks(self, numbers: Sequence[str], texts: Sequence[str]) -> Iterator[Block]: ...


@dataclass(frozen=True)
class Hints:
    """What a file says of itself beside its columns: a MAP that is silent takes it from here."""

    time: Mapping[str, object] | None = None
    """As `time` of a MAP."""
    frequency: float | None = None
    """Hz, nominal."""
    S_base: float | None = None
    """MVA."""
    types: Mapping[str, str] = field(default_factory=dict)
    """Kinds of columns: VM, VA, IM, IA, P, Q, F."""
