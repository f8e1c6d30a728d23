// Classifies the stars of vertices, as sets of elements of any type, into those that remain embedded throughout a step
// and those that may fold.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/detail/cone_signs.hpp>
#include <volccd/culling/detail/element_star_table.hpp>
#include <volccd/culling/detail/suspect_stars.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// A star is clear if no two features of its elements that have no common vertex can touch, or come within the
/// separation, at any time of the step. The conditions, and the proof that they are sufficient, are in
/// docs/star_orphans.md. All predicates are certified: a rounding error can only make a star suspect.
class ElementStars : public SuspectStars {
 public:
  void update(const Step& step, Executor& executor);

  std::size_t bytes() const { return stars_bytes() + heap_bytes(table_, signs_, gap_signs_, all_positive_); }

 private:
  void find_signs(const Step& step, std::vector<ConeSigns>& signs, Executor& executor) const;
  void find_all_positive(const Step& step, Executor& executor);
  bool is_clear(const Step& step, Index v, Ring& scratch);

  ElementStarTable table_;
  std::vector<ConeSigns> signs_, gap_signs_;  ///< by element slot
  std::vector<std::uint8_t> all_positive_;    ///< by vertex: whether common_sign() is 1
};

}  // namespace volccd::detail
