#include <volccd/pictures/surface.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include <volccd/core/sort_unique.hpp>

namespace volccd {

namespace {

/// Calls f(face) for each face of a cell, with the vertices of the face in cyclic order.
template <class F>
void for_each_face(const SequenceCells& cells, std::size_t cell, std::vector<Index>& face, F&& f) {
  const std::span<const Index> vertices = cells.vertices(cell);
  if (cells.types[cell] == ElementType::polytope) {
    visit_faces(cells.face_stream(cell), [&](std::span<const Index> stored) {
      face.assign(stored.begin(), stored.end());
      f(face);
    });
    return;
  }
  if (is_shell(cells.types[cell])) {
    face.assign(vertices.begin(), vertices.end());
    f(face);
    return;
  }
  visit_faces(face_stream(cells.types[cell]), [&](std::span<const std::uint8_t> numbers) {
    face.clear();
    for (const std::uint8_t i : numbers) face.push_back(vertices[i]);
    f(face);
  });
}

/// The fan from the face's smallest vertex, as in Features, so that the triangles of neighbours agree.
template <class F>
void for_each_triangle(std::vector<Index>& face, F&& f) {
  std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  for (std::size_t i = 1; i + 1 < face.size(); ++i) {
    SurfaceTriangle triangle;
    triangle.corners = {face[0], face[i], face[i + 1]};
    triangle.element_edges = static_cast<std::uint8_t>(2 | (i == 1 ? 1 : 0) | (i + 2 == face.size() ? 4 : 0));
    f(triangle);
  }
}

std::array<Index, 3> sorted(std::array<Index, 3> v) {
  std::sort(v.begin(), v.end());
  return v;
}

/// Lists of items by vertex: those of vertex v are items[start[v]] to items[start[v+1] - 1].
struct ByVertex {
  std::vector<std::size_t> start;
  std::vector<Index> items;

  std::span<const Index> at(Index v) const { return {items.data() + start[v], start[v + 1] - start[v]}; }
};

/// Puts item i at each vertex that vertices_of(i) names.
template <class F>
ByVertex by_vertex(std::size_t vertices, std::size_t items, F&& vertices_of) {
  ByVertex result;
  result.start.assign(vertices + 2, 0);
  for (std::size_t i = 0; i < items; ++i)
    for (const Index v : vertices_of(i)) ++result.start[v + 2];
  for (std::size_t v = 2; v < result.start.size(); ++v) result.start[v] += result.start[v - 1];
  result.items.resize(result.start.back());
  for (std::size_t i = 0; i < items; ++i)
    for (const Index v : vertices_of(i)) result.items[result.start[v + 1]++] = static_cast<Index>(i);
  return result;
}

Eigen::Vector3f unit_or_zero(const Vec3& v) {
  const double length = v.norm();
  return length > 0 && std::isfinite(length) ? Eigen::Vector3f((v / length).cast<float>()) : Eigen::Vector3f::Zero();
}

Vec3 area_normal(const Surface& surface, const SurfaceTriangle& t) {
  const Vec3 &a = surface.points[t.corners[0]], &b = surface.points[t.corners[1]], &c = surface.points[t.corners[2]];
  return (b - a).cross(c - a);
}

/// Shells may be numbered in either sense, so that the sign of a normal is ignored.
void add_normals(Surface& surface, const ByVertex& incident, double crease) {
  const float min = std::cos(static_cast<float>(crease * std::numbers::pi / 180));
  const std::size_t n = surface.triangles.size();
  std::vector<Eigen::Vector3f> own(n);
  std::vector<float> area(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 normal = area_normal(surface, surface.triangles[i]);
    own[i] = unit_or_zero(normal);
    area[i] = static_cast<float>(normal.norm());
  }
  surface.normals.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const Index j : incident.at(surface.triangles[i].corners[k])) {
        const float cosine = own[i].dot(own[j]);
        if (std::abs(cosine) >= min) sum += (cosine < 0 ? -area[j] : area[j]) * own[j];
      }
      surface.normals[i][k] = sum.squaredNorm() > 0 ? sum.normalized() : own[i];
    }
}

/// An edge is a feature edge unless exactly one other triangle has it, with the same colour and nearly the same normal.
void mark_features(Surface& surface, const ByVertex& incident, double crease) {
  const double min = std::cos(crease * std::numbers::pi / 180);
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    SurfaceTriangle& t = surface.triangles[i];
    const Vec3 normal = area_normal(surface, t);
    for (int k = 0; k < 3; ++k) {
      const Index a = t.corners[k], b = t.corners[(k + 1) % 3];
      int others = 0;
      bool smooth = true;
      for (const Index j : incident.at(a)) {
        const SurfaceTriangle& other = surface.triangles[j];
        if (j == i || std::find(other.corners.begin(), other.corners.end(), b) == other.corners.end()) continue;
        ++others;
        const Vec3 n = area_normal(surface, other);
        smooth = smooth && other.colour == t.colour && std::abs(normal.dot(n)) >= min * normal.norm() * n.norm();
      }
      if (others != 1 || !smooth) t.feature_edges |= static_cast<std::uint8_t>(1 << k);
    }
  }
}

