// Which of some elements another element touches: the question that all O-Set work comes down to.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <volccd/culling/detail/o_set_vertices.hpp>

namespace volccd::detail {

/// Up to 64 elements are given a bit each; of(vertices of o) has those set that element o has a vertex in common with.
/// Also notes about elements, and visits of features. Costs time for the elements looked at only; memory for all
/// vertices and elements.
class ElementTouch {
 public:
  static constexpr std::size_t kBits = 64;
  static std::uint64_t all(std::size_t n) { return n == 0 ? 0 : ~std::uint64_t{0} >> (kBits - n); }

  /// `features`: the largest number of slots of any kind of feature.
  void fit(std::size_t vertices, std::size_t elements, std::size_t features) {
    bits_.resize(vertices, 0);
    marks_.resize(elements, 0);
    visits_.resize(features, 0);
  }

  void set(std::span<const Index> vertices, std::uint64_t bit) {
    for (Index v : vertices) {
      if (bits_[v] == 0) touched_.push_back(v);
      bits_[v] |= bit;
    }
  }
  void unset(std::span<const Index> vertices, std::uint64_t bit) {
    for (Index v : vertices) bits_[v] &= ~bit;
  }
  /// Bit k for the k-th of these elements.
  void set_elements(const ElementVertices& vertices, std::span<const Index> elements) {
    for (std::size_t k = 0; k < elements.size(); ++k) set(vertices[elements[k]], std::uint64_t{1} << k);
  }
  void clear() {
    for (Index v : touched_) bits_[v] = 0;
    touched_.clear();
  }
  std::uint64_t vertex(Index v) const { return bits_[v]; }
  std::uint64_t of(std::span<const Index> vertices) const {
    std::uint64_t bits = 0;
    for (Index v : vertices) bits |= bits_[v];
    return bits;
  }

  /// Forgets all notes about elements.
  void next_mark() {
    if (mark_ >= kLastMark) {
      std::fill(marks_.begin(), marks_.end(), 0u);
      mark_ = 0;
    }
    mark_ += kMarkStep;
  }
  void note(Index o, std::uint16_t value) { marks_[o] = mark_ | value; }
  bool seen(Index o) const { return marks_[o] >= mark_; }
  /// Of an element that was seen.
  std::uint16_t noted(Index o) const { return static_cast<std::uint16_t>(marks_[o]); }
  void accept(Index o) { note(o, 1); }
  void reject(Index o) { note(o, 0); }
  bool accepted(Index o) const { return marks_[o] == (mark_ | 1u); }

  /// Forgets all visits to features.
  void next_visit() {
    if (visit_ == std::numeric_limits<std::uint32_t>::max()) {
      std::fill(visits_.begin(), visits_.end(), 0u);
      visit_ = 0;
    }
    ++visit_;
  }
  /// Of features of one kind.
  bool first_visit(Index feature) { return std::exchange(visits_[feature], visit_) != visit_; }
  void prefetch_visit(Index feature) const { __builtin_prefetch(visits_.data() + feature); }
  void prefetch(Index o) const { __builtin_prefetch(marks_.data() + o); }

  std::size_t bytes() const {
    return bits_.capacity() * sizeof(bits_[0]) + (marks_.capacity() + visits_.capacity()) * sizeof(marks_[0]) +
           touched_.capacity() * sizeof(Index);
  }

 private:
  static constexpr std::uint32_t kMarkStep = 1u << 16;
  static constexpr std::uint32_t kLastMark = ~std::uint32_t{0} - (kMarkStep - 1);

  std::vector<std::uint64_t> bits_;  ///< by vertex
  std::vector<Index> touched_;       ///< vertices whose bits may not be 0
  /// By element: the mark, and in the lower half what was noted. By feature: the visit.
  std::vector<std::uint32_t> marks_, visits_;
  std::uint32_t mark_ = 0, visit_ = 0;
};

}  // namespace volccd::detail
