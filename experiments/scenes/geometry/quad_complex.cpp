#include <volccd/experiments/scenes/geometry/quad_complex.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include <volccd/core/error.hpp>

namespace volccd {

/// Vertices along the sides, from each side's first corner to its second, both included.
struct QuadComplex::Vertices {
  std::vector<std::vector<Index>> of_side;
};

void QuadComplex::snap(std::int32_t part, Snap surface) { snaps_[part] = std::move(surface); }

Index QuadComplex::corner(const Vec3& p, std::int32_t snapped_by) {
  const std::array<std::int64_t, 3> key{std::llround(p.x() * 1e6), std::llround(p.y() * 1e6),
                                        std::llround(p.z() * 1e6)};
  const auto [found, is_new] = corner_at_.try_emplace(key, static_cast<Index>(corners_.size()));
  if (is_new) {
    corners_.push_back(p);
    corner_snapped_by_.push_back(-1);
  }
  if (corner_snapped_by_[found->second] < 0) corner_snapped_by_[found->second] = snapped_by;
  return found->second;
}

Index QuadComplex::side(Index a, Index b, std::int32_t snapped_by) {
  const std::pair<Index, Index> key = std::minmax(a, b);
  const auto [found, is_new] = side_between_.try_emplace(key, static_cast<Index>(sides_.size()));
  if (is_new) sides_.push_back({key.first, key.second, -1, {}});
  Side& side = sides_[found->second];
  if (side.snapped_by < 0) side.snapped_by = snapped_by;
  return found->second;
}

void QuadComplex::patch(std::int32_t part, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::int32_t snapped_by = snaps_.contains(part) ? part : -1;
  Patch patch{part, {corner(a, snapped_by), corner(b, snapped_by), corner(c, snapped_by), corner(d, snapped_by)}, {}};
  for (std::size_t i = 0; i < 4; ++i) {
    if (patch.corners[i] == patch.corners[(i + 1) % 4]) throw ConfigError("patch with a side of no length");
    patch.sides[i] = side(patch.corners[i], patch.corners[(i + 1) % 4], snapped_by);
  }
  patches_.push_back(patch);
}

void QuadComplex::bend(const Vec3& a, const Vec3& b, Snap curve) {
  const std::size_t corners = corners_.size();
  const auto found = side_between_.find(std::minmax(corner(a, -1), corner(b, -1)));
  if (corners_.size() != corners || found == side_between_.end()) throw ConfigError("no patch has the side to bend");
  sides_[found->second].curve = std::move(curve);
}

void QuadComplex::tube(std::int32_t part, const std::vector<std::vector<Vec3>>& sections) {
  for (std::size_t s = 0; s + 1 < sections.size(); ++s)
    for (std::size_t i = 0, n = sections[s].size(); i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      patch(part, sections[s][i], sections[s][j], sections[s + 1][j], sections[s + 1][i]);
    }
}

void QuadComplex::grid(std::int32_t part, const std::vector<double>& u, const std::vector<double>& v,
                       const std::function<Vec3(double, double)>& place) {
  for (std::size_t i = 0; i + 1 < u.size(); ++i)
    for (std::size_t j = 0; j + 1 < v.size(); ++j)
      patch(part, place(u[i], v[j]), place(u[i + 1], v[j]), place(u[i + 1], v[j + 1]), place(u[i], v[j + 1]));
}

Vec3 QuadComplex::on_surface(std::int32_t part, const Vec3& p) const { return part < 0 ? p : snaps_.at(part)(p); }

std::vector<int> QuadComplex::divisions(double spacing) const {
  std::vector<Index> root(sides_.size());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index s) {
    while (root[s] != s) s = root[s] = root[root[s]];
    return s;
  };
  for (const Patch& patch : patches_)
    for (const std::size_t i : {0u, 1u}) {
      const Index a = find(patch.sides[i]), b = find(patch.sides[i + 2]);
      root[std::max(a, b)] = std::min(a, b);
    }
  std::vector<double> length(sides_.size(), 0);
  std::vector<int> members(sides_.size(), 0), result(sides_.size());
  for (Index s = 0; s < sides_.size(); ++s) {
    length[find(s)] += (corners_[sides_[s].a] - corners_[sides_[s].b]).norm();
    ++members[find(s)];
  }
  for (Index s = 0; s < sides_.size(); ++s) {
    const Index r = find(s);
    result[s] = std::max(1, static_cast<int>(std::lround(length[r] / members[r] / spacing)));
  }
  return result;
}

std::int64_t QuadComplex::triangle_count(double spacing) const {
  const std::vector<int> n = divisions(spacing);
  std::int64_t count = 0;
  for (const Patch& patch : patches_) count += 2 * std::int64_t{n[patch.sides[0]]} * n[patch.sides[1]];
  return count;
}

