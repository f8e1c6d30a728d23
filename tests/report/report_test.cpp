#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include <unistd.h>
#include <zlib.h>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/mesh/sequence/reader.hpp>
#include <volccd/mesh/sequence/stepper.hpp>
#include <volccd/pictures/surface.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/report/encoding.hpp>
#include <volccd/report/record_data.hpp>
#include <volccd/report/scene_export.hpp>
#include <volccd/report/surface_track.hpp>

namespace volccd {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// A folder that only this test uses, and that is removed at its end.
class TestFolder {
 public:
  explicit TestFolder(const std::string& name)
      : path_(fs::temp_directory_path() / ("volccd-report-" + std::to_string(getpid()) + "-" + name)) {
    fs::create_directories(path_);
  }
  ~TestFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

std::string decoded_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    group = group << 6 | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) {
      bits -= 8;
      bytes += static_cast<char>(group >> bits & 0xff);
    }
  }
  return bytes;
}

std::string inflated(const std::string& bytes, std::size_t size) {
  std::string out(size, '\0');
  uLongf length = size;
  EXPECT_EQ(Z_OK, uncompress(reinterpret_cast<Bytef*>(out.data()), &length,
                             reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size())));
  out.resize(length);
  return out;
}

/// Reads what append_planes() wrote, as the page does.
class Planes {
 public:
  explicit Planes(std::string bytes) : bytes_(std::move(bytes)) {}
  std::vector<std::uint32_t> take(std::size_t count, int width) {
    std::vector<std::uint32_t> values(count);
    for (int plane = 0; plane < width; ++plane)
      for (std::uint32_t& value : values)
        value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes_.at(at_++))) << (8 * plane);
    return values;
  }
  std::string text(std::size_t size) {
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  std::vector<std::vector<std::uint16_t>> frames(const std::vector<int>& orders, std::size_t size) {
    std::vector<std::vector<std::uint16_t>> frames;
    for (std::size_t f = 0; f < orders.size(); ++f) {
      const std::vector<std::uint32_t> codes = take(size, 2);
      std::vector<std::uint16_t> frame(size);
      for (std::size_t i = 0; i < size; ++i) {
        const int prediction = orders[f] == 0   ? (i > 0 ? frame[i - 1] : 0)
                               : orders[f] == 1 ? frames[f - 1][i]
                                                : 2 * frames[f - 1][i] - frames[f - 2][i];
        frame[i] = static_cast<std::uint16_t>(prediction + unzigzag(codes[i]));
      }
      frames.push_back(std::move(frame));
    }
    return frames;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// The contents of a script.
struct Decoded {
  json header;
  std::vector<TrackedTriangle> triangles;
  std::vector<std::set<std::uint32_t>> shown;
  std::vector<std::vector<std::uint16_t>> frames;
  std::vector<std::uint32_t> marks[4], flags;
  std::vector<std::uint32_t> pair_columns[6], pair_kinds;

  /// The distance between neighbouring quantized positions of centroids.
  double pair_unit() const {
    return header.at("box").at("scale").get<double>() / ((1 << header.at("pair_bits").get<int>()) - 1);
  }
  Vec3 pair_end(std::size_t i, bool second) const {
    const double unit = pair_unit();
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) {
      std::int32_t value = static_cast<std::int32_t>(pair_columns[axis][i]);
      if (second) value += unzigzag(pair_columns[3 + axis][i]);
      p[axis] = header.at("box").at("low")[axis].get<double>() + unit * value;
    }
    return p;
  }

  Vec3 place(std::size_t frame, std::size_t vertex) const {
    const double unit = header.at("box").at("scale").get<double>() / ((1 << header.at("bits").get<int>()) - 1);
    const std::size_t n = header.at("vertices").get<std::size_t>();
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = header.at("box").at("low")[axis].get<double>() + unit * frames[frame][axis * n + vertex];
    return p;
  }
};

Decoded decode(const std::string& script) {
  Decoded d;
  const std::size_t begin = script.find(", \"") + 3;
  Planes in(inflated(decoded_base64(script.substr(begin, script.size() - begin - 4)), 200'000'000));
  d.header = json::parse(in.text(in.take(1, 4)[0]));
  const auto count = [&](const char* key) { return d.header.at(key).get<std::size_t>(); };
  std::vector<std::uint32_t> columns[3];
  for (auto& column : columns) column = in.take(count("triangles"), 4);
  const auto parts = in.take(count("triangles"), 2), edges = in.take(count("triangles"), 1);
  Index first = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    first += static_cast<Index>(unzigzag(columns[0][i]));
    d.triangles.push_back({{first, first + static_cast<Index>(unzigzag(columns[1][i])),
                            first + static_cast<Index>(unzigzag(columns[2][i]))},
                           static_cast<std::uint16_t>(parts[i]),
                           static_cast<std::uint8_t>(edges[i])});
  }
  const auto deltas = in.take(count("changes"), 4);
  std::size_t at = 0;
  std::vector<int> orders;
  std::set<std::uint32_t> now;
  for (const json& frame : d.header.at("frames")) {
    orders.push_back(frame.at("order").get<int>());
    std::uint32_t i = 0;
    for (int k = frame.at("added").get<int>(); k > 0; --k) EXPECT_TRUE(now.insert(i += deltas.at(at++)).second);
    i = 0;
    for (int k = frame.at("removed").get<int>(); k > 0; --k) EXPECT_EQ(1u, now.erase(i += deltas.at(at++)));
    d.shown.push_back(now);
  }
  d.frames = in.frames(orders, 3 * count("vertices"));
  for (auto& column : d.marks) column = in.take(count("marks"), 2);
  d.flags = in.take(count("marks"), 1);
  for (auto& column : d.pair_columns) column = in.take(count("pairs"), 2);
  d.pair_kinds = in.take(count("pairs"), 1);
  EXPECT_TRUE(in.at_end());
  return d;
}

