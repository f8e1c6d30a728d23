// `cubic` on degenerate geometry with known answers: each kind of case in several positions, sizes and orders of the
// points.
#include <gtest/gtest.h>

#include <volccd/narrowphase/cubic/cubic.hpp>

#include "narrowphase/query_set.hpp"

namespace volccd::test {
namespace {

constexpr double kNone = -1;

struct Case {
  const char* name;
  FeatureKind kind;
  Query query;
  double toi;  ///< or kNone
  bool degenerate = true;
  double accuracy = 1e-12;
};

constexpr FeatureKind vf = FeatureKind::vf, ee = FeatureKind::ee;

Query still(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return {a, b, c, d, a, b, c, d}; }
Query first_moves(int points, const Vec3& by, Query q) {
  for (std::size_t p = 0; p < static_cast<std::size_t>(points); ++p) q[p + 4] += by;
  return q;
}

std::vector<Case> cases() {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), mid(0.25, 0.25, 0);
  std::vector<Case> all;
  const auto add = [&](Case c) { all.push_back(c); };
  // There is no relative motion.
  add({"still, inside", vf, still(mid, o, x, y), 0});
  add({"still, on an edge", vf, still(0.5 * (x + y), o, x, y), 0});
  add({"still, on a corner", vf, still(y, o, x, y), 0});
  add({"still, beside", vf, still(x + y, o, x, y), kNone, false});
  add({"still, above", vf, still(mid + z, o, x, y), kNone, false});
  add({"still, crossing", ee, still(o, x + y, x, y), 0});
  add({"still, parallel", ee, still(o, x, y, x + y), kNone, false});
  add({"still, overlapping on a line", ee, still(o, 2 * x, x, 3 * x), 0});
  add({"still, apart on a line", ee, still(o, x, 2 * x, 3 * x), kNone, false});
  Query moving = still(mid, o, x, y);
  for (std::size_t p = 4; p < 8; ++p) moving[p] += Vec3(3, -5, 7);
  add({"moving together, inside", vf, moving, 0});
  // All points lie in one plane during the whole step.
  add({"slides into the triangle", vf, first_moves(1, 2 * x, still(-x + 0.25 * y, o, x, y)), 0.5});
  add({"slides over a corner", vf, first_moves(1, 4 * x, still(-2 * x + y, o, x, y)), 0.5});
  add({"slides past", vf, first_moves(1, 4 * x, still(-2 * x + 1.25 * y, o, x, y)), kNone, false});
  add({"slides past the long side", vf, first_moves(1, Vec3(2, -2, 0), still(Vec3(0, 2, 0), o, x, y)), kNone, false});
  add({"slides past a corner", vf, first_moves(1, Vec3(2, -0.5, 0), still(Vec3(-1, 1.375, 0), o, x, y)), kNone});
  add({"slides close past a corner", vf, first_moves(1, Vec3(2, -0.5, 0), still(Vec3(-1, 1.25 + 0x1p-20, 0), o, x, y)),
       kNone});
  add({"starts inside and leaves", vf, first_moves(1, 2 * x, still(mid, o, x, y)), 0});
  add({"edges slide into a cross", ee, first_moves(2, 2 * x, still(-x - y, -x + y, o, 4 * x)), 0.5});
  add({"edges slide past", ee, first_moves(2, 2 * x, still(-x + y, -x + 2 * y, o, 4 * x)), kNone, false});
  // There is no time at which two points have equal coordinates, so that each triple of points has to be examined.
  add({"slides into the long side", vf, first_moves(1, -2 * x - 2 * y, still(1.25 * (x + y), o, x, y)), 0.375});
  add({"an end slides into an edge", ee,
       first_moves(2, -2 * y, still(y, Vec3(0.25, 2.5, 0), Vec3(-1, -0.5, 0), Vec3(1, 0.5, 0))), 0.5});
  // All points lie in one plane that rotates: z = t x.
  Query turning = first_moves(1, 2 * y, still(Vec3(0.25, -1, 0), o, x, y));
  for (std::size_t p = 4; p < 8; ++p) turning[p].z() = turning[p].x();
  add({"slides into a triangle in a turning plane", vf, turning, 0.5});
  // The edges are parallel and collinear.
  add({"parallel edges meet", ee, first_moves(2, -4 * y, still(2 * y, x + 2 * y, 0.5 * x, 3 * x)), 0.5});
  add({"parallel edges miss", ee, first_moves(2, -4 * y, still(2 * y, x + 2 * y, 1.5 * x, 3 * x)), kNone, false});
  add({"parallel edges pass in space", ee, first_moves(2, Vec3(0, -4, 0), still(Vec3(0, 2, 1), Vec3(1, 2, 1), o, x)),
       kNone, false});
  add({"ends meet on a line", ee, first_moves(2, 4 * x, still(-2 * x, -x, x, 2 * x)), 0.5});
  add({"collinear, not reached", ee, first_moves(2, x, still(-2 * x, -x, x, 2 * x)), kNone, false});
  // The features have no extent.
  add({"point hits edge", ee, first_moves(2, -2 * z, still(mid + z, mid + z, o, 0.5 * (x + y))), 0.5});
  add({"point misses edge", ee, first_moves(2, -2 * z, still(x + z, x + z, o, y)), kNone, false});
  add({"point hits point", ee, first_moves(2, -2 * z, still(z, z, o, o)), 0.5});
  add({"point misses point", ee, first_moves(2, -2 * z, still(x + z, x + z, o, o)), kNone, false});
  add({"all points the same", ee, still(x, x, x, x), 0});
  add({"all points the same", vf, still(x, x, x, x), 0});
  add({"hits a triangle that is a segment", vf, first_moves(1, -4 * y, still(x + y, o, x, 2 * x)), 0.25});
  add({"hits its end", vf, first_moves(1, -4 * y, still(2 * x + y, o, x, 2 * x)), 0.25});
  add({"misses a triangle that is a segment", vf, first_moves(1, -4 * y, still(3 * x + y, o, x, 2 * x)), kNone, false});
  add({"slants past a triangle that is a segment", vf, first_moves(1, -y - z, still(Vec3(0.5, 0.125, 0.25), o, x, x)),
       kNone});
  add({"hits a triangle that is a point", vf, first_moves(1, Vec3(-2, -2, -2), still(x + y + z, o, o, o)), 0.5});
  add({"misses a triangle that is a point", vf, first_moves(1, Vec3(-2, -2, 0), still(x + y + z, o, o, o)), kNone,
       false});
  // A triangle becomes a segment and is hit then: z of two corners passes through zero together with the vertex.
  Query folding = {Vec3(0.5, 0, 1), o, x, Vec3(0.5, 1, 0), Vec3(0.5, 0, -1), o, x, Vec3(0.5, -1, 0)};
  add({"hits a triangle as it folds", vf, folding, 0.5, true, 1e-5});
  folding[0].x() = folding[4].x() = 2;
  add({"misses a triangle as it folds", vf, folding, kNone, false});
  // A double root: the vertex touches the rotating plane z = (t - 1/2) x from one side, at (1/4, 1/4, 0).
  const Query touch = {Vec3(-0.25, 0.25, -0.125), o, Vec3(1, 0, -0.5), y,
                       Vec3(0.75, 0.25, 0.125),   o, Vec3(1, 0, 0.5),  y};
  add({"double root", vf, touch, 0.5, true, 1e-7});
  for (const double lift : {1e-3, 1e-9}) {
    // With z = (t-1/2)/4 and a x = (t-1/2)(t-1/4), the vertex is below the plane by (t-1/2)^2. If it is lowered, there
    // is no contact.
    Query missed = touch;
    missed[0].z() -= lift, missed[4].z() -= lift;
    add({"near double root", vf, missed, kNone, false});
  }
  // Contacts at the ends of the step.
  add({"touches at the start and leaves", vf, first_moves(1, z, still(mid, o, x, y)), 0, false});
  add({"touches at the end", vf, first_moves(1, -z, still(mid + z, o, x, y)), 1, false});
  add({"edges touch at the end", ee, first_moves(2, -z, still(z, x + y + z, x, y)), 1, false});
  add({"edges touch at the start and leave", ee, first_moves(2, z, still(o, x + y, x, y)), 0, false});
  add({"nearly reaches", vf, first_moves(1, -(1 - 1e-9) * z, still(mid + z, o, x, y)), kNone, false});
  return all;
}

/// The same case at another place and in another size, rotated by a permutation of the axes, with its points in another
/// order.
Query variant(const Case& c, int number) {
  static constexpr std::size_t triangle_orders[6][3] = {{1, 2, 3}, {2, 3, 1}, {3, 1, 2},
                                                        {2, 1, 3}, {1, 3, 2}, {3, 2, 1}};
  const auto n = static_cast<std::size_t>(number);
  const double scale = std::ldexp(1.0, number % 5 * 9 - 18);
  const Vec3 shift = number % 4 == 3 ? Vec3(1024, -512, 96) : Vec3(0, 0, 0);
  Query q;
  for (std::size_t p = 0; p < 8; ++p) {
    std::size_t from = p % 4;
    if (c.kind == FeatureKind::vf && from != 0) from = triangle_orders[n % 6][from - 1];
    if (c.kind == FeatureKind::ee) from ^= (n & 1) | (n & 2);
    const Vec3& x = c.query[from + p / 4 * 4];
    const Vec3 turned(x[number % 3], x[(number + 1) % 3], (number % 2 ? -1 : 1) * x[(number + 2) % 3]);
    // Sizes with which every coordinate is exact.
    q[p] = shift.isZero() ? Vec3(scale * turned) : Vec3(turned + shift);
  }
  return q;
}

TEST(CubicDegenerate, KnownAnswersInEveryPosition) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    std::vector<Query> queries;
    // The coordinates of "Near" and "nearly" cases would change in a translation.
    for (int i = 0; i < 120; ++i)
      if (i % 4 != 3 || std::string_view(c.name).find("near") == std::string_view::npos)
        queries.push_back(variant(c, i));
    const QuerySet set(c.kind, queries);
    NarrowCounters counters;
    const std::vector<Contact> contacts = set.test(Cubic(), 1, &counters);
    if (c.toi == kNone) {
      EXPECT_EQ(contacts.size(), 0u);
    } else {
      EXPECT_EQ(contacts.size(), queries.size());
      for (const Contact& contact : contacts) EXPECT_NEAR(contact.toi, c.toi, c.accuracy);
      if (c.toi == 0) {
        for (const Contact& contact : contacts) EXPECT_EQ(contact.toi, 0);
      }
    }
    if (c.degenerate)
      EXPECT_EQ(counters.degenerate, queries.size());
    else
      EXPECT_EQ(counters.degenerate, 0u);
  }
}

