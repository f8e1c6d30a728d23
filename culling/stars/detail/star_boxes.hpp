// Which pairs of elements at a vertex can have a feature pair that belongs to the region of a step.
#pragma once

#include <cstddef>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Two features of elements A and B at a vertex v that have no common vertex: one of them, say that of A, does not
/// contain v. So its box is in that of the other vertices of A, and the reference point of the two, if they come within
/// the separation of each other, is in the common part of this box and that of B. (Enlarged boxes are monotone.)
class StarBoxes {
 public:
  /// Takes the boxes of the elements at v; none if the region is all of space.
  void set(const Step& step, Index v) {
    boxes_.clear();
    region_ = step.piece.region;
    if (region_.is_all()) return;
    const int points = step.motion.control_points();
    for (const Index o : step.features().vertex_elements(v)) {
      MotionBox others, all;
      for (const Index w : step.mesh().vertices(o))
        if (w != v) extend(others, step.motion, {&w, 1}, points);
      extend(all = others, step.motion, {&v, 1}, points);
      boxes_.push_back({enlarged(all, step.separation), enlarged(others, step.separation)});
    }
  }

  /// False only if no two features without a common vertex, one of each element, have their reference point in the
  /// region. Elements are given by their places among those at v, and may be the same.
  bool may_belong(std::size_t i, std::size_t j) const {
    return boxes_.empty() || common(boxes_[i].others, boxes_[j].all) || common(boxes_[i].all, boxes_[j].others);
  }

  std::size_t bytes() const { return heap_bytes(boxes_); }

 private:
  struct Boxes {
    MotionBox all, others;  ///< of the element's vertices, and of those but v
  };

  bool common(const MotionBox& a, const MotionBox& b) const {
    const MotionBox box{a.low.cwiseMax(b.low), a.high.cwiseMin(b.high)};
    return (box.low.array() <= box.high.array()).all() && region_.meets(box);
  }

  Region region_;
  std::vector<Boxes> boxes_;
};

}  // namespace volccd::detail
