// Planes through a common vertex or edge that separate elements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The other vertices of an element relative to one of its vertices, at all control points, as rows of lanes: the
/// coordinate k of vector i is x[k][i]. The control points of a vertex are in consecutive lanes, in the order of the
/// element's vertices. The vectors are repeated to fill the rows.
struct alignas(64) CornerVectors {
  static constexpr std::size_t kLanes = 16;
  double x[3][kLanes];
  double sum[3];     ///< of the vectors, each once
  std::size_t size;  ///< number of vectors

  static bool fit(const Motion& motion, std::span<const Index> vertices) {
    return (vertices.size() - 1) * static_cast<std::size_t>(motion.control_points()) <= kLanes;
  }
  /// The element has the vertex `corner`, and another one. Pre: its vectors fit; otherwise nothing is set.
  CornerVectors(const Motion& motion, std::span<const Index> vertices, Index corner);

  Vec3 at(std::size_t i) const { return {x[0][i], x[1][i], x[2][i]}; }
};

/// Two corners at one vertex, by their places in a list. If the elements have an edge at this vertex in common: the
/// lanes of each corner where the vectors to its other vertex begin.
struct CornerPair {
  static constexpr std::uint16_t kNoEdge = 0xffff;
  std::uint16_t a, b;
  std::uint16_t edge_a = kNoEdge, edge_b = kNoEdge;
};

/// Sets apart[n] to 1 if the elements of pairs[n] are proven to have only the vertex, or the edge, in common at all t
/// in [0, 1], also if vectors are changed by up to the separation; otherwise to 0. Proven by a direction, for an edge
/// by the normal of the plane through the moving edge and a fixed direction: all vectors of one corner to vertices that
/// are not common have positive dot products with it, and those of the other one have negative ones, far enough from 0.
/// It is found by approaching the point of the convex hull of all these vectors, one set negated, that is nearest to
/// the origin (Gilbert, Johnson, Keerthi 1988). Compiled for each instruction set, with the same results on all of
/// them.
void separate_corners(std::span<const CornerVectors> corners, int control_points, double separation,
                      std::span<const CornerPair> pairs, std::uint8_t* apart);

/// Pairs of elements at one vertex that have at most one other common vertex, and memory for their tests.
class CornerPairs {
 public:
  void begin() { pairs_.clear(); }
  /// Adds a pair with the common vertex v, given by places in the vertex's list of elements, and with the common vertex
  /// `other`, if it is given. Returns false if it cannot be tested.
  bool add(const Step& step, Index v, std::size_t i, std::size_t j, Index other = kNone);

  /// Calls remain(a, b) for the elements of those pairs at v that are not proven to lie on different sides of a plane
  /// through v, and through the other common vertex, also with the separation of the step.
  template <class Remain>
  void decide(const Step& step, Index v, Remain&& remain) {
    if (pairs_.empty()) return;
    decide_apart(step, v);
    const std::span<const Index> star = step.features().vertex_elements(v);
    for (std::size_t n = 0; n < pairs_.size(); ++n)
      if (apart_[n] == 0) remain(star[pairs_[n].a], star[pairs_[n].b]);
  }

  std::size_t bytes() const;

 private:
  void decide_apart(const Step& step, Index v);

  std::vector<CornerVectors> corners_;
  std::vector<CornerPair> pairs_;
  std::vector<std::uint8_t> apart_;
};

}  // namespace volccd::detail
