// The script of a scene: its surface, its contacts and pairs, and what becomes coarser when it is too large.
#include <volccd/report/scene_export.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/pictures/surface.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "report/decode_script.hpp"
#include "support/all_stages.hpp"
#include "support/scratch_folder.hpp"

namespace volccd {
namespace {

using nlohmann::json;
using test::decode;
using test::Decoded;

class SceneExport : public ::testing::Test {
 protected:
  explicit SceneExport(const OptionValues& options = {}) : file_(folder_ / "run.vtkhdf") {
    write_scene(*make_scene("builtin", options), file_);
  }

  ExportedScene run(const SceneExportConfig& config) {
    return export_scene("run", file_, registry_, config, executor_);
  }

  const Registry registry_ = test::all_stages();
  SerialExecutor executor_;
  const test::ScratchFolder folder_;
  const std::string file_;
};

TEST_F(SceneExport, ShowsSurfacePositionsAndContactsOfTheFile) {
  SceneExportConfig config;
  config.pipeline = registry_.pipeline("VolCCD+");
  const ExportedScene scene = run(config);
  const Decoded d = decode(scene.script);
  SequenceReader reader(file_);
  const int steps = reader.frame_count();
  ASSERT_EQ(static_cast<std::size_t>(steps), d.frames.size());
  EXPECT_EQ(16, d.header.at("bits"));
  EXPECT_TRUE(scene.summary.at("notes").empty()) << scene.summary.at("notes");

  // Vertices of the page, as slots of the file.
  std::set<Index> used;
  for (int k = 0; k < steps; ++k) {
    SequenceCells cells;
    reader.read_cells(std::min(k + 1, steps - 1), cells);
    const std::vector<std::uint16_t> colours(cells.size(), 0);
    for (const SurfaceTriangle& t : boundary_triangles(cells, reader.point_count(), colours))
      used.insert(t.corners.begin(), t.corners.end());
    ASSERT_EQ(boundary_triangles(cells, reader.point_count(), colours).size(),
              d.shown[static_cast<std::size_t>(k)].size())
        << k;
  }
  const std::vector<Index> slots(used.begin(), used.end());
  ASSERT_EQ(slots.size(), d.header.at("vertices").get<std::size_t>());
  const double tolerance = d.header.at("box").at("scale").get<double>() / 65535;
  std::vector<Vec3> points;
  for (int k = 0; k < steps; ++k) {
    reader.read_points(k, points);
    for (const std::uint32_t i : d.shown[static_cast<std::size_t>(k)])
      for (const Index v : d.triangles[i].corners)
        ASSERT_LT((d.place(static_cast<std::size_t>(k), v) - points[slots[v]]).cwiseAbs().maxCoeff(), tolerance) << k;
  }

  const Pipeline pipeline(registry_, registry_.pipeline("VolCCD+"));
  Workspace workspace = pipeline.make_workspace();
  SequenceStepper stepper(reader);
  const ObjectFilter filter;
  StepResult result;
  std::size_t mark = 0, all = 0;
  for (int k = 0; k + 1 < steps; ++k) {
    stepper.go_to(k);
    pipeline.run({stepper.topology(), stepper.motion(), filter}, workspace, executor_, result);
    const json& motion = d.header.at("motions").at(static_cast<std::size_t>(k));
    ASSERT_EQ(result.contacts.size(), motion.at("shown").get<std::size_t>());
    EXPECT_EQ(result.statistics.element_pairs, motion.at("stats").at("element_pairs").get<std::uint64_t>());
    EXPECT_EQ(result.statistics.stages.size(), motion.at("stats").at("stages").size());
    for (const Contact& contact : result.contacts) {
      EXPECT_EQ(contact.kind == FeatureKind::ee, (d.flags[mark] & 1) != 0);
      EXPECT_EQ(contact.at_start, (d.flags[mark] & 4) != 0);
      EXPECT_NEAR(contact.toi, d.marks[3][mark] / 65535.0, 1e-5);
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(contact.point[axis],
                    d.header.at("box").at("low")[axis].get<double>() + tolerance * d.marks[axis][mark], tolerance);
      ++mark;
    }
    all += result.contacts.size();
  }
  EXPECT_EQ(d.flags.size(), mark);
  EXPECT_GT(all, 0u);
}

/// Used by tests that export every pair.
class SmallSceneExport : public SceneExport {
 protected:
  SmallSceneExport() : SceneExport({{"elements", "200"}, {"frames", "6"}}) {}
};

/// Numbers of pairs that a stage dropped and kept in a motion, as the statistics count them.
std::array<std::uint64_t, 2> counted(const json& stage) {
  const std::string role = stage.at("role");
  const auto in = stage.at("in").get<std::uint64_t>(), out = stage.at("out").get<std::uint64_t>();
  const bool filters = role == "element-culling" || role == "feature-filter" || role == "narrow-phase";
  return {filters ? in - out : 0, out};
}

TEST_F(SmallSceneExport, ShowsAllPairsThatTheStagesCount) {
  SceneExportConfig config;
  config.pipeline = registry_.pipeline("VolCCD");  // processes each pair once
  config.max_pairs = 1'000'000;
  config.max_bytes = 4'000'000'000;
  const Decoded d = decode(run(config).script);
  std::uint64_t all = 0, dropped = 0;
  for (const json& motion : d.header.at("motions"))
    for (std::size_t i = 0; i < motion.at("pairs").size(); ++i) {
      const json& stage = motion.at("stats").at("stages").at(i);
      const auto [stage_dropped, stage_kept] = counted(stage);
      EXPECT_EQ(stage_dropped, motion.at("pairs")[i][0].get<std::uint64_t>()) << stage;
      EXPECT_EQ(stage_kept, motion.at("pairs")[i][1].get<std::uint64_t>()) << stage;
      all += stage_dropped + stage_kept;
      dropped += stage_dropped;
    }
  EXPECT_EQ(all, d.header.at("pairs").get<std::uint64_t>());
  EXPECT_GT(dropped, 0u);
}

TEST_F(SmallSceneExport, PairsOfTheNarrowPhaseAreDrawnAtTheFeaturesOfContacts) {
  SceneExportConfig config;
  config.pipeline = registry_.pipeline("VolCCD");
  config.max_pairs = 1'000'000;
  config.max_bytes = 4'000'000'000;
  const Decoded d = decode(run(config).script);
  const double unit = d.pair_unit();
  const Pipeline pipeline(registry_, *config.pipeline);
  Workspace workspace = pipeline.make_workspace();
  SequenceReader reader(file_);
  SequenceStepper stepper(reader);
  const ObjectFilter filter;
  StepResult result;
  std::size_t at = 0, found = 0;
  for (std::size_t k = 0; k < d.header.at("motions").size(); ++k) {
    stepper.go_to(static_cast<int>(k));
    pipeline.run({stepper.topology(), stepper.motion(), filter}, workspace, executor_, result);
    std::size_t first = at, kept = 0;
    for (const json& counts : d.header.at("motions")[k].at("pairs")) {
      first = at + counts[0].get<std::size_t>();
      kept = counts[1].get<std::size_t>();
      at = first + kept;
    }
    ASSERT_EQ(result.contacts.size(), kept);
    for (const Contact& contact : result.contacts) {
      const bool ee = contact.kind == FeatureKind::ee;
      Vec3 p[4], ends[2];
      for (int i = 0; i < 4; ++i) p[i] = stepper.motion().position(contact.vertices[static_cast<std::size_t>(i)], 0.5);
      ends[0] = ee ? Vec3((p[0] + p[1]) / 2) : p[0];
      ends[1] = ee ? Vec3((p[2] + p[3]) / 2) : Vec3((p[1] + p[2] + p[3]) / 3);
      const auto drawn_here = [&](std::size_t i) {
        return d.pair_kinds[i] == (ee ? 2u : 1u) && (d.pair_end(i, false) - ends[0]).cwiseAbs().maxCoeff() < unit &&
               (d.pair_end(i, true) - ends[1]).cwiseAbs().maxCoeff() < unit;
      };
      bool drawn = false;
      for (std::size_t i = first; i < first + kept && !drawn; ++i) drawn = drawn_here(i);
      EXPECT_TRUE(drawn) << "motion " << k;
      found += drawn ? 1 : 0;
    }
  }
  EXPECT_GT(found, 0u);
}

TEST_F(SmallSceneExport, ThinnedPairsDependOnNoNumberOfWorkers) {
  SceneExportConfig config;
  config.pipeline = registry_.pipeline("VolCCD+");
  config.max_pairs = 3;
  const Decoded serial = decode(run(config).script);
  const auto threads = make_thread_executor(3);
  const Decoded parallel = decode(export_scene("run", file_, registry_, config, *threads).script);
  EXPECT_EQ(serial.pair_kinds, parallel.pair_kinds);
  for (std::size_t column = 0; column < 6; ++column)
    EXPECT_EQ(serial.pair_columns[column], parallel.pair_columns[column]);
  std::size_t thinned = 0;
  for (const json& motion : serial.header.at("motions"))
    for (std::size_t i = 0; i < motion.at("pairs").size(); ++i)
      for (std::size_t outcome = 0; outcome < 2; ++outcome) {
        const std::uint64_t all = counted(motion.at("stats").at("stages").at(i))[outcome];
        const auto shown = motion.at("pairs")[i][outcome].get<std::uint64_t>();
        EXPECT_LE(shown, std::min<std::uint64_t>(all, 3));
        EXPECT_EQ(all > 0, shown > 0);
        thinned += all > 3 ? 1 : 0;
      }
  EXPECT_GT(thinned, 0u);
}

TEST_F(SmallSceneExport, PairsTakeASixthOfTheScriptAtMost) {
  SceneExportConfig config;
  config.pipeline = registry_.pipeline("VolCCD");
  const auto max = [&](std::size_t max_bytes) {
    config.max_bytes = max_bytes;
    std::size_t shown = 0;
    const Decoded d = decode(run(config).script);
    for (const json& motion : d.header.at("motions"))
      for (const json& counts : motion.at("pairs"))
        for (const json& count : counts) shown = std::max(shown, count.get<std::size_t>());
    std::string bytes;
    for (const auto& column : d.pair_columns) append_planes(bytes, column, 2);
    append_planes(bytes, d.pair_kinds, 1);
    EXPECT_LE(base64(deflated(bytes)).size(), max_bytes / 6 + 2) << "base64 rounds up to whole groups";
    return shown;
  };
  EXPECT_EQ(config.max_pairs, max(10'000'000));
  const std::size_t few = max(30'000);
  EXPECT_GT(config.max_pairs / 2, few);
  EXPECT_LT(1u, few) << "one pair is drawn even if it takes more";
}

TEST_F(SceneExport, BecomesCoarserWhereItWouldBeTooLargeAndSaysSo) {
  SceneExportConfig config;
  const std::size_t whole = run(config).script.size();
  config.max_bytes = whole / 3;
  const ExportedScene coarse = run(config);
  const Decoded d = decode(coarse.script);
  EXPECT_LT(coarse.script.size(), whole);
  EXPECT_EQ(12, d.header.at("bits"));
  EXPECT_TRUE(d.header.at("detection").is_null());
  ASSERT_FALSE(coarse.summary.at("notes").empty());
  EXPECT_NE(std::string::npos, coarse.summary.at("notes").dump().find("frames are shown")) << coarse.summary.dump();
  EXPECT_EQ(0, d.header.at("frames").front().at("step"));
  EXPECT_EQ(SequenceReader(file_).frame_count() - 1, d.header.at("frames").back().at("step"));
}

TEST_F(SceneExport, ThinsTrianglesAndContactsButCountsThemAll) {
  SceneExportConfig config;
  config.pipeline = registry_.pipeline("VolCCD+");
  const json full = decode(run(config).script).header;
  config.max_triangles = full.at("triangles").get<std::size_t>() / 4;
  config.max_contacts = 1;
  const ExportedScene thin = run(config);
  const Decoded d = decode(thin.script);
  for (const auto& shown : d.shown) EXPECT_LE(shown.size(), config.max_triangles);
  EXPECT_GT(d.triangles.size(), 0u);
  for (std::size_t k = 0; k < full.at("motions").size(); ++k) {
    EXPECT_LE(d.header.at("motions")[k].at("shown").get<int>(), 1);
    EXPECT_EQ(full.at("motions")[k].at("stats").at("contacts"), d.header.at("motions")[k].at("stats").at("contacts"));
  }
  EXPECT_EQ(2u, thin.summary.at("notes").size()) << thin.summary.at("notes");
}

}  // namespace
}  // namespace volccd
