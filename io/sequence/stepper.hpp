// From a sequence file to queries: a topology and a motion for each pair of consecutive frames.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <volccd/core/named_values.hpp>
#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/connected_components.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/mesh/features.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

namespace detail {
class ShellSolids;
}

/// How triangles and quads are represented.
enum class ShellModel {
  surface,  ///< as surface elements
  solid     ///< thickened into wedges and hexahedra (mesh/shells.hpp)
};

/// How the object of an element is determined.
enum class ObjectModel {
  stored,     ///< PartId in the file
  components  ///< connected component of the element (ConnectedComponents)
};

/// Trajectories of the vertices from frame k to frame k+1.
enum class MotionModel {
  linear,     ///< straight lines, two control points
  quadratic,  ///< constant acceleration, three control points (Section 7.1)
  tentative,  ///< straight lines from frame k along its velocities, independent of the positions of frame k+1; two
              ///< control points
  query       ///< the last query that the simulation asked before frame k+1; two control points
};

constexpr std::array<NamedValue<ShellModel>, 2> names_of(ShellModel) {
  return {{{"surface", ShellModel::surface}, {"solid", ShellModel::solid}}};
}
constexpr std::array<NamedValue<ObjectModel>, 2> names_of(ObjectModel) {
  return {{{"stored", ObjectModel::stored}, {"components", ObjectModel::components}}};
}
constexpr std::array<NamedValue<MotionModel>, 4> names_of(MotionModel) {
  return {{{"linear", MotionModel::linear},
           {"quadratic", MotionModel::quadratic},
           {"tentative", MotionModel::tentative},
           {"query", MotionModel::query}}};
}

/// Step k leads from the points of frame k to those of frame k+1 and uses the topology of frame k+1. Element ids are
/// GlobalCellIds, objects are PartIds or connected components, and vertices are all points of the file.
///
/// Tentative motion in step k is the motion that a solver tests before it resolves contacts: from the points x of frame
/// k to x + h v, on the topology of frame k, where v are the stored velocities of frame k and h is the length of the
/// step. A vertex that no cell of frame k uses does not move. The statements below about frame k+1 do not apply to
/// tentative motion.
///
/// Query motion in step k is the last query that the simulation asked before it stored frame k+1, if the file has it:
/// straight lines from the positions at its start to those at its end, on the topology of frame k+1. Edits that the
/// simulation made between this query and frame k+1 are included; vertices that are new by them start from the query's
/// positions of the vertices from which they were made. separation() is the distance that it asked for. The positions
/// of the frames k and k+1 are not used.
///
/// If the file has velocities, quadratic motion over a step of length h starts with the stored velocity v of frame k:
/// its control points are x0, x0 + v h/2, x1. Otherwise it is the parabola through the frames k-1, k and k+1 at their
/// times; step 0 uses the frames 0, 1 and 2. (The third frame is k-1 rather than k+2, since a cell of frame k+1 may be
/// removed at frame k+2, and its points may then be anywhere.) If no cell uses a vertex at the frame from which the
/// velocity (frame k) or the third position (frame k-1, or 2) is taken, that value has no meaning, and the vertex moves
/// on a straight line.
///
/// Velocities are in length units per time unit of the file.
///
/// go_to() edits a single Topology by the cells that were added, removed or changed, so that stages can update their
/// states. Steps may be visited in any order. Element slots depend on the order of the visited steps; vertex slots
/// and contacts do not.
///
/// A file stores all points at all frames, including those that no cell uses. Therefore a vertex that cells of frame
/// k+1 use, but no cell of frame k, starts from its stored position at frame k. It is not a new vertex in the sense of
/// Section 6.3.
///
/// Solid shells: every point has three vertices with ids 3 id, 3 id + 1, 3 id + 2 (solid_middle, solid_below,
/// solid_above); element ids are unchanged. The thickness is that of frame k at the start of the motion and that of
/// frame k+1 at its end; a shell that does not exist at frame k has its thickness of frame k+1 at both ends. A file
/// with shells but without thickness is refused. In quadratic motion, the offset from a shell vertex to its solid
/// vertices is linear between its values at the start and at the end. In tentative motion, the thickness is that of
/// frame k at both ends (in query motion, that of frame k+1), and the normals are computed from the positions at each
/// end.
///
/// Memory: the points of two frames, or of three for quadratic motion, and the velocities of one frame if they are
/// used. Not thread-safe.
class SequenceStepper {
 public:
  struct Config {
    EdgeSet edge_set = EdgeSet::triangulated;
    ShellModel shells = ShellModel::surface;
    MotionModel motion = MotionModel::linear;
    ObjectModel objects = ObjectModel::stored;
  };

