// The broad phase `brute-force`: tests every pair of elements. The other broad phases are compared with it.
#pragma once

#include <volccd/query/roles/broad_phase.hpp>

namespace volccd {

/// Uses neither a tree nor a grid: either swept boxes in doubles, which are exact except that the separation is rounded
/// upward, or no bounds at all. Emits the pairs whose boxes come within the separation along each axis, a superset of
/// the pairs whose k-DOPs overlap. O(n^2) time; about 100 bytes per element, and 4 more for each worker.
class BruteForce final : public BroadPhase {
 public:
  enum class Bounds {
    none,  ///< every pair
    aabb   ///< pairs whose swept boxes overlap
  };

  struct Config {
    Bounds bounds = Bounds::aabb;
  };
  static const Options<Config>& options();

  explicit BruteForce(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  std::size_t blocks(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override;

 private:
  Config config_;
};

StageDescriptor<BroadPhase> describe_brute_force();

}  // namespace volccd
