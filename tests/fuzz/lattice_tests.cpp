#include "lattice_tests.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/narrowphase/overlap/initial_overlap.hpp>

#include "support/stages.hpp"

namespace volccd::fuzz {

namespace {

using Integer = std::int64_t;
using Vector = std::array<Integer, 3>;

Vector difference(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Integer dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The control points of the four vertices of a test.
struct Points {
  double separation;
  std::size_t count;                        ///< control points
  std::size_t first;                        ///< vertices of the first feature: 1 or 2
  std::array<std::array<Vector, 3>, 4> at;  ///< [vertex][control point]

  /// Whether all control points of the features lie strictly on different sides of a plane with this normal.
  /// With a separation, they have to be further apart.
  bool separated(const Vector& normal) const {
    std::array<Integer, 2> low, high;
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t begin = side == 0 ? 0 : first, end = side == 0 ? first : 4;
      low[side] = high[side] = dot(normal, at[begin][0]);
      for (std::size_t v = begin; v < end; ++v)
        for (std::size_t i = 0; i < count; ++i) {
          const Integer x = dot(normal, at[v][i]);
          low[side] = std::min(low[side], x);
          high[side] = std::max(high[side], x);
        }
    }
    const Integer gap = std::max(low[1] - high[0], low[0] - high[1]);
    if (gap <= 0 || separation == 0) return gap > 0;
    // Squares of a normal may exceed 64 bits. The factor covers rounding.
    const auto x = static_cast<double>(normal[0]), y = static_cast<double>(normal[1]),
               z = static_cast<double>(normal[2]);
    return static_cast<double>(gap) > separation * std::sqrt(x * x + y * y + z * z) * (1 + 1e-9);
  }

  /// Whether the Bernstein coefficients of det(p1 - p0, p2 - p0, p3 - p0) have one strict sign: the points are never
  /// coplanar.
  bool never_coplanar() const {
    if (separation > 0) return false;
    std::array<Integer, 7> coefficients{};
    const auto weight = [&](std::size_t i) -> Integer { return count == 3 && i == 1 ? 2 : 1; };
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j)
        for (std::size_t k = 0; k < count; ++k)
          coefficients[i + j + k] += weight(i) * weight(j) * weight(k) * determinant(i, j, k);
    const auto used = std::span(coefficients).first(3 * (count - 1) + 1);
    return std::ranges::all_of(used, [](Integer c) { return c > 0; }) ||
           std::ranges::all_of(used, [](Integer c) { return c < 0; });
  }

 private:
  Integer determinant(std::size_t i, std::size_t j, std::size_t k) const {
    const Vector a = difference(at[1][i], at[0][i]), b = difference(at[2][j], at[0][j]),
                 c = difference(at[3][k], at[0][k]);
    return dot(a, cross(b, c));
  }
};

constexpr Vector kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr Vector kDiagonals[] = {{1, 1, 0},  {1, -1, 0}, {1, 0, 1},  {1, 0, -1}, {0, 1, 1},
                                 {0, 1, -1}, {1, 1, 1},  {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};

/// Whether a normal at a control point of the triangle, or of both edges, separates the features.
bool separated_by_normals(FeatureKind kind, const Points& p) {
  for (std::size_t i = 0; i < p.count; ++i) {
    const Vector a = kind == FeatureKind::vf ? difference(p.at[2][i], p.at[1][i]) : difference(p.at[1][i], p.at[0][i]);
    const Vector b = difference(p.at[3][i], p.at[kind == FeatureKind::vf ? 1 : 2][i]);
    const Vector normal = cross(a, b);
    if (p.separated(normal)) return true;
    // Perpendicular to the edges within their planes.
    if (p.separated(cross(normal, a)) || p.separated(cross(normal, b))) return true;
    if (kind == FeatureKind::vf && p.separated(cross(normal, difference(p.at[3][i], p.at[2][i])))) return true;
  }
  return false;
}

TestMotion motion_of(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices) {
  TestMotion motion{kind, step.motion.control_points(), {}};
  for (std::size_t i = 0; i < 4; ++i) motion.points[i] = step.motion.at(vertices[i]);
  return motion;
}

}  // namespace

std::vector<ElementPair> initial_overlaps(const Step& step) {
  const Mesh& mesh = step.mesh();
  std::vector<std::vector<Vec3>> points(mesh.element_slots());
  for (Index o = 0; o < mesh.element_slots(); ++o)
    for (const Index v : mesh.vertices(o)) points[o].push_back(step.motion.point(v, 0));
  const auto adjacent = [&](Index a, Index b) {
    return std::ranges::any_of(
        mesh.vertices(a), [&](Index v) { return std::ranges::find(mesh.vertices(b), v) != mesh.vertices(b).end(); });
  };
  InitialOverlapTest test;
  std::vector<ElementPair> result;
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a + 1; b < mesh.element_slots(); ++b)
      if (step.filter.allows(mesh.object(a), mesh.object(b)) && !adjacent(a, b) &&
          test.overlap(points[a], points[b], step.separation))
        result.push_back({a, b});
  return result;
}

