#include <volccd/experiments/scenes/geometry/tools.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

void add_tetrahedron(Shape& shape, Index a, Index b, Index c, Index d) {
  const std::vector<Vec3>& x = shape.positions;
  if ((x[b] - x[a]).cross(x[c] - x[a]).dot(x[d] - x[a]) < 0) std::swap(c, d);
  shape.elements.push_back({.type = ElementType::tetrahedron,
                            .vertices = {a, b, c, d},
                            .id = static_cast<std::int64_t>(shape.elements.size())});
}

/// A prism over the triangle `low`; vertex i of the other end is `high[i]`. Diagonals go by the order of the vertices
/// of `low`, so that neighbours agree.
void add_prism(Shape& shape, std::array<Index, 3> low, std::array<Index, 3> high) {
  std::array<std::size_t, 3> order{0, 1, 2};
  std::ranges::sort(order, {}, [&](std::size_t i) { return low[i]; });
  const auto [a, b, c] = order;
  add_tetrahedron(shape, low[a], low[b], low[c], high[c]);
  add_tetrahedron(shape, low[a], low[b], high[b], high[c]);
  add_tetrahedron(shape, low[a], high[a], high[b], high[c]);
}

/// Vertex k of ring r; the ring has 6 r, or one if r is 0.
Index ring_vertex(int r, int k) { return static_cast<Index>(r == 0 ? 0 : 3 * r * (r - 1) + 1 + k % (6 * r)); }

}  // namespace

Shape funnel(const FunnelShape& f) {
  if (!(f.depth > 0) || !(f.thickness > 0) || f.rings < 1 || !(f.slope > 0 && f.slope < std::numbers::pi / 2))
    throw ConfigError("funnel: a size or number is not possible");
  Shape shape;
  const double lowest = -f.depth / std::cos(f.slope),
               wide = f.depth / std::sin(f.slope) / std::cos(std::numbers::pi / 6);
  const auto corner = [](int side) {
    const double angle = std::numbers::pi / 6 * (2 * side + 1);
    return Vec3(std::cos(angle), std::sin(angle), 0);
  };
  for (int r = 0; r <= f.rings; ++r)
    for (int k = 0; k < std::max(1, 6 * r); ++k) {
      const double share = static_cast<double>(r) / f.rings, along = r == 0 ? 0 : static_cast<double>(k % r) / r;
      const int side = r == 0 ? 0 : k / r;
      const Vec3 across = wide * share * ((1 - along) * corner(side) + along * corner(side + 1));
      shape.positions.push_back(across + Vec3(0, 0, lowest * (1 - share)));
    }
  const auto layer = static_cast<Index>(shape.positions.size());
  for (Index v = 0; v < layer; ++v)
    shape.positions.push_back(shape.positions[v] - Vec3(0, 0, f.thickness / std::cos(f.slope)));
  const auto add = [&](Index a, Index b, Index c) { add_prism(shape, {a, b, c}, {a + layer, b + layer, c + layer}); };
  for (int r = 1; r <= f.rings; ++r)
    for (int side = 0; side < 6; ++side)
      for (int k = 0; k < r; ++k) {
        const int outer = side * r + k, inner = side * (r - 1) + k;
        add(ring_vertex(r, outer), ring_vertex(r, outer + 1), ring_vertex(r - 1, inner));
        if (k > 0) add(ring_vertex(r - 1, inner - 1), ring_vertex(r, outer), ring_vertex(r - 1, inner));
      }
  return shape;
}

Shape knife(const KnifeShape& k) {
  if (!(k.width > 0) || !(k.height > k.bevel) || !(k.thickness > 0) || !(k.bevel > 0) || k.along < 1 || k.down < 2)
    throw ConfigError("knife: a size or number is not possible");
  Shape shape;
  const auto row = static_cast<Index>(k.along + 1);
  const auto add_row = [&](double y, double z) {
    for (int i = 0; i <= k.along; ++i)
      shape.positions.emplace_back(k.width * (static_cast<double>(i) / k.along - 0.5), y, z);
  };
  add_row(0, 0);
  for (int j = 1; j <= k.down; ++j) {
    const double z = -k.bevel - (k.height - k.bevel) * (j - 1) / (k.down - 1);
    add_row(-k.thickness / 2, z);
    add_row(k.thickness / 2, z);
  }
  // Row j has two lines of vertices, that at -y first; row 0 has one.
  const auto at = [&](int i, int j, Index side) {
    return static_cast<Index>(i) + (j == 0 ? 0 : row * (static_cast<Index>(2 * j - 1) + side));
  };
  for (int i = 0; i < k.along; ++i) {
    add_prism(shape, {at(i, 0, 0), at(i, 1, 0), at(i, 1, 1)}, {at(i + 1, 0, 0), at(i + 1, 1, 0), at(i + 1, 1, 1)});
    for (int j = 1; j < k.down; ++j) {
      const std::array<Index, 3> a{at(i, j, 0), at(i, j + 1, 0), at(i, j + 1, 1)};
      const std::array<Index, 3> b{at(i, j, 0), at(i, j, 1), at(i, j + 1, 1)};
      add_prism(shape, a, {a[0] + 1, a[1] + 1, a[2] + 1});
      add_prism(shape, b, {b[0] + 1, b[1] + 1, b[2] + 1});
    }
  }
  return shape;
}

}  // namespace volccd
