// `inclusion` on tests that touch at the start or for some time, or stay in one plane, compared with `exact`. The
// search has special code for these cases, which random tests hardly reach.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>

#include "narrowphase/query_set.hpp"

namespace volccd::test {
namespace {

/// Small integers in a plane spanned by vectors of small integers, which are coplanar without rounding if `height` is
/// 0. They are scaled and translated by numbers that keep them exact.
class Lattice {
 public:
  Lattice(std::mt19937_64& random, int range) : random_(random), range_(range) {
    u_ = integers();
    v_ = integers();
    scale_ = std::ldexp(1.0, static_cast<int>(random_() % 40) - 20);
    if (random_() % 2) offset_ = 16 * integers();
  }
  int integer() { return static_cast<int>(random_() % (2 * static_cast<unsigned>(range_) + 1)) - range_; }
  Vec3 integers() { return {double(integer()), double(integer()), double(integer())}; }
  Vec3 in_plane() { return integer() * u_ + integer() * v_; }
  Vec3 place(const Vec3& p) const { return scale_ * (p + offset_); }

 private:
  std::mt19937_64& random_;
  int range_;
  Vec3 u_, v_, offset_ = Vec3::Zero();
  double scale_ = 1;
};

enum class LastingCase { flat, resting, shared, nearly_shared, through_edge };

/// The four points at the first control point, then at the next. flat: all points are always in one plane. resting:
/// they are in one plane at the start, and some of them also later. shared: a point of the first feature equals one of
/// the second at the start. nearly_shared: they differ in the last bit of one coordinate. through_edge: a point of the
/// first feature moves through one of the second, which is at rest.
std::vector<Vec3> lasting_test(std::mt19937_64& random, LastingCase what, FeatureKind kind, int control_points) {
  Lattice lattice(random, random() % 2 ? 3 : 40);
  const bool vertex_face = kind == FeatureKind::vf;
  std::vector<Vec3> points;
  const Vec3 slide = lattice.in_plane();
  for (int c = 0; c < control_points; ++c) {
    std::array<Vec3, 4> now;
    for (std::size_t i = 0; i < 4; ++i) {
      const bool stays = c > 0 && random() % 3 == 0;
      const bool in_plane = what == LastingCase::flat || (what == LastingCase::resting && (c == 0 || random() % 2));
      now[i] = stays ? Vec3(points[i]) : in_plane ? lattice.in_plane() : lattice.integers();
      // Points of the second feature move slowly, away from the first one or along it.
      if (stays && random() % 2 && i >= (vertex_face ? 1u : 2u))
        now[i] += std::ldexp(1.0, -static_cast<int>(random() % 30)) * slide;
    }
    if (c == 0 && (what == LastingCase::shared || what == LastingCase::nearly_shared)) {
      const std::size_t second = 2 + random() % 2, first = vertex_face ? 0 : random() % 2;
      now[second] = now[first];
      if (!vertex_face && random() % 3 == 0) now[5 - second] = now[1 - first];
    }
    if (c > 0 && what == LastingCase::through_edge) {
      const Vec3 centre = points[vertex_face ? 1 : 2];
      now[0] = 2 * centre - points[0];
      now[vertex_face ? 1 : 2] = points[vertex_face ? 1 : 2];
    }
    points.insert(points.end(), now.begin(), now.end());
  }
  for (Vec3& p : points) p = lattice.place(p);
  if (what == LastingCase::nearly_shared) {
    const int axis = static_cast<int>(random() % 3);
    double& x = points[0][axis];
    // A denormal is avoided, because `exact` is not used for coordinates of so different magnitudes.
    x = x == 0 ? 0x1p-90 : std::nextafter(x, random() % 2 ? 1e300 : -1e300);
  }
  return points;
}

double size_of_lasting(const TestMotion& motion) {
  double size = 0;
  for (const double* x : motion.points)
    for (int k = 0; k < 3 * motion.control_points; ++k) size = std::max(size, std::abs(x[k] - motion.points[0][k]));
  return size;
}

void expect_as_exact(LastingCase what, FeatureKind kind, int control_points, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  int touching = 0, undecided = 0;
  for (int i = 0; i < count; ++i) {
    const volccd::QuerySet set(kind, control_points, lasting_test(random, what, kind, control_points));
    TestMotion motion{kind, control_points, {}};
    for (Index v = 0; v < 4; ++v) motion.points[v] = set.step(1).motion.at(v);
    const ExactAnswer exact = exact_first_touch(motion);
    std::vector<Contact> contacts;
    NarrowCounters counters;
    const Inclusion inclusion;
    run_stage(inclusion, set.step(1), kind, set.pairs(), contacts, counters);
    const auto where = [&] { return testing::Message() << "test " << i << ", case " << static_cast<int>(what); };
    touching += exact.touches ? 1 : 0;
    undecided += counters.undecided > 0 ? 1 : 0;
    if (!exact.touches && !contacts.empty()) {
      ASSERT_GT(counters.undecided, 0u) << where();
      ASSERT_LE(compare_distance(motion, contacts[0].toi, kUndecidedDistance * size_of_lasting(motion)), 0) << where();
    }
    if (!exact.touches) continue;
    ASSERT_EQ(contacts.size(), 1u) << where();
    ASSERT_LE(contacts[0].toi, exact.toi) << where();
    ASSERT_GE(contacts[0].toi, exact.toi - inclusion.time_tolerance()) << where();
    if (exact.reason == TouchCase::at_start) {
      ASSERT_TRUE(contacts[0].at_start) << where();
    }
  }
  EXPECT_GT(touching, count / 40) << static_cast<int>(what);
  if (what == LastingCase::shared) {
    EXPECT_EQ(undecided, 0);
  } else if (what != LastingCase::nearly_shared) {
    EXPECT_GT(undecided, count / 100) << static_cast<int>(what);
  }
}

TEST(LastingContacts, AreFoundInTime) {
  using enum LastingCase;
  for (const LastingCase what : {flat, resting, shared, nearly_shared, through_edge})
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
      for (const int control_points : {2, 3})
        expect_as_exact(what, kind, control_points, control_points == 2 ? 1500 : 250, 11 + static_cast<unsigned>(what));
}

/// A vertex leaves the corner of a triangle, or the ends of two edges separate.
TEST(LastingContacts, APointInCommonAtTheStartNeedsNoSearch) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const FeatureKind kind = i % 2 ? FeatureKind::ee : FeatureKind::vf;
    std::vector<Vec3> points(8);
    for (Vec3& p : points) p = {number(random), number(random), number(random)};
    const std::size_t second = kind == FeatureKind::vf ? 1 : 2;
    points[second] = points[0];
    // The second feature moves upwards, and the first one downwards.
    for (std::size_t p = 0; p < 4; ++p) {
      const double side = p < second ? -1 : 1;
      if (p != 0 && p != second) points[p].z() = points[0].z() + side * std::abs(number(random));
      points[4 + p] = points[p] + Vec3(0, 0, side);
    }
    detail::TestPoints x;
    std::array<std::array<double, 6>, 4> coordinates;
    for (std::size_t p = 0; p < 4; ++p) {
      for (int k = 0; k < 6; ++k) coordinates[p][static_cast<std::size_t>(k)] = points[p + (k < 3 ? 0 : 4)][k % 3];
      x[p] = coordinates[p].data();
    }
    const detail::InclusionAnswer answer = detail::inclusion_search(kind, x, 2, i % 4 < 2 ? 0 : 0.1, 1e-9, 1, 1);
    ASSERT_EQ(answer.outcome, detail::InclusionAnswer::Outcome::touch) << i;
    ASSERT_EQ(answer.toi, 0) << i;
    ASSERT_TRUE(answer.at_start) << i;
    ASSERT_FALSE(answer.unsettled) << i;
  }
}

}  // namespace
}  // namespace volccd::test