/// A corner of a convex polygon. Bit 0 of `flags`: the edge that starts here is an element's; bit 1: it is a feature
/// edge.
struct Corner {
  Vec3 point;
  Eigen::Vector3f normal;
  int flags;
};

constexpr int kElementEdge = 1, kFeatureEdge = 2;

/// The part of the polygon that is not removed by the plane.
void clip(std::vector<Corner>& polygon, const CuttingPlane& plane, std::vector<Corner>& scratch) {
  scratch.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = plane.normal.dot(a.point) - plane.offset, db = plane.normal.dot(b.point) - plane.offset;
    if (da <= 0) scratch.push_back(a);
    if ((da <= 0) == (db <= 0)) continue;
    const double s = da / (da - db);
    Corner crossing{a.point + s * (b.point - a.point),
                    Eigen::Vector3f(a.normal + static_cast<float>(s) * (b.normal - a.normal)).normalized(),
                    da <= 0 ? kElementEdge | kFeatureEdge : a.flags};
    scratch.push_back(crossing);
  }
  polygon.swap(scratch);
}

void append(Surface& surface, std::span<const Corner> polygon, std::uint16_t colour, bool section) {
  const auto first = static_cast<Index>(surface.points.size());
  for (const Corner& corner : polygon) surface.points.push_back(corner.point);
  const std::size_t n = polygon.size();
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const std::array<int, 3> flags{i == 1 ? polygon[0].flags : 0, polygon[i].flags,
                                   i + 2 == n ? polygon[n - 1].flags : 0};
    SurfaceTriangle t;
    t.corners = {first, first + static_cast<Index>(i), first + static_cast<Index>(i + 1)};
    t.colour = colour;
    t.section = section;
    for (int k = 0; k < 3; ++k) {
      if (flags[k] & kElementEdge) t.element_edges |= static_cast<std::uint8_t>(1 << k);
      if (flags[k] & kFeatureEdge) t.feature_edges |= static_cast<std::uint8_t>(1 << k);
    }
    surface.triangles.push_back(t);
    surface.normals.push_back({polygon[0].normal, polygon[i].normal, polygon[i + 1].normal});
  }
}

void clip_surface(Surface& surface, const CuttingPlane& plane) {
  Surface result;
  std::vector<Corner> polygon, scratch;
  result.points = std::move(surface.points);
  std::vector<char> gone(result.points.size());
  for (std::size_t v = 0; v < gone.size(); ++v) gone[v] = plane.normal.dot(result.points[v]) > plane.offset;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
    const SurfaceTriangle& t = surface.triangles[i];
    const int taken = gone[t.corners[0]] + gone[t.corners[1]] + gone[t.corners[2]];
    if (taken == 3) continue;
    if (taken == 0) {
      result.triangles.push_back(t);
      result.normals.push_back(surface.normals[i]);
      continue;
    }
    polygon.clear();
    for (int k = 0; k < 3; ++k)
      polygon.push_back({result.points[t.corners[k]], surface.normals[i][k],
                         (t.element_edges >> k & 1) * kElementEdge + (t.feature_edges >> k & 1) * kFeatureEdge});
    clip(polygon, plane, scratch);
    append(result, polygon, t.colour, t.section);
  }
  surface = std::move(result);
}

/// The intersection of the plane with a volume, in cyclic order; empty if there is none.
class Section {
 public:
  Section(const CuttingPlane& plane, std::span<const Vec3> points) : plane_(plane), points_(points) {}

  const std::vector<Corner>& of(const SequenceCells& cells, std::size_t cell) {
    polygon_.clear();
    int gone = 0;
    for (const Index v : cells.vertices(cell)) gone += distance(v) > 0;
    if (gone == 0 || gone == static_cast<int>(cells.vertices(cell).size())) return polygon_;
    gather(cells, cell);
    if (polygon_.size() < 3) polygon_.clear();
    std::sort(angles_.begin(), angles_.end());
    for (std::size_t i = 0; i < polygon_.size(); ++i) ordered_[i] = polygon_[angles_[i].second];
    polygon_.swap(ordered_);
    polygon_.resize(angles_.size());
    return polygon_;
  }

 private:
  double distance(Index v) const { return plane_.normal.dot(points_[v]) - plane_.offset; }

