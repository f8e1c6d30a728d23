// The first pass over a block of tests: computes coplanarity cubics, and finds the tests that these prove free of
// contact.
#pragma once

#include <cstddef>

#include <volccd/narrowphase/detail/coplanarity.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::detail {

/// What the first pass finds about the tests of a TestBlock with two control points; test i has the same index in both.
/// Stored on the stack, without allocation.
class CoplanarityBlock {
 public:
  static constexpr std::size_t kCapacity = TestBlock::kCapacity;

  /// Pre: the block is not empty. Afterwards all tests are open, except
  ///  - with `coplanarity`, those whose cubic has no root in [0,1]: all Bernstein coefficients have the same sign, and
  ///    their magnitudes exceed their rounding bounds (Tang et al. 2010);
  ///  - with `axis_test`, those that the x, y or z axis separates at both ends (exact: rounding of differences is
  ///    monotone).
  /// Results have the same bits for every vector length.
  void compute(const TestBlock& tests, bool axis_test, bool coplanarity = true);

  bool open(std::size_t i) const { return open_[i] != 0; }
  /// `error` is infinite or NaN if an overflow or underflow is possible for the size of the test.
  CoplanarityCubic cubic(std::size_t i) const { return {{b_[0][i], b_[1][i], b_[2][i], b_[3][i]}, error_[i]}; }

  /// Rows for the kernel; open flags as 1.0 or 0.0.
  struct Rows {
    double* b[4];
    double* error;
    double* open;
  };

 private:
  alignas(64) double b_[4][kCapacity];
  alignas(64) double error_[kCapacity];
  alignas(64) double open_[kCapacity];
};

}  // namespace volccd::detail
