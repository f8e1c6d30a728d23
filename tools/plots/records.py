"""Records of experiments: reads and checks them, and computes from their rows the numbers of the figures."""

import dataclasses
import json
import math
import statistics

SCHEMA = 1
# The order of the paper's Section 6.2.
PAPER_SCENES = ["octopi", "bullet", "airbag", "crash", "liver"]
TEXTS = ("table", "scene", "motion_model", "pipeline", "variant")
COUNTS = ("vf_tests", "ee_tests")
SIGNED = ("velocity",)
ROLES = ("broad_phase", "element_culling", "assignment", "orphans", "feature_filter", "narrow_phase")
STAGES = ("bounds_s", *(f"{role}_{part}_s" for role in ROLES for part in ("prepare", "run")))


class BadInput(Exception):
    pass


@dataclasses.dataclass(frozen=True)
class Record:
    """The record of an experiment. `rows`: those that a figure uses. `where`: by id() of a row, its place for
    messages."""
    experiment: str
    path: str
    complete: bool
    provenance: dict
    rows: list
    where: dict

    def with_rows(self, rows):
        return dataclasses.replace(self, rows=rows)


def read_record(path, experiment):
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    except (OSError, ValueError) as problem:
        raise BadInput(f"{path}: cannot be read: {problem}") from problem
    if not isinstance(data, dict) or data.get("experiment") != experiment:
        raise BadInput(f"{path}: is no record of the experiment {experiment}; run it again to replace the file")
    if data.get("schema") != SCHEMA:
        raise BadInput(f"{path}: has the schema {data.get('schema')}, but this program reads {SCHEMA}; "
                       "run the experiment again")
    for key, kind in (("rows", list), ("provenance", dict)):
        if not isinstance(data.get(key), kind):
            raise BadInput(f"{path}: has no '{key}'; run the experiment again")
    for key in ("setting", "commit", "cpu", "cores", "threads"):
        if key not in data["provenance"]:
            raise BadInput(f"{path}: the provenance has no '{key}'; run the experiment again")
    for index, row in enumerate(data["rows"]):
        if not isinstance(row, dict):
            raise BadInput(f"{path}: row {index} is no object of columns; run the experiment again")
    where = {id(row): index for index, row in enumerate(data["rows"])}
    return Record(experiment, path, data.get("complete") is True, data["provenance"], data["rows"], where)


def check_columns(record, columns):
    """Checks that every row has the columns that identify it and `columns`. Values are texts or finite numbers.
    Numbers are not negative, except for velocities; times, numbers of elements and lengths are positive."""
    for row in record.rows:
        for column in (*TEXTS, "step", "round", *columns):
            value = row.get(column)
            if column in TEXTS:
                good = isinstance(value, str)
            else:
                good = type(value) in (int, float) and math.isfinite(value) and (value >= 0 or column in SIGNED)
                good = good and (value > 0 or column not in ("seconds", "elements", "moved_edges"))
            if not good:
                there = f"{column} = {json.dumps(value)}" if column in row else f"no column '{column}'"
                raise BadInput(f"{record.path}: row {record.where[id(row)]} has {there}, which a figure of "
                               f"{record.experiment} needs; run the experiment again with this version of the program")


def grouped(rows, *columns):
    """Groups rows by the values of the columns, in the order of the rows. The key is a tuple, or the value for one
    column."""
    groups = {}
    for row in rows:
        key = tuple(row[column] for column in columns)
        groups.setdefault(key if len(columns) > 1 else key[0], []).append(row)
    return groups


def typical(rows):
    """One row for each step: that of the round with the (lower) median time, so that its stages add up."""
    by_time = [sorted(rounds, key=lambda row: (row["seconds"], row["round"]))
               for rounds in grouped(rows, "step").values()]
    return [rounds[(len(rounds) - 1) // 2] for rounds in by_time]


def mean_over_steps(rows, value):
    """The mean over steps of the median over rounds of value(row), as in the tables."""
    return statistics.fmean(statistics.median(map(value, rounds)) for rounds in grouped(rows, "step").values())


def seconds(row):
    return row["seconds"]


def seconds_with_edit(row):
    return row["seconds"] + row["topology_seconds"]


def mean_count(rows, count):
    """The mean over steps of count(row); counts are the same in all rounds."""
    return statistics.fmean(count(row) for row in typical(rows))


def tests(row):
    return row["vf_tests"] + row["ee_tests"]


def is_baseline(pipeline):
    return pipeline.startswith(("NavCCD", "HashCCD"))


def label_of(pipeline, variant):
    return f"{pipeline}, {variant}" if variant else pipeline


def scenes_of(rows):
    """The scenes of the rows: the paper's in the order of its Section 6.2, then all others by name."""
    names = {row["scene"] for row in rows}
    return [name for name in PAPER_SCENES if name in names] + sorted(names.difference(PAPER_SCENES))


def without_common_settings(record, say):
    """The record without the settings that all variants of a table have, such as its narrow phase."""
    rows = []
    for table, of_table in grouped(record.rows, "table").items():
        words = [row["variant"].split() for row in of_table]
        common = {word for word in words[0] if all(word in others for others in words)}
        if common:
            say(f"{record.experiment}: table {table}: {' '.join(sorted(common))} is a setting of all its pipelines")
        rows += [row | {"variant": " ".join(word for word in row["variant"].split() if word not in common)}
                 for row in of_table]
    return record.with_rows(rows)


def caption_of(record):
    steps = {scene: len({row["step"] for row in rows}) for scene, rows in grouped(record.rows, "scene").items()}
    scenes = ", ".join(f"{scene}\N{NO-BREAK SPACE}({steps[scene]})" for scene in scenes_of(record.rows))
    facts = record.provenance
    incomplete = "" if record.complete else ", incomplete record"
    commit = facts["commit"].removesuffix("-dirty")
    changes = " with local changes" if commit != facts["commit"] else ""
    threads = f"{facts['threads']}\N{NO-BREAK SPACE}thread{'' if facts['threads'] == 1 else 's'}"
    return (f"Scenes (steps): {scenes}. Setting: {facts['setting']}{incomplete}. Commit {commit}{changes}. "
            f"{facts['cpu']}, {facts['cores']} cores, {threads}.")
