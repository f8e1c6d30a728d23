#include <volccd/experiments/tables/operations.hpp>

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include <volccd/culling/csat_reference.hpp>
#include <volccd/experiments/tables/counted_operation.hpp>
#include <volccd/narrowphase/provot_test.hpp>
#include <volccd/query/reference_points.hpp>

namespace volccd {

namespace {

using nlohmann::json;
using reference::MovingPoint;
using reference::Vector3;

/// A test, the element that contains one of its features, and the axis that the paper uses for both.
template <class Scalar>
struct Sample {
  std::array<MovingPoint<Scalar>, 4> points;
  std::vector<MovingPoint<Scalar>> element;
  Vector3<Scalar> axis;
  Scalar tolerance, t_max;
};

template <class Scalar>
Vector3<Scalar> axis_of(FeatureKind kind, const std::array<MovingPoint<Scalar>, 4>& p) {
  return kind == FeatureKind::vf ? reference::start_normal<Scalar>({p[1], p[2], p[3]})
                                 : reference::start_cross<Scalar>({p[0], p[1]}, {p[2], p[3]});
}

template <class Scalar>
bool csat(FeatureKind kind, const std::array<MovingPoint<Scalar>, 4>& p, const Vector3<Scalar>& axis) {
  return kind == FeatureKind::vf ? reference::vertex_apart<Scalar>(p[0], {p[1], p[2], p[3]}, axis)
                                 : reference::edges_apart<Scalar>({p[0], p[1]}, {p[2], p[3]}, axis);
}

struct Csat {
  static constexpr const char* kName = "csat";
  template <class Scalar>
  static bool run(FeatureKind kind, const Sample<Scalar>& sample) {
    return csat(kind, sample.points, sample.axis);
  }
};

struct CsatWithAxis {
  static constexpr const char* kName = "csat-with-axis";
  template <class Scalar>
  static bool run(FeatureKind kind, const Sample<Scalar>& sample) {
    return csat(kind, sample.points, axis_of(kind, sample.points));
  }
};

struct CsatElement {
  static constexpr const char* kName = "csat-element";
  template <class Scalar>
  static bool run(FeatureKind kind, const Sample<Scalar>& sample) {
    const std::span<const MovingPoint<Scalar>> feature(sample.points.data(), kind == FeatureKind::vf ? 1u : 2u);
    return reference::apart_along<Scalar>(sample.axis, feature, sample.element);
  }
};

struct ElementaryTest {
  static constexpr const char* kName = "elementary-test";
  template <class Scalar>
  static bool run(FeatureKind kind, const Sample<Scalar>& sample) {
    return reference::provot_test<Scalar>(kind, sample.points, sample.tolerance, sample.t_max).touches;
  }
};

struct ElementaryTestLeft : ElementaryTest {
  static constexpr const char* kName = "elementary-test-left";
};

/// The numbers printed in Section 7.1, which are for VF only.
json printed(FeatureKind kind, const std::string& operation) {
  if (kind == FeatureKind::vf && operation == Csat::kName)
    return {{"additions", 15}, {"multiplications", 12}, {"divisions", 0}};
  if (kind == FeatureKind::vf && operation == ElementaryTest::kName)
    return {{"additions", 155}, {"multiplications", 217}, {"divisions", 6}};
  return nullptr;
}

Sample<double> sample_of(const Step& step, FeatureKind kind, FeaturePair pair, double tolerance) {
  Sample<double> sample;
  const std::array<Index, 4> vertices = test_vertices(step.features(), kind, pair);
  for (std::size_t i = 0; i < 4; ++i) sample.points[i] = reference::moving_point(step.motion, vertices[i]);
  const Features& features = step.features();
  const auto others = kind == FeatureKind::vf ? features.triangle_elements(pair.b)
                                              : features.edge_elements(features.find_edge(vertices[2], vertices[3]));
  const Index other = others.front();
  sample.element = reference::moving_points(step.motion, step.mesh().vertices(other));
  sample.axis = axis_of(kind, sample.points);
  sample.tolerance = tolerance;
  sample.t_max = 1;
  return sample;
}

std::vector<Sample<double>> samples_of(FeatureKind kind, const std::vector<KnownQueries>& queries,
                                       const OperationConfig& config) {
  std::vector<std::pair<const KnownQueries*, FeaturePair>> all;
  for (const KnownQueries& group : queries)
    if (group.kind == kind && group.step.motion.control_points() == 2)
      for (const FeaturePair pair : group.pairs) all.emplace_back(&group, pair);
  std::vector<Sample<double>> samples;
  const std::size_t count = std::min(config.tests, all.size());
  for (std::size_t i = 0; i < count; ++i) {
    const auto& from = all[i * all.size() / count];
    samples.push_back(sample_of(from.first->step, kind, from.second, config.tolerance));
  }
  return samples;
}

Sample<CountedDouble> counted(const Sample<double>& sample) {
  Sample<CountedDouble> result;
  for (std::size_t i = 0; i < 4; ++i) result.points[i] = volccd::counted(sample.points[i]);
  result.element = volccd::counted(sample.element);
  result.axis = {sample.axis[0], sample.axis[1], sample.axis[2]};
  result.tolerance = sample.tolerance;
  result.t_max = sample.t_max;
  return result;
}

template <class What>
CountedOperation operation(FeatureKind kind, const std::vector<Sample<double>>& samples) {
  json row = {{"operation", What::kName},
              {"kind", kind == FeatureKind::vf ? "vf" : "ee"},
              {"paper", printed(kind, What::kName)}};
  return CountedOperation::of(std::move(row), samples, [kind](const auto& sample) { return What::run(kind, sample); });
}

}  // namespace

json operation_counts(const std::vector<KnownQueries>& queries, const OperationConfig& config) {
  const std::array<FeatureKind, 2> kinds = {FeatureKind::vf, FeatureKind::ee};
  std::array<std::vector<Sample<double>>, 2> samples, left;
  std::vector<CountedOperation> operations;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    samples[k] = samples_of(kinds[k], queries, config);
    if (samples[k].empty()) continue;
    operations.push_back(operation<Csat>(kinds[k], samples[k]));
    operations.push_back(operation<CsatWithAxis>(kinds[k], samples[k]));
    operations.push_back(operation<CsatElement>(kinds[k], samples[k]));
    operations.push_back(operation<ElementaryTest>(kinds[k], samples[k]));
    for (const Sample<double>& sample : samples[k])
      if (!Csat::run(kinds[k], sample)) left[k].push_back(sample);
    if (!left[k].empty()) operations.push_back(operation<ElementaryTestLeft>(kinds[k], left[k]));
  }
  for (int repetition = 0; repetition < std::max(config.repetitions, 1); ++repetition)
    for (CountedOperation& one : operations) one.time();
  json result = {{"tolerance", config.tolerance}, {"rows", json::array()}};
  for (const CountedOperation& one : operations) result["rows"].push_back(one.row());
  return result;
}

}  // namespace volccd
