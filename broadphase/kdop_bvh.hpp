// The broad phase `kdop-bvh`: a bounding volume hierarchy of k-DOPs (Klosowski et al. 1998; the paper's Section 3.3).
#pragma once

#include <cstdint>

#include <volccd/broadphase/broad_phase.hpp>

namespace volccd {

/// Binary tree over the elements, bounds of float k-DOPs rounded outward (axes in query/kdop.hpp). Emits the pairs of
/// elements whose swept k-DOPs, widened by half of the separation on each side, overlap; `spatial-hash` with the same k
/// emits the same pairs.
///
/// prepare: built top-down by the surface-area heuristic for a fresh state, O(n log n); then refitted, O(n). Removed
/// elements leave gaps, added ones form a second tree, until so many of either have gathered that the whole is built
/// anew (more than a quarter gone, or 1/32 and 64 added). A subtree is rebuilt in its place when its measured cost, the
/// node sizes in relation to the element sizes, exceeds `degradation` times what it was after its last build: only the
/// parts that degraded.
///
/// run: the tree against itself, from a list of node pairs that does not depend on the number of workers. Memory: about
/// 270 bytes an element for k = 16 and tetrahedra. Bounds are those over [0, 1] whatever t_max is.
class KdopBvh final : public BroadPhase {
 public:
  enum class Restructure {
    none,      ///< refit only
    subtrees,  ///< rebuild the subtrees that degraded
    always     ///< build anew at every step
  };

  struct Config {
    int k = 16;           ///< 6, 14, 16, 18, 24 or 26; the constructor throws ConfigError for others
    int leaf_size = 4;    ///< elements a leaf, 1 .. 8
    Restructure restructure = Restructure::subtrees;
    double degradation = 1.3;  ///< tolerated growth of a subtree's cost
  };
  static const Options<Config>& options();

  /// Summed over the life of a state.
  struct Counters {
    std::uint64_t builds = 0;                 ///< of the whole tree
    std::uint64_t restructured_elements = 0;  ///< in subtrees that were rebuilt
    std::uint64_t node_tests = 0;             ///< overlap tests that involve an inner node or two leaves as wholes
  };

  explicit KdopBvh(const Config& config);

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, PairRange range, Executor& executor, PairSink sink) const override;
  double bounds_seconds(const StageState& state) const override;

  /// Of a state that a KdopBvh made.
  static const Counters& counters(const StageState& state);

 private:
  Config config_;
};

StageDescriptor<BroadPhase> describe_kdop_bvh();

}  // namespace volccd
