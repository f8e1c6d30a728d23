#include <volccd/experiments/scenes/scene.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/builtin.hpp>
#include <volccd/experiments/scenes/deform.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/writer.hpp>

#include "support/scratch_folder.hpp"

namespace volccd {
namespace {

TEST(SceneList, EveryDefaultIsAcceptedAsAValue) {
  const Shape mesh = block(ElementType::hexahedron, 3, 2, 2);
  std::set<std::string> names;
  for (const SceneDescriptor& scene : scenes()) {
    EXPECT_TRUE(names.insert(scene.name).second);
    EXPECT_FALSE(scene.description.empty());
    OptionValues values;
    for (const OptionInfo& option : scene.options)
      if (!option.default_value.empty()) values[option.name] = option.default_value;
    const Shape* wanted = scene.needs_mesh ? &mesh : nullptr;
    const auto spelled_out = make_scene(scene.name, values, wanted), plain = make_scene(scene.name, {}, wanted);
    ASSERT_EQ(spelled_out->frames(), plain->frames());
    std::vector<Vec3> x, y;
    spelled_out->positions(plain->frames() - 1, x);
    plain->positions(plain->frames() - 1, y);
    EXPECT_EQ(x, y);
  }
  EXPECT_TRUE(names.contains("deform") && names.contains("builtin"));
}

TEST(SceneList, OptionsReachTheScene) {
  const Shape mesh = block(ElementType::hexahedron, 3, 2, 2);
  const auto scene = make_scene(
      "deform", {{"motion", "collide"}, {"amount", "0.5"}, {"copies", "4"}, {"frames", "6"}, {"seed", "3"}}, &mesh);
  EXPECT_EQ(scene->frames(), 6);
  EXPECT_EQ(scene->vertex_count(), 4 * mesh.positions.size());
  std::vector<Vec3> x, y;
  scene->positions(5, x);
  make_deform(mesh, {.motions = {{DeformKind::collide, 0.5}}, .copies = 4, .frames = 6, .seed = 3})->positions(5, y);
  EXPECT_EQ(x, y);
  EXPECT_EQ(make_scene("builtin", {{"frames", "5"}})->frames(), 5);
}

TEST(SceneList, FramesBeforeAStopAreKeptAndMarked) {
  const test::ScratchFolder folder;
  const std::string file = folder / "stopped.vtkhdf";
  const auto scene = make_scene("builtin", {{"elements", "300"}, {"frames", "9"}});
  EXPECT_EQ(write_scene(*scene, file, [](int) { return false; }).done, 0);
  EXPECT_FALSE(std::filesystem::exists(file)) << "no frame, no file";
  const StepsDone steps = write_scene(*scene, file, [](int done) { return done < 4; });
  EXPECT_EQ(steps.text(), "frames 0 to 3 of 0 to 8 are complete; interrupted");
  const SequenceReader reader(file);
  EXPECT_EQ(reader.frame_count(), 4);
  EXPECT_EQ(reader.metadata().incomplete, steps.text());
}

TEST(SceneList, RefusesWhatItDoesNotKnow) {
  const Shape mesh = block(ElementType::hexahedron, 3, 2, 2);
  EXPECT_THROW(make_scene("nosuch", {}), ConfigError);
  EXPECT_THROW(make_scene("deform", {}), ConfigError);
  EXPECT_THROW(make_scene("builtin", {}, &mesh), ConfigError);
  EXPECT_THROW(make_scene("deform", {{"frames", "1"}}, &mesh), ConfigError);
  EXPECT_THROW(make_scene("deform", {{"frames", "two"}}, &mesh), ConfigError);
  EXPECT_THROW(make_scene("deform", {{"speed", "2"}}, &mesh), ConfigError);
  EXPECT_THROW(make_scene("deform", {{"amount", "nan"}}, &mesh), ConfigError);
  EXPECT_THROW(make_scene("deform", {{"motion", "fly"}}, &mesh), ConfigError);
  EXPECT_THROW(make_scene("builtin", {{"elements", "12"}}), ConfigError);
}

TEST(SceneFile, HoldsTheScene) {
  const test::ScratchFolder folder;
  const std::string file = folder / "scene.vtkhdf";
  const auto scene = make_builtin({.elements = 300, .frames = 6});
  write_scene(*scene, file);
  SequenceReader reader(file);
  ASSERT_EQ(reader.frame_count(), 6);
  EXPECT_EQ(reader.metadata(), scene->metadata());
  std::vector<Vec3> x, y;
  SequenceCells a, b;
  for (int k = 0; k < 6; ++k) {
    EXPECT_EQ(reader.time(k), scene->time(k));
    scene->positions(k, x);
    reader.read_points(k, y);
    EXPECT_EQ(x, y);
    scene->cells(k, a);
    reader.read_cells(k, b);
    EXPECT_EQ(a, b);
  }
}

TEST(ShapeFromFile, LeavesOutUnusedVertices) {
  const test::ScratchFolder folder;
  const std::string file = folder / "shape.vtkhdf";
  const Shape mesh = block(ElementType::hexahedron, 2, 1, 1);
  {
    SequenceWriter writer(file, std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
    std::vector<Vec3> points = mesh.positions;
    points.insert(points.begin(), Vec3(-99, 0, 0));
    SequenceCells cells;
    for (ElementSpec e : mesh.elements) {
      for (Index& v : e.vertices) ++v;
      e.id += 70;
      e.object = 5;
      cells.add(e);
    }
    writer.write_frame(0, points, cells);
    writer.finish();
  }
  const Shape read = shape_from_file(file);
  EXPECT_EQ(read.positions, mesh.positions);
  ASSERT_EQ(read.elements.size(), 2u);
  EXPECT_EQ(read.elements[1].vertices, mesh.elements[1].vertices);
  EXPECT_EQ(read.elements[1].id, 71);
  EXPECT_EQ(read.elements[1].object, 5);
  EXPECT_THROW(shape_from_file(file, 1), ConfigError);
  EXPECT_THROW(shape_from_file(file, -1), ConfigError);
  EXPECT_THROW(shape_from_file("/nonexistent/file.vtkhdf"), InputError);
}

}  // namespace
}  // namespace volccd
