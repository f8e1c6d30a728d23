#include <volccd/experiments/scenes/stacking.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

#include <volccd/core/sort_unique.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd {

namespace {

/// A uniform grid over the plane normal to an axis. Primitives of N vertices are entered by their boxes, and sorted
/// into one list by counting.
template <std::size_t N>
class ColumnGrid {
 public:
  using Primitive = std::array<Index, N>;

  ColumnGrid(std::span<const Vec3> x, const std::vector<Primitive>& primitives, int axis, double cell)
      : primitives_(primitives), u_((axis + 1) % 3), w_((axis + 2) % 3) {
    Vec3 low = x[0], high = x[0];
    for (const Vec3& p : x) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    origin_ = low;
    // The number of cells is not much larger than that of primitives, even if the body is thin.
    const double max = 2 + 2 * std::sqrt(static_cast<double>(primitives.size()));
    cell_ = std::max({cell, (high[u_] - low[u_]) / max, (high[w_] - low[w_]) / max});
    nu_ = 1 + std::floor((high[u_] - low[u_]) / cell_);
    nw_ = 1 + std::floor((high[w_] - low[w_]) / cell_);
    begin_.assign(static_cast<std::size_t>(nu_ * nw_) + 1, 0);
    const auto enter = [&](auto&& column) {
      for (std::size_t i = 0; i < primitives.size(); ++i) {
        Vec3 from = x[primitives[i][0]], to = from;
        for (const Index v : primitives[i]) {
          from = from.cwiseMin(x[v]);
          to = to.cwiseMax(x[v]);
        }
        columns(from, to, [&](std::size_t c) { column(c, i); });
      }
    };
    enter([&](std::size_t c, std::size_t) { ++begin_[c + 1]; });
    for (std::size_t c = 0; c + 1 < begin_.size(); ++c) begin_[c + 1] += begin_[c];
    list_.resize(begin_.back());
    std::vector<std::size_t> next = begin_;
    enter([&](std::size_t c, std::size_t i) { list_[next[c]++] = i; });
  }

  /// Calls visitor(primitive) for all primitives whose boxes overlap the box [low, high] in the plane, and for some
  /// nearby; a primitive may be visited several times.
  template <class Visitor>
  void near(const Vec3& low, const Vec3& high, Visitor&& visitor) const {
    columns(low, high, [&](std::size_t c) {
      for (std::size_t i = begin_[c]; i < begin_[c + 1]; ++i) visitor(primitives_[list_[i]]);
    });
  }

 private:
  template <class Visitor>
  void columns(const Vec3& low, const Vec3& high, Visitor&& visitor) const {
    const auto at = [&](const Vec3& p, int c) { return std::floor((p[c] - origin_[c]) / cell_); };
    const double u1 = std::min(nu_ - 1, at(high, u_)), w1 = std::min(nw_ - 1, at(high, w_));
    for (double u = std::max(0.0, at(low, u_)); u <= u1; ++u)
      for (double w = std::max(0.0, at(low, w_)); w <= w1; ++w) visitor(static_cast<std::size_t>(u * nw_ + w));
  }

  const std::vector<Primitive>& primitives_;
  int u_, w_;
  Vec3 origin_;
  double cell_, nu_, nw_;  ///< cells along u and w, as whole numbers
  std::vector<std::size_t> begin_, list_;
};

/// Height differences between features of two bodies that overlap in projection.
class Facing {
 public:
  explicit Facing(int axis) : h_(axis), u_((axis + 1) % 3), w_((axis + 2) % 3) {}

  /// Height of triangle abc above or below p, if it covers p in projection.
  std::optional<double> height(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) const {
    const Vec3 e1 = b - a, e2 = c - a, d = p - a;
    const double area = cross(e1, e2);
    if (area == 0) return {};
    const double s = cross(d, e2) / area, t = cross(e1, d) / area;
    if (!(s >= 0 && t >= 0 && s + t <= 1)) return {};
    return a[h_] + s * e1[h_] + t * e2[h_];
  }

