// After any order of motions, the stepper has the same data as a new topology.
#include <chrono>
#include <limits>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/stepper.hpp>

#include "stepper_support.hpp"
#include "support/test_data.hpp"

namespace volccd::test {
namespace {

void expect_fresh(SequenceReader& reader, const SequenceStepper& stepper, int motion, EdgeSet edge_set) {
  SCOPED_TRACE(motion);
  EXPECT_EQ(stepper.current(), motion);
  SequenceCells cells;
  reader.read_cells(motion + 1, cells);
  EXPECT_EQ(describe(stepper.topology()), describe(Topology(mesh_of(reader.point_ids(), cells), edge_set)));
  std::vector<Vec3> x0, x1;
  reader.read_points(motion, x0);
  reader.read_points(motion + 1, x1);
  ASSERT_EQ(stepper.motion().vertex_count(), reader.point_count());
  ASSERT_EQ(stepper.motion().control_points(), 2);
  for (Index v = 0; v < reader.point_count(); ++v) {
    EXPECT_EQ(stepper.motion().point(v, 0), x0[v]);
    EXPECT_EQ(stepper.motion().point(v, 1), x1[v]);
  }
  EXPECT_EQ(stepper.step_length(), reader.time(motion + 1) - reader.time(motion));
}

TEST(SequenceStepper, AnyWalkEqualsFreshTopologies) {
  const ScratchFolder folder;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 7).write(folder / "s.vtkhdf");
    SequenceReader reader(folder / "s.vtkhdf");
    const EdgeSet edge_set = seed % 2 ? EdgeSet::polytope : EdgeSet::triangulated;
    SequenceStepper stepper(reader, {edge_set});
    ASSERT_EQ(stepper.step_count(), 6);
    EXPECT_EQ(stepper.current(), -1);
    std::mt19937_64 random(seed);
    std::vector<int> walk = {0, 1, 2, 3, 4, 5, 4, 3, 3};
    for (int i = 0; i < 6; ++i) walk.push_back(static_cast<int>(random() % 6));
    for (const int k : walk) {
      stepper.go_to(k);
      expect_fresh(reader, stepper, k, edge_set);
    }
  }
}

/// An edit contains the differences, and nothing else.
TEST(SequenceStepper, EditsAreMinimal) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Sequence s = random_sequence(seed, 5, false);
    for (std::size_t k = 1; k < s.steps.size(); ++k) {
      const Mesh before = mesh_of(s.point_ids, s.steps[k - 1].cells);
      const SequenceCells& next = s.steps[k].cells;
      const TopologyEdit edit = edit_to(before, next);
      EXPECT_TRUE(edit.new_vertex_ids.empty());
      std::map<std::int64_t, ElementSpec> old;
      for (std::size_t i = 0; i < s.steps[k - 1].cells.size(); ++i)
        old[s.steps[k - 1].cells.ids[i]] = s.steps[k - 1].cells.spec(i);
      std::set<std::int64_t> gone, come, removed, added;
      const auto equal = [](const ElementSpec& x, const ElementSpec& y) {
        return x.type == y.type && x.vertices == y.vertices && x.faces == y.faces && x.object == y.object;
      };
      for (const auto& [id, spec] : old) gone.insert(id);
      for (std::size_t i = 0; i < next.size(); ++i) {
        const auto found = old.find(next.ids[i]);
        if (found != old.end() && equal(found->second, next.spec(i)))
          gone.erase(next.ids[i]);
        else
          come.insert(next.ids[i]);
      }
      for (const Index o : edit.removed) removed.insert(before.element_id(o));
      for (const ElementSpec& spec : edit.added) added.insert(spec.id);
      EXPECT_EQ(removed, gone);
      EXPECT_EQ(added, come);
      EXPECT_EQ(edit.removed.size(), gone.size());
      EXPECT_EQ(edit.added.size(), come.size());
    }
  }
}

TEST(SequenceStepper, SameCellsKeepTheVersion) {
  const ScratchFolder folder;
  Sequence s = random_sequence(2, 4);
  for (Sequence::Step& step : s.steps) {
    step.cells = s.steps[0].cells;
    step.thickness = s.steps[0].thickness;
  }
  s.write(folder / "s.vtkhdf");
  SequenceReader reader(folder / "s.vtkhdf");
  SequenceStepper stepper(reader);
  stepper.go_to(0);
  const std::uint64_t version = stepper.topology().version();
  stepper.go_to(2);
  EXPECT_EQ(stepper.topology().version(), version);
}

