#include <volccd/experiments/scenes/simulated/bake.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <tuple>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/sequence_statistics.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

namespace fs = std::filesystem;

int models_made = 0;

/// A bar of hexahedra that is torn apart: its ends move away from each other, and vertices in the middle split.
simulation::Model torn_bar(int elements, std::uint64_t seed) {
  ++models_made;
  const Shape bar = block(ElementType::hexahedron, elements, 1, 1);
  simulation::Model model;
  model.mesh.add_vertices(static_cast<Index>(bar.positions.size()));
  for (ElementSpec element : bar.elements) {
    element.object = 0;
    model.mesh.add_element(element);
  }
  model.positions = bar.positions;
  const double middle = 0.5 * elements, speed = 10.0 + static_cast<double>(seed);
  for (const Vec3& x : model.positions) model.velocities.push_back(Vec3((x.x() - middle) / middle * speed, 0, 0));
  simulation::Body body{"bar", {}, 0, false};
  body.material.youngs_modulus = 1e6;
  body.material.failure_stress = 3e4;
  model.bodies = {body};
  return model;
}

SimulatedScene bar_scene() {
  SimulatedScene scene;
  scene.name = "torn-bar";
  scene.description = "a bar that is torn apart";
  scene.model = torn_bar;
  scene.default_elements = 4;
  scene.quick_elements = 2;
  scene.frames = 6;
  scene.duration = 0.1;
  return scene;
}

/// A cache that only this test uses.
class Bake : public testing::Test {
 protected:
  Bake() { use_cache("cache"); }
  ~Bake() override {
    unsetenv("VOLCCD_CACHE");
    fs::remove_all(root());
  }
  static fs::path root() { return fs::temp_directory_path() / ("volccd-bake-" + std::to_string(getpid())); }
  static void use_cache(const std::string& name) { setenv("VOLCCD_CACHE", (root() / name).c_str(), 1); }

  SerialExecutor serial_;
};

/// All contents of a sequence, for comparisons bit for bit.
void expect_equal(const std::string& a, const std::string& b) {
  SequenceReader one(a), other(b);
  ASSERT_EQ(one.frame_count(), other.frame_count());
  ASSERT_EQ(one.metadata(), other.metadata());
  ASSERT_TRUE(
      std::equal(one.point_ids().begin(), one.point_ids().end(), other.point_ids().begin(), other.point_ids().end()));
  for (int k = 0; k < one.frame_count(); ++k) {
    std::vector<Vec3> x, y;
    SequenceCells c, d;
    one.read_points(k, x), other.read_points(k, y);
    EXPECT_EQ(x, y) << k;
    one.read_velocity(k, x), other.read_velocity(k, y);
    EXPECT_EQ(x, y) << k;
    one.read_cells(k, c), other.read_cells(k, d);
    EXPECT_EQ(c, d) << k;
    EXPECT_EQ(one.time(k), other.time(k));
    ASSERT_TRUE(one.has_query() && other.has_query());
    std::vector<Vec3> x1, y1;
    EXPECT_EQ(one.read_query(k, x, x1), other.read_query(k, y, y1));
    EXPECT_EQ(x, y) << k;
    EXPECT_EQ(x1, y1) << k;
  }
}

TEST_F(Bake, TwiceTheSameAndFromTheCacheTheThirdTime) {
  const SimulatedScene scene = bar_scene();
  const auto threads = make_executor(2);
  const std::string first = *bake(scene, {}, serial_);
  use_cache("other");
  const std::string second = *bake(scene, {}, *threads);
  ASSERT_NE(first, second);
  expect_equal(first, second);

  const int made = models_made;
  int calls = 0;
  EXPECT_EQ(bake(scene, {}, serial_, {[&](int, int) { ++calls; }, {}}), second);
  EXPECT_EQ(models_made, made);
  EXPECT_EQ(calls, 0);
  for (const auto& entry : fs::recursive_directory_iterator(root()))
    EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
}

TEST_F(Bake, TheFirstFrameMayBeLaterThanTheFirstMoment) {
  SimulatedScene scene = bar_scene();
  SequenceReader from_zero(*bake(scene, {}, serial_));
  scene.begin = 0.02;  // the time of the second frame of the other bake
  scene.duration = 0.08;
  scene.frames = 5;
  use_cache("other");
  SequenceReader later(*bake(scene, {}, serial_));
  EXPECT_EQ(later.frame_count(), 5);
  EXPECT_EQ(later.time(0), 0.02);
  EXPECT_EQ(later.time(4), 0.1);
  std::vector<Vec3> x, y;
  from_zero.read_points(1, x);
  later.read_points(0, y);
  const std::size_t untorn = 20;  // the vertices that exist in both bakes; new ones may differ
  x.resize(untorn), y.resize(untorn);
  EXPECT_EQ(x, y);
}

