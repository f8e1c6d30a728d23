// The experiment `plus`: the boundary as triangle shells, entrants that run on it, and the contents of record and
// summary.
#include <algorithm>
#include <set>
#include <tuple>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/experiments/harness/boundary_shells.hpp>
#include <volccd/experiments/tables/plus.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "experiments/described_keys.hpp"
#include "experiments/harness/harness_fixture.hpp"
#include "support/one_step.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

Motion falling(const std::vector<Vec3>& x0) {
  std::vector<Vec3> x1 = x0;
  for (Vec3& p : x1) p -= Vec3(0, 0, 1);
  return Motion::linear(x0, x1);
}

/// The triangles as points at t = 0, each rotated so that its smallest point is first, which keeps its orientation.
std::multiset<std::vector<double>> triangles_of(const Topology& topology, const Motion& motion) {
  std::multiset<std::vector<double>> result;
  for (Index o = 0; o < topology.mesh().element_slots(); ++o) {
    if (!topology.mesh().is_live(o)) continue;
    std::vector<std::vector<double>> points;
    for (const Index v : topology.mesh().vertices(o)) {
      const Vec3 p = motion.point(v, 0);
      points.push_back({p.x(), p.y(), p.z()});
    }
    std::rotate(points.begin(), std::min_element(points.begin(), points.end()), points.end());
    std::vector<double> one = {static_cast<double>(topology.mesh().object(o))};
    for (const auto& p : points) one.insert(one.end(), p.begin(), p.end());
    result.insert(one);
  }
  return result;
}

/// Six times the volume enclosed by the shells.
double enclosed(const Topology& topology, const Motion& motion) {
  double sum = 0;
  for (Index o = 0; o < topology.mesh().element_slots(); ++o) {
    if (!topology.mesh().is_live(o)) continue;
    const auto v = topology.mesh().vertices(o);
    sum += motion.point(v[0], 0).dot(motion.point(v[1], 0).cross(motion.point(v[2], 0)));
  }
  return sum;
}

