"""Numbers to text, a whole table at once: ten times as fast as formatting them one by one, with the same digits.

A day of 60 frames/s has 57 million numbers: formatting each on its own takes longer than all the rest of a conversion.
"""

import numpy as np

LARGEST = 1e8
"""With ten decimals such a number fills the 64 bits of an integer; what is larger is written by Python."""

ZERO, MINUS, POINT, COMMA, NEWLINE = b"0-.,\n"
NAN = np.frombuffer(b"nan", dtype=np.uint8)


def table_text(columns: list[np.ndarray], decimals: list[int]) -> bytes:
    """CSV rows: each column with its number of decimals, nan where it is not finite."""
    blocks = []
    for place, (values, digits) in enumerate(zip(columns, decimals, strict=True)):
        last = place == len(columns) - 1
        blocks.append(column_text(np.asarray(values, dtype=float), digits, NEWLINE if last else COMMA))
    characters = np.hstack(blocks)
    return characters[characters != 0].tobytes()


def column_text(values: np.ndarray, decimals: int, end: int) -> np.ndarray:
    """One row of characters a value, uint8, the end behind it; what is to be left out is 0."""
    finite = np.isfinite(values)
    size = np.abs(np.where(finite, values, 0.0))
    if size.max(initial=0.0) >= LARGEST:
        return by_python(values, decimals, end)
    number = np.rint(size * 10.0**decimals).astype(np.int64)
    whole = len(str(int(number.max(initial=0)) // 10**decimals))
    width = 1 + whole + (1 + decimals if decimals else 0) + 1
    text = np.zeros((max(width, 4), len(values)), dtype=np.uint8)  # a row a digit: each is written at one go
    text[width - 1] = end
    text[0] = np.where((values < 0) & (number > 0), MINUS, 0)
    for place in range(decimals):
        number, text[width - 2 - place] = digit(number)
    if decimals:
        text[width - 2 - decimals] = POINT
    for place in range(whole):
        more = number > 0
        number, figure = digit(number)
        text[whole - place] = np.where(more | (place == 0), figure, 0)
    if not finite.all():
        lost = ~finite
        text[:, lost] = 0
        text[:3, lost] = NAN[:, None]
        text[3, lost] = end
    return text.T


def digit(number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is left of a number without its last digit, and the digit's character."""
    rest = number // 10
    return rest, (number - 10 * rest + ZERO).astype(np.uint8)


def by_python(values: np.ndarray, decimals: int, end: int) -> np.ndarray:
    cells = [f"{value:.{decimals}f}" if np.isfinite(value) else "nan" for value in values.tolist()]
    cells = [cell.lstrip("-") if cell.startswith("-") and float(cell) == 0 else cell for cell in cells]
    width = max(map(len, cells))
    text = np.array([cell.encode().ljust(width, b"\0") for cell in cells], dtype=f"S{width}")
    characters = text.view(np.uint8).reshape(len(cells), width)
    return np.hstack([characters, np.full((len(cells), 1), end, dtype=np.uint8)])
