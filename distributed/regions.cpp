#include <volccd/distributed/regions.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

namespace volccd::distributed {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Region kEmpty{Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity)};

struct Cut {
  std::size_t below = 0;  ///< number of points below; 0 if all coordinates are the same
  double at = 0;
};

/// The cut of points in ascending order of the coordinate whose lower side has a weight nearest to `share` of the
/// total.
Cut best_cut(std::span<const Vec3> points, std::span<const double> weights, std::span<const std::size_t> order,
             int axis, double share) {
  double total = 0;
  for (const std::size_t i : order) total += weights[i];
  Cut best;
  double below = 0, smallest = kInfinity;
  for (std::size_t n = 1; n < order.size(); ++n) {
    below += weights[order[n - 1]];
    const double coordinate = points[order[n]][axis];
    const double miss = std::abs(below - share * total);
    if (points[order[n - 1]][axis] < coordinate && miss < smallest) {
      smallest = miss;
      best = {n, coordinate};
    }
  }
  return best;
}

/// Sorts points by a coordinate, and those that have the same one by their numbers.
void sort_along(std::span<const Vec3> points, int axis, std::span<std::size_t> order) {
  std::vector<std::pair<double, std::size_t>> keys;
  keys.reserve(order.size());
  for (const std::size_t i : order) keys.emplace_back(points[i][axis], i);
  std::ranges::sort(keys);
  std::ranges::transform(keys, order.begin(), &std::pair<double, std::size_t>::second);
}

}  // namespace

Regions::Regions(std::span<const Vec3> points, std::span<const double> weights, int ranks) {
  assert(points.size() == weights.size());
  assert(std::ranges::all_of(points, [](const Vec3& p) { return p.allFinite(); }));
  if (ranks < 1) throw ConfigError(fmt::format("ranks: {}, but there must be one at least", ranks));
  regions_.assign(static_cast<std::size_t>(ranks), kEmpty);
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  root_ = divide(points, weights, order, 0, ranks, {});
}

/// Divides a region among ranks by the points in it. Returns the child that stands for it.
int Regions::divide(std::span<const Vec3> points, std::span<const double> weights, std::span<std::size_t> order,
                    int first_rank, int ranks, const Region& region) {
  Cut cut;
  int axis = 0;
  const int ranks_below = ranks / 2;
  if (ranks > 1 && !order.empty()) {
    MotionBox box;
    for (const std::size_t i : order) {
      box.low = box.low.cwiseMin(points[i]);
      box.high = box.high.cwiseMax(points[i]);
    }
    (box.high / 2 - box.low / 2).maxCoeff(&axis);  // halves, which do not overflow
    sort_along(points, axis, order);
    cut = best_cut(points, weights, order, axis, static_cast<double>(ranks_below) / ranks);
  }
  if (cut.below == 0) {
    regions_[static_cast<std::size_t>(first_rank)] = region;
    return ~first_rank;
  }
  Region lower = region, upper = region;
  lower.high[axis] = cut.at;
  upper.low[axis] = cut.at;
  const std::size_t node = nodes_.size();
  nodes_.push_back({axis, cut.at, 0, 0});
  const int below = divide(points, weights, order.first(cut.below), first_rank, ranks_below, lower);
  const int above =
      divide(points, weights, order.subspan(cut.below), first_rank + ranks_below, ranks - ranks_below, upper);
  nodes_[node].below = below;
  nodes_[node].above = above;
  return static_cast<int>(node);
}

int Regions::at(const Vec3& point) const {
  assert(!point.hasNaN());
  int child = root_;
  while (child >= 0) {
    const Node& node = nodes_[static_cast<std::size_t>(child)];
    child = point[node.axis] < node.cut ? node.below : node.above;
  }
  return ~child;
}

}  // namespace volccd::distributed
