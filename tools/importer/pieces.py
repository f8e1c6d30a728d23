"""Meshes in pieces: several of one time, whose borders have the same points."""

import meshio
import numpy as np

from .errors import BadInput, first_bad


def without_ghosts(mesh):
    """The mesh without ghost cells, which another piece has as its own."""
    ghosts = mesh.cell_data.pop("vtkGhostType", mesh.cell_data.pop("vtkGhostLevels", None))
    for name in ("vtkGhostType", "vtkGhostLevels"):
        mesh.point_data.pop(name, None)
        mesh.cell_data.pop(name, None)
    if ghosts is None or not any(np.any(values) for values in ghosts):
        return mesh
    own = [np.asarray(values).reshape(len(values), -1)[:, 0] == 0 for values in ghosts]
    kept = [k for k, rows in enumerate(own) if rows.any()]
    result = meshio.Mesh(mesh.points, [(mesh.cells[k].type, mesh.cells[k].data[own[k]]) for k in kept], point_data=mesh.point_data,
                         cell_data={name: [np.asarray(values[k])[own[k]] for k in kept] for name, values in mesh.cell_data.items()})
    result.field_data = mesh.field_data
    return result


def concatenated(meshes):
    """The points and cells of several meshes, one after the other, with the arrays that all of them have."""
    first = np.cumsum([0] + [len(mesh.points) for mesh in meshes])
    blocks = [(block.type, block.data + shift) for mesh, shift in zip(meshes, first) for block in mesh.cells]
    points = [name for name in meshes[0].point_data if all(name in mesh.point_data for mesh in meshes)]
    cells = [name for name in meshes[0].cell_data if all(name in mesh.cell_data for mesh in meshes)]
    return meshio.Mesh(np.concatenate([mesh.points for mesh in meshes]), blocks,
                       point_data={name: np.concatenate([mesh.point_data[name] for mesh in meshes]) for name in points},
                       cell_data={name: [values for mesh in meshes for values in mesh.cell_data[name]] for name in cells})


def merge_pieces(mesh, ids, how, file):
    """The points that remain of a mesh in pieces, and for each point the one that it is: points of one id are one. Without
    ids, points at one place are one as `how` says."""
    if ids is not None:
        _, first, same = np.unique(ids, return_index=True, return_inverse=True)
    else:
        _, first, same = np.unique(np.asarray(mesh.points), axis=0, return_index=True, return_inverse=True)
    if len(first) == len(mesh.points):
        return None
    if ids is None and how is None:
        raise BadInput(file, "points", f"{len(mesh.points) - len(first)} are at the place of another, and there are no point ids: "
                       "give --pieces join if the pieces are of one body, or --pieces apart")
    if ids is None and how == "apart":
        return None
    points = np.asarray(mesh.points, np.float64)
    apart = first_bad(abs(points[first][same] - points) > 1e-6 * abs(points).max()) if ids is not None else None
    if apart is not None:  # what processes have computed apart may differ by rounding
        raise BadInput(file, "points", f"the id {ids[apart]} is there twice, at two places", apart)
    order = np.argsort(first)  # points stay in the order of the file
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return first[order], rank[same]
