// The counts of `volccd queries` compared with simple counts, and a message if a promise is broken.
#include <algorithm>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/tables/query_comparison.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/oracle/cases/query_set.hpp>

#include "io/sequence/raw_hdf5.hpp"
#include "io/sequence/sequences.hpp"
#include "support/all_stages.hpp"

namespace volccd::test {
namespace {

/// Reports the tests whose first pair index is even, whatever their coordinates.
class EverySecond final : public NarrowPhase {
 public:
  struct Config {};
  static const Options<Config>& options() {
    static const Options<Config> none;
    return none;
  }
  explicit EverySecond(const Config&) {}

  void run(const Step&, StageState&, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    for (std::size_t i = 0; i < block.size(); ++i)
      if (block.vertices(i)[0] / 4 % 2 == 0)
        contacts.push_back({block.kind(), block.vertices(i), 0.5, Vec3::Zero(), {}, Vec3::Zero()});
    counters.undecided += 1;
  }
};

KnownQueries known(std::size_t n, const std::vector<std::uint8_t>& collides) {
  const std::vector<Vec3> points(8 * n, Vec3::Zero());
  const auto set = std::make_shared<const QuerySet>(FeatureKind::vf, 2, points);
  KnownQueries queries{"made",
                       FeatureKind::vf,
                       set->step(),
                       set,
                       {set->pairs().begin(), set->pairs().end()},
                       {},
                       collides,
                       std::vector<double>(n, 0.5),
                       {}};
  for (std::size_t i = 0; i < n; ++i) queries.index.push_back(10 * i);
  queries.toi[2] = 0.25;
  queries.toi[4] = 0.75;
  return queries;
}

TEST(QueryComparison, CountsAndTellsOfBrokenPromises) {
  Registry registry = test::all_stages();
  registry.add(describe_stage<NarrowPhase, EverySecond>("certain", "", Guarantee::conservative));
  registry.add(describe_stage<NarrowPhase, EverySecond>("doubtful", "", Guarantee::approximate));
  const std::vector<KnownQueries> groups = {known(5, {1, 1, 1, 0, 1}), known(5, {0, 0, 0, 1, 1})};
  QueryComparisonConfig config;
  config.narrow_phases = {"certain", "doubtful"};
  config.rounds = 0;
  QueryRecord record;
  compare_on_queries(registry, groups, config, record);
  ASSERT_EQ(record.groups.size(), 2u);
  const QueryScore& first = record.groups[0].scores[1];
  EXPECT_EQ(first.missed, (std::vector<std::uint64_t>{10}));
  EXPECT_TRUE(first.extra.empty());
  EXPECT_EQ(first.contacts, 3u);
  EXPECT_EQ(first.earliest, -0.25);
  EXPECT_EQ(first.latest, 0.25);
  EXPECT_EQ(record.groups[1].scores[0].missed, (std::vector<std::uint64_t>{30}));
  EXPECT_EQ(record.groups[1].scores[0].extra, (std::vector<std::uint64_t>{0, 20}));
  const QueryGroupRecord total = record.total(FeatureKind::vf);
  EXPECT_EQ(total.queries, 10u);
  EXPECT_EQ(total.colliding, 6u);
  EXPECT_EQ(total.scores[0].missed.size(), 2u);
  EXPECT_EQ(total.scores[0].undecided, 2u);
  const std::vector<std::string> broken = record.broken_promises();
  ASSERT_EQ(broken.size(), 1u);
  EXPECT_NE(broken[0].find("certain"), std::string::npos);
  EXPECT_NE(broken[0].find("misses 2"), std::string::npos);
  EXPECT_NE(query_table(record).find("doubtful"), std::string::npos);
}

QuerySourceConfig candidates(std::size_t sample = 0) {
  QuerySourceConfig config;
  config.candidates = true;
  config.sample = sample;
  return config;
}

/// All pairs of features whose boxes overlap.
std::vector<FeaturePair> naive_candidates(const Step& step, FeatureKind kind) {
  const Features& f = step.features();
  const Index n = kind == FeatureKind::vf ? f.vertex_slots() : f.edge_slots();
  const Index m = kind == FeatureKind::vf ? f.triangle_slots() : f.edge_slots();
  std::vector<FeaturePair> pairs;
  for (Index a = 0; a < n; ++a)
    for (Index b = kind == FeatureKind::vf ? 0 : a + 1; b < m; ++b) {
      const bool live = kind == FeatureKind::vf ? !f.vertex_elements(a).empty() && !f.triangle_elements(b).empty()
                                                : !f.edge_elements(a).empty() && !f.edge_elements(b).empty();
      if (!live || !is_test(f, kind, {a, b})) continue;
      const std::array<Index, 4> v = test_vertices(f, kind, {a, b});
      bool overlap = true;
      for (int k = 0; k < 3; ++k) {
        double low[2] = {1e300, 1e300}, high[2] = {-1e300, -1e300};
        for (std::size_t p = 0; p < 4; ++p)
          for (int c = 0; c < 2; ++c) {
            const std::size_t side = p < (kind == FeatureKind::vf ? 1u : 2u) ? 0 : 1;
            low[side] = std::min(low[side], step.motion.point(v[p], c)[k]);
            high[side] = std::max(high[side], step.motion.point(v[p], c)[k]);
          }
        overlap = overlap && low[0] <= high[1] && low[1] <= high[0];
      }
      if (overlap) pairs.push_back({a, b});
    }
  return pairs;
}

TEST(QuerySource, CandidatesAreAllPairsWithOverlappingBoxes) {
  const ScratchFolder folder;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    random_sequence(seed, 2).write(folder / "s");
    EXPECT_THROW(load_queries(folder / "s", {}), InputError) << "no ground truth";
    const std::vector<KnownQueries> groups = load_queries(folder / "s", candidates());
    ASSERT_EQ(groups.size(), 2u);
    for (const KnownQueries& queries : groups) {
      EXPECT_EQ(queries.pairs, naive_candidates(queries.step, queries.kind));
      EXPECT_TRUE(queries.collides.empty());
    }
    const std::vector<KnownQueries> fewer = load_queries(folder / "s", candidates(20));
    for (std::size_t g = 0; g < 2; ++g) {
      ASSERT_EQ(fewer[g].size(), 20u);
      for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(fewer[g].pairs[i], groups[g].pairs[fewer[g].index[i]]);
    }
  }
}

TEST(QuerySource, TruthIsSpreadOverCandidates) {
  const ScratchFolder folder;
  Sequence s;
  s.point_ids = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int k = 0; k < 2; ++k) {
    Sequence::Step step{
        1.0 * k,
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0.2, 0.2, 1.5 - k}, {1, 1, 2}, {2, 1, 2}, {1, 2, 2}},
        {},
        {},
        {}};
    step.cells.add({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}});
    step.cells.add({.type = ElementType::tetrahedron, .vertices = {4, 5, 6, 7}, .id = 1});
    step.cells.add({.type = ElementType::triangle, .vertices = {0, 1, 2}, .id = 2});
    s.steps.push_back(step);
  }
  s.write(folder / "s");
  for (Sequence::Step& step : s.steps) step.velocity.assign(8, Vec3(0, 0, -0.1));
  s.write(folder / "with");
  for (const char* name : {"s", "with"}) {
    RawFile raw(folder / name);
    raw.group("GroundTruth");
    raw.group("GroundTruth/VertexFace");
    raw.put("GroundTruth/VertexFace/Pairs", {2, 2}, H5T_STD_I32LE, std::vector<std::int64_t>{7, 2, 4, 2});
    raw.put("GroundTruth/VertexFace/Collides", {2}, H5T_STD_U8LE, std::vector<std::int64_t>{0, 0});
  }
  {
    const std::vector<KnownQueries> listed = load_queries(folder / "s", {});
    ASSERT_EQ(listed.size(), 1u);
    ASSERT_EQ(listed[0].size(), 2u);
    EXPECT_EQ(listed[0].pairs[1].a, 4u);
    EXPECT_EQ(listed[0].place(1), "4 | 0 1 2");
  }
  for (const MotionModel other : {MotionModel::quadratic, MotionModel::tentative}) {
    QuerySourceConfig config;
    config.stepper.motion = other;
    try {
      load_queries(folder / "with", config);
      ADD_FAILURE() << "the truth of linear motion was taken for another";
    } catch (const InputError& error) {
      EXPECT_EQ(error.dataset(), "GroundTruth");
      EXPECT_NE(std::string(error.what()).find("linear"), std::string::npos) << error.what();
    }
    config.candidates = true;
    for (const KnownQueries& queries : load_queries(folder / "with", config)) EXPECT_TRUE(queries.collides.empty());
  }
  {
    RawFile raw(folder / "s");
    raw.poke("GroundTruth/VertexFace/Collides", 0, std::int64_t{1});
  }
  EXPECT_THROW(load_queries(folder / "s", candidates()), InputError) << "boxes that do not overlap cannot collide";
}

}  // namespace
}  // namespace volccd::test
