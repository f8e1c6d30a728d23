// Contacts of a whole mesh by several ranks in one process.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <volccd/distributed/detector.hpp>
#include <volccd/distributed/in_process_exchange.hpp>

namespace volccd::distributed {

/// Runs a Detector on each of several ranks in this process, one after another (InProcessRanks). Each rank gives an
/// equal part of the elements and vertices of a topology, in the order of their slots.
///
/// Contacts and initial overlaps are those of a StepRunner with the same pipeline on the topology, under the conditions
/// of Detector. One thread at a time. After an exception from step() result() is unspecified, and the next step is as
/// good as any.
class InProcessDetector {
 public:
  /// The configuration holds for each rank; its executor runs the ranks, one after another, each on all workers. Throws
  /// ConfigError for less than one rank, and the errors of Detector.
  InProcessDetector(int ranks, const Registry& registry, const PipelineSpec& spec, const Config& config = {});
  ~InProcessDetector();
  InProcessDetector(InProcessDetector&&) noexcept;
  InProcessDetector& operator=(InProcessDetector&&) noexcept;

  /// The step of all ranks: `motion` has the control points of all vertices of the topology. Slots in the result are
  /// those of the topology. Counts and times in its statistics are the sums of all ranks; `steps` is 1, and
  /// the step counts as fresh if it was fresh on any rank, otherwise as one that made, refreshed or used a list, in
  /// this order. If the topology is another one than before, or has been edited, the ranks receive all of it. If shell
  /// neighbours are left out, the vertices of a shell vertex have the ids 3 i, 3 i + 1 and 3 i + 2.
  ///
  /// Throws ConfigError if the request has ends, tests, candidates or an observer, InputError for a motion of another
  /// number of vertices, and the errors of Detector.
  const StepResult& step(const Topology& topology, const Motion& motion, const Request& request = {});

  /// The result of the last step; valid until the next one.
  const StepResult& result() const { return result_; }
  /// By rank, of the last step.
  std::span<const RankStatistics> statistics() const { return statistics_; }
  /// All of space for rank 0 before the first step.
  const Regions& regions() const;
  /// The pipeline of each rank: the given one and the region filter.
  const Pipeline& pipeline() const;
  double separation() const;
  /// Holds from the next step on. Throws ConfigError if the value is negative or not finite.
  void set_separation(double separation);

 private:
  struct Rank;

  void step_of_rank(Exchange& exchange, const Topology& topology, const Motion& motion, const Request& request,
                    bool same_mesh);
  void append(const RankResult& found, const Topology& topology);
  void finish();

  bool leave_out_shell_neighbours_;
  InProcessRanks in_process_;
  std::vector<std::unique_ptr<Rank>> ranks_;
  std::uint64_t version_ = 0;  ///< of the topology that the ranks have, 0 if none
  StepResult result_;
  std::vector<RankStatistics> statistics_;
};

}  // namespace volccd::distributed
