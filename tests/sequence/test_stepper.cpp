// What the stepper has after any walk over the motions is what a fresh topology would have.
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/mesh/sequence/stepper.hpp>
#include <volccd/mesh/shells.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"
#include "support/test_data.hpp"

namespace volccd::test {
namespace {

using Ids = std::vector<std::int64_t>;

/// A topology by ids alone: elements, and features with the elements that have them.
struct Description {
  std::map<std::int64_t, std::tuple<ElementType, std::int32_t, Ids, Ids>> elements;
  std::map<Ids, std::set<std::int64_t>> edges, triangles, vertices;

  friend bool operator==(const Description&, const Description&) = default;
};

Description describe(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  const auto ids = [&](auto slots) {
    Ids result;
    for (const Index v : slots) result.push_back(mesh.vertex_id(v));
    return result;
  };
  const auto elements = [&](std::span<const Index> slots) {
    std::set<std::int64_t> result;
    for (const Index o : slots) result.insert(mesh.element_id(o));
    return result;
  };
  Description d;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.alive(o)) continue;
    Ids faces;
    for (std::size_t at = 0; at < mesh.polytope_faces(o).size(); at += mesh.polytope_faces(o)[at] + 1) {
      faces.push_back(mesh.polytope_faces(o)[at]);
      for (const std::int64_t id : ids(mesh.polytope_faces(o).subspan(at + 1, mesh.polytope_faces(o)[at])))
        faces.push_back(id);
    }
    d.elements[mesh.element_id(o)] = {mesh.type(o), mesh.object(o), ids(mesh.vertices(o)), faces};
  }
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (!features.vertex_elements(v).empty()) d.vertices[{mesh.vertex_id(v)}] = elements(features.vertex_elements(v));
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (!features.edge_elements(e).empty()) d.edges[ids(features.edge(e))] = elements(features.edge_elements(e));
  for (Index f = 0; f < features.triangle_slots(); ++f)
    if (!features.triangle_elements(f).empty())
      d.triangles[ids(features.triangle(f))] = elements(features.triangle_elements(f));
  return d;
}

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
    ASSERT_EQ(stepper.motion_count(), 6);
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

/// An edit holds what differs and nothing else.
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

/// Thickness by cell id, the second step's where the first has none.
std::vector<double> thickness_at(SequenceReader& reader, int step, int cells_of_step) {
  std::map<std::int64_t, double> by_id;
  for (const int k : {cells_of_step, step}) {
    SequenceCells cells;
    std::vector<double> values;
    reader.read_cells(k, cells);
    reader.read_thickness(k, values);
    for (std::size_t i = 0; i < values.size(); ++i) by_id[cells.ids[i]] = values[i];
  }
  SequenceCells cells;
  reader.read_cells(cells_of_step, cells);
  std::vector<double> result;
  for (const std::int64_t id : cells.ids) result.push_back(by_id.at(id));
  return result;
}

void expect_fresh_solids(SequenceReader& reader, const SequenceStepper& stepper, int motion) {
  SCOPED_TRACE(motion);
  SequenceCells cells;
  reader.read_cells(motion + 1, cells);
  const Mesh shells = mesh_of(reader.point_ids(), cells);
  const ShellThickener thickener(shells);
  EXPECT_EQ(describe(stepper.topology()), describe(Topology(thickener.solid_mesh(shells))));
  std::vector<Vec3> x, solid;
  Index without_normal = 0;
  for (const int end : {0, 1}) {
    reader.read_points(motion + end, x);
    without_normal += thickener.positions(x, thickness_at(reader, motion + end, motion + 1), solid);
    ASSERT_EQ(stepper.motion().vertex_count(), solid.size());
    for (Index v = 0; v < solid.size(); ++v) EXPECT_EQ(stepper.motion().point(v, end), solid[v]);
  }
  EXPECT_EQ(stepper.vertices_without_normal(), without_normal);
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

TEST(SequenceStepper, OneStepHasNoMotion) {
  const ScratchFolder folder;
  random_sequence(1, 1).write(folder / "s.vtkhdf");
  SequenceReader reader(folder / "s.vtkhdf");
  SequenceStepper stepper(reader);
  EXPECT_EQ(stepper.motion_count(), 0);
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
