"""Sequence files and scenes."""

from __future__ import annotations

import operator
import os

from . import _core
from ._arguments import settings_list, suggesting
from ._detect import _options


class Sequence:
    """An open sequence file (VTKHDF): frames of points and cells, and the steps between them.

    Step k leads from frame k to frame k + 1 and uses the cells of frame k + 1; there are len(sequence) steps.

    Parameters
    ----------
    path : str or path
    shells : "surface", "solid"
        Triangles and quads as they are, or thickened by the file's thickness.
    motion : "linear", "quadratic", "tentative", "query"
        To the next frame on straight lines, or with constant acceleration; or from each frame with its velocities; or
        the last query that the simulation of the file asked, without its separation.
    edges : "triangulated", "polytope"
    objects : "stored", "components"
        Objects are those that the file stores (PartId), or connected components.

    Points are by ascending id, as `point_ids` has them; contacts name points by their row there.
    """

    @suggesting
    def __init__(self, path, *, shells="surface", motion="linear", edges="triangulated", objects="stored"):
        self._core = _core.Sequence(os.fspath(path),
                                    {"shells": shells, "motion": motion, "edges": edges, "objects": objects})
        self.shells = shells

    def __len__(self):
        return self._core.frame_count - 1

    def __repr__(self):
        return f"<volccd.Sequence {self.path}: {self.frame_count} frames, {self.point_count} points>"

    @property
    def path(self):
        """str: the name of the file."""
        return self._core.file

    @property
    def frame_count(self):
        """Number of frames in the file; there is one step less."""
        return self._core.frame_count

    @property
    def point_count(self):
        """Number of points in every frame."""
        return self._core.point_count

    @property
    def point_ids(self):
        """int64 (point_count,), ascending."""
        return self._core.point_ids

    @property
    def times(self):
        """float64 (frame_count,), in the file's unit of time."""
        return self._core.times

    @property
    def metadata(self):
        """dict: title, source, license, units, time_unit, object_names, incomplete."""
        return self._core.metadata

    @property
    def element_ids(self):
        """Element ids by slot in the last step that `detect` ran; -1 if a slot is empty."""
        return self._core.element_ids

    def points(self, frame):
        """float64 (point_count, 3), in the file's unit of length."""
        return self._core.points(self._frame(frame))

    def velocity(self, frame):
        """float64 (point_count, 3), or None if the file has none."""
        return self._core.velocity(self._frame(frame))

    def thickness(self, frame):
        """float64, one value for each cell of the frame, or None if the file has none."""
        return self._core.thickness(self._frame(frame))

    def cells(self, frame):
        """The cells of a frame: dict of connectivity, offsets, types, objects, ids, face_offsets, faces, which `detect`
        and `Detector` accept as `cells`, with its objects and ids."""
        return self._core.cells(self._frame(frame))

    def _frame(self, frame):
        frame = operator.index(frame)
        return frame + self.frame_count if frame < 0 else frame

    @suggesting
    def detect(self, steps=None, *, pipeline="VolCCD+", separation=0.0, threads=0, first=False, initial_overlaps=False,
               t_max=1.0, pairs="all", exclude=(), settings=(), shell_neighbours=False):
        """Runs the pipeline on steps and yields (step, Result) for each. The pipeline keeps its memory from one step to
        the next.

        steps : iterable of int, optional
            Default: all, range(len(sequence)).
        shell_neighbours : bool
            With shells="solid": keep contacts between features that stem from one point.
        Other parameters: as in `volccd.detect`.
        """
        runner = _core.SequenceRunner(_options(pipeline, settings, threads, separation, pairs, exclude),
                                       self.shells == "solid" and not shell_neighbours)
        for step in range(len(self)) if steps is None else steps:
            step = operator.index(step)
            yield step, runner.run(self._core, step, first, initial_overlaps, t_max)


def scenes():
    """dict name -> description of the scenes that `scene` knows."""
    return _core.scene_names()


def scene(name, *, simulate=False, threads=0, **options):
    """The sequence of a scene by its name, as in `volccd scene list`.

    Scenes that are simulated take minutes the first time; they are simulated only with simulate=True, else
    InputError is raised. Afterwards, and where the program has simulated them before, they come from its cache.
    `options`: those of `Sequence`.

    >>> import volccd
    >>> len(volccd.scene("builtin"))
    8
    """
    return Sequence(_core.scene_file(name, simulate, threads), **options)


class Verification:
    """The result of `volccd.verify`. True if clean. `steps` has a dict for each step: step (its number), clean,
    reference, contacts, earliest_toi, fcl_hits, fcl_violations, and pipelines, a list of dicts with pipeline,
    same, held, refused and the structured arrays missing, extra and changed (contacts, with the fields of
    Result.contacts)."""

    def __init__(self, steps, skipped):
        self.steps, self.skipped = steps, skipped

    @property
    def clean(self):
        """Whether nothing differs."""
        return all(step["clean"] for step in self.steps)

    @property
    def differing(self):
        """Names of the pipelines that differ from the reference at some step."""
        return sorted({one["pipeline"] for step in self.steps for one in step["pipelines"] if not one["same"]})

    def __bool__(self):
        return self.clean

    def __repr__(self):
        what = "clean: no difference" if self.clean else "DIFFERENCES: " + (", ".join(self.differing) or "FCL")
        count = f"{len(self.steps)} step{'' if len(self.steps) == 1 else 's'}"
        return f"<volccd.Verification of {count}: {what}>"


@suggesting
def verify(sequence, steps=None, *, settings=(), threads=0, separation=0.0, fcl=True, approximate=False,
           brute_force_limit=100000):
    """Runs every registered pipeline on a sequence, those with stages in Python included, and compares the contacts bit
    for bit with those of brute force (beyond `brute_force_limit` elements with NavCCD) and with FCL's overlaps: the
    comparison of `volccd verify`.

    sequence : Sequence, or the path of one
    steps : iterable of int, optional
        Default: all.
    settings : str, list of str, or dict
        One more pipeline: VolCCD+ with these settings ("element-culling=my-stage").
    fcl : bool
        Ask FCL at t = 1/4, 1/2, 3/4 and 1 of each step.
    approximate : bool
        Also run pipelines with an approximate narrow phase: shows what they miss, and does not count it.

    Returns a `Verification`, which is true if nothing differs.
    """
    if not isinstance(sequence, Sequence):
        sequence = Sequence(sequence)
    checker = _core.Verification(settings_list(settings), threads, separation, fcl, approximate, brute_force_limit,
                                 sequence.shells == "solid")
    verdicts = []
    for step in range(len(sequence)) if steps is None else steps:
        verdicts.append({"step": step, **checker.check(sequence._core, step)})
    return Verification(verdicts, checker.skipped)
