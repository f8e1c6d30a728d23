// Query motion of sequences: the last query of a simulation before a step, on the cells of that step.
#include <gtest/gtest.h>

#include <volccd/io/sequence/stepper.hpp>
#include <volccd/io/sequence/writer.hpp>

#include "stepper_support.hpp"

namespace volccd::test {
namespace {

constexpr SequenceStepper::Config kQuery{EdgeSet::triangulated, ShellModel::surface, MotionModel::query};

Vec3 start_of(int step, std::int64_t id) { return {static_cast<double>(id), static_cast<double>(step), 0.5}; }
Vec3 end_of(int step, std::int64_t id) { return {static_cast<double>(id), static_cast<double>(step), -2}; }
double separation_of(int step) { return 0.125 * (step + 1); }

class QueryMotion : public StepperTest {
 protected:
  /// A random sequence with queries, whose points are not in the order of their ids.
  std::string write(std::uint64_t seed) const {
    const Sequence s = random_sequence(seed, 5);
    const std::string name = file("q.vtkhdf");
    SequenceWriter writer(name, s.point_ids);
    for (int k = 0; k < 5; ++k) {
      std::vector<Vec3> start, end;
      for (const std::int64_t id : s.point_ids) {
        start.push_back(start_of(k, id));
        end.push_back(end_of(k, id));
      }
      const Sequence::Step& step = s.steps[static_cast<std::size_t>(k)];
      writer.write_frame(step.time, step.points, step.cells,
                         {step.velocity, step.thickness, start, end, separation_of(k)});
    }
    writer.finish();
    return name;
  }
};

TEST_F(QueryMotion, IsTheQueryOfItsLastStepOnTheCellsOfThatStep) {
  int changes = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    SequenceReader reader(write(seed));
    reader.check_contents();
    SequenceStepper stepper(reader, kQuery);
    ASSERT_EQ(stepper.step_count(), 4);
    for (const int k : {0, 1, 2, 3, 1, 1, 0, 3}) {
      stepper.go_to(k);
      EXPECT_EQ(stepper.separation(), separation_of(k + 1));
      SequenceCells cells;
      reader.read_cells(k + 1, cells);
      EXPECT_EQ(describe(stepper.topology()), describe(Topology(mesh_of(reader.point_ids(), cells))));
      changes += reader.same_cells(k, k + 1) ? 0 : 1;
      ASSERT_EQ(stepper.motion().vertex_count(), reader.point_count());
      for (Index v = 0; v < reader.point_count(); ++v) {
        EXPECT_EQ(stepper.motion().point(v, 0), start_of(k + 1, reader.point_ids()[v]));
        EXPECT_EQ(stepper.motion().point(v, 1), end_of(k + 1, reader.point_ids()[v]));
      }
    }
    SequenceStepper linear(reader);
    linear.go_to(2);
    EXPECT_EQ(linear.separation(), 0) << "of query motion alone";
  }
  EXPECT_GT(changes, 0);
}

/// Files without stored queries are read as before; the error for query motion says how to get queries.
TEST_F(QueryMotion, OfAFileWithoutQueriesIsRefused) {
  random_sequence(1, 3).write(file("old.vtkhdf"));
  SequenceReader reader(file("old.vtkhdf"));
  EXPECT_FALSE(reader.has_query());
  reader.check_contents();
  SequenceStepper(reader).go_to(1);
  std::vector<Vec3> start, end;
  EXPECT_THROW(reader.read_query(1, start, end), InputError);
  try {
    SequenceStepper stepper(reader, kQuery);
    ADD_FAILURE() << "a file without queries was accepted";
  } catch (const InputError& error) {
    for (const char* word : {"old.vtkhdf", "QueryStart", "volccd scene generate"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
}

TEST_F(QueryMotion, DamagedQueriesAreRefused) {
  const std::string name = write(2);
  const Index points = SequenceReader(name).point_count();
  const auto refused = [&](const char* dataset, std::size_t value, double bad) {
    write(2);
    {
      RawFile raw(name);
      raw.poke(dataset, value, bad);
    }
    SequenceReader reader(name);
    std::vector<Vec3> start, end;
    reader.read_query(1, start, end);
    EXPECT_THROW(reader.read_query(2, start, end), InputError) << dataset << " " << bad;
    EXPECT_THROW(reader.check_contents(), InputError);
    SequenceStepper stepper(reader, kQuery);
    stepper.go_to(0);
    EXPECT_THROW(stepper.go_to(1), InputError);
    EXPECT_EQ(stepper.current(), 0);
    EXPECT_EQ(stepper.separation(), separation_of(1)) << "still the motion before";
  };
  refused("VTKHDF/PointData/QueryStart", 3 * (2 * points + 1), std::numeric_limits<double>::quiet_NaN());
  refused("VTKHDF/PointData/QueryEnd", 3 * (2 * points) + 2, std::numeric_limits<double>::infinity());
  for (const double bad : {-1.0, 7.0, std::numeric_limits<double>::quiet_NaN()})
    refused("VTKHDF/PointData/QuerySeparation", 2 * points + 1, bad);
}

TEST_F(QueryMotion, TheWriterRefusesHalfAQuery) {
  const Sequence s = random_sequence(3, 2);
  const Sequence::Step& step = s.steps[0];
  const std::vector<Vec3>& x = step.points;
  const auto write = [&](const FrameFields& first, const FrameFields& second) {
    SequenceWriter writer(file("w.vtkhdf"), s.point_ids);
    writer.write_frame(0, x, step.cells, first);
    writer.write_frame(1, x, step.cells, second);
    writer.finish();
  };
  const FrameFields none, whole{{}, {}, x, x, 1}, start{{}, {}, x, {}, 1}, end{{}, {}, {}, x, 1},
      negative{{}, {}, x, x, -1};
  write(whole, whole);
  write(none, none);
  EXPECT_THROW(write(start, start), InputError);
  EXPECT_THROW(write(end, end), InputError);
  EXPECT_THROW(write(negative, negative), InputError);
  EXPECT_THROW(write(whole, none), InputError);
  EXPECT_THROW(write(none, whole), InputError);
  const std::vector<Vec3> short_one(x.begin(), x.end() - 1);
  EXPECT_THROW(write({{}, {}, x, short_one, 1}, whole), InputError);
}

}  // namespace
}  // namespace volccd::test
