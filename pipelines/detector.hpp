// The front door of the library: a mesh, and the contacts of its steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/topology.hpp>
#include <volccd/pipelines/step_runner.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

struct DetectorConfig {
  /// A pipeline of the registry. All that are exact or conservative find the same contacts (docs/pipelines.md).
  std::string pipeline = "VolCCD+";
  /// Changes of the pipeline in the syntax of `--set`: "csat.axis=optimal", "element-culling=csat".
  std::vector<std::string> settings = {};
  /// Number of threads; 0: as many as the hardware has. Not used if there is an executor.
  unsigned threads = 1;
  /// Runs all work, and must outlive the Detector; null: an executor of its own, from make_executor(threads).
  Executor* executor = nullptr;
  /// Distance at which features are in contact, in the unit of the coordinates; finite, >= 0. 0: when they touch.
  double separation = 0;
  /// The pairs of objects whose contacts are found: all, ObjectFilter(PairScope::inter) for those between objects,
  /// PairScope::intra for those within objects; ObjectFilter::exclude removes single pairs.
  ObjectFilter filter = {};
  /// Whether steps test lists of candidates of earlier steps (docs/candidate_lists.md). Contacts are the same.
  ListConfig lists = {};
  /// Which edges of quads and polygons have contacts; the default is complete for faces that are not planar.
  EdgeSet edge_set = EdgeSet::triangulated;
};

/// Changes of the mesh of a Detector, in this order: elements are removed, vertices are appended, elements are added.
struct DetectorEdit {
  std::vector<std::int64_t> removed = {};  ///< ids of elements, each once
  Index new_vertices = 0;                  ///< get the slots and the ids that follow the last ones
  std::vector<ElementSpec> added = {};     ///< with ids that no remaining element has
  std::vector<double> thickness = {};      ///< [added]; only for thickened shells: one value for each added element
};

/// A mesh with a pipeline, a workspace and an executor: finds the contacts of one step after another. The first step
/// builds the tables of the mesh; later steps reuse them, and edits update them. Once they have grown to the size of
/// the scene, a step allocates memory only for its result (Pipeline::run).
///
/// Positions are arrays by vertex slot, one for each vertex of the mesh, finite, in any unit of length. Contacts name
/// vertices by slot, initial overlaps name elements by slot of topology().mesh(); slots are the order of insertion
/// until an edit removes an element. The same contacts, bit for bit, for any number of threads, and for a kept Detector
/// as for a new one with the same mesh.
///
/// Thickened shells: with a thickness, triangles and quads become wedges and hexahedra along the vertex normals at both
/// ends of a step (mesh/shells.hpp). Positions and edits are still those of the shell mesh, mesh(). topology() and the
/// contacts have the vertices of the solid mesh: vertex v of a contact stems from shell_vertex(v). Contacts
/// between features that stem from one vertex are not asked for (RunConfig::leave_out_shell_neighbours).
///
/// Movable. One thread at a time; different Detectors are independent unless they share an executor. After an exception
/// from a step the mesh is unchanged, result() is unspecified, and the next step is that of a new Detector. After an
/// exception from edit() nothing has changed.
class Detector {
 public:
  /// Throws ConfigError for an unknown pipeline, stage, option or value. The registry, which may contain stages of the
  /// caller's own, is not used later. O(elements), on all threads.
  explicit Detector(Mesh mesh, const DetectorConfig& config = {}, const Registry& registry = Registry::standard());

  /// With thickened shells. `thickness`, by element slot, in the unit of the positions: finite and >= 0 for triangles
  /// and quads; other entries are not read. Throws InputError ("shells", "thickness", slot) as well.
  Detector(Mesh mesh, std::span<const double> thickness, const DetectorConfig& config = {},
           const Registry& registry = Registry::standard());

  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// The contacts of the motion on straight lines from x0 (t = 0) to x1 (t = 1). Contacts later than t_max, in 0 .. 1,
  /// need not be found. The result is valid until the next step. Throws InputError ("motion", "x0", "xm" or "x1",
  /// index) for a wrong number of positions and for one that is not finite, ConfigError for an invalid t_max, and the
  /// exceptions of Pipeline::run.
  const StepResult& step(std::span<const Vec3> x0, std::span<const Vec3> x1, const Request& request = {},
                         double t_max = 1);
  /// The same for constant acceleration: quadratic Bezier curves with middle control points xm, which are not points of
  /// the curves. The offsets of thickened shells are linear in time.
  const StepResult& step(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1,
                         const Request& request = {}, double t_max = 1);
  /// The same for a motion of all vertices of topology(): with thickened shells, those of the solid mesh.
  const StepResult& step(const Motion& motion, const Request& request = {}, double t_max = 1);

  /// The earliest contact of the motion on straight lines, or nothing; for equal times, the first in canonical order.
  /// No contact is reported late if the pipeline is conservative: the motion is then free of contacts before its toi.
  /// Faster than step(), because later contacts are pruned.
  std::optional<Contact> first(std::span<const Vec3> x0, std::span<const Vec3> x1);

  /// Changes the mesh between two steps. Throws InputError ("edit", name of the member, index) or that of
  /// Mesh::add_element for an edit that the mesh does not allow. The time is proportional to the size of the edit;
  /// with thickened shells, to that of the mesh.
  void edit(const DetectorEdit& edit);

  /// The mesh as it was given and edited.
  const Mesh& mesh() const;
  /// The topology on which steps run: that of mesh(), or of its solid mesh if shells are thickened.
  const Topology& topology() const;
  bool thickens_shells() const;

  /// The result of the last step; valid until the next one. release_result() moves it out.
  const StepResult& result() const;
  StepResult release_result();

  const Pipeline& pipeline() const;
  Executor& executor() const;
  double separation() const;
  /// Holds from the next step on. Throws ConfigError if the value is negative or not finite.
  void set_separation(double separation);
  /// Memory that the pipeline keeps from step to step, without mesh, topology and result.
  std::size_t workspace_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;  ///< null only in an object that was moved from
};

}  // namespace volccd
