#include <volccd/pipelines/lists/detail/predicted_motion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <volccd/numerics/rounding.hpp>
#include <volccd/query/line_distance.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kGrain = 4096, kSample = 64;
/// Coordinates above this value are not predicted, so that no square overflows.
constexpr double kMaxCoordinate = 0x1p500;
/// Squares below this value may have lost digits by underflow.
constexpr double kMinDistance = 0x1p-400;

bool is_live(const Features& features, Index v) { return features.first_element_of_vertex(v) != kNone; }

}  // namespace

bool PredictedMotion::set(const Motion& motion, double steps, const Features& features) {
  const int last = motion.control_points() - 1;
  if (lines_.vertex_count() != motion.vertex_count()) lines_ = Motion(motion.vertex_count(), 2);
  largest_ = 0;
  double square = 0;
  bool finite = true;
  for (Index v = 0; v < motion.vertex_count(); ++v) {
    const Vec3 x0 = motion.point(v, 0), x1 = motion.point(v, last);
    const bool live = is_live(features, v);
    const Vec3 from = steps == 0 ? x1 : x0, to = steps == 0 ? from : Vec3(x0 + steps * (x1 - x0));
    // A vertex without elements usually moves as others do, and is then passed over together with them.
    if (!live)
      lines_.set(v, 0, from), lines_.set(v, 1, to.cwiseAbs().maxCoeff() <= kMaxCoordinate ? to : from);
    else
      finite = set_line(v, from, to) && finite;
    if (live) square = std::max(square, (to - from).squaredNorm());
  }
  length_ = std::sqrt(square);
  if (finite) choose_sample(features);
  return finite;
}

bool PredictedMotion::set_line(Index v, const Vec3& from, const Vec3& to) {
  lines_.set(v, 0, from);
  lines_.set(v, 1, to);
  const double magnitude = std::max(from.cwiseAbs().maxCoeff(), to.cwiseAbs().maxCoeff());
  if (!(magnitude <= kMaxCoordinate)) return false;
  largest_ = std::max(largest_, magnitude);
  // P(tau) = p0 + tau (p1 - p0): three roundings of numbers of at most 2, 2 and 1 times `largest_`, and tau itself may
  // be rounded once (the middle of an interval); in each of three coordinates.
  rounding_ = 32 * kUnitRoundoff * largest_;
  return true;
}

bool PredictedMotion::renew(const Motion& motion, Interval at, std::span<const Index> vertices) {
  if (const Index old = lines_.vertex_count(); old != motion.vertex_count()) {
    Motion longer(motion.vertex_count(), 2);
    for (Index v = 0; v < old; ++v)
      for (int c = 0; c < 2; ++c) longer.set(v, c, lines_.point(v, c));
    lines_ = std::move(longer);
  }
  bool finite = true;
  for (const Index v : vertices) {
    const Vec3 x0 = motion.point(v, 0), x1 = motion.point(v, motion.control_points() - 1);
    const double time = at.end - at.begin;
    Vec3 speed = time > 0 ? Vec3((x1 - x0) / time) : Vec3::Zero();
    if (!(speed.norm() <= length_)) speed.setZero();
    const Vec3 from = x1 - at.end * speed;
    finite = set_line(v, from, from + speed) && finite;
  }
  return finite;
}

/// The fastest vertices tell best how far a motion has gone.
void PredictedMotion::choose_sample(const Features& features) {
  speeds_.clear();
  for (Index v = 0; v < lines_.vertex_count(); ++v)
    if (const double speed = (lines_.point(v, 1) - lines_.point(v, 0)).squaredNorm(); speed > 0 && is_live(features, v))
      speeds_.emplace_back(-speed, v);
  const std::size_t count = std::min(kSample, speeds_.size());
  std::nth_element(speeds_.begin(), speeds_.begin() + static_cast<std::ptrdiff_t>(count), speeds_.end());
  sample_.clear();
  for (std::size_t i = 0; i < count; ++i) sample_.push_back(speeds_[i].second);
}

PredictedMotion::Interval PredictedMotion::nearest(const Motion& motion) const {
  double begin = 0, end = 0, squares = 0;
  for (const Index v : sample_) {
    const Vec3 from = lines_.point(v, 0), way = lines_.point(v, 1) - from;
    begin += way.dot(motion.point(v, 0) - from);
    end += way.dot(motion.point(v, motion.control_points() - 1) - from);
    squares += way.squaredNorm();
  }
  const auto time = [&](double sum) { return squares > 0 ? std::clamp(sum / squares, 0.0, 1.0) : 0; };
  return {time(begin), time(end)};
}

double PredictedMotion::square_distance(const Motion& motion, Index v, const double (&times)[3]) const {
  const Vec3 from = lines_.point(v, 0), way = lines_.point(v, 1) - from;
  double square = 0;
  for (int i = 0; i < motion.control_points(); ++i) {
    const double one = (motion.point(v, i) - (from + times[i] * way)).squaredNorm();
    if (!(one <= square)) square = one;
  }
  return square;
}

double PredictedMotion::distance(const Motion& motion, const Features& features, Interval at, Executor& executor) {
  const bool straight = motion.control_points() == 2;
  const double times[3] = {at.begin, straight ? at.end : 0.5 * (at.begin + at.end), at.end};
  worst_.assign(executor.workers(), 0);
  executor.parallel_for(motion.vertex_count(), kGrain, [&](std::size_t begin, std::size_t end, unsigned worker) {
    double worst = worst_[worker];
    for (auto v = static_cast<Index>(begin), last = static_cast<Index>(end); v < last && !std::isnan(worst);) {
      if (straight) v = pass_near_vertices(motion, lines_, {at.begin, at.end}, worst, v, last);
      for (const Index stop = std::min(last, v + kDistanceGroup); v < stop; ++v)
        if (const double square = square_distance(motion, v, times); !(square <= worst) && is_live(features, v))
          worst = square;
    }
    worst_[worker] = worst;
  });
  double square = 0;
  for (const double one : worst_)
    if (!(one <= square)) square = one;
  if (!(square <= std::numeric_limits<double>::max())) return std::numeric_limits<double>::infinity();
  return std::max(std::sqrt(square), kMinDistance) * kLengthSlack + rounding_;
}

}  // namespace volccd::detail
