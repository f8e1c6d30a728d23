// The broad phase `spatial-hash`: Teschner et al. 2003, "Optimized Spatial Hashing for Collision Detection of
// Deformable Objects", made continuous: the paper's HashCCD.
#pragma once

#include <volccd/broadphase/broad_phase.hpp>

namespace volccd {

/// A uniform grid, hashed by the three large primes of that article into a table of about as many buckets as elements.
/// Each element enters the cells that its swept box overlaps; elements that meet in a cell are tested by their k-DOPs.
/// Emits exactly the pairs that `kdop-bvh` with the same k emits.
///
/// - Each pair once, without marks: in the cell that holds the lower corner of the boxes' intersection. Cells that the
///   hash throws into one bucket are told apart by their coordinates.
/// - Cells: `cell_size` times the median extent (longest side) of the swept boxes, or a fifth of the 99.5th percentile
///   if that is more; at rest and for elements of one size about the average edge length. A few outliers do not ruin
///   the grid.
/// - No element enters more than kMostCells cells: larger ones, at most one in 200, are compared with all others. Cell
///   coordinates are clamped, so that elements very far out share cells; that costs time and loses nothing.
///
/// prepare: O(n + cells entered). Memory 8 bytes for each cell entered, about 100 to 200 bytes an element at the
/// default size, and the bounds. The table is made anew at every step (the article's time stamps serve the same end).
class SpatialHash final : public BroadPhase {
 public:
  struct Config {
    int k = 16;              ///< of the final test; 6 for boxes only. ConfigError for others than query/kdop.hpp has
    double cell_size = 1.0;  ///< in median extents of swept boxes, 0.05 .. 100
  };
  static const Options<Config>& options();

  static constexpr int kMostCells = 256;

  explicit SpatialHash(const Config& config);

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  void run(const Step& step, StageState& state, PairRange range, Executor& executor, PairSink sink) const override;
  double bounds_seconds(const StageState& state) const override;

 private:
  Config config_;
};

StageDescriptor<BroadPhase> describe_spatial_hash();

}  // namespace volccd
