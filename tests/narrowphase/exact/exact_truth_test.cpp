// `exact` compared with published ground truth, including queries that the method of the ground truth does not decide.
#include <cmath>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/exact/detail/exact_geometry.hpp>
#include <volccd/narrowphase/exact/exact.hpp>

#include "narrowphase/hdf5_rows.hpp"
#include "narrowphase/query_set.hpp"
#include "support/test_data.hpp"

namespace volccd::test {
namespace {

/// Coordinates of a query in the layout of a motion.
class Bare {
 public:
  Bare(FeatureKind kind, const Query& query) : kind_(kind) {
    for (std::size_t p = 0; p < 8; ++p)
      for (std::size_t k = 0; k < 3; ++k) x_[p % 4][p / 4 * 3 + k] = query[p][static_cast<Eigen::Index>(k)];
  }
  TestMotion motion() const { return {kind_, 2, {x_[0].data(), x_[1].data(), x_[2].data(), x_[3].data()}}; }

 private:
  FeatureKind kind_;
  std::array<std::array<double, 6>, 4> x_;
};

bool coplanar_all_along(const TestMotion& motion) {
  const auto x = detail::relative_curves(motion).x;
  return detail::dot(x[1], detail::cross(x[2], x[3])).is_zero();
}

TEST(ExactTruth, SampleQueries) {
  VOLCCD_NEEDS_DATA(path, "ccd-queries.h5");
  const Hdf5File file(path);
  std::size_t coplanar = 0, coplanar_contacts = 0;
  for (const char* scene : {"erleben-cube-cliff-edges", "erleben-sliding-spike", "erleben-spike-hole",
                            "erleben-spike-wedge", "erleben-spikes", "unit-tests"})
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
      const std::string group = std::string(scene) + (kind == FeatureKind::vf ? "/VertexFace" : "/EdgeEdge");
      const std::vector<double> x = file.doubles(group + "/Points");
      const std::vector<int> collides = file.integers(group + "/Collides");
      std::vector<Query> queries(collides.size());
      for (std::size_t i = 0; i < queries.size(); ++i)
        for (std::size_t p = 0; p < 8; ++p) queries[i][p] = Eigen::Map<const Vec3>(&x[(i * 8 + p) * 3]);
      const QuerySet set(kind, queries);
      std::vector<int> found(queries.size(), 0);
      for (const Contact& contact : set.test(Exact())) found[set.query_of(contact)] = 1;
      EXPECT_EQ(found, collides) << group;
      for (std::size_t i = 0; i < queries.size(); ++i) {
        const Bare bare(kind, queries[i]);
        if (!coplanar_all_along(bare.motion())) continue;
        const ExactAnswer answer = exact_first_touch(bare.motion());
        ++coplanar;
        coplanar_contacts += answer.touches;
        EXPECT_EQ(compare_distance(bare.motion(), answer.toi, 0), answer.touches && answer.toi_exact ? 0 : 1);
        std::printf("  coplanar all along: %s %zu %s\n", group.c_str(), i,
                    answer.touches ? ("touch at " + std::to_string(answer.toi)).c_str() : "apart");
      }
    }
  EXPECT_EQ(coplanar, 33u);
  EXPECT_EQ(coplanar_contacts, 10u);
}

TEST(ExactTruth, RodTwist) {
  VOLCCD_NEEDS_DATA(path, "rod-twist.vtkhdf");
  const Hdf5File file(path);
  const std::vector<double> x = file.doubles("VTKHDF/Points");
  const std::vector<int> edges = file.integers("GroundTruth/Edges"), corners = file.integers("VTKHDF/Connectivity");
  const std::size_t n = x.size() / 6;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    const std::string group = kind == FeatureKind::vf ? "GroundTruth/VertexFace" : "GroundTruth/EdgeEdge";
    const std::vector<int> pairs = file.integers(group + "/Pairs"), collides = file.integers(group + "/Collides");
    const std::vector<double> times = file.doubles(group + "/TimeOfImpact");
    for (std::size_t i = 0; i < collides.size(); ++i) {
      const auto a = static_cast<std::size_t>(pairs[2 * i]), b = static_cast<std::size_t>(pairs[2 * i + 1]);
      const std::array<int, 4> v =
          kind == FeatureKind::vf ? std::array{pairs[2 * i], corners[3 * b], corners[3 * b + 1], corners[3 * b + 2]}
                                  : std::array{edges[2 * a], edges[2 * a + 1], edges[2 * b], edges[2 * b + 1]};
      Query query;
      for (std::size_t p = 0; p < 8; ++p)
        query[p] = Eigen::Map<const Vec3>(&x[(static_cast<std::size_t>(v[p % 4]) + n * (p / 4)) * 3]);
      const ExactAnswer answer = exact_first_touch(Bare(kind, query).motion());
      ASSERT_EQ(answer.touches, collides[i] != 0) << group << ' ' << i;
      // Times of the ground truth are rounded to the nearest double, those of `exact` downwards.
      if (answer.touches) {
        ASSERT_TRUE(answer.toi == times[i] || std::nextafter(answer.toi, 1) == times[i])
            << group << ' ' << i << ": " << answer.toi - times[i];
      }
    }
  }
}

/// Checks that weights, point and normal of a contact belong to the time that the judge found.
template <std::size_t N>
void check_contacts(FeatureKind kind, const std::vector<std::array<Vec3, N>>& queries) {
  const volccd::QuerySet set(kind, queries);
  std::vector<Contact> contacts;
  NarrowCounters counters;
  test::run_stage(Exact(), set.step(), kind, set.pairs(), contacts, counters);
  EXPECT_GT(contacts.size(), 25u);
  for (const Contact& contact : contacts) {
    const Motion& motion = set.step().motion;
    Vec3 first = Vec3::Zero(), second = Vec3::Zero(), apart = Vec3::Zero();
    const double before = std::max(0.0, contact.toi - 1e-5);
    for (std::size_t i = 0; i < 4; ++i) {
      const bool is_second = i >= (kind == FeatureKind::vf ? 1u : 2u);
      const double w = contact.weights[i];
      (is_second ? second : first) += w * motion.position(contact.vertices[i], contact.toi);
      apart += (is_second ? -w : w) * motion.position(contact.vertices[i], before);
      EXPECT_GE(w, 0);
    }
    EXPECT_LT((first - second).norm(), 1e-12);
    EXPECT_LT((contact.point - second).norm(), 1e-12);
    EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
    if (before > 0) {
      EXPECT_GT(contact.normal.dot(apart), 0);
    }
  }
}

TEST(ExactContacts, WeightsPointAndNormal) {
  Random random(9);
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    std::vector<std::array<Vec3, 8>> lines(500);
    std::vector<std::array<Vec3, 12>> curves(500);
    const auto fill = [&](auto& queries) {
      for (auto& query : queries)
        for (Vec3& p : query) p = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    };
    fill(lines);
    fill(curves);
    check_contacts(kind, lines);
    check_contacts(kind, curves);
  }
}

}  // namespace
}  // namespace volccd::test
