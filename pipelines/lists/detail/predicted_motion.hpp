// Where vertices are expected to be in the next steps, and how far a motion is from it.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/features.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::detail {

/// Straight lines P(tau), 0 <= tau <= 1, one for each vertex. A motion q is within b of P if there are tau0 and tau1 in
/// [0, 1] such that all its control points are within b of P between these times: |q_i - P(tau0 + i/n (tau1 - tau0))|
/// <= b for the control points i = 0 .. n of each vertex. Then |q(t) - P(tau0 + t (tau1 - tau0))| <= b at all t, since
/// both are Bezier curves of degree n, and their difference is in the convex hull of those of its control points.
/// Vertices that no element uses do not count. Not thread-safe.
class PredictedMotion {
 public:
  struct Interval {
    double begin = 0, end = 0;
  };

  /// The motion goes on for `steps` steps as from its first to its last control points: P(0) is its start, P(1 / steps)
  /// its end. With 0 steps, P rests at the end. Returns whether P(1) is finite and small enough for distance().
  /// O(vertices).
  bool set(const Motion& motion, double steps, const Features& features);

  /// Sets new lines for some vertices: where the motion is between these times, going on in the same way, or at rest if
  /// they would then go further than the longest line. Vertices that were appended to the mesh are to be among them.
  /// Returns as set().
  bool renew(const Motion& motion, Interval at, std::span<const Index> vertices);

  const Motion& lines() const { return lines_; }

  /// The times at which a sample of fast vertices is nearest to the start and to the end of the motion.
  Interval nearest(const Motion& motion) const;

  /// An upper bound of the distances |q_i - P(...)| between these times, rounding included; infinite if they are too
  /// large. Pre: the motion has the vertices of P.
  double distance(const Motion& motion, const Features& features, Interval at, Executor& executor);

  std::size_t bytes() const { return heap_bytes(lines_, sample_, speeds_, worst_); }

 private:
  bool set_line(Index v, const Vec3& from, const Vec3& to);
  double square_distance(const Motion& motion, Index v, const double (&times)[3]) const;
  void choose_sample(const Features& features);

  Motion lines_;
  std::vector<Index> sample_;                     ///< vertices for nearest()
  std::vector<std::pair<double, Index>> speeds_;  ///< scratch memory of choose_sample()
  std::vector<double> worst_;                     ///< by worker: scratch memory of distance()
  double length_ = 0;                             ///< of the longest line, from P(0) to P(1)
  double largest_ = 0;                            ///< coordinate
  double rounding_ = 0;                           ///< bound of the error of a computed point of P
};

}  // namespace volccd::detail
