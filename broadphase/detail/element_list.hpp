// A list of elements in arbitrary order, with their vertices, laid out for sequential reading at every step.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// Positions 0 .. size()-1 contain element slots, or kNone for the gap that a removed element left.
class ElementList {
 public:
  /// Where a chunk of elements begins in the list and in its vertices; while it is counted, its size there.
  struct Start {
    std::size_t elements, vertices;
  };
  /// Memory of permute(), which its caller keeps from call to call.
  struct Scratch {
    std::vector<Index> slots, vertices;
    std::vector<std::size_t> begins;
    std::vector<Start> starts;

    std::size_t bytes() const { return heap_bytes(slots, vertices, begins, starts); }
  };

  void clear() { truncate(0); }
  void truncate(std::size_t size);
  void append(const Mesh& mesh, Index slot);
  /// Sets the list to all live elements, in ascending order of slots.
  void assign(const Mesh& mesh, Executor& executor);
  /// Removes the slots `touched` (ascending) and appends those that have a live element.
  void update(const Mesh& mesh, std::span<const Index> touched);

  std::size_t size() const { return slots_.size(); }
  Index slot(std::size_t position) const { return slots_[position]; }
  const Index* slots() const { return slots_.data(); }
  /// Vertices of the element at this position; for a gap, those of the removed element.
  std::span<const Index> vertices(std::size_t position) const {
    return {vertices_.data() + begins_[position], begins_[position + 1] - begins_[position]};
  }

  void make_gap(std::size_t position) { slots_[position] = kNone; }

  /// Reorders the positions [begin, begin + order.size()): position begin + i gets the former contents of position
  /// order[i]. Disjoint ranges may be reordered at the same time, each with its own scratch memory.
  void permute(std::size_t begin, std::span<const Index> order, Scratch& scratch, Executor& executor);

  std::size_t bytes() const { return heap_bytes(slots_, begins_, vertices_, scratch_); }

 private:
  std::vector<Index> slots_;
  std::vector<std::size_t> begins_{0};
  std::vector<Index> vertices_;
  Scratch scratch_;
};

}  // namespace volccd::detail
