// What the stepper has after any walk over the motions is what a fresh topology would have.
#include <chrono>
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
    if (!mesh.is_live(o)) continue;
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
    for (Index v = 0; v < solid.size(); ++v)
      EXPECT_EQ(stepper.motion().point(v, end * stepper.motion().degree()), solid[v]);
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

/// Integers, and steps 1, 3 or 7 times as long as the one before: parabolas come out without rounding.
struct Parabolas {
  std::vector<double> times = {0, 1, 2, 5, 8, 29};
  std::vector<Vec3> place, velocity, acceleration;

  explicit Parabolas(std::uint64_t seed, std::size_t points = 12) {
    std::mt19937_64 random(seed);
    const auto whole = [&] { return static_cast<double>(random() % 64) - 32; };
    for (std::size_t i = 0; i < points; ++i) {
      place.emplace_back(whole(), whole(), whole());
      velocity.emplace_back(whole(), whole(), whole());
      acceleration.emplace_back(whole(), whole(), whole());
    }
  }
  Vec3 at(std::size_t v, double t) const { return place[v] + t * velocity[v] + t * t * acceleration[v]; }
  Vec3 velocity_at(std::size_t v, double t) const { return velocity[v] + 2 * t * acceleration[v]; }

  /// Tetrahedra 0-3, 4-7, 8-11; of the last there is none at the steps of `without`.
  void write(const std::string& file, bool velocities, const std::set<std::size_t>& without = {},
             std::size_t steps = 6) const {
    Sequence s;
    for (std::size_t i = 0; i < place.size(); ++i) s.point_ids.push_back(static_cast<std::int64_t>(i));
    for (std::size_t k = 0; k < steps; ++k) {
      Sequence::Step step{times[k], {}, {}, {}, {}};
      for (std::size_t v = 0; v < place.size(); ++v) {
        const bool unused = v >= 8 && without.contains(k);
        step.points.push_back(unused ? Vec3::Constant(1e300) : at(v, times[k]));
        if (velocities) step.velocity.push_back(unused ? Vec3::Constant(-1e308) : velocity_at(v, times[k]));
      }
      for (Index o = 0; o < (without.contains(k) ? 2u : 3u); ++o)
        step.cells.add({ElementType::tetrahedron, {4 * o, 4 * o + 1, 4 * o + 2, 4 * o + 3}, {}, 0, o});
      s.steps.push_back(step);
    }
    s.write(file);
  }
};

void expect_parabola(const Parabolas& p, const Motion& motion, Index v, double t0, double t1) {
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0})
    EXPECT_EQ(motion.position(v, t), p.at(v, t0 + t * (t1 - t0))) << "vertex " << v << " at " << t;
}

