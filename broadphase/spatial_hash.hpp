// The broad phase `spatial-hash`: Teschner et al. 2003, "Optimized Spatial Hashing for Collision Detection of
// Deformable Objects", extended to continuous collision detection; the paper's HashCCD.
#pragma once

#include <volccd/query/roles/broad_phase.hpp>

namespace volccd {

/// A uniform grid, hashed with the three large primes of that article into a table with about as many buckets as there
/// are elements. Each element is entered in all cells that its swept box overlaps; elements that share a cell are
/// tested by their k-DOPs. Emits exactly the same pairs as `kdop-bvh` with the same k.
///
/// - Each pair is emitted once, without marking pairs: in the cell that contains the lower corner of the intersection
///   of the boxes. Cells that are hashed into the same bucket are distinguished by their coordinates.
/// - Cell size: `cell_size` times the median extent (longest side) of the swept boxes, or a fifth of the 99.5th
///   percentile of the extents if that is larger. For elements of similar size at rest this is about the average edge
///   length. A few very large elements do not affect the grid.
/// - No element is entered in more than kMaxCells cells. Larger elements, at most one in 200, are compared with all
///   others. Cell coordinates are clamped, so that elements very far from the origin share cells; this costs time but
///   loses no pair.
///
/// prepare(): O(n + number of entered cells). Memory: 8 bytes for each entered cell, about 100 to 200 bytes per element
/// at the default size, and the bounds. The table is rebuilt at every step (the article uses time stamps for this
/// purpose).
class SpatialHash final : public BroadPhase {
 public:
  struct Config {
    int k = 16;  ///< k of the final test; 6 for boxes only. ConfigError for values that numerics/kdop.hpp does
                 ///< not list
    double cell_size = 1.0;  ///< in units of the median extent of the swept boxes, 0.05 .. 100
  };
  static const Options<Config>& options();

  static constexpr int kMaxCells = 256;

  explicit SpatialHash(const Config& config);

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  std::size_t blocks(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override;
  /// "bounds_seconds": the part of prepare() that computes the bounds of vertices (the paper's Figure 11).
  void append_counters(const StageState& state, std::vector<StageCounter>& out) const override;

 private:
  Config config_;
};

StageDescriptor<BroadPhase> describe_spatial_hash();

}  // namespace volccd
