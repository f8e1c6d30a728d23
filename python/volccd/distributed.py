"""Contacts of a mesh that is divided among the ranks of an MPI communicator (docs/distributed.md).

Needs mpi4py (Debian: python3-mpi4py), whose communicator a program gives; volccd itself needs no MPI.

>>> from mpi4py import MPI                                                            # doctest: +SKIP
>>> detector = volccd.distributed.Detector(MPI.COMM_WORLD, cells, vertices, owned)    # doctest: +SKIP
>>> detector.step(points0, points1)                                                   # doctest: +SKIP
>>> detector.to_owners()                                                              # doctest: +SKIP
"""

from __future__ import annotations

import dataclasses

import numpy as np

from . import _core, _meshes
from ._arguments import suggesting
from ._detect import _options

#: Fields of a contact: as `volccd.contact_dtype`, but `vertices` are ids, int64 (4,); `elements`, int64 (2,): of each
#: feature, the element of smallest id; `objects`, int32 (2,): of these elements.
contact_dtype = _core.rank_contact_dtype

__all__ = ["Detector", "Result", "contact_dtype"]

_MESSAGE, _CONNECT = 0, 1  # tags: of messages, and of connections, two alternately


class _Ranks:
    """The operations that ranks need, on a communicator of mpi4py that is used for nothing else."""

    def __init__(self, communicator):
        from mpi4py import MPI
        self._mpi, self._communicator = MPI, communicator.Dup()
        self.rank, self.size = communicator.Get_rank(), communicator.Get_size()
        self._connections = 0

    def connect(self, destinations):
        """Sends an empty message to each destination; when all of them are received, which synchronous sends tell, the
        rank enters the barrier. When all ranks have entered it, no message is on its way. Returns the senders."""
        tag = _CONNECT + self._connections
        self._connections ^= 1
        sends = [self._communicator.issend(None, dest=rank, tag=tag) for rank in destinations]
        sources, barrier = [], None
        while True:
            status = self._mpi.Status()
            message = self._communicator.improbe(tag=tag, status=status)
            if message is not None:
                message.recv()
                sources.append(status.Get_source())
            elif barrier is not None:
                if barrier.Test():
                    return sorted(sources)
            elif self._mpi.Request.testall(sends)[0]:
                barrier = self._communicator.Ibarrier()

    def exchange(self, destinations, sources, messages):
        sends = [self._communicator.Isend([message, self._mpi.BYTE], dest=rank, tag=_MESSAGE)
                 for rank, message in zip(destinations, messages)]
        received = []
        for source in sources:
            status = self._mpi.Status()
            message = self._communicator.Mprobe(source=source, tag=_MESSAGE, status=status)
            data = bytearray(status.Get_count(self._mpi.BYTE))
            message.Recv([data, self._mpi.BYTE])
            received.append(bytes(data))
        self._mpi.Request.Waitall(sends)
        return received

    def allgather(self, message):
        return self._communicator.allgather(message)

    def allreduce(self, values, operation):
        result = np.empty_like(values)
        self._communicator.Allreduce(values, result, {"sum": self._mpi.SUM, "min": self._mpi.MIN,
                                                      "max": self._mpi.MAX}[operation])
        return result


def _on_all(ranks, convert):
    """What convert() returns; if it raises an Error on some rank, that of the lowest one is raised on all."""
    value, problem = None, None
    try:
        value = convert()
    except _core.Error as error:
        problem = f"rank {ranks.rank} of {ranks.size}: {error}"
    for one in ranks.allgather(problem):
        if one is not None:
            raise _core.Error(one)
    return value


@dataclasses.dataclass(frozen=True)
class Result:
    """What a rank found in a step. Each contact of the mesh is on one rank."""

    contacts: np.ndarray          #: structured (n,), `volccd.distributed.contact_dtype`, in canonical order
    initial_overlaps: np.ndarray  #: int64 (n, 2): ids of elements that overlap at t = 0, if they were asked for
    statistics: dict              #: of the pipeline on this rank's part of the mesh, as `volccd.Result.statistics`
    rank: dict  #: elements, copies, halo, tests, contacts, seconds, piece_seconds, lists, bytes_received, neighbours

    def __len__(self):
        return len(self.contacts)


