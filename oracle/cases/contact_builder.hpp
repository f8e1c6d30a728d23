// Builds tests whose features touch by construction; used by the generators of this folder.
#pragma once

#include <algorithm>
#include <optional>

#include <volccd/oracle/cases/near_degenerate.hpp>

#include <volccd/query/pairs.hpp>

namespace volccd::cases {

/// Position, velocity and half the acceleration of a point at the time of contact. They are dyadic numbers of few bits,
/// so that values computed from them are exact.
struct Path {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero(), a = Vec3::Zero();

  friend Path operator+(const Path& p, const Path& q) { return {p.x + q.x, p.v + q.v, p.a + q.a}; }
  friend Path operator*(double w, const Path& p) { return {w * p.x, w * p.v, w * p.a}; }
  Curve curve(int control_points, double t) const;
};

/// A pair of features that touch at a dyadic time, at points with dyadic weights. Each further operation preserves this
/// exactly, or sets Case::touch to "not known". Coordinates are multiples of 2^-10, below 2^40, until they are scaled
/// or moved.
class ContactBuilder {
 public:
  /// `time`: time of contact; chosen at random if it is not given.
  ContactBuilder(Choices& choices, FeatureKind kind, int control_points, std::optional<double> time = {});

  Case& made() { return case_; }
  Case build() { return std::move(case_); }

  /// Makes the features; must be called first.
  enum class Shape {
    any,        ///< all kinds: they may touch at boundaries, move within a plane, or move along with each other
    general,    ///< they touch in the interior of both, and all points move freely
    degenerate  ///< triangles and edges without extent, parallel edges
  };
  void features(Shape shape = Shape::any) {
    if (shape == Shape::general) between_ = Between::nothing, speed_ = std::max(speed_, 1);
    case_.kind == FeatureKind::vf ? vertex_and_triangle(shape) : two_edges(shape);
  }
  /// Adds points around the features, up to `count` in the set.
  void fill(std::size_t set, std::size_t count);
  /// Moves the first set away by a vector of exactly known length, which becomes the separation.
  void move_apart();

  /// Applies an affine map without rounding.
  void transform();
  void scale();
  void scale_by(const Vec3& factors);
  /// Moves all points away from the origin by up to 1e8 in each coordinate, with rounding.
  void move_far();
  /// Changes a few coordinates by a few units in the last place.
  void nudge();
  void round_and_nudge();
  void reorder();

 private:
  /// How the features are separated.
  enum class Between {
    plane,    ///< the plane z = 0, at every control point; they touch in it
    nothing,  ///< nothing; in general, they pass through each other
    no_space  ///< nothing; they stay in the plane z = 0
  };

  void vertex_and_triangle(Shape shape);
  void two_edges(Shape shape);
  /// The last three of 8 shapes are degenerate.
  int choose(Shape shape) { return shape == Shape::any ? c_.below(8) : shape == Shape::general ? 0 : 5 + c_.below(3); }
  Vec3 lattice(int range) { return {c_.lattice(range), c_.lattice(range), c_.lattice(range)}; }
  Path path();
  Path meeting(const Path& contact, const Vec3& d, const Vec3& e, Shape shape);
  void add(std::size_t set, const Path& path, bool meets);
  Curve offsets(bool diagonal);
  template <class Visit>
  void for_each_point(Visit&& visit) {
    for (auto& set : case_.sets)
      for (Curve& p : set)
        for (std::size_t k = 0; k < 3; ++k) visit(p[k], k);
  }

  Choices& c_;
  Case case_;
  int range_, speed_;
  double t_, lift_ = 0;
  Between between_;
  Vec3 drift_;
};

}  // namespace volccd::cases
