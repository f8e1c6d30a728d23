"""Stages written in Python."""

from __future__ import annotations

import types

import numpy as np

from . import _core
from ._arguments import near, settings_list, suggesting

KEEP, DISJOINT, CONTACT_FREE = 1, 0, 2


class Step:
    """One step, as the input of a stage. The arrays are copies, so that a stage may keep them.

    control_points : float64 (vertices, c, 3)
        Bezier control points of each vertex: c = 2 for straight lines (both ends), 3 for constant acceleration. A
        vertex stays within the convex hull of its control points.
    corners : uint32 (elements, k)
        Vertices of each element, by slot, its last vertex repeated up to the largest number k.
    types, objects : uint8, int32 (elements,)
        VTK's cell type (0: an empty slot) and the object of each element.
    separation : float
        Contact when the distance reaches this.
    t_max : float
        Contacts later than this need not be found.
    state : types.SimpleNamespace
        The stage's own: kept from step to step, one for each workspace.
    """

    __slots__ = ("control_points", "corners", "types", "objects", "separation", "t_max", "state")

    def __init__(self):
        self.state = types.SimpleNamespace()

    @property
    def x0(self):
        """float64 (vertices, 3): positions at t = 0."""
        return self.control_points[:, 0]

    @property
    def x1(self):
        """float64 (vertices, 3): positions at t = 1."""
        return self.control_points[:, -1]

    def element_points(self, elements):
        """float64 (n, k, c, 3): control points of the corners of these elements."""
        return self.control_points[self.corners[elements]]

    def element_bounds(self):
        """Two float64 arrays (elements, 3): the axis-aligned box that each element stays in during the whole step. They
        are exact, and not widened by the separation."""
        low, high = self.control_points.min(axis=1), self.control_points.max(axis=1)
        return low[self.corners].min(axis=1), high[self.corners].max(axis=1)


class Stage:
    """Base of ElementCulling, FeatureFilter and NarrowPhase.

    Class attributes of a stage:

    name : str
        As it is named in settings: lower case, hyphens. Taken by no other stage.
    guarantee : "exact", "conservative", "approximate"
        What it promises. "conservative": never loses a contact, whatever the coordinates are.
    options : dict
        Name -> default (bool, int, float or str), or (default, description). An instance has them as attributes; they
        are set as "name.option=value".

    The first line of the docstring describes it in `volccd stages`. One instance may serve several threads, each with a
    `step` of its own; what changes belongs into `step.state`. Methods are called with the GIL held, from any thread.
    """

    name = None
    role = None
    guarantee = "approximate"
    options = {}

    def prepare(self, step):
        """Called once for each step, before the other method: computes data for all batches and stores them in
        `step.state`."""

    @classmethod
    def _description(cls):
        lines = (cls.__doc__ or "").strip().splitlines()
        return lines[0].strip() if lines else "a stage in Python"

    @classmethod
    def _option_rows(cls):
        for name, value in cls.options.items():
            default, description = value if isinstance(value, tuple) else (value, "")
            if not isinstance(default, (bool, int, float, str)):
                raise _core.ConfigError(f"stage '{cls.name}': the default of option '{name}' is no bool, int, float "
                                        "or str")
            yield name, default, description

    @classmethod
    def _describe_options(cls):
        kinds = {bool: "true|false", int: "an integer", float: "a number", str: "text"}
        return [(name, _text(default), kinds[type(default)], description)
                for name, default, description in cls._option_rows()]

    @classmethod
    def _make(cls, values):
        stage = cls()
        rows = {name: default for name, default, _ in cls._option_rows()}
        for name, text in values.items():
            if name not in rows:
                raise _core.ConfigError(f"no option '{name}' of '{cls.name}'; there are {', '.join(rows) or 'none'}"
                                        + near(name, rows))
            rows[name] = _parsed(cls.name, name, text, type(rows[name]))
        for name, value in rows.items():
            setattr(stage, name, value)
        return stage


def _text(value):
    return str(value).lower() if isinstance(value, bool) else str(value)


def _parsed(stage, name, text, kind):
    try:
        if kind is bool:
            return {"true": True, "false": False}[text.lower()]
        return kind(text)
    except (KeyError, ValueError):
        raise _core.ConfigError(f"{stage}.{name}: '{text}' is not {_KINDS[kind]}") from None


_KINDS = {bool: "true or false", int: "an integer", float: "a number", str: "text"}


