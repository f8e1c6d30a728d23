#include <volccd/experiments/tables/operations.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <span>
#include <string>

#include <volccd/culling/csat_reference.hpp>
#include <volccd/experiments/tables/counted_double.hpp>
#include <volccd/experiments/tables/median.hpp>
#include <volccd/narrowphase/provot_test.hpp>

namespace volccd {

namespace {

using nlohmann::json;
using reference::MovingPoint;
using reference::Vector3;

/// A test, the element that one of its features is of, and the axis that the paper takes for both.
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

/// What Section 7.1 prints: it has numbers for VF alone.
json printed(FeatureKind kind, const std::string& operation) {
  if (kind == FeatureKind::vf && operation == Csat::kName)
    return {{"additions", 15}, {"multiplications", 12}, {"divisions", 0}};
  if (kind == FeatureKind::vf && operation == ElementaryTest::kName)
    return {{"additions", 155}, {"multiplications", 217}, {"divisions", 6}};
  return nullptr;
}

MovingPoint<double> point_of(const Motion& motion, Index v) {
  const double* x = motion.at(v);
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
}

Sample<double> sample_of(const Step& step, FeatureKind kind, FeaturePair pair, double tolerance) {
  Sample<double> sample;
  const std::array<Index, 4> vertices = test_vertices(step.features(), kind, pair);
  for (std::size_t i = 0; i < 4; ++i) sample.points[i] = point_of(step.motion, vertices[i]);
  const Features& features = step.features();
  const auto others = kind == FeatureKind::vf ? features.triangle_elements(pair.b)
                                              : features.edge_elements(features.find_edge(vertices[2], vertices[3]));
  const Index other = others.front();
  for (const Index v : step.mesh().vertices(other)) sample.element.push_back(point_of(step.motion, v));
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

MovingPoint<CountedDouble> counted(const MovingPoint<double>& p) {
  return {{p.x0[0], p.x0[1], p.x0[2]}, {p.x1[0], p.x1[1], p.x1[2]}};
}

Sample<CountedDouble> counted(const Sample<double>& sample) {
  Sample<CountedDouble> result;
  for (std::size_t i = 0; i < 4; ++i) result.points[i] = counted(sample.points[i]);
  for (const MovingPoint<double>& p : sample.element) result.element.push_back(counted(p));
  result.axis = {sample.axis[0], sample.axis[1], sample.axis[2]};
  result.tolerance = sample.tolerance;
  result.t_max = sample.t_max;
  return result;
}

struct NamedCount {
  const char* name;
  std::uint64_t OperationCounts::*count;
};
constexpr NamedCount kCounts[] = {{"additions", &OperationCounts::additions},
                                  {"multiplications", &OperationCounts::multiplications},
                                  {"divisions", &OperationCounts::divisions},
                                  {"comparisons", &OperationCounts::comparisons},
                                  {"square_roots", &OperationCounts::square_roots}};

/// One operation on all samples of a kind.
class Operation {
 public:
  template <class What>
  static Operation of(FeatureKind kind, const std::vector<Sample<double>>& samples) {
    Operation operation;
    operation.row_ = {{"operation", What::kName},
                      {"kind", kind == FeatureKind::vf ? "vf" : "ee"},
                      {"tests", samples.size()},
                      {"paper", printed(kind, What::kName)}};
    operation.count(samples, [kind](const Sample<CountedDouble>& sample) { return What::run(kind, sample); });
    operation.pass_ = [kind, &samples] {
      std::size_t found = 0;
      for (const Sample<double>& sample : samples) found += What::run(kind, sample) ? 1 : 0;
      return found;
    };
    operation.tests_ = samples.size();
    return operation;
  }

  /// Nanoseconds of one pass over the samples, noted.
  void time() {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    for (int pass = 0; pass < kPasses; ++pass) found_ += pass_();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    times_.push_back(seconds * 1e9 / static_cast<double>(kPasses * tests_));
  }
  json row() const {
    json result = row_;
    result["ns"] = median(times_);
    result["positive"] = static_cast<double>(found_) / static_cast<double>(kPasses * times_.size() * tests_);
    return result;
  }

 private:
  static constexpr int kPasses = 8;

  template <class Run>
  void count(const std::vector<Sample<double>>& samples, Run&& run) {
    OperationCounts sum, most;
    for (const Sample<double>& plain : samples) {
      const Sample<CountedDouble> sample = counted(plain);
      CountedDouble::counts() = {};
      run(sample);
      for (const NamedCount& one : kCounts) {
        const std::uint64_t value = CountedDouble::counts().*one.count;
        sum.*one.count += value;
        most.*one.count = std::max(most.*one.count, value);
      }
    }
    for (const NamedCount& one : kCounts) {
      row_[one.name] = static_cast<double>(sum.*one.count) / static_cast<double>(samples.size());
      row_["most"][one.name] = most.*one.count;
    }
  }

  json row_;
  std::function<std::size_t()> pass_;
  std::size_t tests_ = 0, found_ = 0;
  std::vector<double> times_;
};

}  // namespace

json operation_counts(const std::vector<KnownQueries>& queries, const OperationConfig& config) {
  const std::array<FeatureKind, 2> kinds = {FeatureKind::vf, FeatureKind::ee};
  std::array<std::vector<Sample<double>>, 2> samples, left;
  std::vector<Operation> operations;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    samples[k] = samples_of(kinds[k], queries, config);
    if (samples[k].empty()) continue;
    operations.push_back(Operation::of<Csat>(kinds[k], samples[k]));
    operations.push_back(Operation::of<CsatWithAxis>(kinds[k], samples[k]));
    operations.push_back(Operation::of<CsatElement>(kinds[k], samples[k]));
    operations.push_back(Operation::of<ElementaryTest>(kinds[k], samples[k]));
    for (const Sample<double>& sample : samples[k])
      if (!Csat::run(kinds[k], sample)) left[k].push_back(sample);
    if (!left[k].empty()) operations.push_back(Operation::of<ElementaryTestLeft>(kinds[k], left[k]));
  }
  for (int repetition = 0; repetition < std::max(config.repetitions, 1); ++repetition)
    for (Operation& operation : operations) operation.time();
  json result = {{"tolerance", config.tolerance}, {"rows", json::array()}};
  for (const Operation& operation : operations) result["rows"].push_back(operation.row());
  return result;
}

}  // namespace volccd
