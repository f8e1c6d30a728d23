// Written data are read again unchanged, in the order of the ids.
#include <map>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/reader.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"

namespace volccd::test {
namespace {

/// The slot of each point of the file, from the number of smaller ids, without the reader's sort.
std::vector<Index> slots_by_counting(const std::vector<std::int64_t>& ids) {
  std::vector<Index> slots;
  for (const std::int64_t id : ids)
    slots.push_back(static_cast<Index>(std::count_if(ids.begin(), ids.end(), [&](std::int64_t x) { return x < id; })));
  return slots;
}

SequenceCells renumbered(SequenceCells cells, const std::vector<Index>& slots) {
  for (Index& v : cells.connectivity) v = slots[v];
  for (std::size_t at = 0; at < cells.faces.size(); at += cells.faces[at] + 1)
    for (std::size_t i = 1; i <= cells.faces[at]; ++i) cells.faces[at + i] = slots[cells.faces[at + i]];
  return cells;
}

std::vector<Vec3> reordered(const std::vector<Vec3>& values, const std::vector<Index>& slots) {
  std::vector<Vec3> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) result[slots[i]] = values[i];
  return result;
}

void expect_equal(const std::string& file, const Sequence& expected) {
  SequenceReader reader(file);
  const std::vector<Index> slots = slots_by_counting(expected.point_ids);
  ASSERT_EQ(reader.frame_count(), static_cast<int>(expected.steps.size()));
  ASSERT_EQ(reader.point_count(), expected.point_ids.size());
  EXPECT_TRUE(std::ranges::equal(reader.slot_of_point(), slots));
  for (std::size_t i = 0; i < slots.size(); ++i) EXPECT_EQ(reader.point_ids()[slots[i]], expected.point_ids[i]);
  ASSERT_EQ(reader.has_velocity(), !expected.steps[0].velocity.empty());
  ASSERT_EQ(reader.has_thickness(), !expected.steps[0].thickness.empty());

  std::vector<Vec3> vectors;
  std::vector<double> thickness;
  SequenceCells cells;
  // The steps are read backwards, so that nothing depends on the order.
  for (int k = reader.frame_count() - 1; k >= 0; --k) {
    const Sequence::Step& step = expected.steps[static_cast<std::size_t>(k)];
    EXPECT_EQ(reader.time(k), step.time);
    reader.read_points(k, vectors);
    EXPECT_EQ(vectors, reordered(step.points, slots));
    reader.read_cells(k, cells);
    EXPECT_EQ(cells, renumbered(step.cells, slots));
    EXPECT_EQ(reader.cell_count(k), step.cells.size());
    if (reader.has_velocity()) {
      reader.read_velocity(k, vectors);
      EXPECT_EQ(vectors, reordered(step.velocity, slots));
    }
    if (reader.has_thickness()) {
      reader.read_thickness(k, thickness);
      EXPECT_EQ(thickness, step.thickness);
    }
    if (k == 0) continue;
    const bool same = expected.steps[static_cast<std::size_t>(k - 1)].cells == step.cells;
    EXPECT_EQ(reader.same_cells(k, k - 1), same);
    EXPECT_EQ(reader.topology_index(k), reader.topology_index(k - 1) + (same ? 0 : 1));
  }
  EXPECT_NO_THROW(reader.check_contents());
}

TEST(SequenceRoundTrip, RandomSequencesOfMixedCellsThatComeAndGo) {
  const ScratchFolder folder;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const Sequence sequence = random_sequence(seed, 1 + static_cast<int>(seed % 7), seed % 2 == 0);
    sequence.write(folder / "s.vtkhdf");
    expect_equal(folder / "s.vtkhdf", sequence);
  }
}

TEST(SequenceRoundTrip, PolytopesThatAppearLater) {
  const ScratchFolder folder;
  Sequence sequence = random_sequence(3, 4);
  for (std::size_t k : {0u, 1u, 3u}) {
    SequenceCells cells;
    for (std::size_t i = 0; i < sequence.steps[k].cells.size(); ++i)
      if (sequence.steps[k].cells.types[i] != ElementType::polytope) cells.add(sequence.steps[k].cells.spec(i));
    sequence.steps[k].cells = cells;
    if (!sequence.steps[k].thickness.empty()) sequence.steps[k].thickness.resize(cells.size());
  }
  ASSERT_FALSE(sequence.steps[2].cells.face_offsets.empty());
  sequence.write(folder / "s.vtkhdf");
  expect_equal(folder / "s.vtkhdf", sequence);
}

TEST(SequenceRoundTrip, Metadata) {
  const ScratchFolder folder;
  const SequenceMetadata metadata{"A title",        "a source",  "MIT",
                                  "mm (mass in g)", "\xc2\xb5s", {{1, "Projectile"}, {-7, "plate, steel"}, {12, ""}}};
  random_sequence(1).write(folder / "s.vtkhdf", metadata);
  EXPECT_EQ(SequenceReader(folder / "s.vtkhdf").metadata(), metadata);
  random_sequence(1).write(folder / "s.vtkhdf");
  EXPECT_EQ(SequenceReader(folder / "s.vtkhdf").metadata(), SequenceMetadata());
  {
    RawFile raw(folder / "s.vtkhdf");
    raw.put_attribute("/", "Title", "of variable length", true);
  }
  EXPECT_EQ(SequenceReader(folder / "s.vtkhdf").metadata().title, "of variable length");
}

