// `cubic` and `inclusion` compared with published ground truth. The numbers of extra contacts of `cubic` are fixed:
// each was examined, and is a pair whose distance is about 1e-16 of its size.
#include <map>

#include <gtest/gtest.h>

#include <volccd/narrowphase/cubic/cubic.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>

#include "hdf5_rows.hpp"
#include "oracle.hpp"
#include "query_set.hpp"
#include "support/test_data.hpp"

namespace volccd::test {
namespace {

struct Score {
  std::size_t contacts = 0, missed = 0, extra = 0;
  std::uint64_t undecided = 0;
  double worst_time = 0, latest = -1;  ///< greatest error, greatest lateness
  Real worst_distance = 0;             ///< of an extra contact, relative to its size
};

Score score(const NarrowPhase& narrow, FeatureKind kind, const std::vector<Query>& queries,
            const std::vector<int>& collides, const std::vector<double>& toi) {
  const QuerySet set(kind, queries);
  NarrowCounters counters;
  const std::vector<Contact> contacts = set.test(narrow, 1, &counters);
  std::vector<const Contact*> found(queries.size(), nullptr);
  Score s;
  s.contacts = contacts.size();
  s.undecided = counters.undecided;
  for (const Contact& c : contacts) {
    EXPECT_EQ(found[set.query_of(c)], nullptr) << "reported twice";
    found[set.query_of(c)] = &c;
  }
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (collides[i] && !found[i]) ++s.missed;
    if (!found[i]) continue;
    if (!collides[i]) {
      ++s.extra;
      s.worst_distance = std::max(s.worst_distance, distance_at(kind, queries[i], found[i]->toi) / size_of(queries[i]));
    } else if (!toi.empty()) {
      s.worst_time = std::max(s.worst_time, std::abs(found[i]->toi - toi[i]));
      s.latest = std::max(s.latest, found[i]->toi - toi[i]);
    }
  }
  return s;
}

TEST(NarrowPhaseTruth, SampleQueries) {
  VOLCCD_NEEDS_DATA(path, "ccd-queries.h5");
  const Hdf5File file(path);
  const std::map<std::string, std::size_t> max_extra = {{"erleben-cube-cliff-edges/VertexFace", 38},
                                                        {"erleben-cube-cliff-edges/EdgeEdge", 64},
                                                        {"erleben-sliding-spike/VertexFace", 0},
                                                        {"erleben-sliding-spike/EdgeEdge", 0},
                                                        {"erleben-spike-hole/VertexFace", 0},
                                                        {"erleben-spike-hole/EdgeEdge", 0},
                                                        {"erleben-spike-wedge/VertexFace", 0},
                                                        {"erleben-spike-wedge/EdgeEdge", 0},
                                                        {"erleben-spikes/VertexFace", 6},
                                                        {"erleben-spikes/EdgeEdge", 9},
                                                        {"unit-tests/VertexFace", 0},
                                                        {"unit-tests/EdgeEdge", 0}};
  for (const auto& [group, extra] : max_extra) {
    const std::vector<double> x = file.doubles(group + "/Points");
    const std::vector<int> collides = file.integers(group + "/Collides");
    std::vector<Query> queries(collides.size());
    for (std::size_t i = 0; i < queries.size(); ++i)
      for (std::size_t p = 0; p < 8; ++p) queries[i][p] = Eigen::Map<const Vec3>(&x[(i * 8 + p) * 3]);
    const FeatureKind kind = group.ends_with("EdgeEdge") ? FeatureKind::ee : FeatureKind::vf;
    const Score s = score(Cubic(), kind, queries, collides, {});
    EXPECT_EQ(s.missed, 0u) << group;
    EXPECT_LE(s.extra, extra) << group;
    EXPECT_LE(s.worst_distance, 1e-10L) << group;
    std::printf("  %-36s %4zu queries, %3zu contacts, missed %zu, extra %zu (within %.1Le)\n", group.c_str(),
                queries.size(), s.contacts, s.missed, s.extra, s.worst_distance);
    const Score certified = score(Inclusion(), kind, queries, collides, {});
    EXPECT_EQ(certified.missed, 0u) << group;
    EXPECT_LE(certified.extra, certified.undecided) << group;
    EXPECT_LE(certified.worst_distance, 0x1p-40L) << group;
    const Score decided = score(Inclusion({.undecided = Undecided::exact}), kind, queries, collides, {});
    EXPECT_EQ(decided.missed, 0u) << group;
    EXPECT_EQ(decided.extra, 0u) << group;
  }
}

void frame_pair(const std::string& path, bool with_times) {
  const Hdf5File file(path);
  const std::vector<double> x = file.doubles("VTKHDF/Points");
  const std::vector<int> edges = file.integers("GroundTruth/Edges"), corners = file.integers("VTKHDF/Connectivity");
  const std::size_t n = x.size() / 6;
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    const std::string group = kind == FeatureKind::vf ? "GroundTruth/VertexFace" : "GroundTruth/EdgeEdge";
    const std::vector<int> pairs = file.integers(group + "/Pairs"), collides = file.integers(group + "/Collides");
    std::vector<Query> queries(collides.size());
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const auto a = static_cast<std::size_t>(pairs[2 * i]), b = static_cast<std::size_t>(pairs[2 * i + 1]);
      const std::array<int, 4> v =
          kind == FeatureKind::vf ? std::array{pairs[2 * i], corners[3 * b], corners[3 * b + 1], corners[3 * b + 2]}
                                  : std::array{edges[2 * a], edges[2 * a + 1], edges[2 * b], edges[2 * b + 1]};
      for (std::size_t p = 0; p < 8; ++p)
        queries[i][p] = Eigen::Map<const Vec3>(&x[(static_cast<std::size_t>(v[p % 4]) + n * (p / 4)) * 3]);
    }
    const std::vector<double> toi = with_times ? file.doubles(group + "/TimeOfImpact") : std::vector<double>();
    const Score s = score(Cubic(), kind, queries, collides, toi);
    EXPECT_EQ(s.missed, 0u) << group;
    EXPECT_EQ(s.extra, 0u) << group;
    EXPECT_LE(s.worst_time, 1e-11) << group;
    const Score certified = score(Inclusion(), kind, queries, collides, toi);
    EXPECT_EQ(certified.missed, 0u) << group;
    EXPECT_EQ(certified.extra, 0u) << group;
    EXPECT_LE(certified.undecided, 2u) << group;
    EXPECT_LE(certified.worst_time, 1e-9) << group;
    // The time in the ground truth is the nearest double, which may be early by half a unit.
    EXPECT_LE(certified.latest, 0x1p-53) << group;
  }
}

TEST(NarrowPhaseTruth, RodTwist) {
  VOLCCD_NEEDS_DATA(path, "rod-twist.vtkhdf");
  frame_pair(path, true);
}

TEST(NarrowPhaseTruth, ClothBall) {
  VOLCCD_NEEDS_DATA(path, "cloth-ball.vtkhdf");
  frame_pair(path, false);
}

}  // namespace
}  // namespace volccd::test