  /// The reader must outlive the stepper. Throws InputError for a file with several frames if quadratic motion is
  /// requested and there are neither velocities nor a third frame, or if tentative motion is requested and there are no
  /// velocities, or if query motion is requested and the file has no queries. For connected components, the constructor
  /// reads the cells of all frames and throws the errors of reading.
  explicit SequenceStepper(SequenceReader& reader) : SequenceStepper(reader, Config()) {}
  SequenceStepper(SequenceReader& reader, Config config);
  ~SequenceStepper();

  /// Number of frames minus one; 0 for a file with one frame.
  int step_count() const { return reader_.frame_count() - 1; }

  /// The frame whose cells a step uses: the frame at its end, or that at its start for tentative motion.
  int cells_frame(int step) const { return config_.motion == MotionModel::tentative ? step : step + 1; }

  /// Makes a step the current one. Throws InputError if there is no such step or its data are invalid, for example
  /// if a control point that is computed from velocities or three frames overflows for a vertex in use; then topology()
  /// and motion() are unchanged. Without reading, the time is proportional to the number of points and cells and to the
  /// number of features of the changed cells. The first call builds the topology on all workers of the executor; the
  /// result does not depend on it.
  void go_to(int step, Executor& executor = serial_executor());

  /// The step of the last successful go_to(), or -1. The members below require one.
  int current() const { return current_; }
  const Topology& topology() const { return *topology_; }
  const Motion& motion() const { return motion_; }
  /// Query motion: the separation of the query; 0 for all other motions.
  double separation() const { return separation_; }
  /// Time of frame k+1 minus time of frame k.
  double step_length() const { return reader_.time(current_ + 1) - reader_.time(current_); }
  /// Wall-clock time that the last successful go_to() spent in Topology::apply, which edits mesh, features and
  /// adjacency; without reading. 0 if no element changed, and for the first step visited, which builds the topology.
  double edit_seconds() const { return edit_seconds_; }
  /// Solid shells: number of vertices for which ShellThickener found no mean normal, summed over start and end.
  Index vertices_without_normal() const { return without_normal_; }

 private:
  /// The frame whose points determine the curvature of the motion in a step, or -1 if there is none.
  int third_frame(int step) const;
  void read_points(int step);
  void read_cells(int frame);
  void read_middle(int step);
  void read_tentative(int step);
  [[noreturn]] void refuse_overflow(const char* dataset, const char* kind, int step, std::size_t vertex) const;
  void mark_used(int frame);
  void set_topology(int frame, Executor& executor);
  void set_motion(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1, const std::vector<Vec3>& middle);

  SequenceReader& reader_;
  Config config_;
  int current_ = -1;
  int cells_frame_ = -1, topology_frame_ = -1;
  std::optional<Topology> topology_;
  Motion motion_;
  Index without_normal_ = 0;
  double edit_seconds_ = 0, separation_ = 0;
  std::map<int, std::vector<Vec3>> points_;  ///< points of at most three frames of the file, by frame
  SequenceCells cells_;
  std::optional<ConnectedComponents> components_;
  std::unique_ptr<detail::ShellSolids> solids_;  ///< null for ShellModel::surface
  std::vector<Vec3> solid0_, solid1_;
  /// middle_: middle control points of quadratic motion. start_: start of a query. end_: end of a query or of tentative
  /// motion. velocity_: for quadratic and tentative motion. used_cells_: cells of the frame that mark_used() was last
  /// called for; used_: whether they use each vertex.
  std::vector<Vec3> middle_, solid_middle_, start_, end_, velocity_;
  SequenceCells used_cells_;
  std::vector<char> used_;
};

}  // namespace volccd