TEST_F(Bake, TheBarIsTornAndItsRecordSaysSo) {
  const SimulatedScene scene = bar_scene();
  SequenceReader reader(*bake(scene, {}, serial_));
  reader.check_contents();
  EXPECT_EQ(reader.frame_count(), 6);
  EXPECT_EQ(reader.time(5), 0.1);
  EXPECT_TRUE(reader.has_velocity());
  EXPECT_FALSE(reader.has_thickness());
  EXPECT_EQ(reader.metadata().object_names.at(1), "bar");
  EXPECT_GT(reader.point_count(), 20u);
  SequenceCells cells;
  reader.read_cells(5, cells);
  EXPECT_EQ(cells.size(), 4u);
  EXPECT_EQ(std::set<std::int32_t>(cells.objects.begin(), cells.objects.end()), std::set<std::int32_t>{1});

  std::ifstream in(bake_record_file(scene, {}));
  const nlohmann::json record = nlohmann::json::parse(in);
  ASSERT_EQ(record["frames"].size(), 6u);
  std::uint64_t splits = 0;
  for (const auto& frame : record["frames"]) splits += frame["edits"]["splits"].get<std::uint64_t>();
  EXPECT_GT(splits, 0u);

  const std::vector<StepStatistics> steps = sequence_statistics(reader, serial_);
  ASSERT_EQ(steps.size(), 5u);
  std::uint64_t edits = 0;
  for (const StepStatistics& step : steps) {
    EXPECT_EQ(step.elements.at(ElementType::hexahedron), 4u);
    EXPECT_EQ(step.added, step.removed);
    EXPECT_GT(step.largest_motion, 0);
    edits += step.added;
  }
  EXPECT_GT(edits, 0u);
}

/// The bar touches nothing. So the last query ends at the frame and begins one
/// substep earlier, also for the vertices that splitting has created.
TEST_F(Bake, EachFrameHasTheLastQueryOfItsSimulation) {
  SequenceReader reader(*bake(bar_scene(), {}, serial_));
  ASSERT_TRUE(reader.has_query());
  std::vector<Vec3> before, x, start, end;
  for (int k = 0; k < reader.frame_count(); ++k) {
    reader.read_points(k, x);
    const double separation = reader.read_query(k, start, end);
    SequenceCells cells;
    reader.read_cells(k, cells);
    double of_query = 0, of_frame = 0;
    for (const Index v : cells.connectivity) {
      EXPECT_EQ(end[v], x[v]) << k << " " << v;
      of_query += (x[v] - start[v]).norm();
      of_frame += k > 0 ? (x[v] - before[v]).norm() : 0;
    }
    if (k == 0) {
      EXPECT_EQ(of_query, 0) << "nothing has been asked";
    } else {
      EXPECT_GT(separation, 0);
      EXPECT_GT(of_query, 0);
      EXPECT_LT(of_query, 0.8 * of_frame) << k;
    }
    before = x;
  }
}

TEST_F(Bake, GoesOnWhereItStopped) {
  const SimulatedScene scene = bar_scene();
  const std::string whole = *bake(scene, {}, serial_);
  use_cache("stopped");
  std::vector<int> done;
  const auto note = [&](int k, int) { done.push_back(k); };
  EXPECT_EQ(bake(scene, {}, serial_, {note, [&] { return !done.empty() && done.back() == 2; }}), std::nullopt);
  EXPECT_EQ(bake(scene, {}, serial_, {note, [&] { return !done.empty() && done.back() == 5; }}), std::nullopt);
  const std::optional<std::string> resumed = bake(scene, {}, serial_, {note, {}});
  ASSERT_TRUE(resumed);
  EXPECT_EQ(done, (std::vector<int>{0, 1, 2, 2, 3, 4, 5, 5, 6}));
  expect_equal(whole, *resumed);
}

TEST_F(Bake, TellsHowFarAFrameIsAndStopsWithinIt) {
  SimulatedScene scene = bar_scene();
  scene.options.max_step = 0.003;  // at least seven steps in each frame
  const std::string whole = *bake(scene, {}, serial_);
  use_cache("stopped");
  std::vector<std::pair<int, double>> shares;
  BakeHooks hooks;
  hooks.within_frame = [&](int done, double share) { shares.emplace_back(done, share); };
  // The second interruption comes in the same frame, which has begun anew: nothing of an incomplete frame is kept.
  for (int round = 0; round < 2; ++round) {
    hooks.interrupted = [&] { return !shares.empty() && shares.back().first == 3 && shares.back().second > 0.5; };
    EXPECT_EQ(bake(scene, {}, serial_, hooks), std::nullopt);
    EXPECT_GT(shares.size(), 3u);
    EXPECT_EQ(shares.back().first, 3);
    EXPECT_LT(shares.back().second, 0.75);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
    EXPECT_EQ(std::adjacent_find(shares.begin(), shares.end()), shares.end());
    for (const auto& [done, share] : shares) EXPECT_TRUE(done > 0 && share > 0 && share < 1) << done << ' ' << share;
    EXPECT_EQ(shares.front().first, round == 0 ? 1 : 3);
    shares.clear();
  }
  hooks.interrupted = {};
  const std::optional<std::string> resumed = bake(scene, {}, serial_, hooks);
  ASSERT_TRUE(resumed);
  expect_equal(whole, *resumed);
}

