#include <volccd/experiments/scenes/geometry/tetrahedra.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/geometry/relax_tetrahedra.hpp>

namespace volccd {

namespace {

using Tetrahedron = std::array<Index, 4>;

/// If the surface crosses an edge nearer to a lattice point than this fraction of the edge, the lattice point is moved
/// onto the surface.
constexpr double kLongPull = 0.24999, kShortPull = 0.41189;
/// If no point of a part is deeper below the surface than this fraction of `edge`, the part is thin.
constexpr double kThin = 0.55;

/// Steps to the neighbours of a lattice point: 6 along long edges, 8 along short ones.
constexpr int kNeighbours[14][3] = {{2, 0, 0},  {-2, 0, 0},  {0, 2, 0},   {0, -2, 0},  {0, 0, 2},
                                    {0, 0, -2}, {1, 1, 1},   {-1, 1, 1},  {1, -1, 1},  {-1, -1, 1},
                                    {1, 1, -1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, -1}};

/// The points of a body-centred cubic lattice, in coordinates of half a cell: corners have even ones, centres odd ones.
class Lattice {
 public:
  Lattice(const ImplicitSolid& solid, double edge) : half_(edge / 2) {
    // There is one layer of cells around the box, so that every lattice point at which an edge is cut has all its
    // neighbours.
    const Vec3 cells = ((solid.high - solid.low) / edge).array().ceil() + 2;
    if (!(edge > 0) || !(cells.minCoeff() >= 2)) throw ConfigError("tetrahedra: edge length or box not positive");
    if (cells.prod() > 1e7) throw ConfigError("tetrahedra: edge length too small for the size of the solid");
    for (int c = 0; c < 3; ++c) cells_[c] = static_cast<int>(cells[c]);
    // The origin is not symmetric to the box. Otherwise, a symmetric solid would gain or lose many tetrahedra at once
    // when the edge length changes.
    origin_ = (solid.low + solid.high) / 2 - half_ * (cells + Vec3(0.31, 0.53, 0.73));
  }

  int cells(int axis) const { return cells_[static_cast<std::size_t>(axis)]; }
  std::size_t size() const { return index(2 * cells(0), 2 * cells(1), 2 * cells(2)) + 1; }
  /// Points that are neither corners nor centres have an index, too, but it is never used.
  std::size_t index(int x, int y, int z) const {
    const auto s = [](int i) { return static_cast<std::size_t>(i); };
    return (s(z) * s(2 * cells(1) + 1) + s(y)) * s(2 * cells(0) + 1) + s(x);
  }
  Vec3 place(int x, int y, int z) const { return origin_ + half_ * Vec3(x, y, z); }
  Vec3 place(std::size_t i) const {
    const std::size_t row = static_cast<std::size_t>(2 * cells(0) + 1),
                      column = static_cast<std::size_t>(2 * cells(1) + 1);
    return place(static_cast<int>(i % row), static_cast<int>(i / row % column), static_cast<int>(i / row / column));
  }

  /// Calls visitor(x, y, z) for all corners and centres.
  template <class Visitor>
  void for_each(Visitor&& visitor) const {
    for (int z = 0; z <= 2 * cells(2); ++z)
      for (int y = z % 2; y <= 2 * cells(1); y += 2)
        for (int x = z % 2; x <= 2 * cells(0); x += 2) visitor(x, y, z);
  }

  /// Calls visitor(index, n) for the neighbours, in the order of kNeighbours.
  template <class Visitor>
  void for_each_neighbour(int x, int y, int z, Visitor&& visitor) const {
    const auto is_in = [&](int i, int axis) { return i >= 0 && i <= 2 * cells(axis); };
    for (int n = 0; n < 14; ++n) {
      const int p = x + kNeighbours[n][0], q = y + kNeighbours[n][1], r = z + kNeighbours[n][2];
      if (is_in(p, 0) && is_in(q, 1) && is_in(r, 2)) visitor(index(p, q, r), n);
    }
  }

