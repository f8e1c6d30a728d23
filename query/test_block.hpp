// A block of VF or EE tests: features, vertices and coordinates as a structure of arrays, for vector kernels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <volccd/query/pairs.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Up to kCapacity tests of one kind. row(c, p, axis)[i] is coordinate `axis` of control point c of vertex p of test i,
/// where p = 0..3 is in the order of test_vertices(). Rows are aligned to 64 bytes. The entries from size() to
/// padded_size() contain coordinates of other tests or zeros, so that kernels need no remainder loop. No allocation.
class TestBlock {
 public:
  static constexpr std::size_t kCapacity = 64;
  static constexpr int kMaxControlPoints = 3;

  TestBlock() = default;
  TestBlock(const TestBlock&) = delete;
  TestBlock& operator=(const TestBlock&) = delete;

  /// Replaces the contents by at most kCapacity tests. Pre: the motion has two or three control points.
  void gather(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs);
  /// Removes the tests i with keep[i] == 0; the other tests keep their order. Pre: keep.size() >= size().
  void compact(std::span<const std::uint8_t> keep);
  /// Appends the tests i of `from` with i >= begin and keep[i] != 0, in their order, until this block is full. An empty
  /// block takes the kind and the number of control points from `from`; otherwise they must agree. Returns the index at
  /// which to continue: from.size() if no test is left.
  std::size_t append_kept(const TestBlock& from, std::span<const std::uint8_t> keep, std::size_t begin = 0);
  void clear() { size_ = 0; }

  FeatureKind kind() const { return kind_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == kCapacity; }
  std::size_t padded_size() const { return (size_ + 7) / 8 * 8; }
  int control_points() const { return control_points_; }

  FeaturePair pair(std::size_t i) const { return pairs_[i]; }
  std::span<const FeaturePair> pairs() const { return {pairs_.data(), size_}; }
  /// Vertex slots in the order of test_vertices().
  const std::array<Index, 4>& vertices(std::size_t i) const { return vertices_[i]; }
  const double* row(int control_point, int vertex, int axis) const {
    return rows_ + static_cast<std::size_t>((control_point * 4 + vertex) * 3 + axis) * kCapacity;
  }

 private:
  /// Appends the kept tests in [begin, end) like append_kept(). `from` may be this block if size_ <= begin.
  std::size_t take(const TestBlock& from, std::span<const std::uint8_t> keep, std::size_t begin, std::size_t end);

  FeatureKind kind_ = FeatureKind::vf;
  int control_points_ = 2;
  std::size_t size_ = 0;
  std::array<FeaturePair, kCapacity> pairs_;
  std::array<std::array<Index, 4>, kCapacity> vertices_;
  alignas(64) double rows_[std::size_t{12} * kMaxControlPoints * kCapacity] = {};
};

}  // namespace volccd