TEST(SequenceStepper, BadStepLeavesTheLastMotion) {
  const ScratchFolder folder;
  random_sequence(6, 4).write(folder / "s.vtkhdf");
  {
    RawFile raw(folder / "s.vtkhdf");
    const std::size_t row = static_cast<std::size_t>(raw.integers("VTKHDF/Steps/PointOffsets")[2]);
    raw.poke("VTKHDF/Points", 3 * row, std::numeric_limits<double>::quiet_NaN());
  }
  SequenceReader reader(folder / "s.vtkhdf");
  SequenceStepper stepper(reader);
  stepper.go_to(0);
  EXPECT_THROW(stepper.go_to(1), InputError);
  expect_fresh(reader, stepper, 0, EdgeSet::triangulated);
  EXPECT_THROW(stepper.go_to(2), InputError);
  EXPECT_THROW(stepper.go_to(3), InputError);
  EXPECT_THROW(stepper.go_to(-1), InputError);
  expect_fresh(reader, stepper, 0, EdgeSet::triangulated);
  stepper.go_to(0);
  expect_fresh(reader, stepper, 0, EdgeSet::triangulated);
}

TEST(SequenceStepper, SolidShellsEqualFreshOnes) {
  const ScratchFolder folder;
  int files = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 5).write(folder / "s.vtkhdf");
    SequenceReader reader(folder / "s.vtkhdf");
    if (!reader.has_thickness()) continue;
    ++files;
    SequenceStepper stepper(reader, {EdgeSet::triangulated, ShellModel::solid});
    for (const int k : {0, 1, 2, 3, 1, 1, 0, 3}) {
      stepper.go_to(k);
      expect_fresh_solids(reader, stepper, k);
    }
  }
  EXPECT_GE(files, 3);
}

TEST(SequenceStepper, SolidShellsNeedAThickness) {
  const ScratchFolder folder;
  for (const ElementType type : {ElementType::hexahedron, ElementType::quad}) {
    const Shape shape = block(type, 2, 2, 1);
    Sequence s;
    for (std::size_t i = 0; i < shape.positions.size(); ++i) s.point_ids.push_back(static_cast<std::int64_t>(i));
    for (int k = 0; k < 2; ++k) {
      s.steps.push_back({1.0 * k, shape.positions, {}, {}, {}});
      for (const ElementSpec& spec : shape.elements) s.steps.back().cells.add(spec);
    }
    s.write(folder / "s.vtkhdf");
    SequenceReader reader(folder / "s.vtkhdf");
    SequenceStepper stepper(reader, {EdgeSet::triangulated, ShellModel::solid});
    if (is_shell(type))
      EXPECT_THROW(stepper.go_to(0), InputError);
    else
      EXPECT_NO_THROW(stepper.go_to(0));
  }
}

TEST(SequenceStepper, TimeOfEditsIsThatOfTheLastMotion) {
  const ScratchFolder folder;
  const Parabolas p(4);
  p.write(folder / "s.vtkhdf", true, {0, 1, 5});
  for (const MotionModel motion : {MotionModel::linear, MotionModel::tentative}) {
    SequenceReader reader(folder / "s.vtkhdf");
    SequenceStepper stepper(reader, {EdgeSet::triangulated, ShellModel::surface, motion});
    EXPECT_EQ(stepper.edit_seconds(), 0);
    int cells_before = -1;
    for (const int k : {0, 0, 1, 2, 3, 4, 3, 2, 0, 0}) {
      SCOPED_TRACE(k);
      const int cells = motion == MotionModel::tentative ? k : k + 1;
      const std::uint64_t version = stepper.current() < 0 ? 0 : stepper.topology().version();
      const auto start = std::chrono::steady_clock::now();
      stepper.go_to(k);
      const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      EXPECT_LE(stepper.edit_seconds(), wall);
      const bool edited = cells_before >= 0 && version != stepper.topology().version();
      EXPECT_EQ(edited, cells_before >= 0 && reader.cell_count(cells_before) != reader.cell_count(cells));
      EXPECT_EQ(stepper.edit_seconds() > 0, edited);
      EXPECT_THROW(stepper.go_to(9), InputError);
      EXPECT_EQ(stepper.edit_seconds() > 0, edited);
      cells_before = cells;
    }
  }
}

TEST(SequenceStepper, OneStepHasNoMotion) {
  const ScratchFolder folder;
  random_sequence(1, 1).write(folder / "s.vtkhdf");
  SequenceReader reader(folder / "s.vtkhdf");
  SequenceStepper stepper(reader);
  EXPECT_EQ(stepper.step_count(), 0);
  EXPECT_THROW(stepper.go_to(0), InputError);
}

TEST(SequenceStepper, ProjectileEqualsFreshTopologies) {
  VOLCCD_NEEDS_DATA(path, "ls-dyna-projectile.vtkhdf");
  SequenceReader reader(path);
  SequenceStepper stepper(reader);
  for (const int k : {0, 4, 14, 7}) {
    stepper.go_to(k);
    expect_fresh(reader, stepper, k, EdgeSet::triangulated);
  }
}

}  // namespace
}  // namespace volccd::test
