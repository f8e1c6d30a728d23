// `cubic` on constructed contacts that are known exactly, and on random pairs compared with the long double oracle.
#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/cubic/cubic.hpp>

#include "narrowphase/oracle.hpp"
#include "narrowphase/query_set.hpp"

namespace volccd::test {
namespace {

constexpr FeatureKind kKinds[] = {FeatureKind::vf, FeatureKind::ee};

/// A multiple of 1/8 in [-4, 4].
double lattice(Random& random) { return static_cast<double>(random.below(65)) / 8 - 4; }
Vec3 lattice_point(Random& random) { return {lattice(random), lattice(random), lattice(random)}; }

struct Constructed {
  Query query;
  double t;
  Vec3 point;
};

/// Features that meet in one point at t = 1/16 .. 15/16. All numbers are small binary fractions, so that nothing is
/// rounded. Weights are eighths, zero included, so that some features meet at corners and edges. `rigid`: both features
/// translate, and this is the only time at which they are coplanar.
Constructed construct(FeatureKind kind, Random& random, bool rigid) {
  Constructed c;
  c.t = static_cast<double>(1 + random.below(15)) / 16;
  std::array<Vec3, 4> at;
  for (Vec3& p : at) p = lattice_point(random);
  const std::uint64_t i = random.below(9), j = random.below(9 - i);
  const double w1 = static_cast<double>(i) / 8, w2 = static_cast<double>(j) / 8;
  if (kind == FeatureKind::vf) {
    c.point = at[0] = (1 - w1 - w2) * at[1] + w1 * at[2] + w2 * at[3];
  } else {
    c.point = (1 - w1) * at[0] + w1 * at[1];
    // The second edge passes through the point: its far end is the mirror image of the first one, at a distance
    // multiplied by a power of two.
    static constexpr double stretch[] = {0, 0.5, 1, 2};
    at[3] = c.point + stretch[random.below(4)] * (c.point - at[2]);
  }
  const Vec3 first = lattice_point(random), second = lattice_point(random);
  for (std::size_t p = 0; p < 4; ++p) {
    const bool in_first = p < (kind == FeatureKind::vf ? 1u : 2u);
    const Vec3 velocity = rigid ? (in_first ? first : second) : lattice_point(random);
    c.query[p] = at[p] - c.t * velocity;
    c.query[p + 4] = at[p] + (1 - c.t) * velocity;
  }
  return c;
}

TEST(CubicContact, ExactRigidContactIsFoundAtItsTime) {
  Random random(11);
  for (const FeatureKind kind : kKinds) {
    std::vector<Constructed> cases;
    std::vector<Query> queries;
    while (queries.size() < 20000) {
      const Constructed c = construct(kind, random, true);
      const Real v0 = volume_at(c.query, 0), v1 = volume_at(c.query, 1);
      if (!(v0 * v1 < 0)) continue;  // they slide in their common plane, so that there is no single time
      cases.push_back(c);
      queries.push_back(c.query);
    }
    const QuerySet set(kind, queries);
    const std::vector<Contact> contacts = set.test(Cubic());
    ASSERT_EQ(contacts.size(), queries.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      ASSERT_NEAR(contacts[i].toi, cases[i].t, 1e-12) << i;
      ASSERT_LT((contacts[i].point - cases[i].point).norm(), 1e-9) << i;
    }
  }
}

TEST(CubicContact, ExactGeneralContactIsNeverMissedOrLate) {
  Random random(12);
  for (const FeatureKind kind : kKinds) {
    std::vector<Constructed> cases;
    std::vector<Query> queries;
    for (int i = 0; i < 40000; ++i) {
      cases.push_back(construct(kind, random, false));
      queries.push_back(cases.back().query);
    }
    const QuerySet set(kind, queries);
    const std::vector<Contact> contacts = set.test(Cubic());
    ASSERT_EQ(contacts.size(), queries.size());
    std::size_t at_time = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      ASSERT_LE(contacts[i].toi, cases[i].t + 1e-7) << i;
      ASSERT_LE(distance_at(kind, queries[i], contacts[i].toi), 1e-9L * size_of(queries[i])) << i;
      at_time += std::abs(contacts[i].toi - cases[i].t) < 1e-7 ? 1u : 0u;
    }
    EXPECT_GT(at_time, queries.size() / 2) << "most have no earlier contact";
  }
}

Query random_query(Random& random, double travel) {
  Query q;
  for (std::size_t p = 0; p < 4; ++p) {
    for (int k = 0; k < 3; ++k) {
      q[p][k] = random.uniform(-1, 1);
      q[p + 4][k] = q[p][k] + travel * random.uniform(-1, 1);
    }
  }
  return q;
}

TEST(CubicContact, AgreesWithOracleOnRandomPairs) {
  Random random(13);
  for (const FeatureKind kind : kKinds) {
    std::size_t touching = 0, apart = 0, open = 0;
    std::vector<Query> queries;
    for (int i = 0; i < 9000; ++i) queries.push_back(random_query(random, i % 2 ? 2.0 : 0.5));
    const QuerySet set(kind, queries);
    std::vector<const Contact*> found(queries.size(), nullptr);
    const std::vector<Contact> contacts = set.test(Cubic());
    for (const Contact& c : contacts) found[set.query_of(c)] = &c;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const Real size = size_of(queries[i]);
      if (found[i]) {
        ASSERT_LE(distance_at(kind, queries[i], found[i]->toi), 1e-10L * size) << i;
      }
      if (const std::optional<Real> t = sampled_contact(kind, queries[i], 400)) {
        ++touching;
        ASSERT_TRUE(found[i]) << "missed " << i;
        // An earlier time is right only if the features touch then, which has been checked.
        ASSERT_LE(found[i]->toi, static_cast<double>(*t) + 1e-12) << i;
      } else if (proven_apart(kind, queries[i], 1e-4L * size)) {
        ++apart;
        ASSERT_FALSE(found[i]) << "extra " << i;
      } else {
        ++open;
      }
    }
    EXPECT_GT(touching, 300u);
    EXPECT_GT(apart, 1000u);
    EXPECT_LT(open, 180u);
  }
}

