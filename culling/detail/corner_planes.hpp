// Planes through a common vertex that separate elements.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The other vertices of an element relative to one of its vertices, at all control points, as rows of lanes: the
/// coordinate k of vector i is x[k][i]. Vectors are repeated to fill the rows.
struct alignas(64) CornerVectors {
  static constexpr std::size_t kLanes = 16;
  double x[3][kLanes];

  static bool fit(const Motion& motion, std::span<const Index> vertices) {
    return (vertices.size() - 1) * static_cast<std::size_t>(motion.control_points()) <= kLanes;
  }
  /// The element has the vertex `corner`, and another one. Pre: its vectors fit; otherwise x is not set.
  CornerVectors(const Motion& motion, std::span<const Index> vertices, Index corner);
};

/// Sets apart[n] to 1 for each pair (i, j) = pairs[n] of corners at the same vertex if they are proven to have only
/// that vertex in common at all t in [0, 1], also if vectors are changed by up to the separation: all vectors of one
/// have dot products with a fixed direction of unit length that are greater than the separation, and those of the other
/// have such products with the opposite direction. Otherwise to 0. The direction is found by approaching the point of
/// the convex hull of all these vectors, one set negated, that is nearest to the origin (Frank and Wolfe 1956).
/// Compiled for each instruction set.
void separate_corners(std::span<const CornerVectors> corners, double separation,
                      std::span<const std::array<std::uint16_t, 2>> pairs, std::uint8_t* apart);

/// Pairs of elements at one vertex that have no other common vertex, and memory for their tests.
class CornerPairs {
 public:
  void begin() { pairs_.clear(); }
  /// Adds a pair, given by places in the vertex's list of elements. Returns false if it cannot be tested.
  bool add(const Step& step, std::span<const Index> star, std::size_t i, std::size_t j) {
    const auto fits = [&](std::size_t k) { return CornerVectors::fit(step.motion, step.mesh().vertices(star[k])); };
    if (i > 0xffff || j > 0xffff || !fits(i) || !fits(j)) return false;
    pairs_.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j)});
    return true;
  }
  /// Calls remain(a, b) for the elements of those pairs that are not proven to lie on different sides of a plane
  /// through v, also with the separation of the step. `star`: the elements at v, as for add().
  template <class Remain>
  void decide(const Step& step, std::span<const Index> star, Index v, Remain&& remain) {
    if (pairs_.empty()) return;
    corners_.clear();
    for (const Index o : star) corners_.emplace_back(step.motion, step.mesh().vertices(o), v);
    apart_.resize(pairs_.size());
    separate_corners(corners_, step.separation, pairs_, apart_.data());
    for (std::size_t n = 0; n < pairs_.size(); ++n)
      if (apart_[n] == 0) remain(star[pairs_[n][0]], star[pairs_[n][1]]);
  }

  std::size_t bytes() const {
    return corners_.capacity() * sizeof(corners_[0]) + pairs_.capacity() * sizeof(pairs_[0]) + apart_.capacity();
  }

 private:
  std::vector<CornerVectors> corners_;
  std::vector<std::array<std::uint16_t, 2>> pairs_;
  std::vector<std::uint8_t> apart_;
};

}  // namespace volccd::detail
