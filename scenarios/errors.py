"""Messages for a user."""

from collections.abc import Collection
from difflib import get_close_matches


class UserError(Exception):
    """What is wrong with what a user gave, and what to do about it: one line, exit code 2, no traceback."""


class ScenarioError(UserError):
    """What is wrong with a scenario, and what to do about it."""


def alternatives(name: str, known: Collection[str]) -> str:
    """What could have been meant by a name that is not known."""
    close = get_close_matches(name, known, n=1)
    meant = f'did you mean "{close[0]}"? ' if close else ""
    return f"{meant}known: {', '.join(known) or 'none'}"
