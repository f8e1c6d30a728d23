// The first pass over a block of tests: computes differences and coplanarity cubics, and finds the tests that these
// prove free of contact. Stored on the stack, without allocation.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <volccd/narrowphase/detail/coplanarity.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::detail {

/// Up to kCapacity tests of one kind with two control points, as a structure of arrays. In contrast to TestBlock, it
/// stores the differences to the first point, which are sufficient for the elementary tests.
class CoplanarityBlock {
 public:
  static constexpr std::size_t kCapacity = TestBlock::kCapacity;

  /// Reads the tests of a non-empty block.
  void gather(const Motion& motion, const TestBlock& tests);

  /// Computes the cubics. Afterwards all tests are open, except
  ///  - with `coplanarity`, those whose cubic has no root in [0,1]: all Bernstein coefficients have the same sign, and
  ///    their magnitudes exceed their rounding bounds (Tang et al. 2010);
  ///  - with `axis_test`, those that the x, y or z axis separates at both ends (exact: rounding of differences is
  ///    monotone).
  /// Results have the same bits for every vector length.
  void compute(bool axis_test, bool coplanarity = true);

  std::size_t size() const { return size_; }
  bool open(std::size_t i) const { return open_[i] != 0; }
  const TestPoints& coordinates(std::size_t i) const { return coordinates_[i]; }
  const std::array<Index, 4>& vertices(std::size_t i) const { return vertices_[i]; }
  MovingPoints points(std::size_t i) const;
  FeatureKind kind() const { return kind_; }
  /// Coordinate `axis` of the difference of point j + 1 and point 0, at t = `time` (0 or 1).
  double difference(std::size_t i, std::size_t time, std::size_t j, std::size_t axis) const {
    return differences_[row(time, j, axis) + i];
  }
  /// `error` is infinite or NaN if an overflow or underflow is possible for the size of the test.
  CoplanarityCubic cubic(std::size_t i) const { return {{b_[0][i], b_[1][i], b_[2][i], b_[3][i]}, error_[i]}; }

  /// Rows for the kernel: differences as row(time, point - 1, axis), open flags as 1.0 or 0.0.
  struct Rows {
    const double* differences;
    double* b[4];
    double* error;
    double* open;
    std::size_t padded_size;
    FeatureKind kind;
    bool axis_test, coplanarity;
  };

 private:
  static constexpr std::size_t row(std::size_t time, std::size_t i, std::size_t axis) {
    return ((time * 3 + i) * 3 + axis) * kCapacity;
  }

  alignas(64) double differences_[18 * kCapacity];
  alignas(64) double b_[4][kCapacity];
  alignas(64) double error_[kCapacity];
  alignas(64) double open_[kCapacity];
  std::array<TestPoints, kCapacity> coordinates_;
  std::array<std::array<Index, 4>, kCapacity> vertices_;
  std::size_t size_ = 0;
  FeatureKind kind_ = FeatureKind::vf;
};

}  // namespace volccd::detail
