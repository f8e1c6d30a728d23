// The writer leaves a complete file or none, and refuses data that the reader would refuse.
#include <chrono>
#include <fstream>
#include <functional>
#include <limits>
#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/step_text.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"
#include "support/full_disk.hpp"

namespace volccd::test {
namespace {

void write_text(const std::string& file, const std::string& text) { std::ofstream(file) << text; }

/// Records of experiments identify their inputs by a hash of the file.
TEST(SequenceWriter, TheSameSequenceGivesTheSameBytesLater) {
  const ScratchFolder folder;
  const Sequence sequence = random_sequence(3);
  sequence.write(folder / "a.vtkhdf");
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // HDF5 keeps times of change in seconds
  sequence.write(folder / "b.vtkhdf");
  EXPECT_TRUE(text_of(folder / "a.vtkhdf") == text_of(folder / "b.vtkhdf"));
}

TEST(SequenceWriter, NothingIsThereBeforeFinish) {
  const ScratchFolder folder;
  const Sequence s = random_sequence(1, 2);
  {
    SequenceWriter writer(folder / "s.vtkhdf", s.point_ids);
    writer.write_frame(0, s.steps[0].points, s.steps[0].cells);
    EXPECT_FALSE(std::filesystem::exists(folder / "s.vtkhdf"));
    EXPECT_EQ(folder.entries(), 1u) << "the temporary name is beside the target";
  }
  EXPECT_EQ(folder.entries(), 0u);
}

TEST(SequenceWriter, WhatWasThereStaysUntilFinish) {
  const ScratchFolder folder;
  write_text(folder / "s.vtkhdf", "old");
  const Sequence s = random_sequence(1, 2);
  {
    SequenceWriter writer(folder / "s.vtkhdf", s.point_ids);
    writer.write_frame(0, s.steps[0].points, s.steps[0].cells);
  }
  EXPECT_EQ(text_of(folder / "s.vtkhdf"), "old");
  SequenceWriter writer(folder / "s.vtkhdf", s.point_ids);
  writer.write_frame(0, s.steps[0].points, s.steps[0].cells);
  EXPECT_EQ(text_of(folder / "s.vtkhdf"), "old");
  writer.finish();
  EXPECT_EQ(folder.entries(), 1u);
  EXPECT_NO_THROW(SequenceReader(folder / "s.vtkhdf").check_contents());
  struct stat info {};
  ::stat((folder / "s.vtkhdf").c_str(), &info);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  EXPECT_EQ(info.st_mode & 0777, 0666 & ~mask);
}

/// HDF5 itself crashes at the end of the process if a write failed.
TEST(SequenceWriter, AFullDiskIsAnErrorWithTheReasonWhereverItStrikes) {
  const ScratchFolder folder;
  const std::string file = folder / "s.vtkhdf";
  write_text(file, "old");
  const Sequence s = random_sequence(7, 6);
  const auto write = [&] {
    SequenceWriter writer(file, s.point_ids);
    for (std::size_t k = 0; k < s.steps.size(); ++k)
      writer.write_frame(static_cast<double>(k), s.steps[k].points, s.steps[k].cells);
    writer.finish();
  };
  for (std::int64_t room = 0;; room += room < 4000 ? 400 : 3000) {
    std::string message;
    try {
      const FullDisk disk(room);
      write();
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), file);
      message = error.what();
    }
    if (message.empty()) {
      EXPECT_GT(room, 4000);
      break;
    }
    EXPECT_NE(message.find("File too large"), std::string::npos) << message;
    EXPECT_EQ(text_of(file), "old");
    EXPECT_EQ(folder.entries(), 1u);
  }
  EXPECT_NO_THROW(SequenceReader(file).check_contents());
}

TEST(SequenceWriter, LinksStayAndStreamsAreRefused) {
  const ScratchFolder folder;
  const Sequence s = random_sequence(1, 2);
  std::filesystem::create_symlink("s.vtkhdf", folder / "link");
  SequenceWriter writer(folder / "link", s.point_ids);
  writer.write_frame(0, s.steps[0].points, s.steps[0].cells);
  writer.finish();
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_NO_THROW(SequenceReader(folder / "s.vtkhdf").check_contents());
  for (const char* name : {"-", "/dev/fd/1"}) EXPECT_THROW(SequenceWriter(name, s.point_ids), InputError);
}

TEST(SequenceWriter, AnIncompleteSequenceSaysSo) {
  const ScratchFolder folder;
  const Sequence s = random_sequence(1, 2);
  for (const std::string& incomplete : {std::string(), StepsDone{0, 1, 5, "interrupted"}.text()}) {
    SequenceWriter writer(folder / "s.vtkhdf", s.point_ids);
    writer.write_frame(0, s.steps[0].points, s.steps[0].cells);
    writer.finish(incomplete);
    EXPECT_EQ(SequenceReader(folder / "s.vtkhdf").metadata().incomplete, incomplete);
  }
}