  /// Intersections with the edges. An edge belongs to two faces, and is used in the one where its vertices ascend.
  void gather(const SequenceCells& cells, std::size_t cell) {
    edges_.clear();
    for_each_face(cells, cell, face_, [&](std::vector<Index>& face) {
      for (std::size_t i = 0; i < face.size(); ++i) edges_.push_back(std::minmax(face[i], face[(i + 1) % face.size()]));
    });
    sort_unique(edges_);
    Vec3 centre = Vec3::Zero();
    for (const auto& [a, b] : edges_) {
      const double da = distance(a), db = distance(b);
      if ((da > 0) == (db > 0)) continue;
      const Vec3 p = points_[a] + da / (da - db) * (points_[b] - points_[a]);
      polygon_.push_back({p, plane_.normal.cast<float>(), kElementEdge});
      centre += p;
    }
    centre /= static_cast<double>(std::max<std::size_t>(polygon_.size(), 1));
    const Vec3 right = plane_.normal.unitOrthogonal(), up = plane_.normal.cross(right);
    angles_.clear();
    if (polygon_.size() < 3) return;
    for (std::size_t i = 0; i < polygon_.size(); ++i) {
      const Vec3 d = polygon_[i].point - centre;
      angles_.emplace_back(std::atan2(up.dot(d), right.dot(d)), i);
    }
    ordered_.resize(polygon_.size());
  }

  const CuttingPlane& plane_;
  std::span<const Vec3> points_;
  std::vector<Index> face_;
  std::vector<std::pair<Index, Index>> edges_;
  std::vector<std::pair<double, std::size_t>> angles_;
  std::vector<Corner> polygon_, ordered_;
};

}  // namespace

std::vector<SurfaceTriangle> boundary_triangles(const SequenceCells& cells, std::size_t vertices,
                                                std::span<const std::uint16_t> colours) {
  std::vector<SurfaceTriangle> result, solid;
  std::vector<Index> face;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    std::vector<SurfaceTriangle>& target = is_shell(cells.types[cell]) ? result : solid;
    for_each_face(cells, cell, face, [&](std::vector<Index>& f) {
      for_each_triangle(f, [&](SurfaceTriangle triangle) {
        triangle.colour = colours[cell];
        target.push_back(triangle);
      });
    });
  }
  const ByVertex buckets =
      by_vertex(vertices, solid.size(), [&](std::size_t i) { return std::array{sorted(solid[i].corners)[0]}; });
  std::vector<std::pair<std::array<Index, 3>, Index>> bucket;
  for (std::size_t v = 0; v < vertices; ++v) {
    bucket.clear();
    for (const Index i : buckets.at(static_cast<Index>(v))) bucket.emplace_back(sorted(solid[i].corners), i);
    std::sort(bucket.begin(), bucket.end());
    for (std::size_t i = 0; i < bucket.size(); ++i)
      if ((i == 0 || bucket[i - 1].first != bucket[i].first) &&
          (i + 1 == bucket.size() || bucket[i + 1].first != bucket[i].first))
        result.push_back(solid[bucket[i].second]);
  }
  return result;
}

Surface surface_of(const SequenceCells& cells, std::span<const Vec3> points, std::span<const std::uint16_t> colours,
                   double crease) {
  Surface surface;
  surface.points.assign(points.begin(), points.end());
  surface.triangles = boundary_triangles(cells, points.size(), colours);
  const ByVertex incident =
      by_vertex(points.size(), surface.triangles.size(), [&](std::size_t i) { return surface.triangles[i].corners; });
  add_normals(surface, incident, crease);
  mark_features(surface, incident, crease + 15);
  return surface;
}

std::vector<Index> vertices_of_bodies(const SequenceCells& cells, std::size_t vertex_count, double min_share) {
  std::vector<Index> parent(vertex_count);
  std::iota(parent.begin(), parent.end(), Index{0});
  const auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    for (const Index v : cells.vertices(cell)) parent[root(v)] = root(cells.vertices(cell)[0]);

  std::map<std::pair<std::int32_t, Index>, std::size_t> pieces;  // cells by part and root
  std::map<std::int32_t, std::size_t> total, largest;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    ++pieces[{cells.objects[cell], root(cells.vertices(cell)[0])}];
    ++total[cells.objects[cell]];
  }
  for (const auto& [key, count] : pieces) largest[key.first] = std::max(largest[key.first], count);
  std::vector<char> body(vertex_count), wanted(vertex_count);
  for (const auto& [key, count] : pieces)
    if (count == largest[key.first] || static_cast<double>(count) >= min_share * static_cast<double>(total[key.first]))
      body[key.second] = 1;
  for (const Index v : cells.connectivity) wanted[v] = body[root(v)];
  std::vector<Index> result;
  for (std::size_t v = 0; v < vertex_count; ++v)
    if (wanted[v]) result.push_back(static_cast<Index>(v));
  return result;
}

void cut(Surface& surface, const SequenceCells& cells, std::span<const Vec3> points,
         std::span<const std::uint16_t> colours, std::span<const CuttingPlane> planes) {
  std::vector<Corner> polygon, scratch;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    clip_surface(surface, planes[i]);
    Section section(planes[i], points);
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
      if (is_shell(cells.types[cell])) continue;
      polygon = section.of(cells, cell);
      for (std::size_t earlier = 0; earlier < i && !polygon.empty(); ++earlier) clip(polygon, planes[earlier], scratch);
      if (!polygon.empty()) append(surface, polygon, colours[cell], true);
    }
  }
}

}  // namespace volccd
