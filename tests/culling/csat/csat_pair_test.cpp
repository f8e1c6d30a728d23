// CSAT of whole pairs in lanes: verdicts compared with exact separability, for single pairs and in batches, at any
// scale.
#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/csat/csat.hpp>
#include <volccd/culling/csat/csat_axes.hpp>
#include <volccd/culling/csat/csat_points.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/csat_bench.hpp"
#include "culling/quad.hpp"
#include "support/stages.hpp"

namespace volccd::test {
namespace {

__extension__ typedef __int128 Wide;
using WidePoint = std::array<Wide, 3>;

WidePoint wide_cross(const WidePoint& p, const WidePoint& q) {
  return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}
Wide wide_dot(const WidePoint& p, const WidePoint& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }

/// Whether some axis has a positive product with all points, which span space. This is so if the sum of the extreme
/// rays of the cone of axes without negative products is in its interior. Exact.
bool strictly_separable(const std::vector<WidePoint>& points) {
  WidePoint sum = {0, 0, 0};
  const auto add_ray = [&](const WidePoint& ray) {
    for (const WidePoint& p : points)
      if (wide_dot(ray, p) < 0) return;
    for (std::size_t k = 0; k < 3; ++k) sum[k] += ray[k];
  };
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const WidePoint ray = wide_cross(points[i], points[j]);
      add_ray(ray);
      add_ray({-ray[0], -ray[1], -ray[2]});
    }
  return std::all_of(points.begin(), points.end(), [&](const WidePoint& p) { return wide_dot(sum, p) > 0; });
}

/// Differences b - a at the control points of the motion over [0, 1] or, if `half`, over [0, 1/2], times a positive
/// number, in units of 2^-20.
std::vector<WidePoint> lattice_differences(const PairBench& bench, Index pair, bool half) {
  const int n = bench.motion().control_points();
  const auto at = [&](Index side, Index i, int c, int k) {
    return static_cast<Wide>(bench.motion().point(bench.vertex(pair, side, i), c)[k] * 0x1p20);
  };
  const auto coordinate = [&](Index side, Index i, int c, int k) -> Wide {
    if (!half || c == 0) return at(side, i, c, k);
    if (c == 1) return at(side, i, 0, k) + at(side, i, 1, k);
    return at(side, i, 0, k) + 2 * at(side, i, 1, k) + at(side, i, 2, k);
  };
  std::vector<WidePoint> points;
  for (int c = 0; c < n; ++c)
    for (Index i = 0; i < bench.vertices(); ++i)
      for (Index j = 0; j < bench.vertices(); ++j) {
        WidePoint p;
        for (int k = 0; k < 3; ++k) p[static_cast<std::size_t>(k)] = coordinate(1, j, c, k) - coordinate(0, i, c, k);
        points.push_back(p);
      }
  return points;
}

/// Elements below and above a tilted plane, except for one corner of each at one control point, which is at most
/// `depth` lattice cells beyond the plane on either side. All coordinates are exact: heights along n = (3, 5, 7) are
/// multiples of n.
void set_nearly_touching(PairBench& bench, Random& random, std::int64_t depth) {
  const Vec3 n(3, 5, 7), u(5, -3, 0), w(7, 0, -3);
  const auto whole = [&](std::int64_t max) { return static_cast<double>(random.integer(-max, max)); };
  for (Index i = 0; i < bench.pairs(); ++i) {
    const Vec3 offset = Vec3(1, 2, 3) * (random.integer(0, 1) != 0 ? 0x1p40 : 0.0);
    const int corner = static_cast<int>(random.integer(0, bench.motion().control_points() - 1));
    for (Index side = 0; side < 2; ++side)
      for (Index v = 0; v < bench.vertices(); ++v)
        for (int c = 0; c < bench.motion().control_points(); ++c) {
          const bool near = v == 0 && c == corner;
          const double height = near ? whole(depth) : static_cast<double>(random.integer(0, 1 << 22));
          const std::int64_t across = near ? 4 : 1 << 21;
          const Vec3 p = (side == 0 ? -height : height) * n + whole(across) * u + whole(across) * w;
          bench.set(i, side, v, c, (p + offset) * 0x1p-20);
        }
  }
}

std::set<ElementPair> kept_pairs(const OptionValues& options, const Step& step, std::span<const ElementPair> pairs,
                                 std::size_t max) {
  const auto stage = describe_csat().make(options);
  std::set<ElementPair> kept;
  for (std::size_t i = 0; i < pairs.size(); i += max) {
    PairBatch batch;
    batch.assign(pairs.subspan(i, std::min(max, pairs.size() - i)));
    run_stage(*stage, step, batch);
    kept.insert(batch.pairs.begin(), batch.pairs.end());
  }
  return kept;
}

/// Pairs that are in only one of the sets.
std::size_t differences(const std::set<ElementPair>& a, const std::set<ElementPair>& b) {
  std::vector<ElementPair> different;
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(different));
  return different.size();
}