class ElementCulling(Stage):
    """Drops pairs of elements that cannot touch during the step.

    >>> import numpy as np, volccd
    >>> @volccd.register
    ... class Boxes(volccd.ElementCulling):
    ...     '''drops pairs whose swept boxes are apart'''
    ...     name, guarantee = "python-boxes", "conservative"
    ...     def prepare(self, step):
    ...         low, high = step.element_bounds()
    ...         step.state.low = np.nextafter(low - step.separation, -np.inf)
    ...         step.state.high = np.nextafter(high, np.inf)
    ...     def cull(self, step, pairs):
    ...         a, b, s = pairs[:, 0], pairs[:, 1], step.state
    ...         return ((s.low[a] <= s.high[b]) & (s.low[b] <= s.high[a])).all(axis=1)
    >>> [contacts.statistics["contacts"] for _, contacts in
    ...  volccd.scene("builtin").detect(range(2), settings="element-culling=python-boxes")]
    [104, 385]
    """

    role = "element-culling"

    def cull(self, step, pairs):
        """pairs: uint32 (n, 2), element slots. Returns a bool array (n,): True keeps a pair, False drops it (the convex
        hulls stay further apart than the separation). Or integers: volccd.KEEP, volccd.DISJOINT, or volccd.CONTACT_FREE
        for a pair whose features do not touch although one element may lie inside the other."""
        raise NotImplementedError(f"{type(self).__name__}.cull(step, pairs)")


class FeatureFilter(Stage):
    """Drops single tests before the narrow phase."""

    role = "feature-filter"

    def filter(self, step, kind, vertices, points):
        """kind: volccd.VF or volccd.EE; vertices: uint32 (n, 4), {vertex, triangle} or {edge 1, edge 2}; points:
        float64 (c, 4, 3, n), coordinate `axis` of control point c of vertex p of test i in points[c, p, axis, i].
        Returns a bool array (n,): False drops a test that does not touch (come within step.separation) during [0,
        step.t_max]."""
        raise NotImplementedError(f"{type(self).__name__}.filter(step, kind, vertices, points)")


class NarrowPhase(Stage):
    """Elementary tests.

    Further class attributes: max_control_points (2 or 3), handles_separation (bool), time_tolerance (by how much of the
    step a time may be too early).
    """

    role = "narrow-phase"
    max_control_points = 2
    handles_separation = False
    time_tolerance = 0.0

    def test(self, step, kind, vertices, points):
        """Arguments as in FeatureFilter.filter. Returns the time of contact of each test, float64 (n,), NaN for none;
        or a dict with "toi" and, where known, "normal" (n, 3), "point" (n, 3), "weights" (n, 4) and "at_start" (n,).
        The answer to a test must depend only on its points."""
        raise NotImplementedError(f"{type(self).__name__}.test(step, kind, vertices, points)")


_registered = {}
_pipelines = {}


def _apply(stages, added):
    stages, added = dict(stages), dict(added)
    _core.set_registry(list(stages.values()), list(added.values()))
    _registered.clear(), _pipelines.clear()
    _registered.update(stages), _pipelines.update(added)


def register(stage):
    """Class decorator that registers a stage under its name, for every pipeline, `verify` and `main`. A class of a
    name that was registered before replaces the earlier one (cells of a notebook run again). ConfigError if the name
    belongs to a stage of the library, or the class is not as `Stage` says."""
    if not (isinstance(stage, type) and issubclass(stage, Stage) and stage.role and isinstance(stage.name, str)):
        raise _core.ConfigError("register: a class derived from volccd.ElementCulling, FeatureFilter or NarrowPhase, "
                                "with a name, is expected")
    _apply({**_registered, stage.name: stage}, _pipelines)
    return stage


@suggesting
def add_pipeline(name, base="VolCCD+", settings=(), description=""):
    """Registers a pipeline: `base` with the changes in `settings`. It runs in `verify`, and in the tables of
    `main(["experiment", "run", ..., "--pipelines", name])`. One of the same name that was added before is replaced.

    >>> volccd.add_pipeline("Boxes", settings=["element-culling=python-boxes,csat"])  # doctest: +SKIP
    """
    settings = settings_list(settings)
    row = (name, base, settings, description or f"{base} with {' '.join(settings)}")
    _apply(_registered, {**_pipelines, name: row})


def unregister(name):
    """Removes a stage or pipeline that was registered in Python. ConfigError if a pipeline still needs it."""
    if name not in _registered and name not in _pipelines:
        raise _core.ConfigError(f"'{name}' was not registered from Python")
    _apply({key: value for key, value in _registered.items() if key != name},
           {key: value for key, value in _pipelines.items() if key != name})


def stages():
    """list of dict: name, role, guarantee, description, options of every stage, those in Python included."""
    return _core.stages()


def pipelines():
    """dict name -> description of every pipeline."""
    return _core.pipelines()


def main(argv=None):
    """Runs the program `volccd` with these arguments (default: those of the process), with all stages and pipelines
    that are registered. Returns the exit code: 0 done, 1 a difference, 2 bad input, 130 interrupted.

    A script of a few lines is a `volccd` that knows a stage in Python:

        @volccd.register
        class MyStage(volccd.ElementCulling): ...
        volccd.add_pipeline("Mine", settings="element-culling=my-stage")
        sys.exit(volccd.main())
    """
    import sys
    sys.stdout.flush()
    return _core.main(list(sys.argv[1:] if argv is None else argv))
