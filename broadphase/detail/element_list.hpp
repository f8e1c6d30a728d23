// A list of elements in arbitrary order, with their vertices, laid out for sequential reading at every step.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/step.hpp>

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
    std::vector<Index> slots, part_sizes, vertices;
    std::vector<std::size_t> begins;
    std::vector<Start> starts;

    std::size_t bytes() const { return heap_bytes(slots, part_sizes, vertices, begins, starts); }
  };

  void clear() { truncate(0); }
  void truncate(std::size_t size);
  void append(const Step& step, Index slot);
  /// Sets the list to all elements that take part in the step, in ascending order of slots.
  void assign(const Step& step, Executor& executor);
  /// Removes the slots `touched` (ascending) and appends those whose element takes part in the step.
  void update(const Step& step, std::span<const Index> touched);

  std::size_t size() const { return slots_.size(); }
  Index slot(std::size_t position) const { return slots_[position]; }
  const Index* slots() const { return slots_.data(); }
  /// Vertices of the element at this position, those of its part (Step::part) first; for a gap, those of the removed
  /// element.
  std::span<const Index> vertices(std::size_t position) const {
    return {vertices_.data() + begins_[position], begins_[position + 1] - begins_[position]};
  }
  /// Vertices of the part alone.
  std::span<const Index> part(std::size_t position) const {
    return {vertices_.data() + begins_[position], part_sizes_[position]};
  }

  /// Replaces the part of the element at this position if it has the same vertices as the element of the same slot in
  /// the step. Otherwise, or if that element does not take part, returns false without a change.
  bool replace_part(const Step& step, std::size_t position);

  void make_gap(std::size_t position) { slots_[position] = kNone; }

  /// Reorders the positions [begin, begin + order.size()): position begin + i gets the former contents of position
  /// order[i]. Disjoint ranges may be reordered at the same time, each with its own scratch memory.
  void permute(std::size_t begin, std::span<const Index> order, Scratch& scratch, Executor& executor);

  std::size_t bytes() const { return heap_bytes(slots_, begins_, part_sizes_, vertices_, scratch_); }

 private:
  /// Writes the vertices of an element to `out`, those of its part first. Returns the number of these.
  static Index put(const Step& step, Index slot, Index* out);

  std::vector<Index> slots_;
  std::vector<std::size_t> begins_{0};
  std::vector<Index> part_sizes_;
  std::vector<Index> vertices_;
  Scratch scratch_;
};

}  // namespace volccd::detail