/// Motions end at control point 0 or later than 1/2; over [0, 1/2], the corners move less far.
TEST(CsatPairs, WhatIsDroppedIsExactlySeparable) {
  Random random(21);
  std::size_t dropped = 0, inseparable = 0;
  for (const auto type : {ElementType::tetrahedron, ElementType::triangle, ElementType::wedge, ElementType::hexahedron})
    for (const int control_points : {2, 3})
      for (const std::int64_t depth : {1, 4, 64, 4096})
        for (const bool half : {false, true}) {
          PairBench bench(type, control_points, type == ElementType::hexahedron ? 40 : 200);
          set_nearly_touching(bench, random, depth);
          const auto pairs = bench.batch().pairs;
          std::vector<bool> separable;
          for (Index i = 0; i < bench.pairs(); ++i)
            separable.push_back(strictly_separable(lattice_differences(bench, i, half)));
          for (const char* axis : {"centroid", "optimal"})
            for (const char* mode : {"pair", "both"}) {
              const auto kept = kept_pairs({{"axis", axis}, {"mode", mode}, {"iterations", "12"}},
                                           bench.step(0, half ? 0.5 : 1), pairs, 256);
              for (const ElementPair pair : pairs) {
                // contact_free has a test of its own
                if (mode == std::string("both") && !separable[pair.a / 2]) continue;
                dropped += !kept.count(pair);
                inseparable += !separable[pair.a / 2];
                EXPECT_TRUE(kept.count(pair) || separable[pair.a / 2])
                    << to_string(type) << " " << control_points << " depth " << depth << " " << axis << " half "
                    << half;
              }
            }
        }
  EXPECT_GT(dropped, 1000u);
  EXPECT_GT(inseparable, 1000u);
}

/// At one control point, a lies below a tilted plane, b above it, and each has three corners in the plane. These form
/// triangles that overlap; that of b is that of a, rotated by half a turn. At other control points the elements are
/// mirror images, and there they may be smaller by a factor of `size`. So the line between the centroids is the plane's
/// normal, the gap along it is exactly 0, and no axis separates the pair. If a is smaller than b by a factor of `of_a`,
/// its triangle is inside that of b.
void expect_no_gaps(double size, double of_a = 1) {
  Random random(26);
  const Vec3 n(3, 5, 7), u(5, -3, 0), w(7, 0, -3);
  const auto whole = [&](std::int64_t low) { return static_cast<double>(random.integer(low, 1 << 20)); };
  for (const auto type : {ElementType::tetrahedron, ElementType::triangle, ElementType::wedge, ElementType::hexahedron})
    for (const int control_points : {2, 3}) {
      PairBench bench(type, control_points, 1024);
      for (Index i = 0; i < bench.pairs(); ++i) {
        const auto first = static_cast<Index>(random.integer(0, bench.vertices() - 1));
        const int end = static_cast<int>(random.integer(0, control_points - 1));
        const Vec3 p = whole(-(1 << 20)) * u + whole(-(1 << 20)) * w, q = whole(-(1 << 20)) * u + whole(-(1 << 20)) * w;
        const Vec3 corners[3] = {p, q, -p - q},
                   offset = Vec3(1, 2, 3) * (i % 2 == 0 || size < 1 || of_a < 1 ? 0.0 : 0x1p32);
        for (Index v = 0; v < bench.vertices(); ++v)
          for (int c = 0; c < control_points; ++c) {
            const Index corner = (v + first) % bench.vertices();
            const bool touches = corner < 3 && c == end;
            const double scale = c == end ? 1 : size;
            const Vec3 height = scale * (touches ? 0.0 : whole(0)) * n;
            const Vec3 across =
                touches ? corners[corner] : Vec3(scale * (whole(-(1 << 20)) * u + whole(-(1 << 20)) * w));
            const bool in_center = of_a < 1 && !touches;
            bench.set(i, 0, v, c, offset + of_a * ((in_center ? Vec3(0, 0, 0) : across) - height));
            bench.set(i, 1, v, c, offset + (touches ? Vec3(-across) : in_center ? Vec3(0, 0, 0) : across) + height);
          }
      }
      const auto pairs = bench.batch().pairs;
      for (const char* axis : {"centroid", "optimal"})
        EXPECT_EQ(kept_pairs({{"axis", axis}, {"mode", "pair"}}, bench.step(), pairs, 256).size(), pairs.size())
            << to_string(type) << " " << control_points << " " << axis;
    }
}

