// The broad phase `kdop-bvh`: a bounding volume hierarchy of k-DOPs (Klosowski et al. 1998; the paper's Section 3.3).
#pragma once

#include <cstdint>

#include <volccd/query/roles/broad_phase.hpp>

namespace volccd {

/// A binary tree over n elements with k-DOPs in single precision, rounded outward (axes in numerics/kdop.hpp). Emits
/// the pairs of elements whose swept k-DOPs overlap after each is widened by half of the separation on each side.
/// `spatial-hash` with the same k emits the same pairs.
///
/// prepare(): the first tree of a state is built top-down with the surface-area heuristic in O(n log n); later steps
/// refit it in O(n). Removed elements leave empty places, and added elements form a second tree, until there are too
/// many of either (more than 1/4 of n removed, or more than n/32 + 64 added); then the whole tree is rebuilt. A
/// subtree is rebuilt in place when its measured cost (node sizes relative to element sizes) exceeds `degradation`
/// times its cost after its last build, so that only degraded parts are rebuilt.
///
/// run(): tests the tree against itself, starting from a list of node pairs that does not depend on the number of
/// workers. The first query without adjacent pairs after a build makes a table of them, which stays valid for elements
/// that are neither added nor in rebuilt subtrees; the vertices of other elements are compared pair by pair. Memory:
/// about 280 bytes per element for k = 16 and tetrahedra, and 55 to 70 for the table. Bounds cover [0, 1] for every
/// t_max.
class KdopBvh final : public BroadPhase {
 public:
  enum class Restructure {
    none,      ///< refit only
    subtrees,  ///< rebuild degraded subtrees
    always     ///< rebuild the whole tree at every step
  };

  /// How a query that leaves out adjacent pairs finds them.
  enum class AdjacentPairs {
    table,    ///< in a table of the adjacent pairs of leaves, made after a build of the whole tree
    vertices  ///< by comparison of the vertices of each pair
  };

  struct Config {
    int k = 16;         ///< 6, 14, 16, 18, 24 or 26; the constructor throws ConfigError for others
    int leaf_size = 8;  ///< maximum number of elements per leaf, 1 .. 8
    AdjacentPairs adjacent_pairs = AdjacentPairs::table;  ///< `vertices` if the tree is built at every step
    Restructure restructure = Restructure::subtrees;
    double degradation = 2;  ///< a subtree is rebuilt when its cost has grown by more than this factor
  };
  static const Options<Config>& options();

  /// Totals over all steps of a state.
  struct Counters {
    std::uint64_t builds = 0;                 ///< builds of the whole tree
    std::uint64_t restructured_elements = 0;  ///< elements in rebuilt subtrees
    std::uint64_t node_tests = 0;             ///< overlap tests of two tree nodes; not those of single elements
  };

  explicit KdopBvh(const Config& config);

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  std::size_t blocks(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override;
  /// "bounds_seconds": the part of prepare() that computes the bounds of vertices (the paper's Figure 11).
  void append_counters(const StageState& state, std::vector<StageCounter>& out) const override;

  /// The counters of a state that a KdopBvh created.
  static Counters counters(const StageState& state);

 private:
  Config config_;
};

StageDescriptor<BroadPhase> describe_kdop_bvh();

}  // namespace volccd