class Detector:
    """One rank's side of a detector for a mesh that is divided among ranks.

    All ranks make it, and call its methods, in the same order: they are collective. Contacts of all ranks together, each
    found once, are those of `volccd.Detector` on the whole mesh, bit for bit, for any distribution (docs/distributed.md
    has the conditions). An error on one rank is raised on all of them with the same text, and they can go on.

    Parameters
    ----------
    comm : mpi4py communicator
        It is duplicated.
    cells :
        The elements of this rank, in the forms of `volccd.Detector`; their vertices are rows of `vertices`. Each element
        belongs to one rank.
    vertices : int array (n,)
        The ids of the vertices that this rank knows. The first `owned` belong to it; each vertex belongs to one rank.
    owned : int, optional
        Default: all.
    objects, ids : int arrays (m,), optional
        Of the elements: their objects, and their ids, which are distinct over all ranks. Default: objects 0, and ids from
        0, rank after rank.
    skin : float
        How far ahead lists of elements are made, in longest sides of their boxes. Greater: fewer new lists, more copies.
    max_imbalance : float
        Space is divided anew if the slowest rank takes more than this many times the mean. inf: never.
    pipeline, separation, threads, settings, pairs, exclude, edges, lists :
        As for `volccd.Detector`; the same on all ranks but for `threads`, of which a rank has 1 unless it asks for more.
    """

    @suggesting
    def __init__(self, comm, cells, vertices, owned=None, *, objects=None, ids=None, pipeline="VolCCD+", separation=0.0,
                 threads=1, settings=(), pairs="all", exclude=(), edges="triangulated", lists="off", skin=0.2,
                 max_imbalance=1.2):
        try:
            self._ranks = _Ranks(comm)
        except ImportError as error:
            raise _core.ConfigError(f"{error}: volccd.distributed needs mpi4py (Debian: python3-mpi4py)") from error
        options = _on_all(self._ranks, lambda: _options(pipeline, settings, threads, separation, pairs, exclude, lists))
        self._core = _core.RankDetector(self._ranks, options, skin, max_imbalance)
        self.set_mesh(cells, vertices, owned, objects=objects, ids=ids, edges=edges)

    @suggesting
    def set_mesh(self, cells, vertices, owned=None, *, objects=None, ids=None, edges="triangulated"):
        """Gives another mesh: after each change of the elements, or of who owns what. Arguments as above."""
        def arguments():
            arrays = _meshes.cell_arrays(cells, objects, ids)
            numbers = _meshes.numbers_of(vertices, "vertices")
            count = len(numbers) if owned is None else int(_meshes.numbers_of(owned, "owned", np.int64, ()))
            if not 0 <= count <= len(numbers):
                raise _core.InputError(f"owned: {count} is not within 0 .. {len(numbers)}, the number of vertices")
            return arrays, numbers, count

        arrays, numbers, count = _on_all(self._ranks, arguments)
        if ids is None:
            arrays["ids"] += sum(self._ranks.allgather(len(arrays["types"]))[:self._ranks.rank])
        self._core.set_mesh(arrays, numbers, count, edges)

    @suggesting
    def step(self, points0, points1, middle=None, *, first=False, initial_overlaps=False):
        """Contacts of a motion of the owned vertices, float (owned, 3) each; the other arguments are those of
        `volccd.Detector.step`. Returns this rank's `Result`; with `first`, one rank has the earliest contact."""
        given = ((points0, "points0"), (points1, "points1"), (middle, "middle"))
        points0, points1, middle = _on_all(
            self._ranks, lambda: [None if x is None else _meshes.points_of(x, name) for x, name in given])
        return Result(*self._core.step(points0, points1, middle, first, initial_overlaps))

    def to_owners(self):
        """All contacts of the last step with a vertex that this rank owns, structured as `Result.contacts`."""
        return self._core.to_owners()

    @property
    def separation(self):
        """Contact when the distance reaches this; may be changed between steps, on all ranks."""
        return self._core.separation

    @separation.setter
    def separation(self, value):
        self._core.separation = value

    @property
    def facts(self):
        """As `volccd.Detector.facts`."""
        return self._core.facts
