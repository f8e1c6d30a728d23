// Elementary tests from bare coordinates, as a step for any filter and narrow phase.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include <volccd/query/contact.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// `count` tetrahedra without common vertices: element i has the vertices 4 i .. 4 i + 3.
Mesh separate_tetrahedra(Index count);

/// Queries of one kind without common vertices. The four points of query i (VF: vertex, triangle; EE: edge 1, edge 2)
/// become the vertices 4 i .. 4 i + 3 in this order, which is also that of test_vertices(), and belong to one
/// tetrahedron of any volume. Immutable; objects to which step() refers live as long as the set, also if it is moved.
class QuerySet {
 public:
  /// `points`: for each query, the four points at the first control point, then at the next; [queries][control
  /// points][4]. Two or three control points. Throws InputError (source "queries", dataset "points", index of the
  /// query) for a coordinate that is not finite, and for a number of points that does not fit. O(queries).
  QuerySet(FeatureKind kind, int control_points, std::span<const Vec3> points);

  /// Each query as an array: 8 points for two control points, 12 for three.
  template <std::size_t N>
  requires(N == 8 || N == 12) QuerySet(FeatureKind kind, const std::vector<std::array<Vec3, N>>& queries)
      : QuerySet(kind, static_cast<int>(N / 4),
                 {queries.empty() ? nullptr : queries.front().data(), N * queries.size()}) {}

  FeatureKind kind() const { return kind_; }
  std::size_t size() const { return pairs_.size(); }
  /// Query i is pairs()[i].
  std::span<const FeaturePair> pairs() const { return pairs_; }
  Step step(double t_max = 1, double separation = 0) const;

  /// Number of the query that a contact belongs to.
  static std::size_t query_of(const Contact& contact) { return contact.vertices[0] / 4; }

 private:
  struct Scene {
    Topology topology;
    Motion motion;
    ObjectFilter filter;
  };

  FeatureKind kind_;
  std::unique_ptr<const Scene> scene_;
  std::vector<FeaturePair> pairs_;
};

}  // namespace volccd
