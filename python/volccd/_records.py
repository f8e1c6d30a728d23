"""Records of experiments."""

from __future__ import annotations

import json
import os

from . import _core


def read_record(path):
    """The record of an experiment (results/table1.json, ...) as it is: dict of experiment, schema, complete,
    provenance, summary and rows (list of dict). docs/record.schema.json has the schema. InputError if it is none."""
    path = os.fspath(path)
    try:
        with open(path, encoding="utf-8") as file:
            record = json.load(file)
    except (OSError, ValueError) as error:
        raise _input_error(path, "", str(error)) from None
    if not isinstance(record, dict) or not isinstance(record.get("rows"), list):
        raise _input_error(path, "rows", "is not there: this is no record of an experiment")
    return record


def _input_error(path, dataset, problem):
    error = _core.InputError(f"{path}: {dataset + ': ' if dataset else ''}{problem}")
    error.source, error.dataset = path, dataset
    return error


def records(path):
    """The rows of a record as a pandas.DataFrame; nested values become columns with dots ("seconds.median"). What else
    the record holds is in `.attrs` (experiment, provenance, summary). Needs pandas (Debian: python3-pandas).

    >>> import volccd
    >>> table = volccd.records("results/table1.json")           # doctest: +SKIP
    >>> table.groupby("pipeline")["seconds"].median()           # doctest: +SKIP
    """
    try:
        import pandas
    except ImportError:
        raise ImportError("volccd.records needs pandas (Debian: python3-pandas); volccd.read_record returns the same "
                          "as dict and list") from None
    record = read_record(path)
    frame = pandas.json_normalize(record["rows"])
    frame.attrs.update({key: value for key, value in record.items() if key != "rows"})
    return frame
