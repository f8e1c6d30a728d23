// Determines with which of several elements another element has a common vertex. All O-Set algorithms use this
// operation.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/adjacency.hpp>

namespace volccd::detail {

/// Assigns a bit to each of up to 64 elements; of(vertices of o) returns the bits of those elements that have a common
/// vertex with element o. Also marks elements as accepted or rejected. The time is proportional to the examined
/// elements only; the memory is proportional to all vertices and elements.
class ElementTouch {
 public:
  static constexpr std::size_t kBits = 64;
  static std::uint64_t all(std::size_t n) { return n == 0 ? 0 : ~std::uint64_t{0} >> (kBits - n); }

  void fit(std::size_t vertices, std::size_t elements) {
    bits_.resize(vertices, 0);
    marks_.resize(elements, 0);
  }

  /// Assigns bit k to the k-th of these elements.
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

  /// Resets the marks of all elements.
  void next_mark() {
    if (mark_ == kLastMark) {
      std::fill(marks_.begin(), marks_.end(), 0u);
      mark_ = 0;
    }
    mark_ += 2;
    accepted_.clear();
  }
  bool seen(Index o) const { return marks_[o] >= mark_; }
  void accept(Index o) {
    marks_[o] = mark_ + 1;
    accepted_.push_back(o);
  }
  /// An element that was accepted remains in accepted_elements() until the caller removes it.
  void reject(Index o) { marks_[o] = mark_; }
  bool accepted(Index o) const { return marks_[o] == mark_ + 1; }
  std::vector<Index>& accepted_elements() { return accepted_; }

  std::size_t bytes() const { return heap_bytes(bits_, touched_, accepted_, marks_); }

 private:
  static constexpr std::uint32_t kLastMark = std::numeric_limits<std::uint32_t>::max() - 1;

  std::vector<std::uint64_t> bits_;  ///< indexed by vertex
  std::vector<Index> touched_;       ///< vertices whose bits may be non-zero
  std::vector<Index> accepted_;
  std::vector<std::uint32_t> marks_;  ///< indexed by element: mark_ (rejected) or mark_ + 1 (accepted) for elements
                                      ///< seen
  std::uint32_t mark_ = 0;            ///< always even
};

}  // namespace volccd::detail
