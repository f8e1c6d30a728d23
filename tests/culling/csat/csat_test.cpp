#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <ccd/ccd.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <Eigen/Geometry>

#include <volccd/culling/csat/csat.hpp>

#include "culling/csat_bench.hpp"
#include "culling/filter_touching.hpp"
#include "support/stages.hpp"

namespace volccd::test {
namespace {

struct NamedCulling {
  std::string name;
  std::unique_ptr<ElementCulling> stage;
};

NamedCulling make(const OptionValues& options) {
  std::string name;
  for (const auto& [key, value] : options) name += key + "=" + value + " ";
  return {name, describe_csat().make(options)};
}

std::vector<NamedCulling> all_cullings() {
  std::vector<NamedCulling> all;
  for (const char* axis : {"face", "predetermined", "velocity", "centroid", "optimal"})
    for (const char* mode : {"features", "pair", "both"})
      all.push_back(make({{"axis", axis}, {"mode", mode}, {"edges_of_b", "true"}}));
  return all;
}

/// Makes pair `pair` from a touching test; the other vertices are random points of the same kind.
void set_touching(PairBench& bench, Index pair, Random& random, const TouchingTest& test, const TouchingStyle& style) {
  const std::size_t first = test.kind == FeatureKind::vf ? 1 : 2;
  for (Index side = 0; side < 2; ++side)
    for (Index i = 0; i < bench.vertices(); ++i) {
      const std::size_t own = side == 0 ? first : 4 - first;
      const TouchingTest filler = touching_test(random, test.kind, test.control_points, style);
      for (int c = 0; c < test.control_points; ++c) {
        const auto& source = i < own ? test.points[side * first + i] : filler.points[i % 4];
        bench.set(pair, side, i, c, source[static_cast<std::size_t>(c)]);
      }
    }
}

/// Bit of the edge between vertices v0 and v1 in the masks of element o.
std::uint64_t edge_bit(const Features& features, Index o, Index v0, Index v1) {
  const Index e = features.find_edge(v0, v1);
  const auto edges = features.element_edges(o);
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (edges[i] == e) return std::uint64_t{1} << i;
  return 0;  // not an edge of the element
}

/// Whether the pair (2i, 2i + 1), in either order, is still in the batch, with the touching features not masked.
::testing::AssertionResult kept(const PairBench& bench, const PairBatch& batch, Index i, FeatureKind kind,
                                bool swapped) {
  for (std::size_t k = 0; k < batch.size(); ++k) {
    if (std::min(batch.pairs[k].a, batch.pairs[k].b) != 2 * i) continue;
    const FeatureMask& m = batch.masks[k];
    if (kind == FeatureKind::vf) {
      if ((swapped ? m.vertices_b : m.vertices_a) & 1u) return ::testing::AssertionFailure() << "vertex masked";
      return ::testing::AssertionSuccess();
    }
    const auto bit0 = edge_bit(bench.features(), 2 * i, bench.vertex(i, 0, 0), bench.vertex(i, 0, 1));
    const auto bit1 = edge_bit(bench.features(), 2 * i + 1, bench.vertex(i, 1, 0), bench.vertex(i, 1, 1));
    if ((swapped ? m.edges_b : m.edges_a) & bit0 || (swapped ? m.edges_a : m.edges_b) & bit1)
      return ::testing::AssertionFailure() << "edge masked";
    return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure() << "pair dropped";
}

/// Checks the conservative property over all axes and modes. separation_exponent: see part(). t_max: that of a random
/// test of the batch.
void check_touching(ElementType type, std::uint64_t seed, int rounds, bool apart, bool early) {
  const auto cullings = all_cullings();
  Random random(seed);
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3})
      for (const auto& style : touching_styles())
        for (int round = 0; round < rounds; ++round) {
          if (apart && std::abs(style.scale) > 600) continue;
          PairBench bench(type, control_points, 32);
          std::vector<TouchingTest> tests;
          for (Index i = 0; i < bench.pairs(); ++i) {
            tests.push_back(touching_test(random, kind, control_points, style));
            if (apart) part(random, tests.back(), style.scale + 4 + 5 * (round % 5));
            set_touching(bench, i, random, tests.back(), style);
          }
          const Step step = bench.step(apart ? tests[0].distance : 0, early ? tests[0].time : 1);
          for (const auto& [name, stage] : cullings) {
            const bool swapped = round % 2 == 1;
            PairBatch batch = bench.batch(swapped);
            test::run_stage(*stage, step, batch);
            for (Index i = 0; i < bench.pairs(); ++i) {
              if (tests[i].time <= step.t_max) {
                ASSERT_TRUE(kept(bench, batch, i, kind, swapped))
                    << name << control_points << " range " << style.range << " scale " << style.scale;
              }
            }
          }
        }
}

TEST(CsatConservative, TouchingTetrahedraAreKept) { check_touching(ElementType::tetrahedron, 1, 8, false, false); }
TEST(CsatConservative, TouchingHexahedraAreKept) { check_touching(ElementType::hexahedron, 2, 2, false, false); }
TEST(CsatConservative, TouchingPyramidsAreKept) { check_touching(ElementType::pyramid, 3, 2, false, false); }
TEST(CsatConservative, TouchingTrianglesAreKept) { check_touching(ElementType::triangle, 4, 2, false, false); }
TEST(CsatConservative, TouchingByTMaxIsKept) { check_touching(ElementType::tetrahedron, 5, 4, false, true); }
TEST(CsatConservative, WithinTheSeparationIsKept) { check_touching(ElementType::tetrahedron, 6, 5, true, false); }

// In random elements, the touching features are rarely the only ones that an axis fails to separate. Here they are.
TEST(CsatConservative, GrazingTetrahedraAreKept) {
  const auto cullings = all_cullings();
  Random random(7);
  for (int round = 0; round < 200; ++round) {
    PairBench bench(ElementType::tetrahedron, 2);
    // Elements below and above a tilted plane through a common lattice point, which is vertex 0 of both at one end. All
    // coordinates are exact: heights along the normal n = (3, 5, 7) are multiples of n and of vectors normal to it.
    const Vec3 n(3, 5, 7), u(5, -3, 0), w(7, 0, -3);
    for (Index i = 0; i < bench.pairs(); ++i) {
      const Vec3 offset = Vec3(1, 2, 3) * static_cast<double>(random.integer(0, 1) ? random.integer(0, 1 << 30) : 0);
      const int end = static_cast<int>(random.integer(0, 1));
      for (Index side = 0; side < 2; ++side)
        for (Index v = 0; v < 4; ++v)
          for (int c = 0; c < 2; ++c) {
            const double height = v == 0 && c == end ? 0.0 : static_cast<double>(random.integer(0, 1 << 16));
            const double across = v == 0 && c == end ? 0.0 : 1.0;
            Vec3 p = (side == 0 ? -height : height) * n +
                     across * static_cast<double>(random.integer(-(1 << 18), 1 << 18)) * u +
                     across * static_cast<double>(random.integer(-(1 << 18), 1 << 18)) * w;
            bench.set(i, side, v, c, (p + offset) * 0x1p-20);
          }
    }
    for (const auto& [name, stage] : cullings) {
      PairBatch batch = bench.batch();
      test::run_stage(*stage, bench.step(), batch);
      for (Index i = 0; i < bench.pairs(); ++i) {
        ASSERT_TRUE(kept(bench, batch, i, FeatureKind::vf, false)) << name;
        ASSERT_TRUE(kept(bench, batch, i, FeatureKind::vf, true)) << name;
      }
    }
  }
}

double culled_share(const OptionValues& options, ElementType type, int control_points, double gap, double separation,
                    double t_max) {
  const auto stage = describe_csat().make(options);
  Random random(8);
  std::size_t left = 0, all = 0;
  for (int round = 0; round < 20; ++round) {
    PairBench bench(type, control_points);
    set_apart(bench, random, gap);
    PairBatch batch = bench.batch();
    test::run_stage(*stage, bench.step(separation, t_max), batch);
    left += batch.size();
    all += bench.pairs();
  }
  return 1 - static_cast<double>(left) / static_cast<double>(all);
}

TEST(CsatEffect, DropsWhatIsApart) {
  for (const auto type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::triangle})
    for (const int control_points : {2, 3}) {
      const auto share = [&](const char* axis, const char* mode, double gap, double separation = 0, double t_max = 1) {
        return culled_share({{"axis", axis}, {"mode", mode}}, type, control_points, gap, separation, t_max);
      };
      EXPECT_EQ(share("optimal", "pair", 0.01), 1);
      EXPECT_EQ(share("optimal", "features", 0.01), 1);
      EXPECT_EQ(share("optimal", "pair", 0.1, 0.09), 1);
      EXPECT_EQ(share("optimal", "pair", 0.01, 0, 0.4), 1);
      EXPECT_LT(share("optimal", "pair", 0.1, 20), 0.01);
      EXPECT_GT(share("centroid", "pair", 0.5), 0.5);
      EXPECT_GT(share("predetermined", "pair", 0.5), 0.5);
      EXPECT_GT(share("face", "pair", 1.5), 0.02);
      EXPECT_GT(share("face", "features", 4), 0.001);
      EXPECT_GE(share("optimal", "both", -0.2), share("optimal", "pair", -0.2));
    }
}

