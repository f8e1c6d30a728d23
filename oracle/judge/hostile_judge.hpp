// Decides whether pipelines lose contacts of a hostile case.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <volccd/oracle/cases/hostile_meshes.hpp>
#include <volccd/oracle/judge/contact_memory.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

/// `VolCCD+`
///  - with a flood that declines no step,
///  - with the default options of the flood,
///  - without a flood, with `star-orphans` never leaving the orphans to the O-Set.
PipelineSpec forced_flood(const Registry& registry);
PipelineSpec default_flood(const Registry& registry);
PipelineSpec forced_star_orphans(const Registry& registry);

/// Compares pipelines with brute force. Contacts must agree bit for bit, and so must initial overlaps. Not thread-safe.
class HostileJudge {
 public:
  /// All pipelines get the same narrow phase: `inclusion`, which leaves undecided tests to exact arithmetic.
  HostileJudge(const Registry& registry, const std::vector<PipelineSpec>& specs);
  ~HostileJudge();

  /// Runs all steps: each pipeline with a workspace that is kept for the case, on some steps with several workers, and
  /// on some steps with a new workspace as well. Returns "" or a description of the first difference.
  std::string judge(const cases::HostileCase& c);
  /// The same for the case of a seed. The description begins with "seed N".
  std::string judge_seed(std::uint64_t seed);
  /// The text of the reduced case.
  std::string reduced_text(const cases::HostileCase& c);

  /// Sums over all cases judged so far.
  struct Counters {
    std::uint64_t cases = 0, steps = 0, contacts = 0, initial_overlaps = 0;
  };
  const Counters& counters() const { return counters_; }

 private:
  class Trial;
  struct Contestant;

  std::shared_ptr<ContactMemory> memory_;
  std::unique_ptr<Contestant> small_truth_, large_truth_;  ///< for meshes of few and of many elements
  std::vector<std::unique_ptr<Contestant>> contestants_;
  std::unique_ptr<Executor> threads_;
  Counters counters_;
};

}  // namespace volccd
