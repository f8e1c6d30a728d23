// Positions of the vertices during a step: Bezier control points over t in [0,1].
#pragma once

#include <span>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

/// Two control points per vertex: constant velocity (Section 3.1). Three control points: constant acceleration (Section
/// 7.1). Layout: [vertex][control point][axis]; the control points of a vertex are contiguous, so that reading them
/// touches one or two cache lines. Positions are doubles and are regarded as exact. Vertices that no element uses may
/// have any finite positions.
class Motion {
 public:
  Motion() = default;
  Motion(Index vertices, int control_points);

  /// Straight lines from x0 to x1, both of size [vertices]. Throws InputError (source "motion", dataset "x0" or "x1",
  /// index) if a coordinate is not finite, or if the arrays have different lengths.
  static Motion linear(std::span<const Vec3> x0, std::span<const Vec3> x1);
  /// The same as linear() for this object. No allocation if the number of vertices is unchanged.
  void set_linear(std::span<const Vec3> x0, std::span<const Vec3> x1);
  /// Quadratic Bezier curves with middle control points xm (which are not points of the curves).
  static Motion quadratic(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1);
  /// The same as quadratic() for this object. No allocation if the number of vertices and the degree are unchanged.
  void set_quadratic(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1);

  /// The part of another motion between two of its times, as a motion of its own: the same curves, but for rounding.
  /// Parts that follow each other agree at their common time. No allocation if vertices and degree are unchanged.
  void set_part(const Motion& whole, double begin, double end);

  Index vertex_count() const { return vertices_; }
  int control_points() const { return control_points_; }
  int degree() const { return control_points_ - 1; }

  /// 3 * control_points() doubles: x, y, z of the first control point, then of the next one.
  const double* at(Index v) const { return data_.data() + std::size_t{v} * stride(); }
  Vec3 point(Index v, int control_point) const { return Eigen::Map<const Vec3>(at(v) + 3 * control_point); }
  void set(Index v, int control_point, const Vec3& p) {
    Eigen::Map<Vec3>(data_.data() + std::size_t{v} * stride() + 3 * static_cast<std::size_t>(control_point)) = p;
  }

  /// Position at t by de Casteljau's algorithm; exact at t = 0 and t = 1, rounded in between.
  Vec3 position(Index v, double t) const;

  std::size_t bytes() const { return heap_bytes(data_); }

 private:
  std::size_t stride() const { return 3 * static_cast<std::size_t>(control_points_); }

  Index vertices_ = 0;
  int control_points_ = 2;
  std::vector<double> data_;
};

}  // namespace volccd