TEST(CsatEffect, EarlyTimesPruneMore) {
  // The elements pass through each other around t = 0.5; up to t = 0.25, all are apart.
  PairBench bench(ElementType::tetrahedron, 2);
  Random random(9);
  for (Index i = 0; i < bench.pairs(); ++i)
    for (Index side = 0; side < 2; ++side)
      for (Index v = 0; v < 4; ++v) {
        const Vec3 p = random.vector(0, 1) + Vec3(side == 0 ? 0 : 2, 0, 0);
        bench.set(i, side, v, 0, p);
        bench.set(i, side, v, 1, p + Vec3(side == 0 ? 2 : -2, 0, 0));
      }
  const auto stage = describe_csat().make({{"mode", "pair"}});
  const auto left = [&](double t_max) {
    PairBatch batch = bench.batch();
    test::run_stage(*stage, bench.step(0, t_max), batch);
    return batch.size();
  };
  EXPECT_EQ(left(0.2), 0u);
  EXPECT_GT(left(1), 50u);
}

// --- masks against a naive search for contacts
// ------------------------------------------------------------------------

/// Whether the moving point p[0] touches the triangle p[1..3], or edge p[0..1] touches p[2..3]: they are coplanar at a
/// sign change between samples, and the weights there are inside by a margin.
bool robust_contact(FeatureKind kind, const std::array<std::array<Vec3, 2>, 4>& p) {
  const auto at = [&](double t, int v) -> Vec3 {
    const auto& q = p[static_cast<std::size_t>(v)];
    return (1 - t) * q[0] + t * q[1];
  };
  const auto volume = [&](double t) {
    return (at(t, 1) - at(t, 0)).cross(at(t, 2) - at(t, 0)).dot(at(t, 3) - at(t, 0));
  };
  constexpr int samples = 64;
  for (int k = 0; k < samples; ++k) {
    double low = k / double{samples}, high = (k + 1) / double{samples};
    if (volume(low) * volume(high) >= 0) continue;
    for (int i = 0; i < 40; ++i) {
      const double mid = (low + high) / 2;
      (volume(low) * volume(mid) <= 0 ? high : low) = mid;
    }
    Eigen::Matrix<double, 3, 2> sides;
    if (kind == FeatureKind::vf)
      sides << at(low, 2) - at(low, 1), at(low, 3) - at(low, 1);
    else
      sides << at(low, 1) - at(low, 0), at(low, 2) - at(low, 3);
    const Vec3 to = kind == FeatureKind::vf ? Vec3(at(low, 0) - at(low, 1)) : Vec3(at(low, 2) - at(low, 0));
    const Eigen::Vector2d w = (sides.transpose() * sides).inverse() * (sides.transpose() * to);
    const double sum_limit = kind == FeatureKind::vf ? w.sum() : 0;
    if (w.minCoeff() > 1e-6 && w.maxCoeff() < 1 - 1e-6 && sum_limit < 1 - 1e-6) return true;
  }
  return false;
}

