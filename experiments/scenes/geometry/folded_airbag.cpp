#include <volccd/experiments/scenes/geometry/folded_airbag.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

/// The profile of the folded bag in the plane y = 0: the middle surface and its two offsets. Leg 0 is the middle of the
/// bag, leg k lies between folds k and k + 1, and the last leg ends at the rim. Only x >= 0 is described; the profile
/// is symmetric.
class Profile {
 public:
  explicit Profile(const AirbagShape& airbag) : half_gap_(airbag.gap / 2) {
    // At a fold where the slopes of two legs differ by `slope`, the outer sheet is longer by gap / slope.
    width_ = (airbag.radius - 0.02) / (airbag.folds + 1);
    bends_.push_back(0);
    bends_.push_back(airbag.radius - airbag.folds * width_);
    std::vector<double> slopes{0};
    std::vector<std::array<double, 2>> corners{{0, 0}, {bends_[1], 0}};
    for (int k = 1; k <= airbag.folds; ++k) {
      const double way = k % 2 == 1 ? -1 : 1, rise = k == 1 ? 1.6 * airbag.rise : airbag.rise;
      slopes.push_back(way * rise / width_);
      corners.push_back({corners.back()[0] + way * width_, corners.back()[1] + rise});
      bends_.push_back(bends_.back() + width_);
    }
    for (const int sheet : {0, 1}) {
      std::vector<std::array<double, 2>>& ends = ends_[static_cast<std::size_t>(sheet)];
      ends.push_back({0, offset(sheet, 0)});
      for (std::size_t k = 1; k < slopes.size(); ++k) {
        const int leg = static_cast<int>(k);
        const double x = (offset(sheet, leg) - offset(sheet, leg - 1)) / (slopes[k - 1] - slopes[k]);
        ends.push_back({corners[k][0] + x, corners[k][1] + slopes[k] * x + offset(sheet, leg)});
      }
      ends.push_back({corners.back()[0], corners.back()[1] + offset(sheet, static_cast<int>(slopes.size()) - 1)});
    }
    middle_ = corners;
  }

  /// Distances from the middle of the flat bag at which the legs begin; the last entry is the radius.
  const std::vector<double>& bends() const { return bends_; }

  /// The position of the point (x, y) of a flat sheet after folding. Both sheets have the same position if `on_rim`.
  Vec3 place(int sheet, bool on_rim, double x, double y) const {
    const auto& ends = on_rim ? middle_ : ends_[static_cast<std::size_t>(sheet)];
    const double s = std::abs(x);
    std::size_t leg = 0;
    while (leg + 2 < bends_.size() && s > bends_[leg + 1]) ++leg;
    const double t = (s - bends_[leg]) / (bends_[leg + 1] - bends_[leg]);
    const double across = (1 - t) * ends[leg][0] + t * ends[leg + 1][0];
    return {std::copysign(across, x), y, (1 - t) * ends[leg][1] + t * ends[leg + 1][1]};
  }

 private:
  /// The upper sheet becomes the lower one at each fold.
  double offset(int sheet, int leg) const { return (sheet + leg) % 2 == 0 ? -half_gap_ : half_gap_; }

  double half_gap_, width_;
  std::vector<double> bends_;
  std::vector<std::array<double, 2>> middle_;
  std::array<std::vector<std::array<double, 2>>, 2> ends_;
};

/// A disc, triangulated such that the lines x = const at the bends consist of edges.
class FlatDisc {
 public:
  FlatDisc(double radius, const std::vector<double>& bends, double spacing) : radius_(radius), spacing_(spacing) {
    std::vector<double> half;
    for (std::size_t k = 0; k + 1 < bends.size(); ++k) {
      const double length = bends[k + 1] - bends[k];
      const int columns = std::max(k == 0 ? 1 : 2, static_cast<int>(std::lround(length / (spacing * kRowHeight))));
      for (int i = 0; i < columns; ++i) half.push_back(bends[k] + length * i / columns);
      is_bend_.resize(half.size(), 0);
      if (k > 0) is_bend_[half.size() - static_cast<std::size_t>(columns)] = 1;
    }
    const int n = static_cast<int>(half.size());
    std::vector<Index> previous;
    for (int j = 1 - n; j < n; ++j) {
      const auto at = static_cast<std::size_t>(std::abs(j));
      std::vector<Index> column = add_column(std::copysign(half[at], j), is_bend_[at] != 0, (j + n) % 2);
      if (previous.empty()) {
        join(rim_between(column.front(), column.back(), true), column);
      } else {
        join(with_rim(previous, column), with_rim(column, previous));
      }
      previous = std::move(column);
    }
    join(previous, rim_between(previous.front(), previous.back(), false));
  }

  struct Point {
    double x, y;
    bool on_rim, on_bend;
  };
  const std::vector<Point>& points() const { return points_; }
  const std::vector<std::array<Index, 3>>& triangles() const { return triangles_; }

  /// Moves vertices that are neither on the rim nor on a bend, and flips edges, to make the triangles more regular.
  void relax() {
    for (int round = 0; round < 8; ++round) {
      for (int pass = 0; pass < 10 && flip_edges(); ++pass) {
      }
      move_to_neighbours(3);
    }
    for (int pass = 0; pass < 10 && flip_edges(); ++pass) {
    }
  }

