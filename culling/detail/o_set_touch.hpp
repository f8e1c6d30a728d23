// Which of some elements another element touches: the question that all O-Set work comes down to.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <volccd/mesh/adjacency.hpp>

namespace volccd::detail {

/// Up to 64 elements are given a bit each; of(vertices of o) has those set that element o has a vertex in common with.
/// Also marks elements as accepted or rejected. Costs time for the elements looked at only; memory for all vertices and
/// elements.
class ElementTouch {
 public:
  static constexpr std::size_t kBits = 64;
  static std::uint64_t all(std::size_t n) { return n == 0 ? 0 : ~std::uint64_t{0} >> (kBits - n); }

  void fit(std::size_t vertices, std::size_t elements) {
    bits_.resize(vertices, 0);
    marks_.resize(elements, 0);
  }

  /// Bit k for the k-th of these elements.
  void set_elements(const Adjacency& adjacency, std::span<const Index> elements) {
    for (std::size_t k = 0; k < elements.size(); ++k)
      for (Index v : adjacency.vertices(elements[k])) {
        if (bits_[v] == 0) touched_.push_back(v);
        bits_[v] |= std::uint64_t{1} << k;
      }
  }
  void clear() {
    for (Index v : touched_) bits_[v] = 0;
    touched_.clear();
  }
  std::uint64_t of(std::span<const Index> vertices) const {
    std::uint64_t bits = 0;
    for (Index v : vertices) bits |= bits_[v];
    return bits;
  }

  /// Forgets which elements were accepted or rejected.
  void next_mark() {
    if (mark_ == kLastMark) {
      std::fill(marks_.begin(), marks_.end(), 0u);
      mark_ = 0;
    }
    mark_ += 2;
  }
  bool seen(Index o) const { return marks_[o] >= mark_; }
  void accept(Index o) { marks_[o] = mark_ + 1; }
  void reject(Index o) { marks_[o] = mark_; }
  bool accepted(Index o) const { return marks_[o] == mark_ + 1; }

  std::size_t bytes() const {
    return bits_.capacity() * sizeof(bits_[0]) + marks_.capacity() * sizeof(marks_[0]) +
           touched_.capacity() * sizeof(Index);
  }

 private:
  static constexpr std::uint32_t kLastMark = std::numeric_limits<std::uint32_t>::max() - 1;

  std::vector<std::uint64_t> bits_;   ///< by vertex
  std::vector<Index> touched_;        ///< vertices whose bits may not be 0
  std::vector<std::uint32_t> marks_;  ///< by element: mark_ or mark_ + 1 where it was seen
  std::uint32_t mark_ = 0;            ///< even
};

}  // namespace volccd::detail
