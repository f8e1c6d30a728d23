// Contacts by several ranks, each with its own part of the mesh: one rank's side.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/distributed/agreement.hpp>
#include <volccd/distributed/elements.hpp>
#include <volccd/distributed/exchange.hpp>
#include <volccd/distributed/regions.hpp>
#include <volccd/distributed/result.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd::distributed {

/// The same on all ranks, except for the executor.
struct Config {
  /// Runs the work of this rank, and must outlive the Detector. Null: the calling thread.
  Executor* executor = nullptr;
  /// Distance at which features are in contact, in the unit of the coordinates; finite, >= 0. 0: when they touch.
  double separation = 0;
  /// The pairs of objects whose contacts are found.
  ObjectFilter filter = {};
  /// Contacts of shell neighbours are not found (Step::leave_out_shell_neighbours). Vertices 3 i, 3 i + 1 and 3 i + 2
  /// of all meshes then stem from one shell vertex.
  bool leave_out_shell_neighbours = false;
  /// Lists of elements are made with boxes that are greater by this part of their longest side on each side, and are
  /// kept while no box meets another region than its greater one did; finite, >= 0. Greater: fewer new lists, more
  /// elements on each rank.
  double skin = 0.2;
  /// Regions are divided anew when the time that the slowest rank took beyond this many times the mean of all, summed
  /// over steps, exceeds that of the first step with the present regions, and for the n-th new cuts 2^(n-1) times that.
  /// Infinity: regions stay.
  double max_imbalance = 1.2;
  /// Whether a rank tests lists of candidates of earlier steps, as long as it has the same piece of the mesh
  /// (docs/candidate_lists.md).
  ListConfig lists = {};
};

/// One of several ranks, each of which gives some elements of a mesh and the positions of some of its vertices. Ranks
/// divide space into regions. Each receives the elements whose swept boxes, enlarged by half the separation, meet its
/// region, and runs the pipeline on them, with a RegionFilter as last feature filter. Contacts and initial overlaps of
/// all ranks together, each found once, are those of a StepRunner with the same pipeline on the whole mesh bit for bit,
/// for any number of ranks and any distribution of elements and vertices (docs/distributed.md), if the pipeline's
/// guarantee is `exact` or `conservative`, and but for undecided tests: these are contacts only where they are
/// performed, and which of them are performed may depend on the ranks. With `inclusion.undecided=exact`, or a
/// separation, `inclusion` leaves none of them open.
///
/// All members that are said to be collective are called by all ranks in the same order. What they throw is a RankError
/// with the same text on all ranks, if a rank finds an error in its data or cannot go on; the ranks can then call
/// again. After an exception the result is unspecified, and the next step makes everything anew. If an exception leaves
/// a rank in another way, the program has to end the others (Exchange).
///
/// A rank may have no elements, no vertices, or neither. One thread at a time.
class Detector {
 public:
  /// Collective. Throws a RankError for an unknown stage or option, an invalid number in the configuration, a pipeline
  /// whose guarantee is `approximate`, and for pipelines or configurations that are not the same on all ranks. The
  /// exchange must outlive the detector; the registry is not used later.
  Detector(Exchange& exchange, const Registry& registry, const PipelineSpec& spec, const Config& config = {});
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// Sets the mesh: the elements of this rank, and the ids of the vertices whose positions it will give. Together the
  /// ranks give each element once, each vertex once, and all vertices of the elements. Collective. Throws a RankError
  /// for an id that is given twice, which names both ranks, a vertex that no rank gives, and an element that is not
  /// valid (Mesh::add_element). Expected time O(elements + vertices of this rank).
  void set_mesh(Elements elements, std::vector<std::int64_t> vertices, EdgeSet edge_set = EdgeSet::triangulated);

  /// Removes elements of this rank by their ids, appends vertices, adds elements. As set_mesh() with the result, and
  /// takes its time. After an exception the mesh is unchanged.
  void edit(std::span<const std::int64_t> removed, std::span<const std::int64_t> new_vertices, const Elements& added);

  /// The contacts of a motion. `own`: control points of this rank's vertices, in the order in which it gave them; the
  /// number of control points, the separation and the request are the same on all ranks. Query::first: only one rank
  /// has a contact, the earliest of all. Collective. Throws a RankError if set_mesh() has not been called, if the
  /// motion has another number of vertices, if the request has ends, tests, candidates or an observer, for the
  /// exceptions of Pipeline::run, and if shell neighbours are to be left out (the vertices of a shell vertex then have
  /// the ids 3 i, 3 i + 1 and 3 i + 2). The result is valid until the next step.
  const RankResult& step(const Motion& own, const Request& request = {});
  /// The same on straight lines. Throws a RankError also for a position that is not finite.
  const RankResult& step(std::span<const Vec3> x0, std::span<const Vec3> x1, const Request& request = {});

  /// All contacts of the last step that have a vertex of this rank, in canonical order. Collective.
  std::vector<RankContact> to_owners();

  /// The result of the last step of this rank.
  const RankResult& result() const;
  /// The same on all ranks. All of space for rank 0 before the first step.
  const Regions& regions() const;
  /// The given pipeline with the region filter.
  const Pipeline& pipeline() const;
  double separation() const;
  /// Holds from the next step on; the same on all ranks. Throws ConfigError if the value is negative or not finite.
  void set_separation(double separation);

 private:
  struct State;
  std::unique_ptr<State> state_;  ///< null only in an object that was moved from
};

}  // namespace volccd::distributed
