"""The output: a path that may be written, a file object for h5py, and the layout of docs/sequence_files.md."""

import contextlib
import io
import os

import numpy as np

from .errors import BadInput
from .sequence import same_cells


def output_path(name, inputs):
    """The path of the file to which the output `name` leads, whether or not it exists. Links are followed and kept."""
    target = os.path.realpath(name)
    if os.path.isdir(name):
        raise BadInput(name, "", "cannot be written: it is a folder")
    there = os.path.exists(name)
    stream = name == "-" or (there and not os.path.isfile(name))
    with contextlib.suppress(OSError):  # the file to which the shell redirects the standard output
        stream = stream or (there and os.path.samestat(os.stat(name), os.fstat(1)))
    if stream:
        raise BadInput(name, "", "is not a regular file: a sequence (HDF5) is not written from front to back; give the name of "
                       "a file")
    for file in inputs:
        if os.path.realpath(file) == target or (there and os.path.exists(file) and os.path.samefile(file, target)):
            raise BadInput(name, "", f"is the input {file}: give another name; nothing has been written")
    if there and not os.access(target, os.W_OK):
        raise BadInput(name, "", "cannot be written: Permission denied")
    return target


class Sink(io.FileIO):
    """A file object for h5py that does not report write failures to HDF5, because HDF5 1.10 cannot close a file
    whose buffers cannot be written, and then crashes when the process ends. `check` raises the first failure as an
    error about `shown_as`."""

    def __init__(self, path, shown_as):
        self.shown_as, self.error = shown_as, None
        try:
            super().__init__(path, "w+")
        except OSError as error:
            raise BadInput(shown_as, "", f"cannot be written: {error.strerror}") from error

    def write(self, data):
        rest = memoryview(data).cast("B")
        try:
            while self.error is None and len(rest) > 0:
                rest = rest[super().write(rest):]
        except OSError as error:
            self.error = error
        return memoryview(data).nbytes

    def truncate(self, size=None):
        try:
            return super().truncate(size)
        except OSError as error:
            self.error = self.error or error
            return size

    def check(self):
        if self.error is not None:
            raise BadInput(self.shown_as, "", f"cannot be written: {self.error.strerror}")

    def to_disk(self):
        self.check()
        try:
            os.fsync(self.fileno())
        except OSError as error:
            raise BadInput(self.shown_as, "", f"cannot be brought to disk: {error.strerror}") from error


class Writer:
    """Writes the layout of docs/sequence_files.md, one frame at a time."""

    def __init__(self, file):
        self.file = file
        self.root = file.create_group("VTKHDF")
        for name in ("PointData", "CellData", "Steps", "Steps/PointDataOffsets", "Steps/CellDataOffsets"):
            self.root.create_group(name)
        self.last = None
        self.cells, self.connectivity, self.tables = [], [], {}

    def append(self, name, values):
        """Appends rows to a dataset, which is created with its first rows. Returns the number of rows before the
        call."""
        values = np.ascontiguousarray(values)
        if name not in self.root:
            rows = max(16, min(len(values), 16384))
            self.root.create_dataset(name, data=values, maxshape=(None, *values.shape[1:]), chunks=(rows, *values.shape[1:]),
                                     shuffle=True, compression="gzip", compression_opts=4)
            return 0
        dataset = self.root[name]
        before = len(dataset)
        dataset.resize(before + len(values), axis=0)
        dataset[before:] = values
        return before

    def table(self, name, value):
        self.tables.setdefault(name, []).append(value)

    def add(self, frame):
        if self.last is None or not same_cells(frame, self.last):
            self.first_cell = self.append("Types", frame.types)
            self.append("Offsets", frame.offsets)
            self.first_connectivity = self.append("Connectivity", frame.connectivity)
            self.append("CellData/PartId", frame.objects)
            ids = frame.cell_ids if frame.cell_ids is not None else np.arange(len(frame.types), dtype=np.int64)
            self.append("CellData/GlobalCellIds", ids)
            self.cells.append(len(frame.types))
            self.connectivity.append(len(frame.connectivity))
            self.last = frame
        self.table("PartOffsets", len(self.cells) - 1)
        self.table("NumberOfParts", 1)
        self.table("PointOffsets", self.append("Points", frame.points))
        self.table("CellOffsets", self.first_cell)
        self.table("ConnectivityIdOffsets", self.first_connectivity)
        self.table("PointDataOffsets/GlobalPointIds", 0)
        self.table("CellDataOffsets/PartId", self.first_cell)
        self.table("CellDataOffsets/GlobalCellIds", self.first_cell)
        if frame.velocity is not None:
            self.table("PointDataOffsets/Velocity", self.append("PointData/Velocity", frame.velocity))
        if frame.thickness is not None:
            self.table("CellDataOffsets/Thickness", self.append("CellData/Thickness", frame.thickness))

    def finish(self, times, point_ids, points, about):
        self.root.attrs["Version"] = np.array([2, 2], np.int64)
        self.root.attrs["Type"] = np.bytes_(b"UnstructuredGrid")
        self.root["NumberOfPoints"] = np.full(len(self.cells), points, np.int64)
        self.root["NumberOfCells"] = np.array(self.cells, np.int64)
        self.root["NumberOfConnectivityIds"] = np.array(self.connectivity, np.int64)
        ids = point_ids if point_ids is not None else np.arange(points, dtype=np.int64)
        self.root["PointData/GlobalPointIds"] = np.asarray(ids, np.int64)
        self.root["Steps"].attrs["NSteps"] = np.int64(len(times))
        self.root["Steps/Values"] = np.array(times, np.float64)
        for name, values in self.tables.items():
            values = np.array(values, np.int64)
            self.root[f"Steps/{name}"] = values[:, None] if name in ("CellOffsets", "ConnectivityIdOffsets") else values
        for name, text in about.items():
            if text:
                self.file.attrs[name] = np.bytes_(text.encode("ascii", "replace"))
