#include <volccd/narrowphase/overlap/detail/hull_overlap.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <volccd/numerics/hull_simplex.hpp>
#include <volccd/numerics/rounding.hpp>

namespace volccd::detail {

void HullPoints::measure() {
  low = high = points.front();
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
}

void HullPoints::refer_to(const Vec3& reference) {
  extent = Vec3::Constant(kMinExtent);
  mean.setZero();
  for (int k = 0; k < 3; ++k) {
    rows[k].resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double difference = points[i][k] - reference[k];
      rows[k][i] = difference;
      extent[k] = std::max(extent[k], std::abs(difference));
      mean[k] += difference;
    }
  }
  mean /= static_cast<double>(points.size());
}

namespace {

using Simplex = HullSimplex<double>;
using Point = Vector3<double>;

class OverlapSearch {
 public:
  OverlapSearch(const HullPoints& a, const HullPoints& b, double distance)
      : a_(a), b_(b), distance_(distance), extent_(a.extent.cwiseMax(b.extent)) {
    const double greatest = extent_.maxCoeff();
    if (!(greatest < kGreatestMagnitude)) return;
    // A power of two, so that scaling is exact.
    scale_ = std::ldexp(1.0, -std::max(std::ilogb(greatest) + 1, -1000));
    in_range_ = true;
  }

  HullVerdict run(HullStart& start) {
    start.size = 0;
    if (!in_range_) return HullVerdict::close_call;
    HullVerdict verdict = step({b_.mean[0] - a_.mean[0], b_.mean[1] - a_.mean[1], b_.mean[2] - a_.mean[2]});
    for (int i = 1; i < kMaxSteps && verdict == HullVerdict::close_call && progress_; ++i)
      verdict = step(simplex_.direction);
    for (int i = 0; i < simplex_.size; ++i)
      start.names[static_cast<std::size_t>(start.size++)] = simplex_.names[static_cast<std::size_t>(i)];
    return verdict;
  }

 private:
  static constexpr int kMaxSteps = 24;

  /// Computes one support point along `direction`, and its consequences.
  HullVerdict step(const Point& direction) {
    const double greatest = std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
    // Any axis is suitable; if there is no direction, the first axis is used.
    const double inverse = 1 / greatest;
    const Point axis = greatest > 0 && std::isfinite(inverse)
                           ? Point{direction[0] * inverse, direction[1] * inverse, direction[2] * inverse}
                           : Point{1, 0, 0};
    const auto [i, high_a] = extreme<1>(a_, axis);
    const auto [j, low_b] = extreme<-1>(b_, axis);
    if (low_b - high_a > threshold(axis)) return HullVerdict::apart;
    const Vec3 difference = b_.points[static_cast<std::size_t>(j)] - a_.points[static_cast<std::size_t>(i)];
    const Point w{scale_ * difference[0], scale_ * difference[1], scale_ * difference[2]};
    if (difference == Vec3::Zero()) return HullVerdict::overlap;  // x - y is rounded to 0 only if x = y
    progress_ = simplex_.add(w, {i, j}) && simplex_.square > 0;
    return encloses_origin() || comes_close() ? HullVerdict::overlap : HullVerdict::close_call;
  }

  double threshold(const Point& axis) const {
    const double sum = std::abs(axis[0]) * extent_[0] + std::abs(axis[1]) * extent_[1] + std::abs(axis[2]) * extent_[2];
    return gap_error_factor(0) * sum + kGapUnderflow + separation_gap(distance_, axis[0], axis[1], axis[2]);
  }

  /// The vertex of greatest (kSign = 1) or smallest (-1) projection, and the projection.
  template <int kSign>
  static std::pair<int, double> extreme(const HullPoints& set, const Point& axis) {
    int best = 0;
    double max = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < set.points.size(); ++i) {
      const double p = kSign * (axis[0] * set.rows[0][i] + axis[1] * set.rows[1][i] + axis[2] * set.rows[2][i]);
      if (p > max) {
        max = p;
        best = static_cast<int>(i);
      }
    }
    return {best, kSign * max};
  }

  /// Whether four points certainly enclose the origin: all four determinants have the same sign, and their magnitudes
  /// exceed their bounds.
  bool encloses_origin() const {
    if (simplex_.size != 4) return false;
    for (std::size_t k = 0; k < 4; ++k) {
      const Point &p = simplex_.points[(k + 1) % 4], &q = simplex_.points[(k + 2) % 4],
                  &r = simplex_.points[(k + 3) % 4];
      const auto product = [](double x, double y, double z) { return std::abs(x) * std::abs(y) * std::abs(z); };
      const double permanent = product(p[0], q[1], r[2]) + product(p[0], q[2], r[1]) + product(p[1], q[2], r[0]) +
                               product(p[1], q[0], r[2]) + product(p[2], q[0], r[1]) + product(p[2], q[1], r[0]);
      const double bound = determinant_error_factor(2, 0) * permanent + 8 * kDeterminantUnderflow;
      if (!(simplex_.weights[k] > bound)) return false;
    }
    return true;
  }

  /// For the given weights, the weighted mean is a point of the hull of differences; tests whether it is within the
  /// distance. Coordinates with magnitudes less than 2 have errors of less than 20 u.
  bool comes_close() const {
    if (distance_ == 0 || simplex_.size == 4) return false;
    Point sum{0, 0, 0};
    double total = 0;
    for (int i = 0; i < simplex_.size; ++i) {
      const double weight = simplex_.weights[static_cast<std::size_t>(i)];
      const Point& p = simplex_.points[static_cast<std::size_t>(i)];
      sum = {sum[0] + weight * p[0], sum[1] + weight * p[1], sum[2] + weight * p[2]};
      total += weight;
    }
    if (!(total > kMinSquare)) return false;
    const Point mean{sum[0] / total, sum[1] / total, sum[2] / total};
    return std::sqrt(dot(mean, mean)) * kLengthSlack + 128 * kUnitRoundoff <= scale_ * distance_;
  }

  const HullPoints &a_, &b_;
  const double distance_;
  const Vec3 extent_;
  double scale_ = 0;
  bool in_range_ = false, progress_ = true;
  Simplex simplex_;
};

}  // namespace

HullVerdict hulls_in_doubles(const HullPoints& a, const HullPoints& b, double distance, HullStart& start) {
  return OverlapSearch(a, b, distance).run(start);
}

}  // namespace volccd::detail
