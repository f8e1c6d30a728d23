// A program of one-byte operations that makes small meshes, moves their vertices, edits their topologies and asks for
// steps. Every string of bytes is a valid program: operations whose arguments make no sense do nothing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/step.hpp>

#include "byte_reader.hpp"

namespace volccd::fuzz {

/// How a step is run and checked, besides the motion.
struct StepOptions {
  bool quadratic = false;
  /// The pipeline that is run besides the one with the flood forced.
  enum class Second { none, standard, star_orphans };
  Second second = Second::none;
  bool fresh = false;  ///< the last of these pipelines is also run in a new workspace
  bool first = false;  ///< Query::first is run as well
  bool overlaps = false;
  double separation = 0;
  double t_max = 1;
  unsigned executor = 0;  ///< 0: serial; otherwise the seed of a ShuffledExecutor
};

/// Coordinates are integers of at most kMaxCoordinate. A script has several scenes, each with one topology that is
/// edited by the operations; what an operation adds or removes takes effect with the next step.
class MeshScript {
 public:
  static constexpr double kMaxCoordinate = 4095;
  static constexpr std::size_t kMaxVertices = 64, kMaxElements = 80;
  static constexpr int kMaxSteps = 6, kStepsWithRandomMotions = 4;
  /// Opcodes: a step, and random displacements of all vertices (control point, seed, greatest displacement).
  static constexpr std::uint8_t kStep = 0, kJitter = 22;
  /// The script ends when its steps have had this many elements together.
  static constexpr std::size_t kMaxWork = 110;

  explicit MeshScript(Bytes bytes) : bytes_(bytes), in_(bytes) {}

  /// Carries out the operations up to the next step. After the end of the script, further steps follow with random
  /// motions of the last mesh, because a mesh that could reveal an error does so in few motions only. Returns false
  /// after the last step, or if the mesh does not allow an edit. The members below are valid after true.
  bool next_step();

  const Topology& topology() const { return *scene().topology; }
  const Motion& motion() const { return motion_; }
  const ObjectFilter& filter() const { return filter_; }
  const StepOptions& options() const { return options_; }
  /// The mesh, the motion and the options of this step in text.
  std::string text() const;
  /// The operations that have been carried out, without bytes that were not read.
  std::vector<Bytes> operations_read() const;
  /// Number of steps so far.
  int steps() const { return steps_; }

 private:
  using Operation = void (MeshScript::*)();
  static const std::vector<Operation>& operations();

  /// The positions of one vertex. Control points are those of the next step.
  struct Point {
    Vec3 rest, start, middle, end;
  };
  struct Scene {
    std::vector<Point> points;
    std::unique_ptr<Topology> topology;
    TopologyEdit edit;                 ///< not yet applied
    std::vector<ElementSpec> removed;  ///< elements that were removed at some time
    std::int64_t next_id = 0;
    std::int32_t object = 0;

    std::size_t element_count() const;
    bool is_removed(Index slot) const;
  };

  // Operations that add vertices and elements.
  void add_vertex();
  void add_fine_vertex();
  void add_element();
  void add_polytope();
  void cone_face();
  void extrude_face();
  void glue_tetrahedron();
  void add_block();
  void cone_star();
  void fan();
  void add_strip();
  void add_copy();
  // Operations that change what is not yet in the topology, or remove elements.
  void identify();
  void reverse();
  void shuffle();
  void set_object();
  void remove();
  void restore();
  // Operations that move vertices.
  void set_point();
  void move_point();
  void move_range();
  void jitter();
  void mirror();
  void rest();
  // Other operations.
  void set_scene();
  void set_scale();
  void set_filter();
  void request_step();

  Scene& scene() { return scenes_[current_]; }
  const Scene& scene() const { return scenes_[current_]; }
  Vec3 lattice_point();
  Vec3 small_vector();
  Vec3 fine_point();
  Index some_vertex() { return static_cast<Index>(in_.below(scene().points.size())); }
  bool has_vertices() const { return !scene().points.empty(); }
  Index new_vertex(const Vec3& position);
  void push(ElementType type, std::vector<Index> vertices, std::vector<Index> faces = {});
  void append(const Shape& shape, const Vec3& origin, double spacing);
  /// An element of the topology that is not removed, or one that is not yet in the topology; type `none` if there is
  /// none.
  ElementSpec some_element();
  /// A face of some element, in its outward order; empty if there is none.
  std::vector<Index> some_face();
  void set_end(Index v, int control_point, const Vec3& position);
  bool finish_step();
  void set_random_motion();
  bool apply_edit();
  void set_motion();

  Bytes bytes_;
  ByteReader in_;
  std::vector<std::size_t> begins_;  ///< of the operations in bytes_
  std::vector<Scene> scenes_ = std::vector<Scene>(3);
  std::size_t current_ = 0;
  double scale_ = 16;
  ObjectFilter filter_;
  StepOptions options_;
  Motion motion_;
  int steps_ = 0;
  std::size_t work_ = 0;
  bool step_requested_ = false;
};

}  // namespace volccd::fuzz
