#include <volccd/paper2011/operations.hpp>

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include <volccd/paper2011/coplanarity_reference.hpp>
#include <volccd/paper2011/counted_operation.hpp>
#include <volccd/paper2011/csat_reference.hpp>
#include <volccd/paper2011/provot_test.hpp>
#include <volccd/paper2011/reference_vectors.hpp>

namespace volccd {

namespace {

using nlohmann::json;
using reference::MovingPoint;
using reference::Vector3;

/// Numbers, in an element, of the vertices of a triangle, or of an edge and one more that is not used.
using LocalFeature = std::array<std::size_t, 3>;

/// A test, the element that its second feature is of, and the axis that the paper takes for both.
template <class Scalar>
struct Sample {
  std::array<MovingPoint<Scalar>, 4> points;
  std::vector<MovingPoint<Scalar>> element;
  std::vector<LocalFeature> features;  ///< of the element: its triangles (VF) or edges (EE)
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

struct CsatElementWithAxis {
  static constexpr const char* kName = "csat-element-with-axis";
  template <class Scalar>
  static bool run(FeatureKind kind, const Sample<Scalar>& sample) {
    const std::span<const MovingPoint<Scalar>> feature(sample.points.data(), kind == FeatureKind::vf ? 1u : 2u);
    return reference::apart_along<Scalar>(axis_of(kind, sample.points), feature, sample.element);
  }
};

struct Coplanarity {
  static constexpr const char* kName = "coplanarity";
  template <class Scalar>
  static bool run(FeatureKind kind, const Sample<Scalar>& sample) {
    return reference::never_coplanar<Scalar>(kind, sample.points);
  }
};

/// The first feature against every feature of the element, each for itself, as the paper compares it.
struct CoplanarityElement {
  static constexpr const char* kName = "coplanarity-element";
  template <class Scalar>
  static bool run(FeatureKind kind, const Sample<Scalar>& sample) {
    const std::size_t own = kind == FeatureKind::vf ? 1 : 2;  // points of the first feature
    std::array<MovingPoint<Scalar>, 4> points = sample.points;
    bool all = true;
    for (const LocalFeature& feature : sample.features) {
      for (std::size_t i = own; i < 4; ++i) points[i] = sample.element[feature[i - own]];
      all = reference::never_coplanar<Scalar>(kind, points) && all;
    }
    return all;
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

/// What Sections 7.1 and 7.2 print: they have numbers for VF alone.
json printed(FeatureKind kind, const std::string& operation) {
  if (kind != FeatureKind::vf) return nullptr;
  if (operation == Csat::kName) return {{"additions", 15}, {"multiplications", 12}, {"divisions", 0}};
  if (operation == ElementaryTest::kName) return {{"additions", 155}, {"multiplications", 217}, {"divisions", 6}};
  if (operation == Coplanarity::kName) return {{"over_csat", 2}};
  if (operation == CoplanarityElement::kName) return {{"over_csat", 6}};
  return nullptr;
}

/// The triangles (VF) or edges (EE) of an element, in its own numbers of vertices.
std::vector<LocalFeature> local_features(const Step& step, FeatureKind kind, Index element) {
  const std::span<const Index> vertices = step.mesh().vertices(element);
  const auto local = [&](Index v) {
    return static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
  };
  const Features& features = step.features();
  std::vector<LocalFeature> result;
  if (kind == FeatureKind::vf)
    for (const Index f : features.element_triangles(element)) {
      const auto& v = features.triangle(f);
      result.push_back({local(v[0]), local(v[1]), local(v[2])});
    }
  else
    for (const Index e : features.element_edges(element))
      result.push_back({local(features.edge(e)[0]), local(features.edge(e)[1]), 0});
  return result;
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
  sample.features = local_features(step, kind, other);
  sample.axis = axis_of(kind, sample.points);
  sample.tolerance = tolerance;
  sample.t_max = 1;
  return sample;
}

std::vector<Sample<double>> samples_of(FeatureKind kind, std::span<const TestList> lists,
                                       const OperationConfig& config) {
  std::vector<std::pair<const TestList*, FeaturePair>> all;
  for (const TestList& group : lists)
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
  result.features = sample.features;
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

template <class... What>
void add_operations(FeatureKind kind, const std::vector<Sample<double>>& samples,
                    std::vector<CountedOperation>& operations) {
  (operations.push_back(operation<What>(kind, samples)), ...);
}

}  // namespace

json operation_counts(std::span<const TestList> lists, const OperationConfig& config) {
  const std::array<FeatureKind, 2> kinds = {FeatureKind::vf, FeatureKind::ee};
  std::array<std::vector<Sample<double>>, 2> samples, left;
  std::vector<CountedOperation> operations;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    samples[k] = samples_of(kinds[k], lists, config);
    if (samples[k].empty()) continue;
    add_operations<Csat, CsatWithAxis, Coplanarity, CsatElement, CsatElementWithAxis, CoplanarityElement,
                   ElementaryTest>(kinds[k], samples[k], operations);
    for (const Sample<double>& sample : samples[k])
      if (!Csat::run(kinds[k], sample)) left[k].push_back(sample);
    if (!left[k].empty()) add_operations<ElementaryTestLeft>(kinds[k], left[k], operations);
  }
  for (int repetition = 0; repetition < std::max(config.repetitions, 1); ++repetition)
    for (CountedOperation& one : operations) one.time();
  json result = {{"tolerance", config.tolerance}, {"rows", json::array()}};
  for (const CountedOperation& one : operations) result["rows"].push_back(one.row());
  return result;
}

}  // namespace volccd