/// Counts masked features of element `own` of a pair, and expects none of them to touch the other.
std::size_t check_masks(const PairBench& bench, Index own, Index other, std::uint32_t vertices, std::uint64_t edges) {
  const auto points = [&](std::array<Index, 4> v) {
    std::array<std::array<Vec3, 2>, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = {bench.motion().point(v[i], 0), bench.motion().point(v[i], 1)};
    return p;
  };
  const Features& features = bench.features();
  std::size_t masked = 0;
  for (Index i = 0; i < bench.vertices(); ++i) {
    if (!(vertices >> i & 1)) continue;
    ++masked;
    for (const Index f : features.element_triangles(other)) {
      const auto& t = features.triangle(f);
      EXPECT_FALSE(robust_contact(FeatureKind::vf, points({own * bench.vertices() + i, t[0], t[1], t[2]})));
    }
  }
  const auto own_edges = features.element_edges(own);
  for (std::size_t i = 0; i < own_edges.size(); ++i) {
    if (!(edges >> i & 1)) continue;
    ++masked;
    for (const Index e : features.element_edges(other)) {
      const auto &p = features.edge(own_edges[i]), &q = features.edge(e);
      EXPECT_FALSE(robust_contact(FeatureKind::ee, points({p[0], p[1], q[0], q[1]})));
    }
  }
  return masked;
}

