// Second pass of the `inclusion` narrow phase: tests whose four points change sides at most twice, by far the most that
// the first pass leaves. A vector kernel decides those that are clear when they do.
#pragma once

#include <array>
#include <cstdint>

#include <volccd/narrowphase/detail/coplanarity_block.hpp>

namespace volccd::detail {

/// The open tests of a CoplanarityBlock. On the stack: no allocation.
class CrossingBlock {
 public:
  static constexpr std::size_t kCapacity = CoplanarityBlock::kCapacity;

  void gather(const CoplanarityBlock& block);

  /// Decides what it can; the rest is open still. Bernstein coefficients prove the coplanarity cubic free of roots but
  /// for short pieces around one or two of them, in which the features are looked at as MotionPiece does
  /// (overlap_along, separated_along). `tolerance` as for inclusion_search(). The same bits for every vector length.
  void decide(double tolerance);

  std::size_t size() const { return size_; }
  /// Which test of the CoplanarityBlock test i is.
  std::size_t source(std::size_t i) const { return source_[i]; }
  bool apart(std::size_t i) const { return apart_[i] != 0; }
  bool touches(std::size_t i) const { return touch_[i] != 0; }
  /// Of tests that touch: as in InclusionAnswer.
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
