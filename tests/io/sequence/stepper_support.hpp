// Helpers for tests of SequenceStepper: topologies by ids, sequences of parabolas, a fixture.
#pragma once

#include <map>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/mesh/shells.hpp>

#include "raw_hdf5.hpp"
#include "sequences.hpp"

namespace volccd::test {

using Ids = std::vector<std::int64_t>;

/// A topology described by ids: elements, and features with their elements.
struct Description {
  std::map<std::int64_t, std::tuple<ElementType, std::int32_t, Ids, Ids>> elements;
  std::map<Ids, std::set<std::int64_t>> edges, triangles, vertices;

  friend bool operator==(const Description&, const Description&) = default;
};

inline Description describe(const Topology& topology) {
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

/// Thickness by cell id; that of the second step is used for cells that the first one does not have.
inline std::vector<double> thickness_at(SequenceReader& reader, int step, int cells_of_step) {
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

inline void expect_fresh_solids(SequenceReader& reader, const SequenceStepper& stepper, int motion) {
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

/// Integer coefficients, and steps that are 1, 3 or 7 times as long as the one before, so that parabolas are exact.
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

  /// Tetrahedra 0-3, 4-7 and 8-11; the last one is missing at the steps of `without`.
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
        step.cells.add(
            {.type = ElementType::tetrahedron, .vertices = {4 * o, 4 * o + 1, 4 * o + 2, 4 * o + 3}, .id = o});
      s.steps.push_back(step);
    }
    s.write(file);
  }
};

inline void expect_parabola(const Parabolas& p, const Motion& motion, Index v, double t0, double t1) {
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0})
    EXPECT_EQ(motion.position(v, t), p.at(v, t0 + t * (t1 - t0))) << "vertex " << v << " at " << t;
}

/// A fixture for tests that write files.
class StepperTest : public testing::Test {
 protected:
  std::string file(const char* name) const { return folder_ / name; }

  /// Point 5 has a velocity at step 4 with which motion 4, of length 21, overflows. The error names the array and the
  /// point, and the stepper stays at motion 3; `unchanged` is called on it.
  template <class Unchanged>
  void expect_overflow_is_refused(const Parabolas& p, const SequenceStepper::Config& config, Unchanged&& unchanged) {
    p.write(file("huge.vtkhdf"), true);
    {
      RawFile raw(file("huge.vtkhdf"));
      raw.poke("VTKHDF/PointData/Velocity", 3 * (4 * 12 + 5), 1.7e308);
    }
    SequenceReader reader(file("huge.vtkhdf"));
    SequenceStepper stepper(reader, config);
    stepper.go_to(3);
    try {
      stepper.go_to(4);
      ADD_FAILURE() << "overflow was accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(error.dataset(), "VTKHDF/PointData/Velocity");
      for (const char* word : {"step 4", "id 5"})
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
    EXPECT_EQ(stepper.current(), 3);
    unchanged(reader, stepper);
  }

  const ScratchFolder folder_;
};

}  // namespace volccd::test
