// The second pass of the `inclusion` narrow phase, for tests whose coplanarity polynomial changes its sign at most
// twice. These are by far most of the tests that the first pass leaves open. A vector kernel decides the clear cases
// among them.
#pragma once

#include <array>
#include <cstdint>

#include <volccd/narrowphase/detail/coplanarity_block.hpp>

namespace volccd::detail {

/// The tests of a block that the first pass left open. Stored on the stack, without allocation.
class CrossingBlock {
 public:
  static constexpr std::size_t kCapacity = CoplanarityBlock::kCapacity;

  void gather(const TestBlock& tests, const CoplanarityBlock& cubics);

  /// Decides as many tests as possible; the others remain open. Bernstein coefficients prove that the coplanarity cubic
  /// has no root outside of short intervals around one or two roots, in which the features are examined as by
  /// MotionPiece (overlap_along, separated_along). `tolerance` as for inclusion_search(). Results have the same bits
  /// for every vector length.
  void decide(double tolerance);

  std::size_t size() const { return size_; }
  /// Index of test i in the TestBlock.
  std::size_t source(std::size_t i) const { return source_[i]; }
  bool apart(std::size_t i) const { return apart_[i] != 0; }
  bool touches(std::size_t i) const { return touch_[i] != 0; }
  /// For tests that touch, as in InclusionAnswer.
  double toi(std::size_t i) const { return toi_[i]; }
  int side(std::size_t i) const { return (b_[0][i] < 0) != (second_[i] != 0) ? -1 : 1; }

  /// Rows for the kernel; flags as 1.0 or 0.0.
  struct Rows {
    const double *differences, *b[4], *error;
    double *apart, *touch, *toi, *second;
    std::size_t padded_size;
    bool edges;
  };

 private:
  alignas(64) double differences_[18 * kCapacity];
  alignas(64) double b_[4][kCapacity];
  alignas(64) double error_[kCapacity];
  alignas(64) double apart_[kCapacity], touch_[kCapacity], toi_[kCapacity], second_[kCapacity];
  std::array<std::uint8_t, kCapacity> source_;
  std::size_t size_ = 0;
  bool edges_ = false;
};

}  // namespace volccd::detail