TEST(ReportEncoding, Base64IsThatOfTheStandard) {
  // RFC 4648, section 10.
  EXPECT_EQ("", base64(""));
  EXPECT_EQ("Zg==", base64("f"));
  EXPECT_EQ("Zm8=", base64("fo"));
  EXPECT_EQ("Zm9v", base64("foo"));
  EXPECT_EQ("Zm9vYmFy", base64("foobar"));
  EXPECT_EQ("/////w==", base64("\xff\xff\xff\xff"));
}

TEST(ReportEncoding, ZigzagIsSmallWhereTheDifferenceIs) {
  EXPECT_EQ(0u, zigzag(0));
  EXPECT_EQ(1u, zigzag(-1));
  EXPECT_EQ(2u, zigzag(1));
  for (const std::int32_t v : {0, -1, 5, -32768, 32767, INT32_MIN, INT32_MAX}) EXPECT_EQ(v, unzigzag(zigzag(v)));
}

TEST(ReportEncoding, FramesComeBackAndSmoothOnesArePredicted) {
  Random random(1);
  std::vector<std::vector<std::uint16_t>> frames;
  for (int f = 0; f < 6; ++f) {
    std::vector<std::uint16_t>& frame = frames.emplace_back();
    // Linear motion that overflows, then a jump to random values.
    for (int i = 0; i < 500; ++i)
      frame.push_back(static_cast<std::uint16_t>(f < 5 ? 131 * i + f * (900 + i) : random.below(65536)));
  }
  std::string bytes;
  std::vector<int> orders;
  append_frames(bytes, frames, orders);
  EXPECT_EQ(frames, Planes(bytes).frames(orders, 500));
  EXPECT_EQ(0, orders[0]);
  EXPECT_EQ(2, orders[3]);
  EXPECT_EQ(bytes, inflated(deflated(bytes), bytes.size()));
}

SequenceCells two_tetrahedra() {
  SequenceCells cells;
  cells.add({ElementType::tetrahedron, {0, 1, 2, 3}, {}, 7, 0});
  cells.add({ElementType::tetrahedron, {1, 2, 3, 4}, {}, 7, 1});
  return cells;
}

TEST(SurfaceTrackTest, FollowsElementsThatGo) {
  SequenceCells cells = two_tetrahedra(), one;
  one.add(cells.spec(1));
  SurfaceTrack track;
  track.add(cells, 5);
  track.repeat();
  track.add(one, 5);
  ASSERT_EQ(3u, track.frames());
  EXPECT_EQ(6u, track.frame(0).size());  // the common face is inside
  EXPECT_EQ(track.frame(0).data(), track.frame(1).data());
  EXPECT_EQ(4u, track.frame(2).size());
  EXPECT_EQ(7u, track.triangles().size());
  EXPECT_EQ(6u, track.largest_frame());
  ASSERT_EQ(1u, track.parts().size());
  EXPECT_EQ(7, track.parts()[0].id);
  EXPECT_TRUE(track.parts()[0].solid);
}