double QuadComplex::spacing_for(std::int64_t triangles) const {
  if (triangles < 2 * static_cast<std::int64_t>(patches_.size()))
    throw ConfigError("at least " + std::to_string(2 * patches_.size()) + " triangles are needed");
  double low = 1e-5, high = 10, best = high;
  std::int64_t best_error = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < 50; ++i) {
    const double middle = std::sqrt(low * high);
    const std::int64_t error = triangle_count(middle) - triangles;
    if (std::abs(error) < best_error) best_error = std::abs(error), best = middle;
    (error > 0 ? low : high) = middle;
  }
  return best;
}

void QuadComplex::place_sides(const std::vector<int>& divisions, Vertices& vertices, Shape& shape) const {
  shape.positions.resize(corners_.size());
  for (Index c = 0; c < corners_.size(); ++c) shape.positions[c] = on_surface(corner_snapped_by_[c], corners_[c]);
  vertices.of_side.resize(sides_.size());
  for (Index s = 0; s < sides_.size(); ++s) {
    const Side& side = sides_[s];
    const Vec3 a = shape.positions[side.a], b = shape.positions[side.b];
    std::vector<Index>& along = vertices.of_side[s];
    along.push_back(side.a);
    for (int i = 1; i < divisions[s]; ++i) {
      Vec3 p = a + (b - a) * (static_cast<double>(i) / divisions[s]);
      if (side.curve) p = side.curve(p);
      along.push_back(static_cast<Index>(shape.positions.size()));
      shape.positions.push_back(on_surface(side.snapped_by, p));
    }
    along.push_back(side.b);
  }
}

void QuadComplex::fill(const Patch& patch, const std::vector<int>& divisions, const Vertices& vertices,
                       Shape& shape) const {
  const int nu = divisions[patch.sides[0]], nv = divisions[patch.sides[1]];
  // Side k of the patch at step i in the sense of increasing u (sides 0 and 2) or v (1 and 3).
  const auto along = [&](std::size_t k, int i) {
    const Side& side = sides_[patch.sides[k]];
    const std::size_t start = k < 2 ? k : (k + 1) % 4;
    const bool forward = side.a == patch.corners[start];
    const std::vector<Index>& list = vertices.of_side[patch.sides[k]];
    return forward ? list[static_cast<std::size_t>(i)] : list[list.size() - 1 - static_cast<std::size_t>(i)];
  };
  const bool snapped = snaps_.contains(patch.part);
  const auto& x = shape.positions;
  const std::size_t row = static_cast<std::size_t>(nu) + 1;
  std::vector<Index> at(row * (static_cast<std::size_t>(nv) + 1));
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i) {
      Index& vertex = at[static_cast<std::size_t>(j) * row + static_cast<std::size_t>(i)];
      if (j == 0 || j == nv) {
        vertex = along(j == 0 ? 0 : 2, i);
      } else if (i == 0 || i == nu) {
        vertex = along(i == 0 ? 3 : 1, j);
      } else {
        const double u = static_cast<double>(i) / nu, v = static_cast<double>(j) / nv;
        const Vec3 across =
            (1 - v) * x[along(0, i)] + v * x[along(2, i)] + (1 - u) * x[along(3, j)] + u * x[along(1, j)];
        const Vec3 twice = (1 - u) * (1 - v) * x[patch.corners[0]] + u * (1 - v) * x[patch.corners[1]] +
                           u * v * x[patch.corners[2]] + (1 - u) * v * x[patch.corners[3]];
        vertex = static_cast<Index>(x.size());
        shape.positions.push_back(snapped ? on_surface(patch.part, across - twice) : Vec3(across - twice));
      }
    }
  const auto add = [&](Index a, Index b, Index c) {
    shape.elements.push_back({.type = ElementType::triangle,
                              .vertices = {a, b, c},
                              .object = patch.part,
                              .id = static_cast<std::int64_t>(shape.elements.size())});
  };
  for (std::size_t j = 0; j + 1 < at.size() / row; ++j)
    for (std::size_t i = 0; i + 1 < row; ++i) {
      const Index a = at[j * row + i], b = at[j * row + i + 1], c = at[(j + 1) * row + i + 1],
                  d = at[(j + 1) * row + i];
      if ((i + j) % 2 == 0) {
        add(a, b, c), add(a, c, d);
      } else {
        add(a, b, d), add(b, c, d);
      }
    }
}

Shape QuadComplex::mesh(double spacing) const {
  const std::vector<int> n = divisions(spacing);
  Shape shape;
  Vertices vertices;
  place_sides(n, vertices, shape);
  for (const Patch& patch : patches_) fill(patch, n, vertices, shape);
  return shape;
}

}  // namespace volccd