TEST(CsatPairs, RoundingMakesNoGaps) { expect_no_gaps(1); }
TEST(CsatPairs, RoundingMakesNoGapsInElementsThatGrow) {
  for (const double size : {0x1p-8, 0x1p-14, 0x1p-20}) expect_no_gaps(size);
}
TEST(CsatPairs, RoundingMakesNoGapsBesideSmallElements) {
  for (const double of_a : {0x1p-6, 0x1p-10, 0x1p-14}) expect_no_gaps(1, of_a);
}

/// The least gap along the axis at any control point, with 113 bits.
detail::Quad min_gap(const PairBench& bench, Index pair, const Vec3& axis) {
  detail::Quad min = 1e300;
  for (int c = 0; c < bench.motion().control_points(); ++c)
    for (Index i = 0; i < bench.vertices(); ++i)
      for (Index j = 0; j < bench.vertices(); ++j) {
        const auto at = [&](Index side, Index v) {
          return detail::Quad3(bench.motion().point(bench.vertex(pair, side, v), c));
        };
        min = std::min(min, dot(detail::Quad3(axis), at(1, j) - at(0, i)));
      }
  return min;
}

/// The axis that CSAT tests in double precision with `axis=centroid`.
Vec3 centroid_axis(const PairBench& bench, Index pair) {
  detail::CsatFrame frame(bench.motion(), 1);
  const int n = frame.control_points;
  std::copy_n(bench.motion().at(bench.vertex(pair, 0, 0)), 3 * n, frame.reference);
  detail::CsatPoints points[2];
  for (Index side = 0; side < 2; ++side) {
    std::vector<Index> vertices;
    for (Index v = 0; v < bench.vertices(); ++v) vertices.push_back(bench.vertex(pair, side, v));
    if (n == 2)
      points[side].gather<2>(frame, bench.motion(), vertices);
    else
      points[side].gather<3>(frame, bench.motion(), vertices);
  }
  return detail::csat_scaled(detail::csat_centroid_difference(points[0], points[1], n));
}

/// The same in double precision: planes and coordinates that need all bits, so that the gap is about as large as its
/// rounding errors.
TEST(CsatPairs, RoundingOfDoublesMakesNoGapsInElementsThatGrow) {
  Random random(27);
  std::size_t doubtful = 0;
  for (const int control_points : {2, 3})
    for (const double size : {0x1p-10, 0x1p-20, 1.0}) {
      PairBench bench(ElementType::tetrahedron, control_points, 2048);
      for (Index i = 0; i < bench.pairs(); ++i) {
        const Vec3 n = random.vector(-1, 1).normalized(), u = n.unitOrthogonal(), w = n.cross(u);
        const auto in_plane = [&] { return Vec3(random.uniform(-1, 1) * u + random.uniform(-1, 1) * w); };
        const Vec3 p = in_plane(), q = in_plane(), corners[3] = {p, q, -p - q};
        for (Index v = 0; v < 4; ++v)
          for (int c = 0; c < control_points; ++c) {
            const bool last = c == control_points - 1, touches = v < 3 && last;
            const double scale = last ? 1 : size;
            const Vec3 height = touches ? Vec3(0, 0, 0) : Vec3(scale * random.uniform(0.5, 1) * n);
            const Vec3 across = touches ? corners[v] : Vec3(scale * in_plane());
            bench.set(i, 0, v, c, across - height);
            bench.set(i, 1, v, c, (touches ? Vec3(-across) : across) + height);
          }
      }
      const auto pairs = bench.batch().pairs;
      const auto kept = kept_pairs({{"axis", "centroid"}, {"mode", "pair"}}, bench.step(), pairs, 256);
      for (Index i = 0; i < bench.pairs(); ++i) {
        const bool apart = min_gap(bench, i, centroid_axis(bench, i)) > 0;
        doubtful += apart ? 0 : 1;
        ASSERT_TRUE(apart || kept.count(pairs[i])) << i << ", size " << size;
      }
    }
  EXPECT_GT(doubtful, 1000u);
}