TEST(CubicDegenerate, NormalPointsToWhereTheFirstFeatureCameFrom) {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  const auto normal = [](FeatureKind kind, const Query& q) {
    const std::vector<Contact> contacts = QuerySet(kind, {q}).test(Cubic());
    EXPECT_EQ(contacts.size(), 1u);
    return contacts.empty() ? Vec3(Vec3::Constant(-9)) : contacts[0].normal;
  };
  const Vec3 mid(0.25, 0.25, 0);
  EXPECT_TRUE(normal(vf, first_moves(1, -2 * z, still(mid + z, o, x, y))).isApprox(z));
  EXPECT_TRUE(normal(vf, first_moves(1, 2 * z, still(mid - z, o, x, y))).isApprox(-z));
  EXPECT_TRUE(normal(ee, first_moves(2, -2 * z, still(z, x + y + z, x, y))).isApprox(z));
  EXPECT_TRUE(normal(ee, first_moves(2, 2 * z, still(-z, x + y - z, x, y))).isApprox(-z));
  // At the start there is no earlier position; the normal follows from the motion, continued backwards.
  EXPECT_TRUE(normal(vf, first_moves(1, z, still(mid, o, x, y))).isApprox(-z));
  // The contact is in the plane of the triangle. The normal points away from the side that was hit.
  EXPECT_TRUE(normal(vf, first_moves(1, 2 * x, still(-x + 0.25 * y, o, x, y))).isApprox(-x, 1e-9));
  EXPECT_TRUE(normal(ee, first_moves(2, -4 * y, still(2 * y, x + 2 * y, o, x))).isApprox(y, 1e-9));
  // Nothing determines the normal.
  EXPECT_EQ(normal(vf, still(mid, o, x, y)), o);
  EXPECT_EQ(normal(vf, still(x, x, x, x)), o);
}

