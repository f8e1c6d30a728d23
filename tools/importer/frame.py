"""One file as a frame of the sequence: points, cells, ids, objects, velocities, thickness, time."""

import dataclasses

import numpy as np

from .attributes import (POINT_IDS, VELOCITIES, cell_arrays, displacements, ids_of, objects_of, pick, points_of, thickness_of,
                         time_of, vectors)
from .errors import BadInput, first_bad
from .formats import CELLS, LEFT_OUT, NODES, linear_type
from .pieces import merge_pieces

FACES = {10: [(0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)],
         12: [(0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
         13: [(0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
         14: [(0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]}


@dataclasses.dataclass
class Frame:
    """A file after all checks. Cells are in CSR form. Without ids in the source, `point_ids` and `cell_ids` are
    None."""

    points: np.ndarray
    types: np.ndarray
    offsets: np.ndarray
    connectivity: np.ndarray
    objects: np.ndarray
    point_ids: np.ndarray = None
    cell_ids: np.ndarray = None
    velocity: np.ndarray = None
    thickness: np.ndarray = None
    time: float = None
    object_names: dict = dataclasses.field(default_factory=dict)
    notes: list = dataclasses.field(default_factory=list)


def refuse_unsupported(mesh, file):
    bad = {}
    for block in mesh.cells:
        if linear_type(block.type) is None and not LEFT_OUT.fullmatch(block.type):
            bad[block.type] = bad.get(block.type, 0) + len(block.data)
    if bad:
        listed = ", ".join(f"{count} {name}" for name, count in bad.items())
        raise BadInput(file, "cells", f"{listed}: not supported; what is: {', '.join(CELLS)}")


def is_face_of_volume(types, offsets, connectivity):
    """For each cell, whether it is a triangle or quad whose vertices are those of a face of a volume cell."""
    if (types >= 10).all():
        return np.zeros(len(types), bool)
    faces = set()
    for kind, members in FACES.items():
        cells = np.flatnonzero(types == kind)
        if len(cells):
            nodes = connectivity[offsets[cells][:, None] + np.arange(NODES[kind])]
            for face in members:
                faces.update(map(tuple, np.sort(nodes[:, face], axis=1)))
    result = np.zeros(len(types), bool)
    if faces:
        for i in np.flatnonzero(types < 10):
            result[i] = tuple(sorted(set(connectivity[offsets[i]:offsets[i + 1]].tolist()))) in faces
    return result


def check_repeated_vertices(frame, file):
    """Raises an error for cells with too few distinct vertices, and notes how many other cells have a vertex twice."""
    repeated = 0
    for kind, nodes in NODES.items():
        cells = np.flatnonzero(frame.types == kind)
        members = np.sort(frame.connectivity[frame.offsets[cells][:, None] + np.arange(nodes)], axis=1)
        distinct = 1 + (np.diff(members, axis=1) != 0).sum(axis=1)
        minimum = 3 if kind < 10 else 4
        bad = first_bad(distinct < minimum)
        if bad is not None:
            cell = int(cells[bad])
            name = "" if frame.cell_ids is None else f" (cell id {frame.cell_ids[cell]})"
            raise BadInput(file, "cells", f"has {distinct[bad]} distinct vertices, an element has at minimum {minimum}{name}", cell)
        repeated += int((distinct < nodes).sum())
    if repeated:
        frame.notes.append(f"{repeated} cells have a vertex more than once, and stand for elements with fewer")


def by_corners(mesh, notes):
    """Elements of higher order are replaced by those of their corners. Returns blocks (VTK's type or 0, corners), and
    which points remain: not those that only elements of higher order have, as middle nodes."""
    blocks, counts = [], {}
    used, middle = np.zeros(len(mesh.points), bool), np.zeros(len(mesh.points), bool)
    for block in mesh.cells:
        data = np.asarray(block.data)
        if not len(data):
            continue
        kind = linear_type(block.type)
        number, nodes, _ = CELLS.get(kind, (0, data.shape[1], 0))
        if kind and data.shape[1] > nodes:
            counts[block.type] = counts.get(block.type, 0) + len(data)
            inside = data[:, nodes:]
            middle[inside[(inside >= 0) & (inside < len(middle))]] = True
            data = data[:, :nodes]
        blocks.append((number, data))
        if kind:
            used[data[(data >= 0) & (data < len(used))]] = True
    stay = used | ~middle
    if counts:
        listed = ", ".join(f"{count} {name}" for name, count in counts.items())
        notes.append(f"{listed}: taken as straight, by their corners; {int((~stay).sum())} middle nodes are left out")
    return blocks, stay


def without_points(mesh, blocks, stay, file, options, in_pieces):
    """Mesh and blocks after points have gone: middle nodes, and those that pieces have in common."""
    ids = pick(mesh.point_data, options.point_ids, POINT_IDS, file, "point ids")
    merged = merge_pieces(mesh, ids, options.pieces, file) if in_pieces else None
    rows, same = merged if merged else (np.arange(len(mesh.points)), np.arange(len(mesh.points)))
    kept = np.zeros(len(rows), bool)
    np.logical_or.at(kept, same, stay)
    if merged is None and kept.all():
        return blocks, rows
    number = np.cumsum(kept) - 1
    new = np.where(kept[same], number[same], -1)
    blocks = [(kind, new[data] if kind else data) for kind, data in blocks]
    mesh.points = np.asarray(mesh.points)[rows[kept]]
    mesh.point_data = {name: np.asarray(values)[rows[kept]] for name, values in mesh.point_data.items()}
    return blocks, rows[kept]


def check_connectivity(connectivity, offsets, points, file):
    outside = (connectivity < 0) | (connectivity >= points)
    if outside.any():
        at = int(np.searchsorted(offsets, first_bad(outside), "right")) - 1
        raise BadInput(file, "cells", f"uses point {connectivity[first_bad(outside)]} of {points}", at)


def offsets_of(types):
    return np.concatenate([[0], np.cumsum([NODES[kind] for kind in types])]).astype(np.int64)


def read_frame(source, options):
    file = source.name
    mesh, said, numbering = source.read()
    notes = [said] if said else []
    refuse_unsupported(mesh, file)
    points_of(mesh, file)
    blocks, stay = by_corners(mesh, notes)
    if not any(kind for kind, _ in blocks):
        raise BadInput(file, "cells", "no cells of a supported type: " + ", ".join(CELLS))
    types = np.concatenate([np.full(len(data), kind, np.uint8) for kind, data in blocks])
    keep = types > 0
    nodes = np.concatenate([data.reshape(-1) for kind, data in blocks if kind]).astype(np.int64)
    check_connectivity(nodes, offsets_of(types[keep]), len(mesh.points), file)
    blocks, rows = without_points(mesh, blocks, stay, file, options, source.in_pieces)
    points, arrays = points_of(mesh, file), cell_arrays(mesh)
    connectivity = np.concatenate([data.reshape(-1) for kind, data in blocks if kind]).astype(np.int64)
    offsets = offsets_of(types[keep])
    if not options.keep_faces:
        face = is_face_of_volume(types[keep], offsets, connectivity)
        if face.any():
            notes.append(f"{int(face.sum())} triangles and quads that are faces of volume cells are left out")
            connectivity = connectivity[np.repeat(~face, np.diff(offsets))]
            keep[np.flatnonzero(keep)[face]] = False
            offsets = offsets_of(types[keep])
    moved, name = displacements(mesh, options, source)
    if moved is not None:
        points = points + moved
        notes.append(f"{name} is added to the points")
    objects, names = objects_of(mesh, arrays, numbering, keep, options, file)
    time = source.time if source.time is not None else time_of(mesh, file)
    frame = Frame(points, types[keep], offsets, connectivity, objects, time=time, object_names=names, notes=notes)
    ids_of(frame, mesh, arrays, numbering, rows, keep, options, file)
    frame.velocity = vectors(mesh, options.velocity, VELOCITIES, file, "velocity")
    frame.thickness = thickness_of(arrays, keep, frame.types, options.thickness, file)
    check_repeated_vertices(frame, file)
    return frame