TEST(SurfaceTrackTest, ClusteringKeepsTheFormAndFewerTriangles) {
  SequenceCells cells;
  std::vector<Vec3> points;
  constexpr Index n = 40;
  for (Index y = 0; y <= n; ++y)
    for (Index x = 0; x <= n; ++x) points.emplace_back(x, y, 0);
  for (Index y = 0; y < n; ++y)
    for (Index x = 0; x < n; ++x) {
      const Index a = y * (n + 1) + x;
      cells.add({ElementType::quad, {a, a + 1, a + n + 2, a + n + 1}, {}, 0, static_cast<std::int64_t>(cells.size())});
    }
  SurfaceTrack track;
  track.add(cells, points.size());
  const SurfaceTrack coarse = track.clustered(points, 4);
  EXPECT_EQ(2u * n * n, track.largest_frame());
  EXPECT_EQ(200u, coarse.largest_frame());  // 11 x 11 cells of the grid
  double area = 0;
  for (const std::uint32_t i : coarse.frame(0)) {
    const auto& v = coarse.triangles()[i].corners;
    area += 0.5 * (points[v[1]] - points[v[0]]).cross(points[v[2]] - points[v[0]]).norm();
  }
  EXPECT_DOUBLE_EQ(1600, area);
}

class SceneExport : public ::testing::Test {
 protected:
  explicit SceneExport(const OptionValues& options = {}) : folder_("scene"), file_(folder_.file("run.vtkhdf")) {
    write_scene(*make_scene("builtin", options), file_);
  }

  ExportedScene run(const SceneExportConfig& config) {
    return export_scene("run", file_, registry_, config, executor_);
  }

  const Registry registry_ = Registry::standard();
  SerialExecutor executor_;
  TestFolder folder_;
  const std::string file_;
};

TEST_F(SceneExport, ShowsSurfacePositionsAndContactsOfTheFile) {
  SceneExportConfig config;
  config.pipeline = registry_.pipeline("VolCCD+");
  const ExportedScene scene = run(config);
  const Decoded d = decode(scene.script);
  SequenceReader reader(file_);
  const int steps = reader.step_count();
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
  SmallSceneExport() : SceneExport({{"elements", "200"}, {"steps", "6"}}) {}
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
  const auto most = [&](std::size_t max_bytes) {
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
  EXPECT_EQ(config.max_pairs, most(10'000'000));
  const std::size_t few = most(30'000);
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
  EXPECT_EQ(SequenceReader(file_).step_count() - 1, d.header.at("frames").back().at("step"));
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

TEST(ReportRecords, TablesAndProvenanceOfTheKeptResults) {
  const json records = records_of(VOLCCD_SOURCE_DIR "/results");
  std::set<std::string> names;
  for (const json& record : records) {
    names.insert(record.at("name").get<std::string>());
    ASSERT_FALSE(record.at("tables").empty()) << record.at("name");
    for (const json& table : record.at("tables")) {
      EXPECT_FALSE(table.at("header").empty());
      for (const json& row : table.at("rows")) EXPECT_LE(row.size(), table.at("header").size()) << table.at("title");
    }
    for (const char* key : {"commit", "cpu", "date"})
      EXPECT_TRUE(record.at("provenance").contains(key)) << record.at("name");
  }
  for (const char* name : {"table1", "culling", "plus", "scenes", "feature-sets"})
    EXPECT_EQ(1u, names.count(name)) << name;
  bool octopi = false;
  for (const RecordedInput& input : inputs_of(records))
    octopi = octopi || (input.scene == "octopi" && input.fnv1a.size() == 16 && !input.records.empty());
  EXPECT_TRUE(octopi);
}

TEST(ReportRecords, PointsAreMediansOverRounds) {
  const TestFolder folder("points");
  json rows = json::array();
  for (const double seconds : {0.5, 0.1, 0.3})
    for (const int motion : {4, 5})
      rows.push_back({{"pipeline", "P"},
                      {"scene", "s"},
                      {"motion", motion},
                      {"seconds", seconds * motion},
                      {"vf_tests", 7},
                      {"narrow_phase_prepare_s", 0.25},
                      {"narrow_phase_run_s", 0.5},
                      {"threads", 1},
                      {"elements", 10}});
  rows.push_back({{"operation", "of another form"}});
  std::ofstream(folder.file("plus.json")) << json{{"experiment", "plus"}, {"schema", 1}, {"rows", rows}};
  const json points = points_of(folder.file(""));
  const json& columns = points.at("columns");
  ASSERT_EQ(2u, columns.at("seconds").size());
  EXPECT_EQ(1.2, columns.at("seconds")[0]);
  EXPECT_EQ(0.4, columns.at("seconds_least")[0]);
  EXPECT_EQ(2.5, columns.at("seconds_most")[1]);
  EXPECT_EQ(3, columns.at("rounds")[0]);
  EXPECT_EQ(0.75, columns.at("narrow_phase_s")[1]);
  EXPECT_EQ("s", points.at("texts")[columns.at("scene")[0].get<std::size_t>()]);
}

TEST(ReportRecords, AFolderWithoutRecordsIsAnError) {
  const TestFolder folder("empty");
  try {
    records_of(folder.file(""));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string::npos, std::string(error.what()).find("volccd experiment run"));
  }
}

}  // namespace
}  // namespace volccd
