"""Errors about an input."""

import numpy as np


class BadInput(Exception):
    """An error whose message has the form `file: what[index]: problem`, as those of the program."""

    def __init__(self, file, what, problem, index=None):
        place = what + (f"[{index}]" if index is not None else "")
        super().__init__(": ".join(part for part in (file, place, problem) if part))


def first_bad(bad):
    """Index of the first row that contains a True value, or None."""
    rows = np.flatnonzero(bad.reshape(len(bad), -1).any(axis=1)) if bad.size else []
    return int(rows[0]) if len(rows) else None
