// Elements that overlap at t = 0 (docs/initial_overlaps.md).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/query/step.hpp>

namespace volccd {

/// Decides whether two elements, as the convex hulls of their vertices at t = 0, have a point in common (one inside the
/// other included), or with a separation d > 0 come as close as d. Inverted, flat and point-like elements are legal.
///
/// Guarantee: exact, on the given doubles. The verdict is a function of the pair alone: whatever conservative stages
/// have dropped before, the same pairs are found.
///
/// A convex search in doubles decides all but pairs that touch or miss by rounding; those are decided in integers.
/// O(vertices) a turn; 0.1 to 1.5 microseconds for a clear pair, 4 to 7 for a close call. In steady state only close
/// calls allocate. One object serves one thread at a time.
class InitialOverlapTest {
 public:
  InitialOverlapTest();
  ~InitialOverlapTest();
  InitialOverlapTest(InitialOverlapTest&&) noexcept;
  InitialOverlapTest& operator=(InitialOverlapTest&&) noexcept;

  /// Appends those of `pairs` that overlap to `out`, in their order. Does not look at adjacency or step.filter. The
  /// first element is gathered once for a run of pairs that have it (1.0 to 1.6 pairs on average as broad phases emit
  /// them).
  void find(const Step& step, std::span<const ElementPair> pairs, std::vector<ElementPair>& out);

  /// The same for two sets of points that need not be elements; an empty set overlaps nothing. Pre: finite coordinates,
  /// separation >= 0.
  bool overlap(std::span<const Vec3> a, std::span<const Vec3> b, double separation = 0);

  /// Pairs decided in integers so far.
  std::uint64_t close_calls() const;
  std::size_t bytes() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace volccd