// Numbers that floats cannot represent are processed in doubles. Differences are formed before anything is rounded to
// floats.
TEST(CsatPairs, DropsWhatIsApartAtAnyScale) {
  for (const auto type : {ElementType::tetrahedron, ElementType::triangle, ElementType::wedge, ElementType::hexahedron})
    for (const int control_points : {2, 3})
      for (const int scale : {-300, -140, -125, -70, -55, 0, 55, 70, 101, 127, 140, 300})
        for (const double offset : {0.0, 0x1p30}) {
          Random random(22);
          PairBench bench(type, control_points, 64);
          set_apart(bench, random, 0.01);
          for (Index i = 0; i < bench.pairs(); ++i)
            for (Index side = 0; side < 2; ++side)
              for (Index v = 0; v < bench.vertices(); ++v)
                for (int c = 0; c < control_points; ++c) {
                  const Vec3 p = bench.motion().point(bench.vertex(i, side, v), c);
                  bench.set(i, side, v, c, (p + Vec3::Constant(offset)) * std::ldexp(1, scale));
                }
          const auto pairs = bench.batch().pairs;
          const double separation = std::ldexp(0.009, scale);
          for (const double d : {0.0, separation})
            EXPECT_TRUE(
                kept_pairs({{"axis", "optimal"}, {"mode", "pair"}, {"iterations", "32"}}, bench.step(d), pairs, 256)
                    .empty())
                << to_string(type) << " " << control_points << " scale " << scale << " offset " << offset << " d " << d;
        }
}

/// A pair is kept with twice the separation at which it is still dropped, in whichever precision it is decided.
TEST(CsatPairs, SeparationCounts) {
  Random random(23);
  PairBench bench(ElementType::tetrahedron, 2, 256);
  for (Index i = 0; i < bench.pairs(); ++i)
    for (Index side = 0; side < 2; ++side)
      for (Index v = 0; v < 4; ++v)
        for (int c = 0; c < 2; ++c) {
          Vec3 p = random.vector(-1, 1);
          p[0] = v == 0 ? 0.5 : 0.5 + random.uniform(0, 1);  // the corner (0.5, 0, 0) of b, (-0.5, 0, 0) of a
          if (v == 0) p[1] = p[2] = 0;
          if (side == 0) p[0] = -p[0];
          bench.set(i, side, v, c, p);
        }
  const auto pairs = bench.batch().pairs;
  for (const double near : {1e-3, 1e-5, 1e-7, 1e-9, 1e-12}) {
    const OptionValues options = {{"axis", "optimal"}, {"mode", "pair"}, {"iterations", "64"}};
    EXPECT_EQ(kept_pairs(options, bench.step(1 - near), pairs, 256).size(), 0u) << near;
    EXPECT_EQ(kept_pairs(options, bench.step(1 + near), pairs, 256).size(), pairs.size()) << near;
  }
}

/// Elements of all types in random motion, and all their pairs, self pairs included, in the order of the first
/// elements.
struct MixedScene {
  MixedScene() : topology(shape().mesh()), motion(topology.mesh().vertex_count(), 2) {
    const std::vector<Vec3> start = jittered(shape().positions, 0.2, 1), end = jittered(start, 0.3, 2);
    for (Index v = 0; v < motion.vertex_count(); ++v) {
      motion.set(v, 0, start[v]);
      motion.set(v, 1, end[v]);
    }
    for (Index a = 0; a < topology.mesh().element_slots(); ++a)
      for (Index b = a; b < topology.mesh().element_slots(); ++b) pairs.push_back({a, b});
  }
  static Shape shape() { return mixed_block(1, 2).append(mixed_block(1, 2).translate(Vec3(0.4, 0.3, 0.6)), 1); }

  Topology topology;
  Motion motion;
  ObjectFilter filter;
  std::vector<ElementPair> pairs;
};

