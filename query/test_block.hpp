// A block of VF or EE tests with their coordinates gathered into structure of arrays, for vector kernels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/query/step.hpp>

namespace volccd {

/// Up to kCapacity tests. Row (c, p, axis) = coordinate `axis` of control point c of the test's vertex p (0..3, order of
/// test_vertices), for all tests: row(c, p, axis)[i]. Rows are 64-byte aligned and padded to a multiple of 8 with copies
/// of the last test, so that kernels need no tail.
class TestBlock {
 public:
  static constexpr std::size_t kCapacity = 64;

  TestBlock() = default;
  TestBlock(const TestBlock&) = delete;
  TestBlock& operator=(const TestBlock&) = delete;

  /// Takes in at most kCapacity tests of one kind. No allocation after the first call with that number of control points.
  void gather(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs);

  FeatureKind kind() const { return kind_; }
  std::size_t size() const { return size_; }
  std::size_t padded_size() const { return (size_ + 7) / 8 * 8; }
  int control_points() const { return control_points_; }
  const double* row(int control_point, int vertex, int axis) const {
    return rows_ + static_cast<std::size_t>((control_point * 4 + vertex) * 3 + axis) * kCapacity;
  }

 private:
  FeatureKind kind_ = FeatureKind::vf;
  std::size_t size_ = 0;
  int control_points_ = 2;
  double* rows_ = nullptr;       ///< 64-byte aligned, within storage_
  std::vector<double> storage_;
};

}  // namespace volccd