TEST(CubicDegenerate, ExtremeSizesGiveTheSameAnswers) {
  // Factors are powers of two, and the results must have the same bits, from the smallest normal numbers to overflow.
  const Query hit = {Vec3(0.3, 0.2, 1),  Vec3(0, 0.1, 0), Vec3(1, 0, 0.2), Vec3(0, 1, 0),
                     Vec3(0.2, 0.4, -1), Vec3(0, 0, 0),   Vec3(1, 0.3, 0), Vec3(0, 1, -0.1)};
  const std::vector<Contact> expected = QuerySet(vf, {hit}).test(Cubic());
  ASSERT_EQ(expected.size(), 1u);
  for (const int exponent : {-960, -600, -340, -101, -30, 0, 30, 101, 340, 700, 1022}) {
    Query scaled = hit;
    for (Vec3& p : scaled) p *= std::ldexp(1.0, exponent);
    const std::vector<Contact> contacts = QuerySet(vf, {scaled}).test(Cubic());
    ASSERT_EQ(contacts.size(), 1u) << exponent;
    EXPECT_NEAR(contacts[0].toi, expected[0].toi, 1e-15) << exponent;
    EXPECT_TRUE(contacts[0].normal.isApprox(expected[0].normal, 1e-14)) << exponent;
    Query missed = scaled;
    missed[4].z() = missed[0].z();
    EXPECT_TRUE(QuerySet(vf, {missed}).test(Cubic()).empty()) << exponent;
  }
}

}  // namespace
}  // namespace volccd::test