TEST(CsatPairs, CompanyDoesNotMatter) {
  const MixedScene scene;
  const Step step = {scene.topology, scene.motion, scene.filter, 0.01};
  for (const char* axis : {"centroid", "optimal"}) {
    const OptionValues options = {{"axis", axis}, {"mode", "pair"}};
    const auto alone = kept_pairs(options, step, scene.pairs, 1);
    EXPECT_GT(alone.size(), scene.pairs.size() / 10);
    EXPECT_LT(alone.size(), scene.pairs.size() / 2);
    for (const std::size_t max : {2, 7, 8, 9, 64, 256, 1000})
      EXPECT_EQ(differences(kept_pairs(options, step, scene.pairs, max), alone), 0u) << axis << " " << max;
    std::vector<ElementPair> shuffled = scene.pairs;
    volccd::Random random(24);
    random.shuffle(shuffled);
    for (const std::size_t max : {3, 256})
      EXPECT_EQ(differences(kept_pairs(options, step, shuffled, max), alone), 0u) << axis << " " << max;
  }
}

/// A hexagonal prism has 12 vertices, too many for lanes. With three copies of each corner of a tetrahedron, it has the
/// tetrahedron's hull, and its centroid up to rounding.
ElementSpec prism(Index first, std::int64_t id) {
  ElementSpec element;
  element.type = ElementType::polytope;
  element.id = id;
  for (Index i = 0; i < 12; ++i) element.vertices.push_back(first + i);
  const auto face = [&](const std::vector<Index>& corners) {
    element.faces.push_back(static_cast<Index>(corners.size()));
    for (const Index i : corners) element.faces.push_back(first + i);
  };
  face({5, 4, 3, 2, 1, 0});
  face({6, 7, 8, 9, 10, 11});
  for (Index i = 0; i < 6; ++i) face({i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i});
  return element;
}

TEST(CsatPairs, LanesAgreeWithDoubles) {
  Random random(25);
  std::size_t dropped = 0, all = 0;
  for (const int control_points : {2, 3})
    for (const double gap : {0.1, 1e-4, -0.1, -0.4, -0.8}) {
      PairBench lanes(ElementType::tetrahedron, control_points, 400);
      set_apart(lanes, random, gap);
      Mesh mesh;
      mesh.add_vertices(2 * 400 * 12);
      for (Index o = 0; o < 2 * 400; ++o) mesh.add_element(prism(12 * o, o));
      const Topology topology(std::move(mesh));
      Motion motion(2 * 400 * 12, control_points);
      for (Index v = 0; v < motion.vertex_count(); ++v)
        for (int c = 0; c < control_points; ++c) motion.set(v, c, lanes.motion().point(v / 12 * 4 + v % 4, c));
      const ObjectFilter filter;
      const auto pairs = lanes.batch().pairs;
      for (const double separation : {0.0, 0.05})
        for (const double t_max : {1.0, 0.7}) {
          const OptionValues options = {{"axis", "optimal"}, {"mode", "pair"}, {"iterations", "64"}};
          const auto in_lanes = kept_pairs(options, lanes.step(separation, t_max), pairs, 256);
          const auto in_doubles = kept_pairs(options, {topology, motion, filter, separation, t_max}, pairs, 256);
          EXPECT_EQ(differences(in_lanes, in_doubles), 0u) << control_points << " gap " << gap << " d " << separation;
          dropped += pairs.size() - in_lanes.size();
          all += pairs.size();
        }
    }
  EXPECT_GT(dropped, all / 5);
  EXPECT_LT(dropped, all * 4 / 5);
}

TEST(CsatPairs, OptimalDropsAllThatItsFirstAxisDrops) {
  const MixedScene scene;
  for (const double t_max : {1.0, 0.3}) {
    const Step step = {scene.topology, scene.motion, scene.filter, 0, t_max};
    const auto first = kept_pairs({{"axis", "centroid"}, {"mode", "pair"}}, step, scene.pairs, 256);
    const auto all = kept_pairs({{"axis", "optimal"}, {"mode", "pair"}, {"iterations", "64"}}, step, scene.pairs, 256);
    EXPECT_LT(all.size(), first.size());
    EXPECT_TRUE(std::includes(first.begin(), first.end(), all.begin(), all.end()));
  }
}

}  // namespace
}  // namespace volccd::test
