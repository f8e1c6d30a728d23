// Planes through a common vertex or edge that separate elements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/stars/detail/star_boxes.hpp>
#include <volccd/query/pairs.hpp>
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

/// Pairs of elements at one vertex that have at most one other common vertex, and memory for their tests.
class CornerPairs {
 public:
  void begin() { pairs_.clear(); }
  /// Adds a pair with the common vertex v, given by places in the vertex's list of elements, and with the common vertex
  /// `other`, if it is given. Returns false if it cannot be tested.
  bool add(const Step& step, Index v, std::size_t i, std::size_t j, Index other = kNone);

  /// Appends to `found` the elements of those pairs at v that are not proven to have only v, or the edge of both common
  /// vertices, in common at all t in [0, 1], also if vectors are changed by up to the separation of the step. Proven by
  /// a direction, for an edge by the normal of the plane through the moving edge and a fixed direction: all vectors of
  /// one corner to vertices that are not common have positive dot products with it, and those of the other one have
  /// negative ones, far enough from 0. It is found by approaching the point of the convex hull of all these vectors,
  /// one set negated, that is nearest to the origin (Gilbert, Johnson, Keerthi 1988). Compiled for each instruction
  /// set, with the same results on all of them.
  void decide(const Step& step, Index v, std::vector<ElementPair>& found);

  std::size_t bytes() const { return heap_bytes(corners_, pairs_, apart_); }

 private:
  std::vector<CornerVectors> corners_;
  std::vector<CornerPair> pairs_;
  std::vector<std::uint8_t> apart_;
};

/// How a pair of elements with a common vertex is listed.
struct ListedPair {
  bool listed = false;
  /// Listed only if CornerPairs does not prove it to be apart; `other`: its other common vertex.
  bool tested = false;
  Index other = kNone;
};

/// Lists pairs of elements at vertices, on all threads.
class CornerPairList {
 public:
  /// Lists pairs (a, b), a <= b, of elements at each of the vertices, as how(a, b, v) says, a ListedPair. Pairs that
  /// have no feature pair in the region of the step (StarBoxes) are left out.
  template <class How>
  void update(const Step& step, std::span<const Index> vertices, Executor& executor, How&& how) {
    constexpr std::size_t kGrain = 16;
    workers_.resize(executor.workers());
    for (Worker& worker : workers_) worker.found.clear();
    executor.parallel_for(vertices.size(), kGrain, [&](std::size_t begin, std::size_t end, unsigned w) {
      for (std::size_t i = begin; i < end; ++i) list_at(step, vertices[i], workers_[w], how);
    });
    pairs_.clear();
    for (const Worker& worker : workers_) pairs_.insert(pairs_.end(), worker.found.begin(), worker.found.end());
  }

  /// Their order depends on the executor.
  std::span<const ElementPair> pairs() const { return pairs_; }

  std::size_t bytes() const { return heap_bytes(pairs_, workers_); }

 private:
  /// Scratch memory of one worker, and what it has found.
  struct alignas(64) Worker {
    std::vector<ElementPair> found;
    StarBoxes boxes;
    CornerPairs corners;
    std::size_t bytes() const { return heap_bytes(found, boxes, corners); }
  };

  template <class How>
  static void list_at(const Step& step, Index v, Worker& worker, How&& how) {
    const std::span<const Index> star = step.features().vertex_elements(v);
    worker.boxes.set(step, v);
    worker.corners.begin();
    for (std::size_t i = 0; i < star.size(); ++i)
      for (std::size_t j = i; j < star.size(); ++j) {
        if (!worker.boxes.may_belong(i, j)) continue;
        const ListedPair pair = how(star[i], star[j], v);
        if (pair.listed && !(pair.tested && worker.corners.add(step, v, i, j, pair.other)))
          worker.found.push_back({star[i], star[j]});
      }
    worker.corners.decide(step, v, worker.found);
  }

  std::vector<ElementPair> pairs_;
  std::vector<Worker> workers_;
};

}  // namespace volccd::detail