/// VTKHDF 1.0 has neither steps nor polyhedra.
TEST(SequenceWriter, TheSingleFormHasOneStep) {
  const ScratchFolder folder;
  const std::string file = folder / "s.vtkhdf";
  const Shape shape = block(ElementType::hexahedron, 2, 1, 1);
  SequenceCells cells;
  for (const ElementSpec& spec : shape.elements) cells.add(spec);
  std::vector<std::int64_t> ids(shape.positions.size());
  std::iota(ids.begin(), ids.end(), 5);
  {
    SequenceWriter writer(file, ids, {}, SequenceForm::single);
    writer.write_frame(0.25, shape.positions, cells);
    EXPECT_THROW(writer.write_frame(0.5, shape.positions, cells), InputError);
  }
  SequenceWriter writer(file, ids, {}, SequenceForm::single);
  writer.write_frame(0.25, shape.positions, cells);
  writer.finish();
  {
    SequenceReader reader(file);
    EXPECT_EQ(reader.frame_count(), 1);
    EXPECT_TRUE(std::equal(ids.begin(), ids.end(), reader.point_ids().begin(), reader.point_ids().end()));
    SequenceCells read;
    reader.read_cells(0, read);
    EXPECT_EQ(read, cells);
  }
  const RawFile raw(file);
  EXPECT_EQ(H5Lexists(raw.id(), "VTKHDF/Steps", H5P_DEFAULT), 0);
  EXPECT_EQ(raw.reals("VTKHDF/FieldData/TimeValue"), std::vector<double>{0.25});

  SequenceCells polytope;
  polytope.add({.type = ElementType::polytope,
                .vertices = {0, 1, 2, 3},
                .faces = {3, 0, 1, 2, 3, 0, 3, 1, 3, 1, 3, 2, 3, 2, 3, 0}});
  SequenceWriter other(folder / "p.vtkhdf", ids, {}, SequenceForm::single);
  EXPECT_THROW(other.write_frame(0, shape.positions, polytope), InputError);
}

TEST(SequenceWriter, TwoWritersOfOneTargetDoNotMeet) {
  const ScratchFolder folder;
  const Sequence s = random_sequence(1, 2);
  SequenceWriter one(folder / "s.vtkhdf", s.point_ids), two(folder / "s.vtkhdf", s.point_ids);
  one.write_frame(1, s.steps[0].points, s.steps[0].cells);
  two.write_frame(2, s.steps[0].points, s.steps[0].cells);
  two.finish();
  EXPECT_EQ(SequenceReader(folder / "s.vtkhdf").time(0), 2);
  one.finish();
  EXPECT_EQ(SequenceReader(folder / "s.vtkhdf").time(0), 1);
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(SequenceWriter, PlacesThatCannotBeWritten) {
  const ScratchFolder folder;
  const Sequence s = random_sequence(1, 1);
  for (const std::string& file : {folder / "no/such/folder/s.vtkhdf", folder / "", std::string("/proc/s.vtkhdf")}) {
    try {
      SequenceWriter writer(file, s.point_ids);
      ADD_FAILURE() << file;
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), file);
    }
  }
  EXPECT_EQ(folder.entries(), 0u);
}

struct Refusal {
  const char* name;
  std::function<void(Sequence&)> spoil;
  const char* dataset;
  std::int64_t index;
};
void PrintTo(const Refusal& r, std::ostream* out) { *out << r.name; }

class SequenceWriterRefuses : public testing::TestWithParam<Refusal> {};

/// A tetrahedron and a quad, two steps.
Sequence pair_of_cells() {
  Sequence s;
  for (std::int64_t i = 0; i < 6; ++i) s.point_ids.push_back(i);
  for (int k = 0; k < 2; ++k) {
    Sequence::Step step{
        1.0 * k, std::vector<Vec3>(6, Vec3(1, 2, 3)), std::vector<Vec3>(6, Vec3(0, 0, k)), {}, {0, 0.5}};
    step.cells.add({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .id = 4});
    step.cells.add({.type = ElementType::quad, .vertices = {2, 3, 4, 5}, .id = 9});
    s.steps.push_back(step);
  }
  return s;
}

TEST_P(SequenceWriterRefuses, AndLeavesNothing) {
  const Refusal& r = GetParam();
  const ScratchFolder folder;
  ASSERT_NO_THROW(pair_of_cells().write(folder / "good"));
  Sequence s = pair_of_cells();
  r.spoil(s);
  try {
    s.write(folder / "bad");
    ADD_FAILURE() << "was written";
  } catch (const InputError& error) {
    EXPECT_EQ(error.source(), folder / "bad");
    EXPECT_EQ(error.dataset(), r.dataset) << error.what();
    EXPECT_EQ(error.index(), r.index) << error.what();
  }
  EXPECT_EQ(folder.entries(), 1u);
}

constexpr std::int64_t kNo = InputError::kNoIndex;

