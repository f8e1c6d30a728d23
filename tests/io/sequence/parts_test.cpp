// Parts of a frame are those of the whole frame.
#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/reader.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"

namespace volccd::test {
namespace {

/// Without polyhedra, whose parts cannot be read.
Sequence without_polyhedra(std::uint64_t seed) {
  Sequence sequence = random_sequence(seed);
  for (Sequence::Step& step : sequence.steps) {
    SequenceCells cells;
    for (std::size_t i = 0; i < step.cells.size(); ++i)
      if (const ElementSpec spec = step.cells.spec(i); spec.type != ElementType::polytope) cells.add(spec);
    if (cells.size() == 0) cells = sequence.steps.front().cells;
    step.cells = cells;
    step.thickness.clear();
  }
  return sequence;
}

void append(const SequenceCells& part, SequenceCells& all) {
  for (std::size_t i = 0; i < part.size(); ++i) all.add(part.spec(i));
}

TEST(SequenceParts, TogetherAreTheFrame) {
  const ScratchFolder folder;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const std::string file = folder / "run.vtkhdf";
    without_polyhedra(seed).write(file);
    SequenceReader reader(file);
    ASSERT_TRUE(reader.can_read_parts());
    for (int k = 0; k < reader.frame_count(); ++k)
      for (const Index parts : {1u, 2u, 5u}) {
        SequenceCells whole, cells, part;
        std::vector<Vec3> points, rows;
        reader.read_cells(k, whole);
        reader.read_points(k, points);
        const auto begin = [&](Index count, Index i) { return count * i / parts; };
        for (Index i = 0; i < parts; ++i) {
          const Index count = reader.cell_count(k), n = reader.point_count();
          reader.read_cells(k, begin(count, i), begin(count, i + 1) - begin(count, i), part);
          append(part, cells);
          reader.read_points(k, begin(n, i), begin(n, i + 1) - begin(n, i), rows);
          ASSERT_EQ(rows.size(), begin(n, i + 1) - begin(n, i));
          for (std::size_t row = 0; row < rows.size(); ++row)
            EXPECT_EQ(rows[row], points[reader.slot_of_point()[begin(n, i) + row]]);
        }
        EXPECT_EQ(cells, whole);
      }
  }
}

TEST(SequenceParts, ErrorsNameTheRowOfTheFile) {
  const ScratchFolder folder;
  const std::string file = folder / "run.vtkhdf";
  Sequence sequence = without_polyhedra(3);
  sequence.steps.resize(1);
  sequence.write(file);
  const auto cells = static_cast<Index>(sequence.steps[0].cells.size());
  ASSERT_GT(cells, 4u);
  const std::size_t row = sequence.steps[0].cells.offsets[cells - 1] + 1;
  RawFile(file).poke("VTKHDF/Connectivity", row, std::int64_t{-1});
  SequenceReader reader(file);
  SequenceCells part;
  EXPECT_NO_THROW(reader.read_cells(0, 0, cells - 1, part));
  std::string whole;
  try {
    reader.read_cells(0, part);
  } catch (const InputError& error) {
    whole = error.what();
  }
  try {
    reader.read_cells(0, cells - 2, 2, part);
    ADD_FAILURE() << "nothing was refused";
  } catch (const InputError& error) {
    EXPECT_EQ(error.index(), static_cast<std::int64_t>(row));
    EXPECT_EQ(error.what(), whole);
  }
}

TEST(SequenceParts, NotOfPolyhedra) {
  const ScratchFolder folder;
  const std::string file = folder / "run.vtkhdf";
  random_sequence(1).write(file);
  const SequenceReader reader(file);
  EXPECT_FALSE(reader.can_read_parts());
}

}  // namespace
}  // namespace volccd::test
