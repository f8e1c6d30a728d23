"""Errors about an input."""

import difflib
import importlib

import numpy as np


class BadInput(Exception):
    """An error whose message has the form `file: what[index]: problem`, as those of the program."""

    def __init__(self, file, what, problem, index=None):
        place = what + (f"[{index}]" if index is not None else "")
        super().__init__(": ".join(part for part in (str(file), place, problem) if part))


def first_bad(bad):
    """Index of the first row that contains a True value, or None."""
    rows = np.flatnonzero(bad.reshape(len(bad), -1).any(axis=1)) if bad.size else []
    return int(rows[0]) if len(rows) else None


def did_you_mean(name, known):
    """"; did you mean 'a'?", or "" if nothing known is like the name."""
    by_lower = {key.lower(): key for key in known}
    near = difflib.get_close_matches(name.lower(), by_lower, 1)
    return f"; did you mean '{by_lower[near[0]]}'?" if near else ""


def needed(module, package, file):
    """The module; an error that names its Debian package if it is not there."""
    try:
        return importlib.import_module(module)
    except ImportError as problem:
        raise BadInput(file, "", f"needs {module}: install {package} ({problem})") from problem