TEST(CubicContact, TimeIsTheFirst) {
  // The vertex passes through a triangle that turns over twice, so that there are two or three roots inside the step.
  Random random(14);
  for (const FeatureKind kind : kKinds) {
    std::vector<Query> queries;
    for (int i = 0; i < 4000; ++i) queries.push_back(random_query(random, 4));
    const QuerySet set(kind, queries);
    std::size_t later = 0;
    for (const Contact& c : set.test(Cubic())) {
      const Query& q = queries[set.query_of(c)];
      // If sampling finds a contact before the reported time, the first contact was missed.
      const std::optional<Real> t = sampled_contact(kind, q, 1000);
      if (!t) continue;
      ASSERT_LE(c.toi, static_cast<double>(*t) + 1e-12);
      later += c.toi < static_cast<double>(*t) - 1e-6 ? 1u : 0u;
    }
    EXPECT_LT(later, 100u);
  }
}

TEST(CubicContact, NormalWeightsAndPointAreConsistent) {
  Random random(15);
  for (const FeatureKind kind : kKinds) {
    std::vector<Query> queries;
    for (int i = 0; i < 20000; ++i) queries.push_back(random_query(random, 2));
    const QuerySet set(kind, queries);
    const std::vector<Contact> contacts = set.test(Cubic());
    ASSERT_GT(contacts.size(), 1000u);
    std::size_t signed_normals = 0;
    for (const Contact& c : contacts) {
      const Query& q = queries[set.query_of(c)];
      const std::size_t split = kind == FeatureKind::vf ? 1 : 2;
      const auto combine = [&](std::size_t from, std::size_t to, Real t) {
        Point p = Point::Zero();
        for (std::size_t i = from; i < to; ++i) p += Real(c.weights[i]) * points_at(q, t)[i];
        return p;
      };
      double sum0 = 0, sum1 = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        ASSERT_GE(c.weights[i], 0);
        (i < split ? sum0 : sum1) += c.weights[i];
      }
      ASSERT_NEAR(sum0, 1, 1e-15);
      ASSERT_NEAR(sum1, 1, 4e-15);
      ASSERT_LT((combine(split, 4, c.toi) - c.point.cast<Real>()).norm(), 1e-14L);
      ASSERT_LT((combine(0, split, c.toi) - c.point.cast<Real>()).norm(), 1e-9L);
      ASSERT_NEAR(c.normal.norm(), 1, 1e-14);
      const Points p = points_at(q, c.toi);
      const std::array<Point, 2> in_plane = kind == FeatureKind::vf ? std::array<Point, 2>{p[2] - p[1], p[3] - p[1]}
                                                                    : std::array<Point, 2>{p[1] - p[0], p[3] - p[2]};
      for (const Point& e : in_plane) ASSERT_LT(std::abs(c.normal.cast<Real>().dot(e)), 1e-7L);
      // Before the contact, the first feature is on the side to which the normal points.
      const Real before = c.toi - 1e-4L;
      const Real approach = c.normal.cast<Real>().dot(combine(0, split, before) - combine(split, 4, before));
      if (std::abs(approach) < 1e-5L) continue;
      ASSERT_GT(approach, 0);
      ++signed_normals;
    }
    EXPECT_GT(signed_normals, contacts.size() * 3 / 4);
  }
}

}  // namespace
}  // namespace volccd::test