 private:
  std::array<int, 3> cells_{};
  double half_;
  Vec3 origin_;
};

class Stuffing {
 public:
  Stuffing(const ImplicitSolid& solid, double edge)
      : solid_(solid),
        lattice_(solid, edge),
        value_(lattice_.size(), 1.0),
        thin_(lattice_.size(), false),
        vertex_(lattice_.size(), kNone) {
    lattice_.for_each([&](int x, int y, int z) {
      double& value = value_[lattice_.index(x, y, z)];
      value = solid_.value(lattice_.place(x, y, z));
      if (!std::isfinite(value)) throw ConfigError("tetrahedra: the solid's function is not finite");
    });
    mark_thin_parts(edge);
    pull_to_surface();
    // There are four tetrahedra around the line between two neighbouring centres.
    for (int z = 1; z < 2 * lattice_.cells(2); z += 2)
      for (int y = 1; y < 2 * lattice_.cells(1); y += 2)
        for (int x = 1; x < 2 * lattice_.cells(0); x += 2)
          for (int axis = 0; axis < 3; ++axis)
            if ((axis == 0 ? x : axis == 1 ? y : z) + 2 < 2 * lattice_.cells(axis)) stuff_around({x, y, z}, axis);
  }

  std::vector<Vec3> positions;
  std::vector<Tetrahedron> tetrahedra;

 private:
  /// A corner of a lattice tetrahedron.
  using Corner = std::size_t;

  /// The point at which the surface crosses the edge from inside (value < 0) to outside, as a fraction of the edge,
  /// found by the Illinois method. If the solid is thin there, the point keeps a distance from the inner end, which is
  /// not moved.
  double crossing(Corner inside, Corner outside, bool is_long) const {
    const double share = true_crossing(inside, outside);
    return thin_[inside] ? std::max(share, is_long ? kLongPull : kShortPull) : share;
  }

  double true_crossing(Corner inside, Corner outside) const {
    const Vec3 a = lattice_.place(inside), b = lattice_.place(outside);
    double low = 0, high = 1, at_low = value_[inside], at_high = value_[outside], middle = 0.5;
    for (int i = 0; i < 12 && high - low > 1e-4; ++i) {
      middle = low + (high - low) * std::clamp(at_low / (at_low - at_high), 0.02, 0.98);
      const double value = solid_.value(a + middle * (b - a));
      if (value == 0) break;
      if (value < 0) {
        low = middle;
        at_low = value;
        at_high /= 2;
      } else {
        high = middle;
        at_high = value;
        at_low /= 2;
      }
    }
    return middle;
  }

  /// Marks the inside points that are not deep and have no deep neighbour. They lie in the middle of a thin part, and
  /// must not be moved onto its surface. (Below a flat surface, each point has a neighbour that is at least 0.7 edges
  /// deep.)
  void mark_thin_parts(double edge) {
    lattice_.for_each([&](int x, int y, int z) {
      const Corner here = lattice_.index(x, y, z);
      double deepest = value_[here];
      lattice_.for_each_neighbour(x, y, z, [&](Corner other, int) { deepest = std::min(deepest, value_[other]); });
      thin_[here] = value_[here] < 0 && deepest > -kThin * edge;
    });
  }

  /// Moves each lattice point that is too near to a crossing onto the nearest such crossing. Then none of its edges is
  /// cut.
  void pull_to_surface() {
    lattice_.for_each([&](int x, int y, int z) {
      const Corner here = lattice_.index(x, y, z);
      if (thin_[here]) return;
      double nearest = std::numeric_limits<double>::infinity();
      Vec3 place = Vec3::Zero();
      lattice_.for_each_neighbour(x, y, z, [&](Corner other, int n) {
        if (!(value_[here] * value_[other] < 0)) return;
        const double share = value_[here] < 0 ? crossing(here, other, n < 6) : 1 - crossing(other, here, n < 6);
        const Vec3 edge = lattice_.place(other) - lattice_.place(here);
        if (share < (n < 6 ? kLongPull : kShortPull) && share * edge.norm() < nearest) {
          nearest = share * edge.norm();
          place = lattice_.place(here) + share * edge;
        }
      });
      if (nearest == std::numeric_limits<double>::infinity()) return;
      value_[here] = 0;
      vertex_[here] = new_vertex(place);
    });
  }