bool is_included(const Step& step, FeatureKind kind, FeaturePair pair) {
  const Features& features = step.features();
  const bool vf = kind == FeatureKind::vf;
  for (const Index a : vf ? features.vertex_elements(pair.a) : features.edge_elements(pair.a))
    for (const Index b : vf ? features.triangle_elements(pair.b) : features.edge_elements(pair.b))
      if (step.filter.allows(step.mesh().object(a), step.mesh().object(b))) return true;
  return false;
}

LatticeTests::LatticeTests(const Step& step) : step_(step) {
  const auto points = static_cast<std::size_t>(step.motion.control_points());
  for (Index v = 0; v < step.motion.vertex_count(); ++v)
    for (std::size_t i = 0; i < 3 * points; ++i)
      coordinates_.push_back(static_cast<std::int64_t>(step.motion.at(v)[i]));
  enumerate();
  std::sort(tests_.begin(), tests_.end(),
            [](const Test& x, const Test& y) { return x.kind != y.kind ? x.kind < y.kind : x.vertices < y.vertices; });
}

void LatticeTests::enumerate() {
  const Features& features = step_.features();
  for (Index v = 0; v < features.vertex_slots(); ++v) {
    if (features.vertex_elements(v).empty()) continue;
    for (Index f = 0; f < features.triangle_slots(); ++f)
      if (!features.triangle_elements(f).empty()) add(FeatureKind::vf, {v, f});
  }
  for (Index a = 0; a < features.edge_slots(); ++a) {
    if (features.edge_elements(a).empty()) continue;
    for (Index b = a + 1; b < features.edge_slots(); ++b)
      if (!features.edge_elements(b).empty()) add(FeatureKind::ee, {a, b});
  }
}

void LatticeTests::add(FeatureKind kind, FeaturePair pair) {
  if (!is_test(step_.features(), kind, pair)) return;
  const std::array<Index, 4> vertices = test_vertices(step_.features(), kind, pair);
  if (apart(kind, vertices)) return;
  if (step_.filter.trivial() || is_included(step_, kind, pair)) tests_.push_back({kind, pair, vertices, std::nullopt});
}

bool LatticeTests::apart(FeatureKind kind, const std::array<Index, 4>& vertices) const {
  Points p{
      step_.separation, static_cast<std::size_t>(step_.motion.control_points()), kind == FeatureKind::vf ? 1u : 2u, {}};
  for (std::size_t v = 0; v < 4; ++v)
    for (std::size_t i = 0; i < p.count; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        p.at[v][i][axis] = coordinates_[(vertices[v] * p.count + i) * 3 + axis];
  const auto separates = [&](const Vector& normal) { return p.separated(normal); };
  return std::ranges::any_of(kAxes, separates) || p.never_coplanar() || std::ranges::any_of(kDiagonals, separates) ||
         separated_by_normals(kind, p);
}

bool LatticeTests::in_contact(Test& test) const {
  if (!test.toi) {
    const TestMotion motion = motion_of(step_, test.kind, test.vertices);
    const ExactAnswer answer = exact_first_touch(motion, step_.t_max, step_.separation);
    test.toi = answer.touches ? answer.toi : -1;
  }
  return *test.toi >= 0;
}

std::string LatticeTests::problem(std::span<const Contact> contacts) {
  const auto name = [](const char* what, FeatureKind kind, const std::array<Index, 4>& v) {
    return fmt::format("{} {} {} {} {} {}", what, kind == FeatureKind::vf ? "VF" : "EE", v[0], v[1], v[2], v[3]);
  };
  auto next = contacts.begin();
  for (Test& test : tests_) {
    const auto order = [&] { return std::pair(next->kind, next->vertices) <=> std::pair(test.kind, test.vertices); };
    if (next != contacts.end() && order() < 0) break;
    if (next != contacts.end() && order() == 0)
      ++next;
    else if (in_contact(test))
      return name("misses", test.kind, test.vertices) + fmt::format(" at {:a} = {}", *test.toi, *test.toi);
  }
  if (next == contacts.end()) return {};
  return name("reports without reason", next->kind, next->vertices);
}

}  // namespace volccd::fuzz
