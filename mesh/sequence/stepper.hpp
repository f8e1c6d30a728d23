// From a sequence file to queries: a topology and a motion for each pair of neighbouring steps.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <volccd/mesh/features.hpp>
#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/sequence/connected_parts.hpp>
#include <volccd/mesh/sequence/reader.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

namespace detail {
class ShellSolids;
}

/// How triangles and quads are taken.
enum class ShellModel {
  surface,  ///< as they are
  solid     ///< thickened into wedges and hexahedra (mesh/shells.hpp)
};

/// Which object an element belongs to.
enum class PartModel {
  stored,     ///< PartId of the file
  components  ///< its connected component (ConnectedParts)
};

/// How vertices get from step k to step k+1.
enum class MotionModel {
  linear,     ///< on straight lines: two control points
  quadratic,  ///< with constant acceleration: three (Section 7.1)
  tentative   ///< from step k with its velocities, whatever step k+1 is: two, on straight lines
};

/// Motion k goes from the points of step k to those of step k+1, on the topology of step k+1: a query runs on the new
/// topology. Element ids are GlobalCellIds, objects are PartId or connected components, vertices are all points of the
/// file.
///
/// Tentative motion k is the one that a solver asks about before it resolves contacts: from the points x of step k to
/// x + h v, on the topology of step k, where v are the stored velocities of step k and h is the length of the step. A
/// vertex that no cell of step k uses stands still. What follows for step k+1 does not apply to it.
///
/// Quadratic motion over a step of length h starts with the stored velocity v of step k, if the file has velocities:
/// control points x0, x0 + v h/2, x1. Else it is the parabola through the steps k-1, k and k+1, in their own times;
/// motion 0 takes the steps 0, 1 and 2. (Looking back: a cell of step k+1 may be gone at k+2, and its points anywhere.)
/// A vertex that no cell uses where the velocity (at step k) or the third position (at step k-1, or 2) is taken has
/// none that means anything, and moves on a straight line.
///
/// Velocities are lengths of the file in its units of time.
///
/// Going from one motion to another edits one Topology by the cells that came, went or changed, so that stages can
/// follow its changes; jumping works as well as going on. Element slots therefore depend on the way taken, vertex slots
/// and contacts do not.
///
/// A file holds all its points at all steps, also those that no cell uses. So a vertex that the cells of step k do not
/// use and those of step k+1 do starts from its stored place at step k, and is not a new vertex in the sense of
/// Section 6.3.
///
/// Solid shells: every point has three vertices, whose ids are 3 id, 3 id + 1, 3 id + 2 (solid_middle, solid_below,
/// solid_above); element ids stay. The thickness is that of step k at the start and of step k+1 at the end; a shell
/// that step k does not have is as thick as at step k+1. A file that has shells but no thickness is refused. In
/// quadratic motion the offset from a shell's vertex still goes straight from that at the start to that at the end. In
/// tentative motion the thickness is that of step k at both ends, the normals are those of the points at each end.
///
/// Holds two steps of points, three for quadratic motion, and one step of velocities where they are used. One thread at
/// a time.
class SequenceStepper {
 public:
  struct Config {
    EdgeSet edge_set = EdgeSet::triangulated;
    ShellModel shells = ShellModel::surface;
    MotionModel motion = MotionModel::linear;
    PartModel parts = PartModel::stored;
  };

  /// The reader outlives the stepper. Throws InputError if the file has motions, but for quadratic motion neither
  /// velocities nor a third step, or for tentative motion no velocities. Connected components: reads the cells of all
  /// steps, and throws what that throws.
  explicit SequenceStepper(SequenceReader& reader) : SequenceStepper(reader, Config()) {}
  SequenceStepper(SequenceReader& reader, Config config);
  ~SequenceStepper();

  /// Steps less one; 0 for a file of one step.
  int motion_count() const { return reader_.step_count() - 1; }

  /// The step whose cells a motion runs on: the one after it, or its own for tentative motion.
  int cells_step(int motion) const { return config_.motion == MotionModel::tentative ? motion : motion + 1; }

  /// Throws InputError if there is no such motion or its data are bad (a control point computed from velocities or
  /// three steps that overflows, where a cell uses it, included); then topology() and motion() are as before. Time
  /// without reading: proportional to the points, the cells, and the features of the cells that change.
  void go_to(int motion);

  /// The motion gone to last, or -1. What follows needs one.
  int current() const { return current_; }
  const Topology& topology() const { return *topology_; }
  const Motion& motion() const { return motion_; }
  /// Time of step k+1 less that of step k.
  double step_length() const { return reader_.time(current_ + 1) - reader_.time(current_); }
  /// Wall clock that the last successful go_to() spent in Topology::apply: the edits of mesh, features and adjacency,
  /// without reading. 0 where no element changed, and for the first, which builds the topology.
  double edit_seconds() const { return edit_seconds_; }
  /// Solid shells: vertices whose normal had to be made up, at the start and at the end together (ShellThickener).
  Index vertices_without_normal() const { return without_normal_; }

 private:
  /// Points of one step of the file.
  struct Points {
    int step = -1;
    std::vector<Vec3> positions;
  };

  /// The step whose points decide the curvature of a motion, or -1 if none does.
  int third_step(int motion) const;
  void read_points(int motion);
  const std::vector<Vec3>& points(int step) const;
  void read_cells(int step);
  void read_middle(int motion);
  void read_tentative(int motion);
  void mark_used(int step);
  void set_solid_middle(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1);
  void set_topology(int step);
  void set_motion(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1, const std::vector<Vec3>& middle);

  SequenceReader& reader_;
  Config config_;
  int current_ = -1;
  int cells_step_ = -1, topology_step_ = -1;
  std::optional<Topology> topology_;
  Motion motion_;
  Index without_normal_ = 0;
  double edit_seconds_ = 0;
  std::array<Points, 3> points_;
  SequenceCells cells_;
  std::optional<ConnectedParts> components_;
  std::unique_ptr<detail::ShellSolids> solids_;  ///< null for surfaces
  std::vector<Vec3> solid0_, solid1_;
  /// Quadratic motion: middle control points. Tentative motion: ends. Both: velocities; cells of the step that
  /// mark_used() was last called for, and which vertices they use.
  std::vector<Vec3> middle_, solid_middle_, tentative_, velocity_;
  SequenceCells used_cells_;
  std::vector<char> used_;
};

}  // namespace volccd