/// Without velocities by three steps, unequal ones included, with velocities by those: the same parabola, exactly,
/// after any walk.
TEST(SequenceStepper, QuadraticMotionReproducesParabolas) {
  const ScratchFolder folder;
  for (const bool velocities : {false, true})
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      SCOPED_TRACE(testing::Message() << "velocities " << velocities << " seed " << seed);
      const Parabolas p(seed);
      p.write(folder / "s.vtkhdf", velocities);
      SequenceReader reader(folder / "s.vtkhdf");
      SequenceStepper stepper(reader, {EdgeSet::triangulated, ShellModel::surface, MotionModel::quadratic});
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

/// A parabola is looked up where cells use the point; where they do not, its place and velocity are anything.
TEST(SequenceStepper, QuadraticMotionDoesNotLookAtUnusedPoints) {
  const ScratchFolder folder;
  const Parabolas p(7);
  for (const bool velocities : {false, true}) {
    SCOPED_TRACE(velocities);
    // Born at step 2, gone at step 5.
    p.write(folder / "s.vtkhdf", velocities, {0, 1, 5});
    SequenceReader reader(folder / "s.vtkhdf");
    SequenceStepper stepper(reader, {EdgeSet::triangulated, ShellModel::surface, MotionModel::quadratic});
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

/// Velocities that contradict the positions: the motion begins with them and ends at the next step all the same.
TEST(SequenceStepper, QuadraticMotionBeginsWithTheStoredVelocity) {
  const ScratchFolder folder;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    random_sequence(seed, 4).write(folder / "s.vtkhdf");
    SequenceReader reader(folder / "s.vtkhdf");
    if (!reader.has_velocity()) continue;
    SequenceStepper stepper(reader, {EdgeSet::triangulated, ShellModel::surface, MotionModel::quadratic});
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

TEST(SequenceStepper, QuadraticMotionCarriesSolidShells) {
  const ScratchFolder folder;
  int files = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 5).write(folder / "s.vtkhdf");
    SequenceReader reader(folder / "s.vtkhdf");
    if (!reader.has_thickness()) continue;
    ++files;
    SequenceStepper surface(reader, {EdgeSet::triangulated, ShellModel::surface, MotionModel::quadratic});
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

TEST(SequenceStepper, QuadraticMotionIsRefusedWhereItCannotBe) {
  const ScratchFolder folder;
  const SequenceStepper::Config quadratic{EdgeSet::triangulated, ShellModel::surface, MotionModel::quadratic};
  const Parabolas p(1);
  p.write(folder / "two.vtkhdf", false, {}, 2);
  SequenceReader two(folder / "two.vtkhdf");
  EXPECT_THROW(SequenceStepper(two, quadratic), InputError);
  p.write(folder / "with.vtkhdf", true, {}, 2);
  SequenceReader with(folder / "with.vtkhdf");
  EXPECT_NO_THROW(SequenceStepper(with, quadratic).go_to(0));

  p.write(folder / "huge.vtkhdf", true);
  {
    RawFile raw(folder / "huge.vtkhdf");
    raw.poke("VTKHDF/PointData/Velocity", 3 * (4 * 12 + 5), 1.7e308);
  }
  SequenceReader huge(folder / "huge.vtkhdf");
  SequenceStepper stepper(huge, quadratic);
  stepper.go_to(3);
  try {
    stepper.go_to(4);  // 21 units of time
    ADD_FAILURE() << "overflow was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.dataset(), "VTKHDF/PointData/Velocity");
    EXPECT_NE(std::string(error.what()).find("id 5"), std::string::npos) << error.what();
  }
  EXPECT_EQ(stepper.current(), 3);
  for (Index v = 0; v < 12; ++v) expect_parabola(p, stepper.motion(), v, p.times[3], p.times[4]);
}

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

/// From the points and velocities of step k, on the cells of step k, also where the next step has others.
TEST(SequenceStepper, TentativeMotionIsOfItsStepAlone) {
  const ScratchFolder folder;
  int files = 0, changes = 0, unused = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 5).write(folder / "s.vtkhdf");
    SequenceReader reader(folder / "s.vtkhdf");
    if (!reader.has_velocity()) continue;
    ++files;
    SequenceStepper stepper(reader, kTentative);
    ASSERT_EQ(stepper.motion_count(), 4);
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

/// What is stored for points that no cell uses means nothing: they stand still.
TEST(SequenceStepper, TentativeMotionLeavesUnusedPointsWhereTheyAre) {
  const ScratchFolder folder;
  const Parabolas p(3);
  p.write(folder / "s.vtkhdf", true, {0, 1, 5});
  SequenceReader reader(folder / "s.vtkhdf");
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

/// The middle moves as the surface does; above and below lie where thickening puts them at either end.
TEST(SequenceStepper, TentativeMotionCarriesSolidShells) {
  const ScratchFolder folder;
  int files = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    random_sequence(seed, 5).write(folder / "s.vtkhdf");
    SequenceReader reader(folder / "s.vtkhdf");
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

TEST(SequenceStepper, TentativeMotionIsRefusedWhereItCannotBe) {
  const ScratchFolder folder;
  const Parabolas p(2);
  p.write(folder / "without.vtkhdf", false);
  SequenceReader without(folder / "without.vtkhdf");
  try {
    SequenceStepper(without, kTentative);
    ADD_FAILURE() << "a file without velocities was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.dataset(), "VTKHDF/PointData/Velocity");
    for (const char* word : {"without.vtkhdf", "velocities", "linear"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }

  p.write(folder / "huge.vtkhdf", true);
  {
    RawFile raw(folder / "huge.vtkhdf");
    raw.poke("VTKHDF/PointData/Velocity", 3 * (4 * 12 + 5), 1.7e308);
  }
  SequenceReader huge(folder / "huge.vtkhdf");
  SequenceStepper stepper(huge, kTentative);
  stepper.go_to(3);
  try {
    stepper.go_to(4);  // 21 units of time
    ADD_FAILURE() << "overflow was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.dataset(), "VTKHDF/PointData/Velocity");
    for (const char* word : {"motion 4", "id 5"})
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
  }
  expect_tentative(huge, stepper, 3);
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