 private:
  static constexpr double kRowHeight = 0.87;  // height of equilateral triangles, in edge lengths

  /// Moves each vertex to the centroid of its neighbours; a vertex on a bend moves along the bend only.
  void move_to_neighbours(int rounds) {
    for (int round = 0; round < rounds; ++round) {
      std::vector<std::array<double, 3>> sums(points_.size(), {0, 0, 0});
      for (const auto& t : triangles_)
        for (std::size_t i = 0; i < 3; ++i) {
          const Point& q = points_[t[(i + 1) % 3]];
          std::array<double, 3>& sum = sums[t[i]];  // each inner edge is visited once in either direction
          sum[0] += q.x, sum[1] += q.y, sum[2] += 1;
        }
      for (std::size_t v = 0; v < points_.size(); ++v) {
        Point& p = points_[v];
        if (p.on_rim) continue;
        if (!p.on_bend) p.x = sums[v][0] / sums[v][2];
        p.y = sums[v][1] / sums[v][2];
      }
    }
  }

  double turn(Index a, Index b, Index c) const {
    const Point &p = points_[a], &q = points_[b], &r = points_[c];
    return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  }
  /// Angle at c, between a and b.
  double corner(Index a, Index b, Index c) const {
    const Point &p = points_[a], &q = points_[b], &r = points_[c];
    return std::atan2(std::abs(turn(a, b, c)), (p.x - r.x) * (q.x - r.x) + (p.y - r.y) * (q.y - r.y));
  }

  /// Whether edge (a, b), between triangles with third vertices c and d, is to be replaced by (c, d): the Delaunay
  /// criterion.
  bool should_flip(Index a, Index b, Index c, Index d) const {
    const Point &p = points_[a], &q = points_[b];
    if (p.on_bend && q.on_bend && p.x == q.x) return false;
    if (points_[c].on_rim && points_[d].on_rim) return false;
    return corner(a, b, c) + corner(a, b, d) > std::numbers::pi + 1e-6;
  }

  /// Makes one pass, in which each triangle takes part in at most one flip. Returns false if nothing changed.
  bool flip_edges() {
    struct Side {
      Index a, b;
      std::size_t triangle;
      Index apex;
    };
    std::vector<Side> sides;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& v = triangles_[t];
        sides.push_back({std::min(v[i], v[(i + 1) % 3]), std::max(v[i], v[(i + 1) % 3]), t, v[(i + 2) % 3]});
      }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
      return std::tie(x.a, x.b, x.triangle) < std::tie(y.a, y.b, y.triangle);
    });
    std::vector<char> done(triangles_.size(), 0);
    bool changed = false;
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      const Side &s = sides[i], &o = sides[i + 1];
      if (s.a != o.a || s.b != o.b || done[s.triangle] || done[o.triangle]) continue;
      if (!should_flip(s.a, s.b, s.apex, o.apex)) continue;
      const bool left = turn(s.a, s.b, s.apex) > 0;
      const Index c = left ? s.apex : o.apex, d = left ? o.apex : s.apex;
      triangles_[s.triangle] = {s.a, d, c};
      triangles_[o.triangle] = {s.b, c, d};
      done[s.triangle] = done[o.triangle] = 1;
      changed = true;
    }
    return changed;
  }

  Index add(double x, double y, bool on_rim, bool on_bend) {
    points_.push_back({x, y, on_rim, on_bend});
    return static_cast<Index>(points_.size() - 1);
  }

  /// Adds vertices from the lower rim to the upper one. Neighbouring columns have even and odd numbers of vertices, so
  /// that they interlock.
  std::vector<Index> add_column(double x, bool on_bend, int odd) {
    const double y = std::sqrt(radius_ * radius_ - x * x);
    const int n = 2 * std::max(1, static_cast<int>(std::lround(y / spacing_ - 0.5 * odd))) + odd;
    std::vector<Index> column;
    for (int i = 0; i <= n; ++i) column.push_back(add(x, y * (2.0 * i / n - 1), i == 0 || i == n, on_bend));
    return column;
  }

  double angle(Index v) const { return std::atan2(points_[v].y, points_[v].x); }

  /// Adds vertices that divide the rim between two angles, without its ends.
  std::vector<Index> arc(double from, double to, int pieces) {
    std::vector<Index> result;
    for (int i = 1; i < pieces; ++i) {
      const double a = from + (to - from) * i / pieces;
      result.push_back(add(radius_ * std::cos(a), radius_ * std::sin(a), true, false));
    }
    return result;
  }
  int pieces(double from, double to) const {
    return std::max(1, static_cast<int>(std::lround(radius_ * std::abs(to - from) / spacing_)));
  }

  /// The vertices of the rim beyond the outermost column, from its lower to its upper end.
  std::vector<Index> rim_between(Index low, Index high, bool left) {
    const double turn = left ? 2 * std::numbers::pi : 0;
    const double from = angle(low) + turn, to = angle(high);
    return arc(from, to, std::max(3, pieces(from, to)));
  }

  /// The column, extended along the rim until it is as far out as the shorter column.
  std::vector<Index> with_rim(const std::vector<Index>& column, const std::vector<Index>& other) {
    if (std::abs(points_[column[0]].x) >= std::abs(points_[other[0]].x)) return column;
    const double turn = points_[other[0]].x < 0 ? 2 * std::numbers::pi : 0;  // avoids the discontinuity of atan2
    const double low = angle(column.front()) + turn, low_end = angle(other.front()) + turn;
    std::vector<Index> result = arc(low_end, low, pieces(low, low_end));
    result.insert(result.end(), column.begin(), column.end());
    const double high = angle(column.back()), high_end = angle(other.back());
    const std::vector<Index> upper = arc(high, high_end, pieces(high, high_end));
    result.insert(result.end(), upper.begin(), upper.end());
    return result;
  }

  /// Fills the strip between two chains with triangles, choosing the shorter diagonal each time. Only the edges at the
  /// ends of the chains may join two vertices of the rim, because the two sheets would share any other such edge.
  void join(const std::vector<Index>& left, const std::vector<Index>& right) {
    std::size_t i = 0, j = 0;
    while (i + 1 < left.size() || j + 1 < right.size()) {
      if (cost(left, i + 1, right, j) <= cost(right, j + 1, left, i)) {
        triangles_.push_back({left[i], right[j], left[i + 1]});
        ++i;
      } else {
        triangles_.push_back({left[i], right[j], right[j + 1]});
        ++j;
      }
    }
  }

  /// The cost of advancing to vertex `next` of a chain, which adds an edge from it to vertex `other` of the other
  /// chain.
  double cost(const std::vector<Index>& chain, std::size_t next, const std::vector<Index>& others,
              std::size_t other) const {
    if (next == chain.size()) return kImpossible;
    const Point &p = points_[chain[next]], &q = points_[others[other]];
    const bool last = next + 1 == chain.size(), other_last = other + 1 == others.size();
    if (p.on_rim && q.on_rim && !(last && other_last)) return kWrong;
    const bool strands = last && other + 2 < others.size() && points_[others[others.size() - 2]].on_rim;
    return strands ? kWrong : std::hypot(p.x - q.x, p.y - q.y);
  }
  static constexpr double kWrong = 1e9, kImpossible = 2e9;

  double radius_, spacing_;
  std::vector<char> is_bend_;
  std::vector<Point> points_;
  std::vector<std::array<Index, 3>> triangles_;
};

