#include <volccd/oracle/cases/hostile_covers.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <Eigen/Dense>

namespace volccd::cases {
namespace {

Surface double_pyramid(int sides, int radius) {
  Surface s;
  s.points = {Vec3(0, 0, 12), Vec3(0, 0, -12)};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    s.points.push_back(rounded(radius * Vec3(std::cos(angle), std::sin(angle), 0)));
  }
  for (int i = 0; i < sides; ++i) {
    const Index u = static_cast<Index>(2 + i), w = static_cast<Index>(2 + (i + 1) % sides);
    s.triangles.push_back({0, u, w});
    s.triangles.push_back({1, w, u});
  }
  return s;
}

Surface icosahedron() {
  Surface s;
  for (const int a : {-5, 5})
    for (const int b : {-8, 8}) {
      s.points.push_back(Vec3(0, a, b));
      s.points.push_back(Vec3(a, b, 0));
      s.points.push_back(Vec3(b, 0, a));
    }
  // Its faces are the triples of points with pairwise distance 10 or nearly so.
  const auto near = [&](Index i, Index j) { return (s.points[i] - s.points[j]).squaredNorm() < 110; };
  for (Index i = 0; i < 12; ++i)
    for (Index j = i + 1; j < 12; ++j)
      for (Index k = j + 1; k < 12; ++k) {
        if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
        const bool outward = s.points[i].cross(s.points[j]).dot(s.points[k]) > 0;
        s.triangles.push_back(outward ? std::array{i, j, k} : std::array{i, k, j});
      }
  return s;
}

/// Divides a triangle into three.
void divide(Surface& s, std::size_t t) {
  const auto [a, b, c] = s.triangles[t];
  const Index m = static_cast<Index>(s.points.size());
  s.points.push_back(rounded((s.points[a] + s.points[b] + s.points[c]) / 2));
  s.triangles[t] = {a, b, m};
  s.triangles.push_back({b, c, m});
  s.triangles.push_back({c, a, m});
}

/// Sets of corners of triangles that are one vertex.
class Classes {
 public:
  explicit Classes(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::size_t i, std::size_t j) { parent_[find(i)] = find(j); }

 private:
  std::vector<std::size_t> parent_;
};

/// An edge of the base with its two triangles, `corner`: position of its first vertex in each.
struct BaseEdge {
  std::size_t triangle[2];
  std::size_t corner[2];
};

std::vector<BaseEdge> edges_of(const Surface& s) {
  std::map<std::pair<Index, Index>, std::pair<std::size_t, std::size_t>> sides;
  std::vector<BaseEdge> edges;
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = s.triangles[t][k], b = s.triangles[t][(k + 1) % 3];
      const auto other = sides.find({b, a});
      // In the other triangle, the edge begins at b, and a is its next corner.
      if (other != sides.end()) edges.push_back({{t, other->second.first}, {k, (other->second.second + 1) % 3}});
      sides[{a, b}] = {t, k};
    }
  return edges;
}

/// For each edge, the sheet in its second triangle that continues each sheet of the first.
std::vector<std::vector<std::size_t>> permutations(Choices& c, std::size_t edges, std::size_t sheets) {
  std::vector<std::size_t> identity(sheets);
  std::iota(identity.begin(), identity.end(), std::size_t{0});
  std::vector<std::vector<std::size_t>> all(edges, identity);
  for (int cuts = between(c, 1, 5); cuts > 0; --cuts) {
    auto& one = all[static_cast<std::size_t>(c.below(static_cast<int>(edges)))];
    const auto i = static_cast<std::size_t>(c.below(static_cast<int>(sheets)));
    std::swap(one[i], one[(i + 1) % sheets]);
  }
  return all;
}

}  // namespace

Surface sphere(Choices& c) {
  Surface s = c.one_in(4) ? icosahedron() : double_pyramid(between(c, 3, 7), between(c, 6, 12));
  for (int i = c.below(4); i > 0; --i)
    divide(s, static_cast<std::size_t>(c.below(static_cast<int>(s.triangles.size()))));
  return s;
}