INSTANTIATE_TEST_SUITE_P(
    Input, SequenceWriterRefuses,
    testing::Values(
        Refusal{"NoSteps", [](Sequence& s) { s.steps.clear(); }, "VTKHDF/Steps/Values", kNo},
        Refusal{"TimeNan", [](Sequence& s) { s.steps[0].time = kNan; }, "VTKHDF/Steps/Values", 0},
        Refusal{"TimeEqual", [](Sequence& s) { s.steps[1].time = 0; }, "VTKHDF/Steps/Values", 1},
        Refusal{"NoPoints", [](Sequence& s) { s.point_ids.clear(); }, "VTKHDF/PointData/GlobalPointIds", kNo},
        Refusal{"PointIdTwice", [](Sequence& s) { s.point_ids[4] = 1; }, "VTKHDF/PointData/GlobalPointIds", 4},
        Refusal{"PointIdNegative", [](Sequence& s) { s.point_ids[0] = -1; }, "VTKHDF/PointData/GlobalPointIds", 0},
        Refusal{"FewPoints", [](Sequence& s) { s.steps[1].points.pop_back(); }, "VTKHDF/Points", kNo},
        Refusal{"PointNan", [](Sequence& s) { s.steps[1].points[5].z() = kNan; }, "VTKHDF/Points", 5},
        Refusal{"VelocityNan", [](Sequence& s) { s.steps[0].velocity[2].x() = kNan; }, "VTKHDF/PointData/Velocity", 2},
        Refusal{"VelocityMissing", [](Sequence& s) { s.steps[1].velocity.clear(); }, "VTKHDF/PointData/Velocity", 1},
        Refusal{"VelocityAppears", [](Sequence& s) { s.steps[0].velocity.clear(); }, "VTKHDF/PointData/Velocity", 1},
        Refusal{"ThicknessNegative", [](Sequence& s) { s.steps[1].thickness[1] = -1; }, "VTKHDF/CellData/Thickness", 1},
        Refusal{"ThicknessShort", [](Sequence& s) { s.steps[1].thickness.pop_back(); }, "VTKHDF/CellData/Thickness",
                kNo},
        Refusal{"ThicknessMissing", [](Sequence& s) { s.steps[1].thickness.clear(); }, "VTKHDF/CellData/Thickness", 1},
        Refusal{"NoCells",
                [](Sequence& s) {
                  s.steps[0] = {0, s.steps[0].points, {}, {}, {}};
                },
                "VTKHDF/Types", kNo},
        Refusal{"VertexOutOfRange", [](Sequence& s) { s.steps[1].cells.connectivity[6] = 6; }, "VTKHDF/Connectivity",
                1},
        Refusal{"VertexTwice", [](Sequence& s) { s.steps[1].cells.connectivity[0] = 1; }, "VTKHDF/Connectivity", 0},
        Refusal{"TypeUnknown", [](Sequence& s) { s.steps[1].cells.types[0] = ElementType{11}; }, "VTKHDF/Connectivity",
                0},
        Refusal{"TypeNone", [](Sequence& s) { s.steps[1].cells.types[1] = ElementType::none; }, "VTKHDF/Connectivity",
                1},
        Refusal{"OffsetsFall", [](Sequence& s) { s.steps[1].cells.offsets[1] = 9; }, "VTKHDF/Offsets", kNo},
        Refusal{"CellIdTwice", [](Sequence& s) { s.steps[1].cells.ids[1] = 4; }, "VTKHDF/CellData/GlobalCellIds", 1},
        Refusal{"CellIdNegative", [](Sequence& s) { s.steps[1].cells.ids[0] = -4; }, "VTKHDF/CellData/GlobalCellIds",
                0},
        Refusal{"PartsShort", [](Sequence& s) { s.steps[1].cells.objects.pop_back(); }, "VTKHDF/CellData/PartId", kNo},
        Refusal{"PolytopeWithoutFaces", [](Sequence& s) { s.steps[1].cells.types[0] = ElementType::polytope; },
                "VTKHDF/Connectivity", 0}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(SequenceWriter, IsOfNoUseAfterAnErrorOrTheEnd) {
  const ScratchFolder folder;
  Sequence s = pair_of_cells();
  SequenceWriter writer(folder / "s", s.point_ids);
  EXPECT_THROW(writer.write_frame(kNan, s.steps[0].points, s.steps[0].cells), InputError);
  EXPECT_THROW(writer.write_frame(0, s.steps[0].points, s.steps[0].cells), InputError);
  EXPECT_THROW(writer.finish(), InputError);
  SequenceWriter other(folder / "s", s.point_ids);
  other.write_frame(0, s.steps[0].points, s.steps[0].cells);
  other.finish();
  EXPECT_THROW(other.finish(), InputError);
  EXPECT_THROW(other.write_frame(1, s.steps[0].points, s.steps[0].cells), InputError);
}

}  // namespace
}  // namespace volccd::test