TEST(SequenceRoundTrip, PartNames) {
  EXPECT_EQ(parse_object_names("f", "1 rail, hat section; 2  box ;3 x"),
            (std::map<std::int32_t, std::string>{{1, "rail, hat section"}, {2, "box"}, {3, "x"}}));
  EXPECT_TRUE(parse_object_names("f", " ").empty());
  for (const char* bad : {"rail", "1 a; b", "1 a; 1 b", "1a", "99999999999 x", "1 a;; 2 b"})
    EXPECT_THROW(parse_object_names("f", bad), InputError) << bad;
}

/// A grid without time as VTK writes it: floats, some 32-bit integers, no ids, no group Steps.
void write_static(const std::string& file) {
  RawFile raw(file, true);
  raw.group("VTKHDF");
  raw.put_attribute("VTKHDF", "Version", std::vector<std::int64_t>{1, 0});
  raw.put_attribute("VTKHDF", "Type", "UnstructuredGrid");
  raw.put("VTKHDF/NumberOfPoints", {1}, H5T_STD_I64LE, std::vector<std::int64_t>{5});
  raw.put("VTKHDF/NumberOfCells", {1}, H5T_STD_I32BE, std::vector<std::int64_t>{2});
  raw.put("VTKHDF/NumberOfConnectivityIds", {1}, H5T_STD_I64LE, std::vector<std::int64_t>{7});
  raw.put("VTKHDF/Points", {5, 3}, H5T_IEEE_F32LE, std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.1, 1, 1});
  raw.put("VTKHDF/Connectivity", {7}, H5T_STD_U32LE, std::vector<std::int64_t>{0, 1, 2, 3, 1, 2, 4});
  raw.put("VTKHDF/Offsets", {3}, H5T_STD_U64LE, std::vector<std::int64_t>{0, 4, 7});
  raw.put("VTKHDF/Types", {2}, H5T_STD_U8LE, std::vector<std::int64_t>{10, 5});
}

TEST(SequenceRoundTrip, GridWithoutStepsAsVtkWritesIt) {
  const ScratchFolder folder;
  write_static(folder / "s.vtkhdf");
  SequenceReader reader(folder / "s.vtkhdf");
  EXPECT_EQ(reader.frame_count(), 1);
  EXPECT_EQ(reader.time(0), 0);
  EXPECT_TRUE(std::ranges::equal(reader.point_ids(), std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  std::vector<Vec3> points;
  reader.read_points(0, points);
  EXPECT_EQ(points[4], Vec3(static_cast<double>(0.1f), 1, 1));
  SequenceCells cells, expected;
  expected.add({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}});
  expected.add({.type = ElementType::triangle, .vertices = {1, 2, 4}, .id = 1});
  reader.read_cells(0, cells);
  EXPECT_EQ(cells, expected);
  EXPECT_FALSE(reader.has_velocity());
  EXPECT_THROW(reader.read_velocity(0, points), InputError);
  std::vector<double> thickness;
  EXPECT_THROW(reader.read_thickness(0, thickness), InputError);
}

TEST(SequenceRoundTrip, OffsetsOfCellsWithOneOrTwoAxes) {
  const ScratchFolder folder;
  const Sequence sequence = random_sequence(4, 5);
  sequence.write(folder / "s.vtkhdf");
  {
    RawFile raw(folder / "s.vtkhdf");
    for (const std::string path : {"VTKHDF/Steps/CellOffsets", "VTKHDF/Steps/ConnectivityIdOffsets"}) {
      ASSERT_EQ(raw.shape(path), (std::vector<hsize_t>{5, 1}));
      raw.put(path, {5}, H5T_STD_I64LE, raw.integers(path));
    }
    // VTK's first temporal files do not have this array.
    raw.remove("VTKHDF/Steps/NumberOfParts");
  }
  expect_equal(folder / "s.vtkhdf", sequence);
}

/// Point ids are stored at every step instead of once.
TEST(SequenceRoundTrip, PointIdsAtEveryStep) {
  const ScratchFolder folder;
  const Sequence sequence = random_sequence(5, 3);
  sequence.write(folder / "s.vtkhdf");
  const std::int64_t n = static_cast<std::int64_t>(sequence.point_ids.size());
  std::vector<std::int64_t> ids;
  for (int k = 0; k < 3; ++k) ids.insert(ids.end(), sequence.point_ids.begin(), sequence.point_ids.end());
  {
    RawFile raw(folder / "s.vtkhdf");
    raw.put("VTKHDF/PointData/GlobalPointIds", {ids.size()}, H5T_STD_I64LE, ids);
    raw.put("VTKHDF/Steps/PointDataOffsets/GlobalPointIds", {3}, H5T_STD_I64LE, std::vector<std::int64_t>{0, n, 2 * n});
  }
  expect_equal(folder / "s.vtkhdf", sequence);
  {
    RawFile raw(folder / "s.vtkhdf");
    raw.poke("VTKHDF/PointData/GlobalPointIds", static_cast<std::size_t>(2 * n + 4), std::int64_t{5});
  }
  SequenceReader reader(folder / "s.vtkhdf");
  std::vector<Vec3> points;
  EXPECT_NO_THROW(reader.read_points(1, points));
  try {
    reader.read_points(2, points);
    FAIL() << "other points at frame 2 were accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.dataset(), "VTKHDF/PointData/GlobalPointIds");
    EXPECT_EQ(error.index(), 2 * n + 4);
  }
}

TEST(SequenceCells, ThereAndBackThroughAMesh) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Sequence sequence = random_sequence(seed, 3, false);
    for (const Sequence::Step& step : sequence.steps)
      EXPECT_EQ(cells_of(mesh_of(sequence.point_ids, step.cells)), step.cells);
  }
}

}  // namespace
}  // namespace volccd::test