  void stuff_around(std::array<int, 3> centre, int axis) {
    const auto at = [&](int along, int side, int up) {
      std::array<int, 3> p = centre;
      p[static_cast<std::size_t>(axis)] += along;
      p[static_cast<std::size_t>((axis + 1) % 3)] += side;
      p[static_cast<std::size_t>((axis + 2) % 3)] += up;
      return lattice_.index(p[0], p[1], p[2]);
    };
    constexpr int ring[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    const Corner first = at(0, 0, 0), second = at(2, 0, 0);
    for (int i = 0; i < 4; ++i) {
      const auto& [s0, u0] = ring[i];
      const auto& [s1, u1] = ring[(i + 1) % 4];
      stuff({first, second, at(1, s0, u0), at(1, s1, u1)});
    }
  }

  /// Fills the part of a lattice tetrahedron that is inside. `t` has positive volume; its long edges are 0-1 and 2-3.
  void stuff(const std::array<Corner, 4>& t) {
    std::array<int, 4> order{};
    int count = 0, inside = 0, outside = 0;
    for (const int sign : {-1, 0, 1})
      for (int i = 0; i < 4; ++i) {
        const double value = value_[t[static_cast<std::size_t>(i)]];
        if ((value > 0) - (value < 0) != sign) continue;
        order[static_cast<std::size_t>(count++)] = i;
        inside += sign < 0;
        outside += sign > 0;
      }
    if (inside == 0) return;
    int swaps = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) swaps += order[i] > order[j];
    // With two or more points inside, their order is chosen such that the sorted tetrahedron has positive volume again.
    if (inside >= 2 && swaps % 2 == 1) std::swap(order[0], order[1]);
    if (outside == 0 || inside == 1) return emit_corner(t, order, inside >= 2 || swaps % 2 == 0);
    const auto c = [&](std::size_t i) { return t[static_cast<std::size_t>(order[i])]; };
    const auto partners = [&](std::size_t i, std::size_t j) { return (order[i] ^ 1) == order[j]; };
    if (inside == 2 && outside == 1) emit_pyramid(c(0), c(1), c(2), c(3), partners(0, 3), partners(1, 3));
    if (inside == 2 && outside == 2) emit_ridge({c(0), c(1), c(2), c(3)}, partners(0, 2), partners(0, 3));
    if (inside == 3) {
      // The long edge that is cut is moved to the first place.
      while ((order[0] ^ 1) != order[3]) std::rotate(order.begin(), order.begin() + 1, order.begin() + 3);
      emit_frustum({c(0), c(1), c(2)}, c(3));
    }
  }

  /// One tetrahedron, if no corner is outside or one corner is inside.
  void emit_corner(const std::array<Corner, 4>& t, const std::array<int, 4>& order, bool positive) {
    Tetrahedron out{};
    for (std::size_t i = 0; i < 4; ++i) {
      const Corner c = t[static_cast<std::size_t>(order[i])];
      out[i] = value_[c] > 0 ? cut(t[static_cast<std::size_t>(order[0])], c) : corner(c);
    }
    if (!positive) std::swap(out[2], out[3]);
    tetrahedra.push_back(out);
  }

  /// Corners a and b are inside, o is on the surface, c is outside.
  void emit_pyramid(Corner a, Corner b, Corner o, Corner c, bool long_ac, bool long_bc) {
    const Index ac = cut(a, c), bc = cut(b, c), va = corner(a), vb = corner(b), vo = corner(o);
    if (diagonal_from_a(va, vb, ac, bc, long_ac, long_bc)) {
      tetrahedra.push_back({va, vb, vo, bc});
      tetrahedra.push_back({va, bc, vo, ac});
    } else {
      tetrahedra.push_back({va, vb, vo, ac});
      tetrahedra.push_back({vb, bc, vo, ac});
    }
  }

  /// Corners 0 and 1 are inside, 2 and 3 are outside; the volume is positive.
  void emit_ridge(const std::array<Corner, 4>& c, bool long_02, bool long_03) {
    const Index a = corner(c[0]), b = corner(c[1]);
    const std::array<Index, 3> p = {a, cut(c[0], c[2]), cut(c[0], c[3])}, q = {b, cut(c[1], c[2]), cut(c[1], c[3])};
    // If 0-1 is a short edge, one long edge is cut on each of the two faces: 0-2 and 1-3, or 0-3 and 1-2.
    const bool first = diagonal_from_a(a, b, p[1], q[1], long_02, long_03);
    const bool second = diagonal_from_a(a, b, p[2], q[2], long_03, long_02);
    bool third = second;  // the diagonal of the quad on the surface; the three must not form a cycle
    if (first == second) third = shorter(p[1], q[2], p[2], q[1]);
    emit_prism(p, q, {first, third, second});
  }