TEST_F(Bake, AStateOfAnotherBuildIsNotUsed) {
  const SimulatedScene scene = bar_scene();
  int last = 0;
  const auto note = [&](int k, int) { last = k; };
  EXPECT_EQ(bake(scene, {}, serial_, {note, [&] { return last == 3; }}), std::nullopt);
  const std::string state = baked_file(scene, {}).substr(0, baked_file(scene, {}).size() - 7) + ".partial/state";
  ASSERT_TRUE(fs::exists(state));
  // The same state with the signature of another build.
  std::fstream(state, std::ios::binary | std::ios::in | std::ios::out) << '?';
  std::vector<int> done;
  const std::string again = *bake(scene, {}, serial_, {[&](int k, int) { done.push_back(k); }, {}});
  EXPECT_EQ(done.front(), 0);
  use_cache("other");
  expect_equal(again, *bake(scene, {}, serial_));
}

TEST_F(Bake, SettingsNameTheFile) {
  const SimulatedScene scene = bar_scene();
  SimulatedScene newer = scene;
  ++newer.version;
  const std::set<std::string> files = {baked_file(scene, {}), baked_file(scene, {5, 0, 1}),
                                       baked_file(scene, {0, 7, 1}), baked_file(scene, {0, 0, 2}),
                                       baked_file(newer, {})};
  EXPECT_EQ(files.size(), 5u);
  EXPECT_EQ(baked_file(scene, {4, 6, 1}), baked_file(scene, {}));
  EXPECT_THROW(baked_file(scene, {0, 1, 1}), ConfigError);
  EXPECT_THROW(baked_file(scene, {-1, 0, 1}), ConfigError);
}

TEST_F(Bake, NamesBecomeFiles) {
  EXPECT_EQ(resolve_scene("no-such-scene", serial_), "no-such-scene");
  const std::string builtin = *resolve_scene("builtin", serial_);
  EXPECT_EQ(SequenceReader(builtin).frame_count(), 9);
  EXPECT_EQ(resolve_scene(builtin, serial_), builtin);
  EXPECT_EQ(resolve_scene("deform", serial_), "deform");  // requires a mesh
  copy_file_whole(builtin, (root() / "openradioss-bullet.vtkhdf").string());
  setenv("VOLCCD_DATA", root().c_str(), 1);
  const std::vector<ExternalScene> external = external_scenes();
  const std::optional<std::string> file = resolve_scene("openradioss-bullet", serial_);
  unsetenv("VOLCCD_DATA");
  ASSERT_EQ(external.size(), 1u);
  EXPECT_EQ(external[0].name, "openradioss-bullet");
  EXPECT_EQ(file, (root() / "openradioss-bullet.vtkhdf").string());
}

TEST(SceneToBake, IsASizeAndASeed) {
  const SimulatedScene* liver = find_simulated_scene("liver");
  for (const auto& [name, elements, seed] :
       {std::tuple("liver", 0, 1u), std::tuple("liver-quick", liver->quick_elements, 1u),
        std::tuple("liver-seed-20", 0, 20u), std::tuple("liver-quick-seed-3", liver->quick_elements, 3u)}) {
    const std::optional<SceneToBake> found = scene_to_bake(name);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(found->scene, liver);
    EXPECT_EQ(found->settings.elements, elements) << name;
    EXPECT_EQ(found->settings.seed, seed) << name;
  }
  for (const char* name : {"liver-seed-", "liver-seed-x", "liver-seed-2-quick", "liver-quick-quick", "-quick",
                           "builtin", "liver-seed--1", "liver-seed-99999999999999999999"})
    EXPECT_FALSE(scene_to_bake(name)) << name;
}

TEST(SimulatedScenes, TheListHasThemAll) {
  std::set<std::string> names, variants;
  for (const SimulatedScene& scene : simulated_scenes()) {
    EXPECT_TRUE((scene.variant_of.empty() ? names : variants).insert(scene.name).second);
    EXPECT_TRUE(scene.variant_of.empty() || names.contains(scene.variant_of));
    EXPECT_EQ(find_simulated_scene(scene.name), &scene);
    EXPECT_FALSE(scene.description.empty());
    EXPECT_NE(scene.model, nullptr);
    EXPECT_GE(scene.frames, 60);
    EXPECT_LE(scene.frames, 100);
    EXPECT_GT(scene.duration, 0);
    EXPECT_LT(scene.quick_elements, scene.default_elements);
  }
  EXPECT_EQ(names, (std::set<std::string>{"airbag", "bullet", "crash", "liver", "octopi", "weld"}));
  EXPECT_EQ(variants, (std::set<std::string>{"bullet-boundary", "bullet-surface"}));
  EXPECT_EQ(find_simulated_scene("none"), nullptr);
}

}  // namespace
}  // namespace volccd