TEST(BoundaryShells, AreTheOutsideOfSolidsOrientedOutward) {
  for (const ElementType type : {ElementType::tetrahedron, ElementType::wedge, ElementType::hexahedron}) {
    const Shape shape = block(type, 3, 3, 3);
    const Topology mesh(shape.mesh());
    BoundaryShells shells;
    shells.update(mesh, falling(shape.positions));
    EXPECT_EQ(shells.topology().mesh().element_count(), 6u * 9u * 2u) << to_string(type);
    EXPECT_EQ(shells.motion().vertex_count(), 64u - 8u) << to_string(type) << ": without those inside";
    Vec3 low = shape.positions[0], high = low;
    for (const Vec3& p : shape.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
    EXPECT_NEAR(enclosed(shells.topology(), shells.motion()), 6 * (high - low).prod(), 1e-9) << to_string(type);
    for (Index v = 0; v < shells.motion().vertex_count(); ++v)
      EXPECT_EQ(shells.motion().point(v, 1), Vec3(shells.motion().point(v, 0) - Vec3(0, 0, 1)));
  }
}

TEST(BoundaryShells, KeepShellsAlsoOnSolidsAndGroupsOfVertices) {
  const Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  const Topology solid_alone(shape.mesh());
  const Features& features = solid_alone.features();
  for (const std::size_t tetrahedra : {1u, 2u}) {
    Index f = 0;
    while (features.triangle_elements(f).size() != tetrahedra) ++f;
    const auto& v = features.triangle(f);
    Mesh mesh = shape.mesh();
    mesh.add_element({.type = ElementType::triangle, .vertices = {v[0], v[1], v[2]}, .object = 7, .id = 1000});
    BoundaryShells shells;
    shells.update(Topology(mesh), falling(shape.positions));
    EXPECT_EQ(shells.topology().mesh().element_count(), tetrahedra == 1 ? 12u : 13u) << "glued to the outside, inside";
  }

  const Shape sheet = block(ElementType::quad, 2, 2, 1);
  const Mesh plain = sheet.mesh();
  BoundaryShells flat;
  flat.update(Topology(plain), falling(sheet.positions));
  EXPECT_EQ(flat.topology().mesh().element_count(), 2 * plain.element_count()) << "two triangles a quad";
  const ShellThickener thickener(plain);
  std::vector<Vec3> solid;
  thickener.positions(sheet.positions, std::vector<double>(plain.element_slots(), 0.1), solid);
  BoundaryShells thick(3);
  thick.update(Topology(thickener.solid_mesh(plain)), falling(solid));
  EXPECT_EQ(thick.motion().vertex_count(), 3 * sheet.positions.size()) << "middle vertices stay between the others";
  EXPECT_EQ(thick.topology().mesh().element_count(), 2u * 2u * plain.element_count() + 2u * 8u);
}

/// After each edit of a scene whose elements are removed, the shells equal those of a new mesh.
TEST_F(Harness, BoundaryShellsFollowEdits) {
  SequenceReader reader(file_);
  SequenceStepper stepper(reader);
  BoundaryShells followed;
  int edits = 0;
  for (const int k : {0, 1, 2, 3, 4, 5, 6, 7, 2, 5}) {
    stepper.go_to(k);
    followed.update(stepper.topology(), stepper.motion());
    edits += followed.edit_seconds() > 0;
    BoundaryShells fresh;
    fresh.update(stepper.topology(), stepper.motion());
    EXPECT_EQ(fresh.edit_seconds(), 0);
    EXPECT_EQ(triangles_of(followed.topology(), followed.motion()), triangles_of(fresh.topology(), fresh.motion()))
        << "motion " << k;
  }
  EXPECT_GT(edits, 1) << "the scene shows nothing: no element erodes";
}

using PlacedContact = std::tuple<FeatureKind, std::array<std::array<double, 3>, 4>, double>;

/// Contacts for which `wanted` is true, as the positions of their vertices at t = 0.
template <class Wanted>
std::multiset<PlacedContact> contacts_of(const Topology& topology, const Motion& motion, Wanted&& wanted) {
  const StepResult result = test::run_step({topology, motion, test::kAllObjects});
  std::multiset<PlacedContact> contacts;
  for (const Contact& contact : result.contacts) {
    if (!wanted(contact)) continue;
    std::array<std::array<double, 3>, 4> places;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 p = motion.point(contact.vertices[i], 0);
      places[i] = {p.x(), p.y(), p.z()};
    }
    contacts.emplace(contact.kind, places, contact.toi);
  }
  return contacts;
}

/// The contacts of the whole mesh whose two features are on the boundary.
TEST_F(Harness, ContactsOfBoundaryShellsAreThoseOfBoundaryFeatures) {
  SequenceReader reader(file_);
  SequenceStepper stepper(reader);
  std::size_t contacts = 0, interior = 0;
  for (const int k : {3, 5}) {
    stepper.go_to(k);
    BoundaryShells shells;
    shells.update(stepper.topology(), stepper.motion());
    const Features& features = stepper.topology().features();
    std::set<Index> vertices, triangles;
    std::set<std::array<Index, 2>> edges;
    for (Index f = 0; f < features.triangle_slots(); ++f) {
      if (features.triangle_elements(f).size() != 1) continue;
      const auto& v = features.triangle(f);
      triangles.insert(f);
      vertices.insert(v.begin(), v.end());
      edges.insert({{v[0], v[1]}, {v[0], v[2]}, {v[1], v[2]}});
    }
    const auto on_boundary = [&](const Contact& contact) {
      const auto& v = contact.vertices;
      const auto has_edge = [&](Index a, Index b) { return edges.contains({std::min(a, b), std::max(a, b)}); };
      const bool all = contact.kind == FeatureKind::vf
                           ? vertices.contains(v[0]) && triangles.contains(features.find_triangle(v[1], v[2], v[3]))
                           : has_edge(v[0], v[1]) && has_edge(v[2], v[3]);
      interior += !all;
      return all;
    };
    const auto expected = contacts_of(stepper.topology(), stepper.motion(), on_boundary);
    EXPECT_EQ(contacts_of(shells.topology(), shells.motion(), [](const Contact&) { return true; }), expected);
    contacts += expected.size();
  }
  EXPECT_GT(contacts, 0u) << "the scene shows nothing";
  EXPECT_GT(interior, 0u) << "the scene shows nothing: no contact inside";
}

