// The reference implementation of 2011 with counting numbers gives the same answers, and the counts of the formulas.
#include <volccd/paper2011/operations.hpp>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/experiments/tables/query_source.hpp>
#include <volccd/oracle/cases/query_set.hpp>
#include <volccd/paper2011/coplanarity_reference.hpp>
#include <volccd/paper2011/counted_double.hpp>
#include <volccd/paper2011/csat_reference.hpp>
#include <volccd/paper2011/provot_test.hpp>

#include "support/test_data.hpp"

namespace volccd {
namespace {

using reference::MovingPoint;
using TestQuery = std::array<Vec3, 8>;

std::vector<TestQuery> queries(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<TestQuery> result(n);
  for (std::size_t i = 0; i < n; ++i)
    for (Vec3& p : result[i])
      for (int k = 0; k < 3; ++k) p[k] = i % 4 ? random.uniform(-1, 1) : static_cast<double>(random.below(3)) - 1;
  return result;
}

template <class Scalar>
std::array<MovingPoint<Scalar>, 4> points_of(const TestQuery& q) {
  std::array<MovingPoint<Scalar>, 4> points;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      points[i].x0[k] = q[i][static_cast<int>(k)];
      points[i].x1[k] = q[i + 4][static_cast<int>(k)];
    }
  return points;
}

TEST(CountedDouble, AnswersAsDoubleDoes) {
  int touching = 0, degenerate = 0, apart = 0;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const TestQuery& q : queries(4000, 1)) {
      const auto plain = points_of<double>(q);
      const auto counted = points_of<CountedDouble>(q);
      const auto x = reference::provot_test<double>(kind, plain, 1e-10, 1.0);
      const auto y = reference::provot_test<CountedDouble>(kind, counted, 1e-10, 1.0);
      ASSERT_EQ(x.touches, y.touches);
      ASSERT_EQ(x.degenerate, y.degenerate);
      ASSERT_EQ(x.t, y.t.value());
      ASSERT_EQ(x.side, y.side);
      touching += x.touches ? 1 : 0;
      degenerate += x.degenerate ? 1 : 0;
      const bool a = reference::vertex_apart<double>(plain[0], {plain[1], plain[2], plain[3]},
                                                     reference::start_normal<double>({plain[1], plain[2], plain[3]}));
      const bool b = reference::vertex_apart<CountedDouble>(
          counted[0], {counted[1], counted[2], counted[3]},
          reference::start_normal<CountedDouble>({counted[1], counted[2], counted[3]}));
      ASSERT_EQ(a, b);
      apart += a ? 1 : 0;
    }
  EXPECT_GT(touching, 200);
  EXPECT_GT(degenerate, 20);
  EXPECT_GT(apart, 200);
}

/// f(t) of the four points; its sign is that of the volume that they span.
double determinant(const std::array<MovingPoint<double>, 4>& p, double t) {
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) x[i][static_cast<int>(k)] = (1 - t) * p[i].x0[k] + t * p[i].x1[k];
  return (x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0]));
}

TEST(CoplanarityReference, DropsWhatNeverIsCoplanarAndNothingElse) {
  int dropped = 0, touching = 0, changed = 0;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const TestQuery& q : queries(4000, 5)) {
      const auto points = points_of<double>(q);
      double min = determinant(points, 0), max = min;
      for (int k = 1; k <= 64; ++k) {
        const double value = determinant(points, k / 64.0);
        min = std::min(min, value), max = std::max(max, value);
      }
      const bool apart = reference::never_coplanar<double>(kind, points);
      changed += min * max <= 0;
      touching += reference::provot_test<double>(kind, points, 1e-10, 1.0).touches;
      dropped += apart;
      if (apart) {
        ASSERT_GT(min * max, 0) << "the points are coplanar in between";
        ASSERT_FALSE(reference::provot_test<double>(kind, points, 1e-10, 1.0).touches);
      }
      if (std::abs(min) > 1e-3 && min * max > 0 && min / max > 0.9 && max / min > 0.9) {
        ASSERT_TRUE(apart) << "the volume hardly changes";
      }
    }
  EXPECT_GT(dropped, 500);
  EXPECT_GT(touching, 200);
  EXPECT_GT(changed, 2000);
}

