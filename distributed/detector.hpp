// Contacts by several ranks, each with its own part of the mesh: the same as those of the whole mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/distributed/regions.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd::distributed {

struct Config {
  /// Number of ranks, > 0; more than there are elements are allowed.
  int ranks = 1;
  /// Runs the ranks, one after another, each on all workers; must outlive the Detector. Null: the calling thread.
  Executor* executor = nullptr;
  /// Distance at which features are in contact, in the unit of the coordinates; finite, >= 0. 0: when they touch.
  double separation = 0;
  /// The pairs of objects whose contacts are found.
  ObjectFilter filter = {};
};

/// What a rank did in a step, or in several.
struct RankStatistics {
  std::uint64_t elements = 0;  ///< elements that it held
  std::uint64_t copies = 0;    ///< those among them whose centre is in the region of another rank
  std::uint64_t tests = 0;     ///< elementary tests that it performed
  std::uint64_t contacts = 0;  ///< contacts that it found, all of which are its own
  double seconds = 0;          ///< wall-clock time of its pipeline
  double piece_seconds = 0;    ///< wall-clock time to make its piece of the mesh and of the motion

  RankStatistics& operator+=(const RankStatistics& other);
};

/// Runs a pipeline on several ranks, all of them in this process. The first step divides space into regions
/// (Regions, by the centres of the swept boxes of the elements, each of weight 1), which stay. In each step, a rank
/// holds the elements whose swept boxes, enlarged by half the separation, meet its region (PieceMesh). It runs the
/// pipeline on these as on any mesh, with a RegionFilter as last feature filter and with its workspace of the steps
/// before.
///
/// Contacts and initial overlaps are those of a StepRunner with the same pipeline on the whole mesh, bit for bit and in
/// the same order, for any number of ranks (docs/distributed.md), if the pipeline's guarantee is `exact` or
/// `conservative`, and but for undecided tests: these are contacts only where they are performed, and which of them are
/// performed may depend on the number of ranks. With `inclusion.undecided=exact`, or a separation, `inclusion` leaves
/// none of them open.
///
/// One thread at a time. After an exception from step() result() is unspecified, and the next step is as good as any.
class Detector {
 public:
  /// Throws ConfigError for less than one rank, for an unknown stage or option, for an invalid separation, and for a
  /// pipeline whose guarantee is `approximate`. The registry is not used later.
  Detector(const Registry& registry, const PipelineSpec& spec, const Config& config);
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// The step of all ranks: `motion` has the control points of all vertices of the topology. Slots in the result are
  /// those of the topology. Counts and times in its statistics are the sums of all ranks; `steps` is 1. Query::first is
  /// supported: ranks find their earliest contacts, of which the earliest is returned.
  ///
  /// Throws ConfigError if the request has ends, tests, candidates or an observer, and the exceptions of Pipeline::run.
  /// O(elements log ranks + copies) besides the pipelines; pieces that change are built anew.
  const StepResult& step(const Topology& topology, const Motion& motion, const Request& request = {});

  /// The result of the last step; valid until the next one.
  const StepResult& result() const { return result_; }
  /// By rank, of the last step.
  std::span<const RankStatistics> statistics() const { return statistics_; }
  /// All of space for rank 0 before the first step.
  const Regions& regions() const { return regions_; }
  /// The pipeline of each rank: the given one and the region filter.
  const Pipeline& pipeline() const;
  double separation() const { return separation_; }
  /// Holds from the next step on. Throws ConfigError if the value is negative or not finite.
  void set_separation(double separation);

 private:
  struct Rank;

  void make_boxes(const Topology& topology, const Motion& motion);
  void assign_elements(const Mesh& mesh);
  void run_rank(Rank& rank, RankStatistics& statistics, const Topology& topology, const Motion& motion,
                const Request& request);
  void append(Rank& rank, const Topology& topology, const Motion& motion);
  void finish(const Request& request);

  Executor* executor_;
  double separation_ = 0;
  ObjectFilter filter_;
  Regions regions_;
  bool divided_ = false;  ///< whether regions_ are those of the ranks
  std::vector<std::unique_ptr<Rank>> ranks_;
  std::vector<Box> boxes_;  ///< by element slot, of this step
  StepResult result_, rank_result_;
  std::vector<RankStatistics> statistics_;
};

}  // namespace volccd::distributed