  /// The corners in `c` are inside; c[0] and `outside` are the ends of a long edge. The volume is positive.
  void emit_frustum(const std::array<Corner, 3>& c, Corner outside) {
    const std::array<Index, 3> p = {corner(c[0]), corner(c[1]), corner(c[2])};
    const std::array<Index, 3> q = {cut(c[0], outside), cut(c[1], outside), cut(c[2], outside)};
    emit_prism(p, q, {false, diagonal_from_a(p[1], p[2], q[1], q[2], false, false), false});
  }

  /// How a face with corners a, b inside and c outside is divided, which is the same for both of its tetrahedra: true
  /// if the diagonal of the quad a, b, bc, ac starts at a. The diagonal starts at the crossing on the long edge if
  /// there is one; otherwise the shorter diagonal is chosen.
  bool diagonal_from_a(Index a, Index b, Index ac, Index bc, bool long_ac, bool long_bc) const {
    if (long_ac) return false;
    if (long_bc) return true;
    return shorter(a, bc, b, ac);
  }

  /// Whether line v0-v1 is shorter than w0-w1. Lengths that differ by rounding only count as equal; then the line with
  /// the smallest vertex counts as the shorter one.
  bool shorter(Index v0, Index v1, Index w0, Index w1) const {
    const double v = (positions[v0] - positions[v1]).norm(), w = (positions[w0] - positions[w1]).norm();
    if (std::abs(v - w) > 1e-9 * (v + w)) return v < w;
    return std::min(v0, v1) < std::min(w0, w1);
  }

  /// A prism with the triangles p (positive as seen from q) and q. If rule[0], the diagonal of the quad 0-1 is p0-q1,
  /// else p1-q0; rule[1] is the same for the quad 1-2; if rule[2], the diagonal of the quad 0-2 is p0-q2, else p2-q0.
  /// The rules must not form a cycle, so that the three columns have an order.
  void emit_prism(const std::array<Index, 3>& p, const std::array<Index, 3>& q, const std::array<bool, 3>& rule) {
    std::array<std::size_t, 3> column{};
    column[static_cast<std::size_t>(!rule[0]) + static_cast<std::size_t>(!rule[2])] = 0;
    column[static_cast<std::size_t>(rule[0]) + static_cast<std::size_t>(!rule[1])] = 1;
    column[static_cast<std::size_t>(rule[2]) + static_cast<std::size_t>(rule[1])] = 2;
    const auto [i, j, k] = column;
    const bool even = (j + 3 - i) % 3 == 1;
    const auto emit = [&](Index a, Index b, Index c, Index d) {
      tetrahedra.push_back(even ? Tetrahedron{a, b, c, d} : Tetrahedron{b, a, c, d});
    };
    emit(p[i], p[j], p[k], q[k]);
    emit(p[i], p[j], q[k], q[j]);
    emit(p[i], q[i], q[j], q[k]);
  }

  Index corner(Corner c) {
    if (vertex_[c] == kNone) vertex_[c] = new_vertex(lattice_.place(c));
    return vertex_[c];
  }

  Index cut(Corner inside, Corner outside) {
    const auto [place, is_new] = cuts_.try_emplace(inside * lattice_.size() + outside, kNone);
    if (is_new) {
      const Vec3 a = lattice_.place(inside);
      const Vec3 edge = lattice_.place(outside) - a;
      // Long edges are parallel to an axis.
      const bool is_long = (edge.array() != 0).count() == 1;
      place->second = new_vertex(a + crossing(inside, outside, is_long) * edge);
    }
    return place->second;
  }

  Index new_vertex(const Vec3& place) {
    positions.push_back(place);
    return static_cast<Index>(positions.size() - 1);
  }