/// Section 7.2: the two are complementary.
TEST(CoplanarityReference, AndCsatEachDropWhatTheOtherKeeps) {
  using Points = std::array<MovingPoint<double>, 4>;
  const auto csat = [](const Points& p) {
    return reference::vertex_apart<double>(p[0], {p[1], p[2], p[3]},
                                           reference::start_normal<double>({p[1], p[2], p[3]}));
  };
  // Vertex and triangle turn together by a quarter: no plane of the start lies between them.
  const Points turning = {
      {{{0.2, 0.2, 0.1}, {0.1, 0.2, -0.2}}, {{0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {0, 0, -1}}, {{0, 1, 0}, {0, 1, 0}}}};
  EXPECT_FALSE(csat(turning));
  EXPECT_TRUE(reference::never_coplanar<double>(FeatureKind::vf, turning));
  // The triangle turns over while the vertex stays above it.
  const Points flipping = {
      {{{0.2, 0.2, 5}, {0.2, 0.2, 5}}, {{0, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {0, 1, 0}}, {{0, 1, 0}, {1, 0, 0}}}};
  EXPECT_TRUE(csat(flipping));
  EXPECT_FALSE(reference::never_coplanar<double>(FeatureKind::vf, flipping));
}

TEST(CountedDouble, CountsEachOperation) {
  CountedDouble::counts() = {};
  const CountedDouble a = 2, b = 3;
  const CountedDouble c = sqrt(a * b + a - b) / -b;
  const bool compared = c < a && c <= b && !(c > a) && !(c >= b);
  EXPECT_TRUE(compared);
  EXPECT_EQ(c.value(), std::sqrt(5.0) / -3);
  EXPECT_EQ(CountedDouble::counts(), (OperationCounts{2, 1, 1, 4, 1}));
}

const nlohmann::json& row(const nlohmann::json& record, const char* operation, const char* kind) {
  for (const auto& one : record.at("rows"))
    if (one.at("operation") == operation && one.at("kind") == kind) return one;
  throw std::runtime_error("no such row");
}

/// Tests of the first feature of each query with the second one of the next query, so that they are of different
/// elements.
std::vector<FeaturePair> shifted(const QuerySet& set) {
  std::vector<FeaturePair> pairs;
  for (std::size_t i = 0; i + 1 < set.size(); ++i) pairs.push_back({set.pairs()[i].a, set.pairs()[i + 1].b});
  return pairs;
}

TEST(Operations, AreThoseOfTheFormulas) {
  const QuerySet vf(FeatureKind::vf, queries(1000, 2)), ee(FeatureKind::ee, queries(700, 3));
  const auto vf_pairs = shifted(vf), ee_pairs = shifted(ee);
  const std::vector<TestList> lists = {{vf.kind(), vf.step(), vf_pairs}, {ee.kind(), ee.step(), ee_pairs}};
  const auto record = operation_counts(lists, {.tests = 600, .repetitions = 3});
  EXPECT_EQ(record.at("rows").size(), 16u);
  for (const auto& one : record.at("rows")) {
    if (one.at("operation") == "elementary-test-left") continue;
    EXPECT_EQ(one.at("tests"), 600);
    EXPECT_GT(one.at("ns").get<double>(), 0);
    EXPECT_GT(one.at("positive").get<double>(), 0.001) << one;
    EXPECT_LT(one.at("positive").get<double>(), 0.9) << one;
    for (const char* count : {"additions", "multiplications", "comparisons"})
      EXPECT_LE(one.at(count).get<double>(), one.at("max").at(count).get<double>()) << one;
  }
  // A dot product of a difference: 5 additions and 3 multiplications; 4 of them for VF, 5 for EE.
  EXPECT_EQ(row(record, "csat", "vf").at("max").at("additions"), 20);
  EXPECT_EQ(row(record, "csat", "vf").at("max").at("multiplications"), 12);
  EXPECT_EQ(row(record, "csat", "ee").at("max").at("additions"), 25);
  EXPECT_EQ(row(record, "csat", "ee").at("max").at("multiplications"), 15);
  // In addition two differences and a cross product.
  EXPECT_EQ(row(record, "csat-with-axis", "vf").at("max").at("additions"), 29);
  EXPECT_EQ(row(record, "csat-with-axis", "ee").at("max").at("multiplications"), 21);
  // Four vertices at two times, and differences between one point and two others.
  EXPECT_EQ(row(record, "csat-element", "vf").at("max").at("multiplications"), 24);
  EXPECT_EQ(row(record, "csat-element", "ee").at("max").at("multiplications"), 48);
  EXPECT_EQ(row(record, "csat-element-with-axis", "vf").at("max").at("multiplications"), 30);
  // Six differences of points and two of vectors, three cross products and their sum, six dot products and two sums.
  for (const char* kind : {"vf", "ee"}) {
    EXPECT_EQ(row(record, "coplanarity", kind).at("max").at("additions"), 53);
    EXPECT_EQ(row(record, "coplanarity", kind).at("max").at("multiplications"), 36);
    EXPECT_GT(row(record, "coplanarity", kind).at("positive"), row(record, "coplanarity-element", kind).at("positive"));
  }
  // All four triangles and six edges of a tetrahedron, whatever the first of them says: at least two dot products each.
  for (const auto& [kind, features] : {std::pair("vf", 4.0), std::pair("ee", 6.0)}) {
    EXPECT_GE(row(record, "coplanarity-element", kind).at("multiplications").get<double>(), features * 15);
    EXPECT_LE(row(record, "coplanarity-element", kind).at("max").at("multiplications").get<double>(), features * 36);
  }
  EXPECT_EQ(row(record, "coplanarity", "vf").at("paper").at("over_csat"), 2);
  EXPECT_EQ(row(record, "coplanarity-element", "vf").at("paper").at("over_csat"), 6);
  EXPECT_TRUE(row(record, "coplanarity", "ee").at("paper").is_null());
  EXPECT_EQ(row(record, "csat", "vf").at("paper").at("additions"), 15);
  EXPECT_EQ(row(record, "elementary-test", "vf").at("paper").at("multiplications"), 217);
  EXPECT_TRUE(row(record, "elementary-test", "ee").at("paper").is_null());
  EXPECT_GT(row(record, "elementary-test", "ee").at("square_roots").get<double>(), 0.5);
  for (const char* kind : {"vf", "ee"}) {
    const auto &all = row(record, "elementary-test", kind), &left = row(record, "elementary-test-left", kind);
    const double apart = row(record, "csat", kind).at("positive");
    EXPECT_NEAR(left.at("tests").get<double>(), 600 * (1 - apart), 1e-6);
    // No test that touches is found apart, so that the remaining tests include all contacts.
    EXPECT_NEAR(left.at("positive").get<double>() * (1 - apart), all.at("positive").get<double>(), 1e-9);
  }
}

TEST(Operations, OfARealMotionAreOfThePapersOrder) {
  VOLCCD_NEEDS_DATA(file, "ls-dyna-projectile.vtkhdf");
  QuerySourceConfig source;
  source.candidates = true;
  source.sample = 4000;
  source.step = 5;
  const std::vector<KnownQueries> queries = load_queries(file, source);
  std::vector<TestList> lists;
  for (const KnownQueries& known : queries) lists.push_back({known.kind, known.step, known.pairs});
  const auto record = operation_counts(lists, {.tests = 2000});
  RecordProperty("record", record.dump());
  for (const char* kind : {"vf", "ee"}) {
    const auto &cheap = row(record, "csat", kind), &test = row(record, "elementary-test", kind);
    EXPECT_GT(test.at("multiplications").get<double>(), 40);
    EXPECT_LT(test.at("multiplications").get<double>(), 434) << "twice the paper's";
    EXPECT_LT(cheap.at("multiplications").get<double>(), 0.4 * test.at("multiplications").get<double>());
    EXPECT_LT(cheap.at("ns").get<double>(), test.at("ns").get<double>());
  }
}

}  // namespace
}  // namespace volccd