TEST(CsatMasks, MaskedFeaturesTouchNothing) {
  for (const auto type : {ElementType::tetrahedron, ElementType::hexahedron})
    for (const char* axis : {"face", "velocity", "centroid", "optimal"}) {
      const auto stage = describe_csat().make({{"axis", axis}, {"mode", "features"}, {"edges_of_b", "true"}});
      PairBench bench(type, 2, type == ElementType::tetrahedron ? 150 : 20);
      Random random(10);
      set_apart(bench, random, -0.6);
      PairBatch batch = bench.batch();
      test::run_stage(*stage, bench.step(), batch);
      std::size_t masked = 0;
      for (std::size_t k = 0; k < batch.size(); ++k) {
        const auto [a, b] = batch.pairs[k];
        const FeatureMask& m = batch.masks[k];
        masked += check_masks(bench, a, b, m.vertices_a, m.edges_a) + check_masks(bench, b, a, m.vertices_b, m.edges_b);
      }
      EXPECT_GT(batch.size(), bench.pairs() / 2u) << axis;
      EXPECT_GT(masked, bench.pairs() / 2u) << axis;
    }
}

TEST(CsatMasks, KnownBitsAndOrderStay) {
  PairBench bench(ElementType::tetrahedron, 2);
  Random random(11);
  set_apart(bench, random, -1.2);
  for (const auto& [name, stage] : all_cullings()) {
    PairBatch batch = bench.batch();
    for (auto& mask : batch.masks) mask = {1, 2, 4, 8};
    test::run_stage(*stage, bench.step(), batch);
    ASSERT_EQ(batch.pairs.size(), batch.masks.size());
    EXPECT_TRUE(std::is_sorted(batch.pairs.begin(), batch.pairs.end()));
    for (const auto& m : batch.masks)
      EXPECT_TRUE((m.vertices_a & 1u) && (m.vertices_b & 2u) && (m.edges_a & 4u) && (m.edges_b & 8u)) << name;
  }
}

TEST(CsatMasks, SharedFeaturesOfAdjacentElementsStay) {
  // Two tetrahedra with a common triangle 1 2 3, without motion.
  Mesh mesh;
  mesh.add_vertices(5);
  for (const auto& vertices : {std::vector<Index>{0, 1, 2, 3}, std::vector<Index>{1, 2, 3, 4}}) {
    ElementSpec element;
    element.type = ElementType::tetrahedron;
    element.vertices = vertices;
    element.id = vertices[0];
    mesh.add_element(element);
  }
  const Topology topology(std::move(mesh));
  Motion motion(5, 2);
  const Vec3 x[] = {{0.3, 0.3, -1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1}};
  for (Index v = 0; v < 5; ++v)
    for (int c = 0; c < 2; ++c) motion.set(v, c, x[v]);
  const ObjectFilter filter;
  for (const auto& [name, stage] : all_cullings()) {
    PairBatch batch;
    batch.pairs = {{0, 0}, {0, 1}};
    batch.masks.resize(2);
    test::run_stage(*stage, {topology, motion, filter}, batch);
    ASSERT_EQ(batch.size(), 2u) << name;
    EXPECT_EQ(batch.masks[0].vertices_a | batch.masks[0].vertices_b, 0u) << name;
    EXPECT_EQ(batch.masks[1].vertices_a & ~1u, 0u) << name;
    EXPECT_EQ(batch.masks[1].vertices_b & ~8u, 0u) << name;
    // all of them extend to the common triangle
    EXPECT_EQ(batch.masks[1].edges_a | batch.masks[1].edges_b, 0u) << name;
  }
}

// --- libccd
// -----------------------------------------------------------------------------------------------------------

struct Differences {
  std::vector<Vec3> points;  // of the hull of B_c - A_c
  double inflate = 0;
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& set = *static_cast<const Differences*>(object);
  const Vec3 d(direction->v[0], direction->v[1], direction->v[2]);
  const Vec3* best = &set.points[0];
  for (const Vec3& p : set.points)
    if (p.dot(d) > best->dot(d)) best = &p;
  const Vec3 p = *best + set.inflate * d.normalized();
  ccdVec3Set(out, p[0], p[1], p[2]);
}

