"""What is wrong with an input."""

import numpy as np


class BadInput(Exception):
    """`file: what[index]: problem`, as the program words it."""

    def __init__(self, file, what, problem, index=None):
        place = what + (f"[{index}]" if index is not None else "")
        super().__init__(": ".join(part for part in (file, place, problem) if part))


def first_bad(bad):
    """Index of the first row that has a True in it, or None."""
    rows = np.flatnonzero(bad.reshape(len(bad), -1).any(axis=1)) if bad.size else []
    return int(rows[0]) if len(rows) else None
