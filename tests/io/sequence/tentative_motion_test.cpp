// Tentative motion of sequences: from stored velocities, on the cells of the first step.
#include <gtest/gtest.h>

#include <volccd/io/sequence/stepper.hpp>

#include "stepper_support.hpp"

namespace volccd::test {
namespace {

class TentativeMotion : public StepperTest {};

constexpr SequenceStepper::Config kTentative{EdgeSet::triangulated, ShellModel::surface, MotionModel::tentative};

/// Ends of tentative motion k as a solver computes them.
std::vector<Vec3> tentative_ends(SequenceReader& reader, int k) {
  std::vector<Vec3> x, v;
  SequenceCells cells;
  reader.read_points(k, x);
  reader.read_velocity(k, v);
  reader.read_cells(k, cells);
  const double h = reader.time(k + 1) - reader.time(k);
  const std::set<Index> used(cells.connectivity.begin(), cells.connectivity.end());
  for (const Index i : used) x[i] = x[i] + h * v[i];
  return x;
}

void expect_tentative(SequenceReader& reader, const SequenceStepper& stepper, int k) {
  SCOPED_TRACE(k);
  ASSERT_EQ(stepper.current(), k);
  SequenceCells cells;
  reader.read_cells(k, cells);
  EXPECT_EQ(describe(stepper.topology()), describe(Topology(mesh_of(reader.point_ids(), cells))));
  std::vector<Vec3> x0;
  reader.read_points(k, x0);
  const std::vector<Vec3> x1 = tentative_ends(reader, k);
  ASSERT_EQ(stepper.motion().vertex_count(), reader.point_count());
  ASSERT_EQ(stepper.motion().control_points(), 2);
  for (Index v = 0; v < reader.point_count(); ++v) {
    EXPECT_EQ(stepper.motion().point(v, 0), x0[v]);
    EXPECT_EQ(stepper.motion().point(v, 1), x1[v]);
  }
  EXPECT_EQ(stepper.step_length(), reader.time(k + 1) - reader.time(k));
}

/// The motion uses the points, velocities and cells of step k, even if the next step has other cells.
TEST_F(TentativeMotion, IsOfItsStepAlone) {
  int files = 0, changes = 0, unused = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 5).write(file("s.vtkhdf"));
    SequenceReader reader(file("s.vtkhdf"));
    if (!reader.has_velocity()) continue;
    ++files;
    SequenceStepper stepper(reader, kTentative);
    ASSERT_EQ(stepper.step_count(), 4);
    for (const int k : {0, 1, 2, 3, 1, 1, 0, 3, 2}) {
      stepper.go_to(k);
      expect_tentative(reader, stepper, k);
      if (!reader.same_cells(k, k + 1)) ++changes;
      unused += static_cast<int>(reader.point_count() - stepper.topology().features().vertex_count());
    }
  }
  EXPECT_GE(files, 3);
  EXPECT_GT(changes, 0);
  EXPECT_GT(unused, 0);
}

/// Values stored for points that no cell uses have no meaning; these points do not move.
TEST_F(TentativeMotion, LeavesUnusedPointsWhereTheyAre) {
  const Parabolas p(3);
  p.write(file("s.vtkhdf"), true, {0, 1, 5});
  SequenceReader reader(file("s.vtkhdf"));
  SequenceStepper stepper(reader, kTentative);
  for (const int k : {4, 0, 1, 2, 3}) {
    stepper.go_to(k);
    expect_tentative(reader, stepper, k);
    const auto i = static_cast<std::size_t>(k);
    for (Index v = 8; v < 12; ++v) {
      const bool used = k >= 2;
      EXPECT_EQ(stepper.motion().point(v, 0) == stepper.motion().point(v, 1), !used);
      if (used) continue;
      EXPECT_EQ(stepper.motion().point(v, 0), Vec3::Constant(1e300));
    }
    for (Index v = 0; v < 8; ++v)
      EXPECT_EQ(stepper.motion().point(v, 1),
                p.at(v, p.times[i]) + (p.times[i + 1] - p.times[i]) * p.velocity_at(v, p.times[i]));
  }
}

/// The middle layer moves as the shell does; the outer layers are placed by thickening at either end.
TEST_F(TentativeMotion, CarriesSolidShells) {
  int files = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 5).write(file("s.vtkhdf"));
    SequenceReader reader(file("s.vtkhdf"));
    if (!reader.has_thickness() || !reader.has_velocity()) continue;
    ++files;
    SequenceStepper stepper(reader, {EdgeSet::triangulated, ShellModel::solid, MotionModel::tentative});
    for (const int k : {0, 1, 3, 2, 2, 0}) {
      SCOPED_TRACE(k);
      stepper.go_to(k);
      SequenceCells cells;
      std::vector<double> thickness;
      std::vector<Vec3> x0, solid;
      reader.read_cells(k, cells);
      reader.read_thickness(k, thickness);
      reader.read_points(k, x0);
      const Mesh shells = mesh_of(reader.point_ids(), cells);
      const ShellThickener thickener(shells);
      EXPECT_EQ(describe(stepper.topology()), describe(Topology(thickener.solid_mesh(shells))));
      const std::vector<Vec3> x1 = tentative_ends(reader, k);
      Index without_normal = 0;
      for (const int end : {0, 1}) {
        without_normal += thickener.positions(end == 0 ? x0 : x1, thickness, solid);
        ASSERT_EQ(stepper.motion().vertex_count(), solid.size());
        for (Index v = 0; v < solid.size(); ++v) EXPECT_EQ(stepper.motion().point(v, end), solid[v]);
      }
      EXPECT_EQ(stepper.vertices_without_normal(), without_normal);
    }
  }
  EXPECT_GE(files, 3);
}

TEST_F(TentativeMotion, IsRefusedWhereItCannotBe) {
  const Parabolas p(2);
  p.write(file("without.vtkhdf"), false);
  SequenceReader without(file("without.vtkhdf"));
  try {
    SequenceStepper(without, kTentative);
    ADD_FAILURE() << "a file without velocities was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.dataset(), "VTKHDF/PointData/Velocity");
    for (const char* word : {"without.vtkhdf", "velocities", "linear"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }

  expect_overflow_is_refused(p, kTentative, [](SequenceReader& reader, const SequenceStepper& stepper) {
    expect_tentative(reader, stepper, 3);
  });
}

}  // namespace
}  // namespace volccd::test