class Plus : public Harness {
 protected:
  ExperimentPlan small_plan(bool full) const {
    return plus_plan({registry_, full, {}, {}, [&](const std::string& name) {
                        return name == "octopi" || name == "octopi-quick" ? std::optional(file_) : std::nullopt;
                      }});
  }
};

TEST_F(Plus, RowsOnTheBoundaryHaveItsSizesAndItsContacts) {
  const std::vector<json> rows = rows_of(small_plan(false), 1, "plus");
  std::set<std::string> names;
  double boundary_contacts = 0, contacts = 0, plain = 0;
  for (const json& row : rows) {
    names.insert(row.at("pipeline").get<std::string>() + "/" + row.at("variant").get<std::string>());
    const bool on_boundary = row.at("pipeline").get<std::string>().starts_with("boundary alone");
    EXPECT_EQ(row.at("mesh"), on_boundary ? "boundary" : "whole");
    EXPECT_EQ(row.at("elements") == row.at("triangle_count"), on_boundary) << "triangles alone";
    EXPECT_LE(row.at("window"), row.at("step"));
    if (row.at("pipeline") == "VolCCD+") contacts += row.at("contacts").get<double>();
    if (on_boundary)
      (row.at("pipeline") == "boundary alone" ? boundary_contacts : plain) += row.at("contacts").get<double>();
  }
  EXPECT_EQ(names, (std::set<std::string>{"VolCCD/inclusion", "VolCCD+/inclusion", "VolCCD+ without flood/inclusion",
                                          "boundary alone/inclusion", "boundary alone without flood/inclusion"}));
  EXPECT_GT(boundary_contacts, 0) << "the scene shows nothing";
  EXPECT_LE(boundary_contacts, contacts);
  EXPECT_EQ(boundary_contacts, plain) << "with and without flood";
  EXPECT_TRUE(contact_differences(registry_, small_plan(false), rows).empty()) << "the boundary's are not compared";
}

TEST_F(Plus, SummaryHasTheDocumentedKeysAndRatios) {
  ExperimentPlan plan = small_plan(true);
  for (SceneRun& run : plan.runs) run.windows = {{1, 3}}, run.rounds = 1;
  const json record = {{"rows", rows_of(plan, 1, "plus")}};
  const json summary = plus_summary(record);
  ASSERT_EQ(summary.size(), plan.runs.size());
  for (const json& line : summary) {
    for (const char* key :
         {"scene", "threads", "volccd_ms", "volccd_plus_ms", "boundary_only_ms", "boundary_without_flood_ms",
          "speedup_volccd", "volume_over_surface", "flood_gain", "contacts"})
      EXPECT_TRUE(line.contains(key)) << key;
    EXPECT_EQ(line.at("steps"), 3);
    EXPECT_NEAR(line.at("speedup_volccd").get<double>() * line.at("volccd_plus_ms").get<double>(),
                line.at("volccd_ms").get<double>(), 1e-9);
    EXPECT_NEAR(line.at("volume_over_surface").get<double>() * line.at("boundary_only_ms").get<double>(),
                line.at("volccd_plus_ms").get<double>(), 1e-9);
    EXPECT_EQ(line.contains("speedup_threads"), line.at("threads") != 1);
  }
  expect_described(summary.back(), "plus_summary");
  const std::string tables = render(plus_tables(record), TableFormat::text);
  EXPECT_NE(tables.find("volume / surface"), std::string::npos);
}

}  // namespace
}  // namespace volccd::test