  const ImplicitSolid& solid_;
  Lattice lattice_;
  std::vector<double> value_;  ///< by lattice index
  std::vector<bool> thin_;     ///< by lattice index
  std::vector<Index> vertex_;  ///< by lattice index; kNone: not used so far
  std::unordered_map<std::size_t, Index> cuts_;
};

/// For each tetrahedron, the smallest index of a tetrahedron in its piece, that is, connected with it through faces.
std::vector<Index> pieces(const std::vector<Tetrahedron>& tetrahedra) {
  std::vector<std::pair<std::array<Index, 3>, Index>> faces;
  for (Index t = 0; t < tetrahedra.size(); ++t)
    for (std::size_t skip = 0; skip < 4; ++skip) {
      Tetrahedron sorted = tetrahedra[t];
      std::swap(sorted[skip], sorted[3]);
      std::sort(sorted.begin(), sorted.begin() + 3);
      faces.push_back({{sorted[0], sorted[1], sorted[2]}, t});
    }
  std::sort(faces.begin(), faces.end());
  std::vector<Index> root(tetrahedra.size());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index t) {
    while (root[t] != t) t = root[t] = root[root[t]];
    return t;
  };
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].first == faces[i - 1].first) {
      const Index a = find(faces[i].second), b = find(faces[i - 1].second);
      root[std::max(a, b)] = std::min(a, b);
    }
  for (Index t = 0; t < tetrahedra.size(); ++t) root[t] = find(t);
  return root;
}

/// The largest piece, with its vertices renumbered in ascending order.
void keep_largest_piece(std::vector<Vec3>& positions, std::vector<Tetrahedron>& tetrahedra) {
  const std::vector<Index> piece = pieces(tetrahedra);
  std::vector<Index> size(tetrahedra.size(), 0);
  for (const Index p : piece) ++size[p];
  const auto largest = static_cast<Index>(std::max_element(size.begin(), size.end()) - size.begin());
  std::vector<Index> number(positions.size(), kNone);
  std::size_t kept = 0;
  for (Index t = 0; t < piece.size(); ++t) {
    if (piece[t] != largest) continue;
    for (const Index v : tetrahedra[t]) number[v] = 0;
    tetrahedra[kept++] = tetrahedra[t];
  }
  tetrahedra.resize(kept);
  Index vertices = 0;
  for (Index v = 0; v < positions.size(); ++v)
    if (number[v] != kNone) {
      positions[vertices] = positions[v];
      number[v] = vertices++;
    }
  positions.resize(vertices);
  for (Tetrahedron& t : tetrahedra)
    for (Index& v : t) v = number[v];
}

Stuffing stuff(const ImplicitSolid& solid, double edge) {
  Stuffing stuffing(solid, edge);
  if (!stuffing.tetrahedra.empty()) keep_largest_piece(stuffing.positions, stuffing.tetrahedra);
  return stuffing;
}

Shape finish(const ImplicitSolid& solid, Stuffing stuffing) {
  if (stuffing.tetrahedra.empty()) throw ConfigError("tetrahedra: edge length too large, nothing fits into the solid");
  relax_tetrahedra(solid, stuffing.positions, stuffing.tetrahedra);
  Shape shape;
  shape.positions = std::move(stuffing.positions);
  for (const Tetrahedron& t : stuffing.tetrahedra)
    shape.elements.push_back({.type = ElementType::tetrahedron,
                              .vertices = {t.begin(), t.end()},
                              .id = static_cast<std::int64_t>(shape.elements.size())});
  return shape;
}

}  // namespace

Shape fill_with_tetrahedra(const ImplicitSolid& solid, double edge) { return finish(solid, stuff(solid, edge)); }

Shape fill_with_about(const ImplicitSolid& solid, int elements, double* edge) {
  if (elements < 1) throw ConfigError("tetrahedra: the number of elements must be positive");
  const double wanted = elements;
  // A cell of the lattice has twelve tetrahedra, and those at the surface are smaller.
  double trial = std::cbrt(6 * (solid.high - solid.low).prod() / wanted), best = trial;
  double best_error = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 24 && best_error > 0.003; ++i) {
    const double count = std::max<double>(1, static_cast<double>(stuff(solid, trial).tetrahedra.size()));
    if (const double error = std::abs(count - wanted) / wanted; error < best_error) {
      best_error = error;
      best = trial;
    }
    // The first trials go straight to the edge length with the required count. The count jumps up and down near it, so
    // that later trials are taken on both sides of the best one.
    if (i < 4)
      trial *= std::clamp(std::cbrt(count / wanted), 0.4, 2.5);
    else
      trial = best * (1 + (i % 2 == 0 ? 4e-3 : -4e-3) * (i / 2 - 1));
  }
  if (edge) *edge = best;
  return fill_with_tetrahedra(solid, best);
}

}  // namespace volccd