  /// Height of edge ab minus that of edge cd at the point where they cross in projection, if they do.
  std::optional<double> difference(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) const {
    const Vec3 e1 = b - a, e2 = d - c, ac = c - a;
    const double area = cross(e1, e2);
    if (area == 0) return {};
    const double s = cross(ac, e2) / area, t = cross(ac, e1) / area;
    if (!(s >= 0 && s <= 1 && t >= 0 && t <= 1)) return {};
    return a[h_] + s * e1[h_] - c[h_] - t * e2[h_];
  }

 private:
  double cross(const Vec3& p, const Vec3& q) const { return p[u_] * q[w_] - p[w_] * q[u_]; }

  int h_, u_, w_;
};

std::vector<std::array<Index, 2>> edges_of(const std::vector<std::array<Index, 3>>& triangles) {
  std::vector<std::array<Index, 2>> edges;
  for (const auto& f : triangles)
    for (std::size_t i = 0; i < 3; ++i)
      edges.push_back({std::min(f[i], f[(i + 1) % 3]), std::max(f[i], f[(i + 1) % 3])});
  sort_unique(edges);
  return edges;
}

}  // namespace

std::vector<std::array<Index, 3>> face_triangles(const Shape& shape) {
  std::vector<std::array<Index, 3>> triangles;
  const auto add_faces = [&](auto stream, auto slot) {
    visit_faces(stream, [&](auto face) {
      for (std::size_t k = 1; k + 1 < face.size(); ++k)
        triangles.push_back({slot(face[0]), slot(face[k]), slot(face[k + 1])});
    });
  };
  for (const ElementSpec& e : shape.elements)
    if (e.type == ElementType::polytope)
      add_faces(std::span(e.faces), [](Index v) { return v; });
    else
      add_faces(face_stream(e.type), [&](std::uint8_t i) { return e.vertices[i]; });
  return triangles;
}

double mean_edge_length(const Shape& shape) {
  Features features(EdgeSet::polytope);
  features.build(shape.mesh());
  double sum = 0;
  for (Index e = 0; e < features.edge_slots(); ++e) {
    const auto [v0, v1] = features.edge(e);
    sum += (shape.positions[v1] - shape.positions[v0]).norm();
  }
  return features.edge_count() == 0 ? 0 : sum / features.edge_count();
}

double touching_shift(std::span<const Vec3> a, std::span<const Vec3> b,
                      const std::vector<std::array<Index, 3>>& triangles, int axis, double cell) {
  double shift = -INFINITY;
  const Facing facing(axis);
  const ColumnGrid<3> triangles_a(a, triangles, axis, cell), triangles_b(b, triangles, axis, cell);
  for (const Vec3& p : a)
    triangles_b.near(p, p, [&](const std::array<Index, 3>& f) {
      if (const auto h = facing.height(p, b[f[0]], b[f[1]], b[f[2]])) shift = std::max(shift, p[axis] - *h);
    });
  for (const Vec3& p : b)
    triangles_a.near(p, p, [&](const std::array<Index, 3>& f) {
      if (const auto h = facing.height(p, a[f[0]], a[f[1]], a[f[2]])) shift = std::max(shift, *h - p[axis]);
    });
  const std::vector<std::array<Index, 2>> edges = edges_of(triangles);
  const ColumnGrid<2> edges_b(b, edges, axis, cell);
  for (const auto& [v0, v1] : edges) {
    const Vec3 &p = a[v0], &q = a[v1];
    edges_b.near(p.cwiseMin(q), p.cwiseMax(q), [&](const std::array<Index, 2>& e) {
      if (const auto d = facing.difference(p, q, b[e[0]], b[e[1]])) shift = std::max(shift, *d);
    });
  }
  if (shift > -INFINITY) return shift;
  const auto by_height = [&](const Vec3& p, const Vec3& q) { return p[axis] < q[axis]; };
  return (*std::max_element(a.begin(), a.end(), by_height))[axis] -
         (*std::min_element(b.begin(), b.end(), by_height))[axis];
}

}  // namespace volccd