void check(const AirbagShape& airbag, double spacing) {
  if (!(airbag.radius > 0.05) || airbag.folds < 1 || !(airbag.gap > 0) || !(airbag.rise > airbag.gap) ||
      !(spacing > 0) || spacing > airbag.radius / (airbag.folds + 1))
    throw ConfigError("airbag: a size is out of range");
}

}  // namespace

Shape folded_airbag(const AirbagShape& airbag, double spacing) {
  check(airbag, spacing);
  const Profile profile(airbag);
  FlatDisc disc(airbag.radius, profile.bends(), spacing);
  disc.relax();
  Shape shape;
  std::array<std::vector<Index>, 2> vertex;
  for (const int sheet : {0, 1})
    for (std::size_t v = 0; v < disc.points().size(); ++v) {
      const FlatDisc::Point& p = disc.points()[v];
      const bool shared = sheet == 1 && p.on_rim;
      vertex[static_cast<std::size_t>(sheet)].push_back(shared ? vertex[0][v]
                                                               : static_cast<Index>(shape.positions.size()));
      if (!shared) shape.positions.push_back(profile.place(sheet, p.on_rim, p.x, p.y));
    }
  for (const int sheet : {0, 1})
    for (const auto& [a, b, c] : disc.triangles()) {
      const std::vector<Index>& of = vertex[static_cast<std::size_t>(sheet)];
      ElementSpec element{.type = ElementType::triangle,
                          .vertices = {of[a], of[b], of[c]},
                          .object = sheet,
                          .id = static_cast<std::int64_t>(shape.elements.size())};
      if (sheet == 0) std::swap(element.vertices[1], element.vertices[2]);
      shape.elements.push_back(std::move(element));
    }
  return shape;
}

Shape folded_airbag_of(const AirbagShape& airbag, int triangles) {
  const Profile profile(airbag);
  const double widest = airbag.radius / (airbag.folds + 1), area = 2 * std::numbers::pi * airbag.radius * airbag.radius;
  const double even = std::sqrt(area / triangles / 0.433);  // edge length of as many equilateral triangles
  double best = widest;
  std::int64_t best_error = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i <= 60; ++i) {  // the number of triangles jumps when columns change their numbers of vertices
    const double spacing = std::min(widest, even * (0.85 + 0.005 * i));
    const FlatDisc disc(airbag.radius, profile.bends(), spacing);
    const std::int64_t error = std::abs(2 * static_cast<std::int64_t>(disc.triangles().size()) - triangles);
    if (error < best_error) best_error = error, best = spacing;
  }
  return folded_airbag(airbag, best);
}

}  // namespace volccd
