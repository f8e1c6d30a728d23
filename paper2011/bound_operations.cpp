#include <volccd/paper2011/bound_operations.hpp>

#include <algorithm>

#include <volccd/broadphase/candidate_pairs.hpp>
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/core/error.hpp>
#include <volccd/paper2011/counted_operation.hpp>
#include <volccd/paper2011/moving_obb.hpp>
#include <volccd/paper2011/reference_vectors.hpp>

namespace volccd {

namespace {

using nlohmann::json;
using reference::MovingKdop;
using reference::MovingObb;
using reference::MovingPoint;

using Element = std::vector<MovingPoint<double>>;

template <class Bounds>
struct BoundsPair {
  Bounds a, b;
};

MovingKdop<CountedDouble> counted(const MovingKdop<double>& bounds) {
  MovingKdop<CountedDouble> result;
  std::copy(bounds.low.begin(), bounds.low.end(), result.low.begin());
  std::copy(bounds.high.begin(), bounds.high.end(), result.high.begin());
  return result;
}

MovingObb<CountedDouble> counted(const MovingObb<double>& bounds) {
  MovingObb<CountedDouble> result;
  std::copy(bounds.center.begin(), bounds.center.end(), result.center.begin());
  std::copy(bounds.half.begin(), bounds.half.end(), result.half.begin());
  for (std::size_t i = 0; i < 3; ++i) std::copy(bounds.axes[i].begin(), bounds.axes[i].end(), result.axes[i].begin());
  return result;
}

template <class Bounds>
auto counted(const BoundsPair<Bounds>& pair) {
  const auto a = counted(pair.a);
  return BoundsPair<std::remove_const_t<decltype(a)>>{a, counted(pair.b)};
}

/// Makes the compiler store the whole value.
template <class T>
void store(T& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

struct KdopUpdate {
  template <class Scalar>
  bool operator()(const std::vector<MovingPoint<Scalar>>& points) const {
    auto bounds = reference::moving_kdop<Scalar>(points);
    store(bounds);
    return true;
  }
};

struct ObbUpdate {
  template <class Scalar>
  bool operator()(const std::vector<MovingPoint<Scalar>>& points) const {
    auto bounds = reference::moving_obb<Scalar>(points);
    store(bounds);
    return true;
  }
};

struct Apart {
  template <class Bounds>
  bool operator()(const BoundsPair<Bounds>& pair) const {
    return reference::apart(pair.a, pair.b);
  }
};

/// At most `most` of the values, evenly spread.
template <class T>
std::vector<T> evenly_spread(const std::vector<T>& all, std::size_t max) {
  std::vector<T> result;
  const std::size_t count = std::min(max, all.size());
  for (std::size_t i = 0; i < count; ++i) result.push_back(all[i * all.size() / count]);
  return result;
}

std::vector<ElementPair> overlapping_pairs(Step step) {
  KdopBvh::Config boxes_alone;
  boxes_alone.k = 6;
  const KdopBvh broad(boxes_alone);
  SerialExecutor executor;
  const auto state = broad.make_state();
  step.range = PairRange::nonadjacent;
  broad.prepare(step, *state, executor);
  return candidate_pairs(broad, step, *state, executor);
}

struct BoundSamples {
  BoundSamples(const Step& step, const OperationConfig& config) {
    const auto points = [&](Index o) { return reference::moving_points(step.motion, step.mesh().vertices(o)); };
    std::vector<Index> live;
    for (Index o = 0; o < step.mesh().element_slots(); ++o)
      if (step.mesh().is_live(o)) live.push_back(o);
    for (const Index o : evenly_spread(live, config.tests)) elements.push_back(points(o));
    for (const ElementPair pair : evenly_spread(overlapping_pairs(step), config.tests)) {
      const Element a = points(pair.a), b = points(pair.b);
      kdops.push_back({reference::moving_kdop<double>(a), reference::moving_kdop<double>(b)});
      obbs.push_back({reference::moving_obb<double>(a), reference::moving_obb<double>(b)});
    }
  }

  std::vector<Element> elements;
  std::vector<BoundsPair<MovingKdop<double>>> kdops;
  std::vector<BoundsPair<MovingObb<double>>> obbs;
};

json first_columns(const char* operation, const char* kind, json paper = nullptr) {
  return {{"operation", operation}, {"kind", kind}, {"paper", std::move(paper)}};
}

}  // namespace

std::vector<json> bound_operation_counts(const Step& step, const OperationConfig& config) {
  if (step.motion.control_points() != 2) throw ConfigError("bounds are compared for motions of constant velocity only");
  const BoundSamples samples(step, config);
  const json paper_test = {
      {"additions", 60}, {"multiplications", 81}, {"divisions", 0}, {"comparisons", 15}, {"absolute_values", 24}};
  std::vector<CountedOperation> operations;
  if (!samples.elements.empty()) {
    operations.push_back(CountedOperation::of(first_columns("kdop-update", "element"), samples.elements, KdopUpdate{}));
    operations.push_back(CountedOperation::of(first_columns("obb-update", "element", {{"slower", {15, 25}}}),
                                              samples.elements, ObbUpdate{}));
  }
  if (!samples.kdops.empty()) {
    operations.push_back(CountedOperation::of(first_columns("kdop-test", "element-pair"), samples.kdops, Apart{}));
    operations.push_back(
        CountedOperation::of(first_columns("obb-test", "element-pair", paper_test), samples.obbs, Apart{}));
  }
  for (int repetition = 0; repetition < std::max(config.repetitions, 1); ++repetition)
    for (CountedOperation& one : operations) one.time();
  std::vector<json> rows;
  for (const CountedOperation& one : operations) {
    rows.push_back(one.row());
    if (rows.back().at("kind") == "element") rows.back()["positive"] = nullptr;
  }
  return rows;
}

}  // namespace volccd
