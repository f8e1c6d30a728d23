#!/usr/bin/env python3
"""Turns mesh files of other programs into one sequence file that `volccd` reads.

Input: .vtu, .vtk (legacy), .msh (Gmsh), .ply, .obj, .inp (Abaqus), .bdf/.fem/.nas (Nastran), read through meshio. Each file
is one frame. Output: VTKHDF, the layout that docs/sequence_files.md describes.

These data are kept if the source has them:
  point ids    array GlobalPointIds, NODE_ID, ..; node numbers of Gmsh (text), Abaqus and Nastran
  cell ids     array GlobalCellIds, ElementId, ELEMENT_ID, ..; element numbers of Gmsh (text), Abaqus and Nastran
  objects      array PartId, PART_ID, ..; Gmsh physical groups, Nastran property ids, groups of .obj, element sets of Abaqus
               (numbered from 1 in the order of the file)
  velocities   array Velocity, ..; as point vectors
  displacement only as --displacement says: files do not tell whether their points are displaced already
  thickness    array Thickness, ..; per cell
With point ids, files may list points in different orders, and may have different points. In a frame without a certain
point, the point is written at its last (or else its first) position, and no cell uses it. With cell ids, files may have
different cells. Without ids, all files must have the same points and cells.

Cells whose nodes repeat (a wedge as a hexahedron, a triangle as a quad) are written unchanged; volccd reads them as the
elements that they represent. A cell with too few distinct nodes for any element is an error.

Lines and single vertices are left out, and so are triangles and quads that are faces of volume cells (--keep-faces keeps
them). Higher-order cells, polygons and polyhedra are errors, and so are Abaqus decks with more than one part or instance,
with an instance that is moved, or with generated nodes or elements.

Examples:
  import_sequence.py block.msh -o block.vtkhdf                        one frame
  import_sequence.py run_*.vtu -o run.vtkhdf --sort natural           run_2 before run_10, times from the files, else 0, 1, ..
  import_sequence.py run_*.vtk -o run.vtkhdf --sort natural --dt 1e-6 --units m --time-unit second
  import_sequence.py a.inp b.inp -o run.vtkhdf --times 0,0.5 --sets Bolt,Plate
  import_sequence.py cloth_*.ply -o cloth.vtkhdf --sort natural --velocity vx,vy,vz --thickness 0.001

The output must be a regular file and not one of the inputs. If it is a symbolic link, the target of the link is replaced.

Needs python3-meshio and python3-h5py. Exit code: 0 written, 2 bad input, output or usage, 130 interrupted. If the exit
code is not 0, no new file remains, and an earlier output is unchanged.
"""

import argparse
import contextlib
import os
import stat
import sys

try:
    import h5py
    import meshio  # noqa: F401  # pylint: disable=unused-import
    import numpy  # noqa: F401  # pylint: disable=unused-import
except ImportError as problem:
    sys.exit(f"import_sequence.py: {problem}; install python3-meshio and python3-h5py")

from importer.errors import BadInput
from importer.sequence import Union, check_same, order_files, times_of
from importer.frame import read_frame
from importer.writer import Sink, Writer, output_path

def about_of(options, first, files):
    names = "; ".join(f"{number} {name.replace(';', ',')}" for number, name in sorted(first.object_names.items()))
    source = os.path.basename(files[0]) + (f" .. {os.path.basename(files[-1])}" if len(files) > 1 else "")
    return {"Title": options.title, "Source": options.source or source, "License": options.license, "Units": options.units,
            "TimeUnit": options.time_unit, "Parts": names}


def import_files(files, options, output, check):
    """Imports the files as frames. `check` raises an error if the data written so far could not be stored."""
    union, found = Union(), []
    # Files are read twice and not kept, because a run may be larger than memory.
    first = None
    for file in files:
        frame = read_frame(file, options)
        union.add(frame, file)
        found.append(frame.time)
        first = first or frame
    times = times_of(files, options, found)
    writer, notes, shapes = Writer(output), [], []
    for file in files:
        frame = union.renumber(read_frame(file, options) if len(files) > 1 else first)
        first = frame if not shapes else first
        check_same(frame, first, file)
        writer.add(frame)
        check()
        shapes.append(len(frame.types))
        notes += [f"{file}: {note}" for note in frame.notes if not notes]
    writer.finish(times, union.ids, len(union.places), about_of(options, first, files))
    given = ", ".join(f"{name} {'kept' if there else 'made up'}" for name, there in (
        ("point ids", union.ids is not None), ("cell ids", first.cell_ids is not None)))
    return notes, f"{len(files)} frames, {len(union.places)} points, {shapes[0]} cells at first, {shapes[-1]} at last; {given}"


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE", help="one for each frame")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="sequence to write (VTKHDF)")
    parser.add_argument("--sort", choices=("given", "natural"), help="order of the files; default: as given, refused if the "
                        "numbers in the names say otherwise")
    when = parser.add_mutually_exclusive_group()
    when.add_argument("--times", type=lambda text: [float(word) for word in text.split(",")], metavar="T0,T1,..",
                      help="times of the frames")
    when.add_argument("--dt", type=float, help="time from frame to frame")
    for name, text in (("point-ids", "point array of ids"), ("cell-ids", "cell array of ids"), ("part", "cell array of objects"),
                       ("velocity", "point array of velocities, or three: vx,vy,vz"),
                       ("thickness", "cell array of shell thickness, or a number for all shells")):
        parser.add_argument(f"--{name}", metavar="NAME", help=f"{text}; 'none': not used; default: by its usual names")
    parser.add_argument("--displacement", metavar="NAME", help="point array of displacements, or three: ux,uy,uz, which are "
                        "added to the points; 'none': not added; must be given if an array has a usual name (disp, U, ..)")
    parser.add_argument("--sets", type=lambda text: text.split(","), metavar="A,B,..",
                        help="element sets that are the objects 1, 2, .. (Abaqus)")
    parser.add_argument("--keep-faces", action="store_true", help="keep triangles and quads that are faces of volume cells")
    for name in ("title", "source", "license", "units", "time-unit"):
        parser.add_argument(f"--{name}", default="", metavar="TEXT", help="attribute of the sequence")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse_arguments(arguments)
    temporary = None
    try:
        files = order_files(options.files, options.sort)
        target = output_path(options.output, files)
        name = f"{target}.{os.getpid()}.tmp"
        with Sink(name, options.output) as sink:
            temporary = name
            if os.path.exists(target):
                os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
            with h5py.File(sink, "w") as output:
                notes, summary = import_files(files, options, output, sink.check)
            sink.to_disk()
        os.replace(temporary, target)
    except (BadInput, OSError, MemoryError) as problem:
        print(f"import_sequence.py: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"import_sequence.py: interrupted; nothing has been written to {options.output}", file=sys.stderr)
        return 130
    finally:
        if temporary:
            with contextlib.suppress(FileNotFoundError):
                os.remove(temporary)
    for note in notes:
        print(f"import_sequence.py: {note}", file=sys.stderr)
    print(f"{options.output}: {summary}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