void origin_support(const void*, const ccd_vec3_t*, ccd_vec3_t* out) { ccdVec3Set(out, 0, 0, 0); }

bool libccd_intersects(const Differences& set) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = support;
  ccd.support2 = origin_support;
  ccd.max_iterations = 1000;
  return ccdGJKIntersect(&set, &set, &ccd) != 0;
}

Differences differences(const PairBench& bench, Index pair, double inflate) {
  Differences set;
  set.inflate = inflate;
  for (int c = 0; c < bench.motion().control_points(); ++c)
    for (Index i = 0; i < bench.vertices(); ++i)
      for (Index j = 0; j < bench.vertices(); ++j)
        set.points.push_back(bench.motion().point(bench.vertex(pair, 1, j), c) -
                             bench.motion().point(bench.vertex(pair, 0, i), c));
  return set;
}

TEST(CsatOptimal, AgreesWithLibccd) {
  static_assert(sizeof(ccd_real_t) == 8);
  const auto stage = describe_csat().make({{"axis", "optimal"}, {"mode", "pair"}, {"iterations", "64"}});
  Random random(12);
  std::size_t separated = 0, all = 0;
  for (const auto type : {ElementType::tetrahedron, ElementType::hexahedron})
    for (const int control_points : {2, 3})
      for (const double gap : {0.1, -0.1, -0.3, -0.6, -1.0, -1.5}) {
        PairBench bench(type, control_points, 512);
        set_apart(bench, random, gap);
        const auto is_kept = [&](double separation) {
          PairBatch batch = bench.batch();
          test::run_stage(*stage, bench.step(separation), batch);
          std::vector<bool> flags(bench.pairs(), false);
          for (const auto& pair : batch.pairs) flags[pair.a / 2] = true;
          return flags;
        };
        const auto near = is_kept(1e-9), touching = is_kept(0);
        for (Index i = 0; i < bench.pairs(); ++i) {
          // If one judge finds a distance above 1e-9, the other must find the elements apart.
          EXPECT_TRUE(near[i] || !libccd_intersects(differences(bench, i, 0))) << "gap " << gap << " pair " << i;
          EXPECT_TRUE(!touching[i] || libccd_intersects(differences(bench, i, 1e-9))) << "gap " << gap << " pair " << i;
          separated += !touching[i];
          ++all;
        }
      }
  EXPECT_GT(separated, all / 5);
  EXPECT_LT(separated, all * 4 / 5);
}

// --- the same everywhere
// ----------------------------------------------------------------------------------------------

TEST(CsatSimd, AllInstructionSetsAgree) {
  Random random(13);
  for (const auto type : {ElementType::triangle, ElementType::tetrahedron, ElementType::wedge, ElementType::hexahedron})
    for (const int control_points : {2, 3}) {
      PairBench bench(type, control_points, 256);
      set_apart(bench, random, -0.5);
      const Step step = bench.step(0.01, control_points == 2 ? 1 : 0.8);
      for (const auto& [name, stage] : all_cullings()) {
        const auto run = [&, &culling = stage] {
          PairBatch batch = bench.batch();
          test::run_stage(*culling, step, batch);
          return batch;
        };
        const PairBatch expected = run();
        for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
          hwy::SetSupportedTargetsForTest(left & -left);
          hwy::GetChosenTarget().Update(hwy::SupportedTargets());
          const PairBatch batch = run();
          hwy::SetSupportedTargetsForTest(0);
          hwy::GetChosenTarget().Update(hwy::SupportedTargets());
          EXPECT_EQ(batch.pairs, expected.pairs) << name;
          for (std::size_t k = 0; k < batch.size(); ++k)
            EXPECT_TRUE(batch.masks[k].vertices_a == expected.masks[k].vertices_a &&
                        batch.masks[k].vertices_b == expected.masks[k].vertices_b &&
                        batch.masks[k].edges_a == expected.masks[k].edges_a &&
                        batch.masks[k].edges_b == expected.masks[k].edges_b)
                << name;
        }
      }
    }
}

TEST(CsatConfig, RefusesNonsense) {
  EXPECT_THROW(describe_csat().make({{"axis", "best"}}), ConfigError);
  EXPECT_THROW(describe_csat().make({{"iterations", "0"}}), ConfigError);
}

}  // namespace
}  // namespace volccd::test
