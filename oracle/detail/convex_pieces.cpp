#include <volccd/oracle/detail/convex_pieces.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>

namespace volccd::detail {

namespace {

using Triangle = std::array<Index, 3>;

// {n, i0 .. i(n-1), n, ...}, VTK node order; faces of a volume type are oriented alike.
constexpr std::uint8_t kTriangle[] = {3, 0, 1, 2};
constexpr std::uint8_t kQuad[] = {4, 0, 1, 2, 3};
constexpr std::uint8_t kTetrahedron[] = {3, 0, 2, 1, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0, 3};
constexpr std::uint8_t kPyramid[] = {4, 0, 3, 2, 1, 3, 0, 1, 4, 3, 1, 2, 4, 3, 2, 3, 4, 3, 3, 0, 4};
constexpr std::uint8_t kWedge[] = {3, 0, 1, 2, 3, 3, 5, 4, 4, 0, 3, 4, 1, 4, 1, 4, 5, 2, 4, 2, 5, 3, 0};
constexpr std::uint8_t kHexahedron[] = {4, 0, 4, 7, 3, 4, 1, 2, 6, 5, 4, 0, 1, 5, 4,
                                        4, 3, 7, 6, 2, 4, 0, 3, 2, 1, 4, 4, 5, 6, 7};

std::span<const std::uint8_t> faces_of(ElementType type) {
  switch (type) {
    case ElementType::triangle: return kTriangle;
    case ElementType::quad: return kQuad;
    case ElementType::tetrahedron: return kTetrahedron;
    case ElementType::pyramid: return kPyramid;
    case ElementType::wedge: return kWedge;
    case ElementType::hexahedron: return kHexahedron;
    default: return {};
  }
}

/// The fan around the smallest vertex of the face v[0 .. n-1].
void append_fan(std::span<const Index> v, std::vector<Triangle>& triangles) {
  const std::size_t n = v.size();
  const std::size_t first = static_cast<std::size_t>(std::min_element(v.begin(), v.end()) - v.begin());
  for (std::size_t i = 1; i + 1 < n; ++i) triangles.push_back({v[first], v[(first + i) % n], v[(first + i + 1) % n]});
}

bool has_directed_edge(const Triangle& f, Index from, Index to) {
  for (std::size_t i = 0; i < 3; ++i)
    if (f[i] == from && f[(i + 1) % 3] == to) return true;
  return false;
}

/// Orients the triangles of a closed surface such that neighbours traverse their common edge in opposite directions.
void orient_alike(std::vector<Triangle>& triangles) {
  std::vector<char> done(triangles.size(), 0);
  std::vector<std::size_t> open = {0};
  if (!triangles.empty()) done[0] = 1;
  while (!open.empty() && !triangles.empty()) {
    const Triangle f = triangles[open.back()];
    open.pop_back();
    for (std::size_t j = 0; j < triangles.size(); ++j) {
      if (done[j]) continue;
      for (std::size_t i = 0; i < 3 && !done[j]; ++i) {
        const Index from = f[i], to = f[(i + 1) % 3];
        const bool same = has_directed_edge(triangles[j], from, to);
        if (!same && !has_directed_edge(triangles[j], to, from)) continue;
        if (same) std::swap(triangles[j][1], triangles[j][2]);
        done[j] = 1;
        open.push_back(j);
      }
    }
  }
}

/// Whether the tetrahedra (apex, triangle) all have the same orientation, each beyond doubt. Then a point's winding
/// number is the number of tetrahedra around it, up to the sign, and their union is the body.
bool same_orientation(const Vec3& apex, std::span<const Vec3> x, const std::vector<Triangle>& triangles) {
  double size = 0;
  for (const Triangle& f : triangles)
    for (const Index v : f) size = std::max(size, (x[v] - apex).cwiseAbs().maxCoeff());
  const double doubt = 1e-12 * size * size * size;
  double low = INFINITY, high = -INFINITY;
  for (const Triangle& f : triangles) {
    const double volume = (x[f[0]] - apex).cross(x[f[1]] - apex).dot(x[f[2]] - apex);
    low = std::min(low, volume);
    high = std::max(high, volume);
  }
  return low > doubt || high < -doubt;
}

}  // namespace

void boundary_triangles(const Mesh& mesh, Index o, std::vector<Triangle>& triangles) {
  triangles.clear();
  std::vector<Index> face;
  const auto split = [&](auto stream, auto slot) {
    for (std::size_t i = 0; i < stream.size(); i += std::size_t{1} + stream[i]) {
      face.clear();
      for (std::size_t k = 1; k <= stream[i]; ++k) face.push_back(slot(stream[i + k]));
      append_fan(face, triangles);
    }
  };
  if (mesh.type(o) == ElementType::polytope) {
    split(mesh.polytope_faces(o), [](Index v) { return v; });
    orient_alike(triangles);
  } else {
    const std::span<const Index> vertices = mesh.vertices(o);
    split(faces_of(mesh.type(o)), [&](std::uint8_t i) { return vertices[i]; });
  }
}

bool append_pieces(const Mesh& mesh, std::span<const Vec3> positions, Index o, Cover cover,
                   std::vector<ConvexPiece>& pieces) {
  const std::span<const Index> vertices = mesh.vertices(o);
  const ElementType type = mesh.type(o);
  if (type == ElementType::tetrahedron) {
    pieces.push_back(
        {{positions[vertices[0]], positions[vertices[1]], positions[vertices[2]], positions[vertices[3]]}, 4});
    return true;
  }
  std::vector<Triangle> triangles;
  boundary_triangles(mesh, o, triangles);
  bool solid = type != ElementType::triangle && type != ElementType::quad, exact = true;
  Vec3 apex = Vec3::Zero();
  if (solid) {
    for (const Index v : vertices) apex += positions[v] / static_cast<double>(vertices.size());
    exact = same_orientation(apex, positions, triangles);
    if (!exact && cover == Cover::within) solid = false;
  }
  for (const Triangle& f : triangles)
    pieces.push_back({{positions[f[0]], positions[f[1]], positions[f[2]], apex}, solid ? 4 : 3});
  return exact;
}

bool share_vertex(const Mesh& mesh, Index a, Index b) {
  const std::span<const Index> of_b = mesh.vertices(b);
  for (const Index v : mesh.vertices(a))
    if (std::find(of_b.begin(), of_b.end(), v) != of_b.end()) return true;
  return false;
}

}  // namespace volccd::detail
