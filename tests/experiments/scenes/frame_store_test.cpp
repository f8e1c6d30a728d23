#include <volccd/experiments/scenes/simulated/frame_store.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include <unistd.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/reader.hpp>

#include "support/full_disk.hpp"

namespace volccd {
namespace {

class FrameStore : public testing::Test {
 protected:
  FrameStore() {
    folder_ = std::filesystem::temp_directory_path() / ("volccd-frames-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~FrameStore() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::filesystem::path folder_;
};

/// Two triangles on vertices 0 .. 3 that move upwards. From frame 2 on the second one has a vertex of its own, from
/// frame 3 on both have.
Frame frame(int k) {
  Frame f;
  f.time = 0.5 * k;
  f.seconds = k;
  const int vertices = k < 2 ? 4 : k < 3 ? 5 : 6;
  for (int v = 0; v < vertices; ++v) {
    f.vertex_ids.push_back(v);
    f.positions.push_back(Vec3(v, v % 2, k));
    f.velocities.push_back(Vec3(v + 1, 0, 2));
    f.query_start.push_back(Vec3(v, 7, k));
    f.query_end.push_back(Vec3(v, 8, k));
  }
  if (k == 2) f.start_positions = {Vec3(0.25, 0, 1.5)};
  if (k == 3) f.start_positions = {Vec3(0.75, 0, 2.5)};
  const Index a = k < 3 ? 1 : 5, b = k < 2 ? 1 : 4;
  f.cells.add({.type = ElementType::triangle, .vertices = {0, a, 2}, .object = 1, .id = 7});
  f.cells.add({.type = ElementType::triangle, .vertices = {b, 3, 2}, .object = 2, .id = 8});
  f.thickness = {0.125, 0.25};
  f.query_separation = 0.25 + k;
  f.counts.inter = static_cast<std::uint64_t>(k);
  f.ledger.kinetic = 3.5;
  f.ledger.momentum = Vec3(1, 2, 3);
  return f;
}

TEST_F(FrameStore, AFullDiskIsAnErrorWithTheReasonAndLeavesWhatWasThere) {
  write_frame(path("frame"), frame(0));
  for (const std::int64_t room : {0, 300}) {
    std::string message;
    try {
      const test::FullDisk disk(room);
      write_frame(path("frame"), frame(1));
    } catch (const InputError& error) {
      message = error.what();
    }
    EXPECT_EQ(message, path("frame") + ": cannot be written: File too large");
    EXPECT_EQ(read_frame(path("frame")).time, frame(0).time);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
  }
}

TEST_F(FrameStore, FramesComeBack) {
  const Frame written = frame(3);
  write_frame(path("f"), written);
  const Frame read = read_frame(path("f"));
  EXPECT_EQ(read.time, written.time);
  EXPECT_EQ(read.vertex_ids, written.vertex_ids);
  EXPECT_EQ(read.positions, written.positions);
  EXPECT_EQ(read.velocities, written.velocities);
  EXPECT_EQ(read.start_positions, written.start_positions);
  EXPECT_EQ(read.query_start, written.query_start);
  EXPECT_EQ(read.query_end, written.query_end);
  EXPECT_EQ(read.query_separation, 3.25);
  EXPECT_EQ(read.cells, written.cells);
  EXPECT_EQ(read.thickness, written.thickness);
  EXPECT_EQ(read.counts.inter, 3u);
  EXPECT_EQ(read.ledger.kinetic, 3.5);
  EXPECT_EQ(read.ledger.momentum, Vec3(1, 2, 3));
  EXPECT_FALSE(std::filesystem::exists(path("f.tmp")));
}

TEST_F(FrameStore, ATruncatedFrameIsRefused) {
  write_frame(path("f"), frame(1));
  std::filesystem::resize_file(path("f"), std::filesystem::file_size(path("f")) - 1);
  EXPECT_THROW(read_frame(path("f")), InputError);
  EXPECT_THROW(read_frame(path("none")), InputError);
}

TEST_F(FrameStore, NewVerticesWaitWhereTheirFirstMotionStarts) {
  std::vector<std::string> files;
  for (int k = 0; k < 4; ++k) {
    files.push_back(path("frame-" + std::to_string(k)));
    write_frame(files.back(), frame(k));
  }
  SequenceMetadata metadata;
  metadata.title = "two triangles";
  write_frames(files, path("out.vtkhdf"), metadata);

  SequenceReader reader(path("out.vtkhdf"));
  reader.check_contents();
  EXPECT_EQ(reader.metadata().title, "two triangles");
  ASSERT_EQ(reader.frame_count(), 4);
  ASSERT_EQ(reader.point_count(), 6u);
  EXPECT_TRUE(reader.same_cells(0, 1));
  EXPECT_FALSE(reader.same_cells(1, 2));
  for (int k = 0; k < 4; ++k) {
    const Frame f = frame(k);
    std::vector<Vec3> x, v;
    std::vector<double> thickness;
    SequenceCells cells;
    reader.read_points(k, x);
    reader.read_velocity(k, v);
    reader.read_thickness(k, thickness);
    std::vector<Vec3> start, end;
    EXPECT_EQ(reader.read_query(k, start, end), 0.25 + k);
    reader.read_cells(k, cells);
    EXPECT_EQ(reader.time(k), f.time);
    EXPECT_EQ(cells, f.cells);
    EXPECT_EQ(thickness, f.thickness);
    for (std::size_t i = 0; i < 6; ++i) {
      const bool there = i < f.positions.size();
      EXPECT_EQ(x[i], there ? f.positions[i] : i == 4 ? Vec3(0.25, 0, 1.5) : Vec3(0.75, 0, 2.5)) << k << " " << i;
      EXPECT_EQ(v[i], there ? f.velocities[i] : Vec3::Zero().eval());
      EXPECT_EQ(start[i], there ? f.query_start[i] : x[i]) << "before a vertex exists, it does not move";
      EXPECT_EQ(end[i], there ? f.query_end[i] : x[i]);
    }
  }
}

TEST_F(FrameStore, StartPositionsThatDoNotFitAreRefused) {
  Frame second = frame(2);
  second.start_positions.clear();
  write_frame(path("0"), frame(0));
  write_frame(path("1"), second);
  EXPECT_THROW(write_frames({path("0"), path("1")}, path("out.vtkhdf"), {}), InputError);
  EXPECT_FALSE(std::filesystem::exists(path("out.vtkhdf")));
}

}  // namespace
}  // namespace volccd