Surface branched_cover(Choices& c, const Surface& base, int sheets, int spread) {
  const std::size_t n = base.triangles.size(), copies = static_cast<std::size_t>(sheets);
  const std::vector<BaseEdge> edges = edges_of(base);
  const auto next_sheet = permutations(c, edges.size(), copies);
  Classes classes(3 * n * copies);
  const auto corner = [&](std::size_t sheet, std::size_t t, std::size_t k) { return 3 * (sheet * n + t) + k % 3; };
  for (std::size_t e = 0; e < edges.size(); ++e)
    for (std::size_t sheet = 0; sheet < copies; ++sheet) {
      const auto& [t, k] = edges[e];
      const std::size_t other = next_sheet[e][sheet];
      classes.unite(corner(sheet, t[0], k[0]), corner(other, t[1], k[1]));
      classes.unite(corner(sheet, t[0], k[0] + 1), corner(other, t[1], k[1] + 2));
    }
  Surface cover;
  std::map<std::size_t, Index> number;
  for (std::size_t i = 0; i < n * copies; ++i) {
    auto& triangle = cover.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [at, fresh] = number.try_emplace(classes.find(3 * i + k), static_cast<Index>(cover.points.size()));
      if (fresh)
        cover.points.push_back(between(c, 3, 8) * base.points[base.triangles[i % n][k]] + lattice_point(c, spread));
      triangle[k] = at->second;
    }
  }
  return cover;
}

void open_rings(Choices& c, Surface& s) {
  const auto any_point = [&] { return static_cast<Index>(c.below(static_cast<int>(s.points.size()))); };
  std::vector<std::array<Index, 3>> kept = s.triangles;
  for (int rings = between(c, 1, 2); rings > 0; --rings) {
    const Index v = any_point();
    std::erase_if(kept, [&](const auto& t) { return std::find(t.begin(), t.end(), v) != t.end(); });
  }
  if (c.one_in(3) && !kept.empty()) kept.erase(kept.begin() + c.below(static_cast<int>(kept.size())));
  if (kept.size() > 2) s.triangles = kept;
}

void open_over_sheet(Choices& c, Surface& s, std::size_t base_triangles) {
  const Index v = static_cast<Index>(c.below(static_cast<int>(s.points.size())));
  std::vector<std::array<Index, 3>> kept, uncovered;
  for (std::size_t i = 0; i < s.triangles.size(); ++i) {
    const auto& t = s.triangles[i];
    if (std::find(t.begin(), t.end(), v) == t.end())
      kept.push_back(t);
    else
      uncovered.push_back(s.triangles[(i + base_triangles) % s.triangles.size()]);
  }
  for (const auto& t : uncovered) {
    const auto at = std::find(kept.begin(), kept.end(), t);
    if (at != kept.end()) std::rotate(kept.begin(), at, at + 1);
  }
  if (kept.size() > 2) s.triangles = kept;
}

HostileMesh star_over(const Surface& link) {
  HostileMesh mesh;
  mesh.shape.positions = {Vec3::Zero()};
  mesh.shape.positions.insert(mesh.shape.positions.end(), link.points.begin(), link.points.end());
  for (const auto& [a, b, c] : link.triangles)
    add_element(mesh.shape.elements, ElementType::tetrahedron, {0, a + 1, b + 1, c + 1});
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
  remove_unused_vertices(mesh);
  return mesh;
}

HostileMesh winding_star(Choices& c, Winding winding) {
  const int sides = between(c, 7, 14), first_turns = between(c, 1, 2);
  const int slope = winding == Winding::inside ? 0 : c.below(5), tilt = c.below(6);
  HostileMesh mesh;
  mesh.poses.resize(3);
  for (int pose = -1; pose < 3; ++pose) {
    auto& x = pose < 0 ? mesh.shape.positions : mesh.poses[static_cast<std::size_t>(pose)];
    x = {Vec3::Zero()};
    if (winding != Winding::shells) x.push_back(Vec3(0, 0, -64));
    if (winding == Winding::inside) x.push_back(Vec3(0, 0, 64));
    const int turns = pose < 0 ? first_turns : pose + 1;
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * turns * i / sides, radius = between(c, 40, 72);
      const double height = slope * 2 * (sides - 2 * i) + c.lattice(tilt);
      x.push_back(rounded(Vec3(radius * std::cos(angle), radius * std::sin(angle), height)));
    }
  }
  const Index ring = winding == Winding::shells ? 1 : winding == Winding::inside ? 3 : 2;
  const bool closed = !c.one_in(6);
  for (Index i = 0; i + (closed ? 0 : 1) < static_cast<Index>(sides); ++i) {
    const Index u = ring + i, w = ring + (i + 1) % static_cast<Index>(sides);
    auto& elements = mesh.shape.elements;
    if (winding == Winding::shells) add_element(elements, ElementType::triangle, {0, u, w});
    if (winding != Winding::shells) add_element(elements, ElementType::tetrahedron, {0, w, u, 1});
    if (winding == Winding::inside) add_element(elements, ElementType::tetrahedron, {0, u, w, 2});
  }
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
  return mesh;
}

}  // namespace volccd::cases
