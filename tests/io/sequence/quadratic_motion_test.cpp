// Quadratic motion of sequences: parabolas through three steps or by stored velocities.
#include <gtest/gtest.h>

#include <volccd/io/sequence/stepper.hpp>

#include "stepper_support.hpp"

namespace volccd::test {
namespace {

class QuadraticMotion : public StepperTest {};

constexpr SequenceStepper::Config kQuadratic{EdgeSet::triangulated, ShellModel::surface, MotionModel::quadratic};

/// Parabolas follow from three steps (of different lengths, too) if there are no velocities, and from velocities
/// otherwise. Both give the same parabola exactly, in any order of motions.
TEST_F(QuadraticMotion, ReproducesParabolas) {
  for (const bool velocities : {false, true})
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      SCOPED_TRACE(testing::Message() << "velocities " << velocities << " seed " << seed);
      const Parabolas p(seed);
      p.write(file("s.vtkhdf"), velocities);
      SequenceReader reader(file("s.vtkhdf"));
      SequenceStepper stepper(reader, kQuadratic);
      for (const int k : {0, 1, 2, 3, 4, 2, 0, 4, 4, 3, 1}) {
        SCOPED_TRACE(k);
        stepper.go_to(k);
        ASSERT_EQ(stepper.motion().control_points(), 3);
        ASSERT_EQ(stepper.motion().vertex_count(), 12u);
        const auto i = static_cast<std::size_t>(k);
        for (Index v = 0; v < 12; ++v) expect_parabola(p, stepper.motion(), v, p.times[i], p.times[i + 1]);
      }
    }
}

/// A parabola is computed only for points that cells use. Other points may have any positions and velocities.
TEST_F(QuadraticMotion, DoesNotLookAtUnusedPoints) {
  const Parabolas p(7);
  for (const bool velocities : {false, true}) {
    SCOPED_TRACE(velocities);
    // The cell exists from step 2 to step 4.
    p.write(file("s.vtkhdf"), velocities, {0, 1, 5});
    SequenceReader reader(file("s.vtkhdf"));
    SequenceStepper stepper(reader, kQuadratic);
    for (const int k : {4, 0, 1, 2, 3}) {
      SCOPED_TRACE(k);
      stepper.go_to(k);
      const Motion& motion = stepper.motion();
      const auto i = static_cast<std::size_t>(k);
      for (Index v = 0; v < 8; ++v) expect_parabola(p, motion, v, p.times[i], p.times[i + 1]);
      for (Index v = 8; v < 12; ++v) {
        EXPECT_TRUE(motion.point(v, 1).allFinite());
        if (k == 3 || (k == 2 && velocities)) {
          expect_parabola(p, motion, v, p.times[i], p.times[i + 1]);
        } else if (k == 1 || k == 2) {
          EXPECT_EQ(motion.point(v, 1), Vec3(0.5 * motion.point(v, 0) + 0.5 * motion.point(v, 2)));
        }
      }
    }
  }
}

/// The velocities contradict the positions: the motion begins with the velocities, and ends at the next step.
TEST_F(QuadraticMotion, BeginsWithTheStoredVelocity) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    random_sequence(seed, 4).write(file("s.vtkhdf"));
    SequenceReader reader(file("s.vtkhdf"));
    if (!reader.has_velocity()) continue;
    SequenceStepper stepper(reader, kQuadratic);
    std::vector<Vec3> x0, x1, v0;
    SequenceCells cells;
    for (int k = 0; k < 3; ++k) {
      stepper.go_to(k);
      reader.read_points(k, x0);
      reader.read_points(k + 1, x1);
      reader.read_velocity(k, v0);
      reader.read_cells(k, cells);
      for (const Index v : cells.connectivity) {
        EXPECT_EQ(stepper.motion().point(v, 0), x0[v]);
        EXPECT_EQ(stepper.motion().point(v, 2), x1[v]);
        EXPECT_LE((2 * (stepper.motion().point(v, 1) - x0[v]) - stepper.step_length() * v0[v]).norm(), 1e-14);
      }
    }
  }
}

TEST_F(QuadraticMotion, CarriesSolidShells) {
  int files = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 5).write(file("s.vtkhdf"));
    SequenceReader reader(file("s.vtkhdf"));
    if (!reader.has_thickness()) continue;
    ++files;
    SequenceStepper surface(reader, kQuadratic);
    SequenceStepper solid(reader, {EdgeSet::triangulated, ShellModel::solid, MotionModel::quadratic});
    for (const int k : {0, 1, 3, 2}) {
      surface.go_to(k);
      solid.go_to(k);
      expect_fresh_solids(reader, solid, k);
      for (Index v = 0; v < reader.point_count(); ++v)
        for (const double t : {0.25, 0.5})
          for (const Index s : {solid_middle(v), solid_below(v), solid_above(v)}) {
            const auto offset = [&](double at) {
              return Vec3(solid.motion().position(s, at) - surface.motion().position(v, at));
            };
            EXPECT_LE((offset(t) - ((1 - t) * offset(0) + t * offset(1))).norm(), 1e-13);
          }
    }
  }
  EXPECT_GE(files, 3);
}

TEST_F(QuadraticMotion, IsRefusedWhereItCannotBe) {
  const Parabolas p(1);
  p.write(file("two.vtkhdf"), false, {}, 2);
  SequenceReader two(file("two.vtkhdf"));
  EXPECT_THROW(SequenceStepper(two, kQuadratic), InputError);
  p.write(file("with.vtkhdf"), true, {}, 2);
  SequenceReader with(file("with.vtkhdf"));
  EXPECT_NO_THROW(SequenceStepper(with, kQuadratic).go_to(0));

  expect_overflow_is_refused(p, kQuadratic, [&](SequenceReader&, const SequenceStepper& stepper) {
    for (Index v = 0; v < 12; ++v) expect_parabola(p, stepper.motion(), v, p.times[3], p.times[4]);
  });
}

}  // namespace
}  // namespace volccd::test
