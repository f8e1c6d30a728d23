"""Combines frames to a sequence: order, points, and times."""

import re

import numpy as np

from .errors import BadInput


def natural_key(file):
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", file)]


def order_files(files, how):
    natural = sorted(files, key=natural_key)
    if how == "natural":
        return natural
    if how is None and files != natural:
        first = next(i for i, (given, sorted_) in enumerate(zip(files, natural)) if given != sorted_)
        raise BadInput("", "files", f"{files[first]} comes before {natural[first]}, but the numbers in the names say otherwise: "
                       "give --sort natural, or --sort given", first)
    return files


class Union:
    """The points of all files: those of the first file in its order, then the others in the order in which they
    occur."""

    def __init__(self):
        self.ids = self.order = self.places = None

    def add(self, frame, file):
        if self.places is None:
            self.ids, self.places = frame.point_ids, frame.points
        elif (frame.point_ids is None) != (self.ids is None):
            raise BadInput(file, "point ids", "given here but not in the first file" if self.ids is None else
                           "not given here but in the first file")
        elif self.ids is None:
            if len(frame.points) != len(self.places):
                raise BadInput(file, "points", f"{len(frame.points)}, the first file has {len(self.places)}, and there are no "
                               "point ids")
        else:
            new = ~np.isin(frame.point_ids, self.ids)
            self.ids = np.concatenate([self.ids, frame.point_ids[new]])
            self.places = np.concatenate([self.places, frame.points[new]])
        self.order = None if self.ids is None else np.argsort(self.ids)

    def renumber(self, frame):
        """Renumbers the points of a frame. Points that it lacks keep their last positions and have no velocity."""
        if self.ids is None:
            return frame
        row = self.order[np.searchsorted(self.ids, frame.point_ids, sorter=self.order)]
        self.places = self.places.copy()
        self.places[row] = frame.points
        if frame.velocity is not None:
            velocity = np.zeros_like(self.places)
            velocity[row] = frame.velocity
            frame.velocity = velocity
        frame.points, frame.connectivity = self.places, row[frame.connectivity]
        return frame


def check_same(frame, first, file):
    """Checks that a frame has the same arrays, cells and object names as the first one, as far as frames must agree."""
    for what in ("velocity", "thickness", "cell_ids"):
        if (getattr(frame, what) is None) != (getattr(first, what) is None):
            there = "not in this file" if getattr(frame, what) is None else "not in the first file"
            raise BadInput(file, what.replace("_", " "), f"{there}, but in others")
    if frame.cell_ids is None and not same_cells(frame, first):
        raise BadInput(file, "cells", "differ from those of the first file, and there are no cell ids")
    for number, name in frame.object_names.items():
        if first.object_names.setdefault(number, name) != name:
            raise BadInput(file, "object", f"{number} is '{name}' here and '{first.object_names[number]}' before")


def same_cells(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("types", "connectivity", "objects", "cell_ids"))


def times_of(frames, options, found):
    """Times of the frames: those of the options, else those in the files, else 0, 1, .."""
    if options.times is not None:
        times = options.times
        if len(times) != len(frames):
            raise BadInput("", "--times", f"{len(times)} times for {len(frames)} frames")
    elif options.dt is not None:
        times = [options.dt * k for k in range(len(frames))]
    else:
        times = list(found) if None not in found else [float(k) for k in range(len(frames))]
    for k in range(len(times)):
        if not np.isfinite(times[k]) or (k > 0 and not times[k] > times[k - 1]):
            raise BadInput(frames[k], "time", f"{times[k]} is not finite or not after that of the file before: give --times or "
                           "--dt", k)
    return times
