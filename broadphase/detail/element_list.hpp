// Elements in an order of one's own, with their vertices: what is gathered from every step, laid out as it is read.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Positions 0 .. size()-1 hold element slots, or kNone: a gap, left by an element that was removed.
class ElementList {
 public:
  void clear() { truncate(0); }
  void truncate(std::size_t size);
  void append(const Mesh& mesh, Index slot);
  /// All elements that take part in the step, by slot.
  void assign(const Step& step);
  /// Takes out the touched slots and appends those that take part. `touched` ascends.
  void update(const Step& step, std::span<const Index> touched);

  std::size_t size() const { return slots_.size(); }
  Index slot(std::size_t position) const { return slots_[position]; }
  const Index* slots() const { return slots_.data(); }
  /// Vertices of the element; of a gap, those that it had.
  std::span<const Index> vertices(std::size_t position) const {
    return {vertices_.data() + begins_[position], begins_[position + 1] - begins_[position]};
  }

  void make_gap(std::size_t position) { slots_[position] = kNone; }

  /// Reorders positions [begin, begin + order.size()): the i-th of them takes what was at position order[i].
  void permute(std::size_t begin, std::span<const Index> order);

  std::size_t bytes() const;

 private:
  std::vector<Index> slots_;
  std::vector<std::size_t> begins_{0};
  std::vector<Index> vertices_;
  std::vector<Index> slots_scratch_, vertices_scratch_;
  std::vector<std::size_t> begins_scratch_;
};

}  // namespace volccd::detail
