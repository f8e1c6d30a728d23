// The Detector returns what the parts behind it return, bit for bit, through steps, edits and errors.
#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/pipelines/detector.hpp>

#include "pipelines/scenes.hpp"
#include "support/allocations.hpp"

namespace volccd::detector_test {
namespace {

/// The motion of a shape: its control points by vertex.
struct Course {
  std::vector<Vec3> x0, xm, x1;

  Course(const std::vector<Vec3>& positions, std::uint64_t seed, double jitter = 0.35)
      : x0(jittered(positions, jitter, seed)),
        xm(jittered(positions, jitter, seed + 1)),
        x1(jittered(positions, jitter, seed + 2)) {}
};

void expect_equal(const StepResult& expected, const StepResult& found, const std::string& what) {
  EXPECT_EQ(expected.contacts, found.contacts) << what;
  EXPECT_EQ(expected.initial_overlaps, found.initial_overlaps) << what;
  EXPECT_EQ(expected.statistics.tests(), found.statistics.tests()) << what;
  EXPECT_EQ(expected.statistics.earliest_toi, found.statistics.earliest_toi) << what;
}

/// The result of the pipeline with new tables, on the calling thread.
StepResult run(const Step& step, const Request& request, const std::string& name = "VolCCD+") {
  const Registry registry = Registry::standard();
  const Pipeline pipeline(registry, registry.pipeline(name));
  Workspace workspace = pipeline.make_workspace();
  StepResult result;
  pipeline.run(step, workspace, serial_executor(), result, request);
  return result;
}

/// Shapes of all types of elements, in two objects that touch in most motions.
std::vector<std::pair<std::string, Shape>> shapes() {
  std::vector<std::pair<std::string, Shape>> list;
  const auto add = [&](const std::string& name, const Shape& shape) {
    Shape both, other = shape;
    double height = 0;
    for (const Vec3& p : shape.positions) height = std::max(height, p.z());
    both.append(shape, 1);
    both.append(other.translate(Vec3(0.31, 0.27, height + 0.2)), 2);
    list.emplace_back(name, permuted(both, 5));
  };
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::quad})
    add(to_string(type), block(type, 2, 2, 1));
  add("mixed", mixed_block(1, 1));
  return list;
}

Shape sheets() {
  Shape both, other = block(ElementType::quad, 2, 2, 1);
  both.append(block(ElementType::triangle, 2, 2, 1), 1);
  both.append(other.translate(Vec3(0.2, 0.1, 0.16)), 2);
  return both;
}

TEST(Detector, EqualsARunOfItsPipeline) {
  const ObjectFilter all;
  for (const auto& [name, shape] : shapes())
    for (const unsigned threads : {1u, 2u})
      for (const double separation : {0.0, 0.05}) {
        const std::string what = name + ", threads " + std::to_string(threads);
        Detector detector(shape.mesh(), {.threads = threads, .separation = separation});
        const Topology topology(shape.mesh());
        const Request request{.initial_overlaps = true};
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
          const Course c(shape.positions, 10 * seed);
          const Motion linear = Motion::linear(c.x0, c.x1), curved = Motion::quadratic(c.x0, c.xm, c.x1);
          const StepResult expected = run({topology, linear, all, separation}, request);
          EXPECT_GT(expected.contacts.size(), 0u) << what;
          expect_equal(expected, detector.step(c.x0, c.x1, request), what);
          expect_equal(expected, detector.step(linear, request), what + ", by its motion");
          expect_equal(run({topology, curved, all, separation}, {}), detector.step(c.x0, c.xm, c.x1),
                       what + ", quadratic");
        }
      }
}

TEST(Detector, HasTheContactsOfTheObjectsThatAreAskedFor) {
  const Shape shape = shapes().back().second;
  const Topology topology(shape.mesh());
  const Course c(shape.positions, 3);
  const Motion motion = Motion::linear(c.x0, c.x1);
  ObjectFilter without(PairScope::all);
  without.exclude(1, 1);
  std::vector<std::size_t> counts;
  for (const ObjectFilter& filter :
       {ObjectFilter(), ObjectFilter(PairScope::inter), ObjectFilter(PairScope::intra), without}) {
    Detector detector(shape.mesh(), {.filter = filter});
    const StepResult& found = detector.step(c.x0, c.x1);
    expect_equal(run({topology, motion, filter}, {}), found, "filter");
    counts.push_back(found.contacts.size());
  }
  EXPECT_EQ(counts[0], counts[1] + counts[2]);
  EXPECT_GT(counts[1], 0u);
  EXPECT_GT(counts[0], counts[3]);
}

TEST(Detector, FirstIsTheEarliestContact) {
  for (const auto& [name, shape] : shapes()) {
    Detector detector(shape.mesh());
    const Course c(shape.positions, 4, 0.01), still(shape.positions, 4, 0);
    // Where shells lie on volumes, the diagonals of a common face may cross.
    EXPECT_TRUE(name == "mixed" || !detector.first(still.x0, still.x0)) << name;
    const std::vector<Contact> contacts = detector.step(c.x0, still.x1).contacts;
    const auto earliest = std::ranges::min_element(contacts, {}, &Contact::toi);
    const std::optional<Contact> first = detector.first(c.x0, still.x1);
    ASSERT_EQ(first.has_value(), earliest != contacts.end()) << name;
    EXPECT_TRUE(!first || *first == *earliest) << name;
  }
}

TEST(Detector, TakesPipelineSettingsAndStagesOfTheCaller) {
  const Shape shape = shapes().front().second;
  const Course c(shape.positions, 6);
  Registry registry = Registry::standard();
  PipelineSpec own = registry.pipeline("VolCCD");
  own.name = "own";
  registry.add_pipeline(own);
  Detector detector(shape.mesh(), {.pipeline = "own", .settings = {"csat.axis=optimal", "feature-filter=none"}},
                    registry);
  EXPECT_EQ(detector.pipeline().spec().name, "own");
  EXPECT_TRUE(detector.pipeline().spec().feature_filters.empty());
  EXPECT_EQ(detector.pipeline().spec().element_culling.front().options.at("axis"), "optimal");
  Detector plain(shape.mesh());
  EXPECT_EQ(detector.step(c.x0, c.x1).contacts, plain.step(c.x0, c.x1).contacts);
  EXPECT_THROW(Detector(shape.mesh(), {.pipeline = "own"}), ConfigError);
  EXPECT_THROW(Detector(shape.mesh(), {.settings = {"csat.axis=none"}}), ConfigError);
  EXPECT_THROW(Detector(shape.mesh(), {.threads = kMaxThreads + 1}), ConfigError);
  EXPECT_THROW(Detector(shape.mesh(), {.separation = -1}), ConfigError);
}

TEST(Detector, ChangesItsSeparation) {
  const Shape shape = shapes().front().second;
  const Course c(shape.positions, 7, 0.02);
  Detector changed(shape.mesh()), wide(shape.mesh(), {.separation = 0.3});
  changed.step(c.x0, c.x1);
  changed.set_separation(0.3);
  expect_equal(wide.step(c.x0, c.x1), changed.step(c.x0, c.x1), "separation 0.3");
  EXPECT_THROW(changed.set_separation(std::numeric_limits<double>::infinity()), ConfigError);
  EXPECT_EQ(changed.separation(), 0.3);
}

/// The motion of the solid mesh that the parts of the library make of a course.
struct SolidCourse {
  std::vector<Vec3> x0, xm, x1;

  SolidCourse(const ShellThickener& thickener, const std::vector<double>& thickness, const Course& c) {
    thickener.positions(c.x0, thickness, x0);
    thickener.positions(c.x1, thickness, x1);
    solid_middle_points(c.x0, c.xm, c.x1, x0, x1, xm);
  }
};

TEST(Detector, ThickensShells) {
  const Shape shape = sheets();
  const Mesh mesh = shape.mesh();
  std::vector<double> thickness(mesh.element_slots(), 0.1);
  thickness[1] = 0.2;
  const ShellThickener thickener(mesh);
  const Topology solids(thickener.solid_mesh(mesh));
  const ObjectFilter all;
  Detector detector(mesh, thickness), surfaces(mesh);
  ASSERT_TRUE(detector.thickens_shells());
  EXPECT_EQ(detector.mesh().vertex_count() * 3, detector.topology().mesh().vertex_count());
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Course c(shape.positions, 20 + seed, 0.15);
    const SolidCourse s(thickener, thickness, c);
    const auto step = [&](const Motion& motion) {
      return Step{.topology = solids, .motion = motion, .filter = all, .leave_out_shell_neighbours = true};
    };
    const Request request{.initial_overlaps = true};
    const Motion linear = Motion::linear(s.x0, s.x1), curved = Motion::quadratic(s.x0, s.xm, s.x1);
    expect_equal(run(step(linear), request), detector.step(c.x0, c.x1, {.initial_overlaps = true}), "linear");
    expect_equal(run(step(curved), request), detector.step(c.x0, c.xm, c.x1, {.initial_overlaps = true}), "quadratic");
    EXPECT_NE(detector.step(c.x0, c.x1).contacts.size(), surfaces.step(c.x0, c.x1).contacts.size());
    // A straight motion as a curve: the middle control points of the solids are the means of their ends.
    Course straight = c;
    for (std::size_t v = 0; v < c.x0.size(); ++v) straight.xm[v] = 0.5 * c.x0[v] + 0.5 * c.x1[v];
    const SolidCourse means(thickener, thickness, straight);
    for (std::size_t v = 0; v < means.xm.size(); ++v)
      EXPECT_LT((means.xm[v] - (means.x0[v] + means.x1[v]) / 2).norm(), 1e-12);
  }
}

/// A random edit of a detector's mesh: removes some elements, adds those that an earlier edit removed, and an element
/// on new vertices.
DetectorEdit random_edit(const Detector& detector, Random& random, std::vector<ElementSpec>& out, bool thick,
                         std::vector<Vec3>& positions) {
  const Mesh& mesh = detector.mesh();
  DetectorEdit edit{.added = std::move(out)};
  out.clear();
  std::int64_t next = 1000;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    next = std::max(next, mesh.element_id(o) + 1);
    if (random.below(4) != 0) continue;
    edit.removed.push_back(mesh.element_id(o));
    out.push_back(mesh.spec(o));
  }
  for (const ElementSpec& element : edit.added) next = std::max(next, element.id + 1);
  edit.new_vertices = 2;
  const Index n = mesh.vertex_count();
  edit.added.push_back({.type = ElementType::triangle, .vertices = {0, n, n + 1}, .object = 2, .id = next});
  if (thick) edit.thickness.assign(edit.added.size(), 0.15);
  positions.push_back(positions[0] + Vec3(0.5, 0.2, 0.1 * static_cast<double>(n)));
  positions.push_back(positions[0] + Vec3(0.1, 0.6, -0.1 * static_cast<double>(n)));
  return edit;
}

/// A mesh with the same vertices, elements and ids, without empty slots; and the thickness of each element.
Mesh compact(const Detector& detector) {
  const Mesh& mesh = detector.mesh();
  Mesh copy;
  copy.add_vertices(mesh.vertex_ids());
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) copy.add_element(mesh.spec(o));
  return copy;
}

TEST(Detector, FollowsEdits) {
  for (const bool thick : {false, true})
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const Shape shape = thick ? sheets() : shapes().back().second;
      std::vector<Vec3> positions = shape.positions;
      const std::vector<double> thickness(shape.elements.size(), 0.15);
      Detector kept = thick ? Detector(shape.mesh(), thickness) : Detector(shape.mesh());
      Random random(seed);
      std::vector<ElementSpec> out;
      for (int round = 0; round < 6; ++round) {
        const std::string what = (thick ? "solid" : "surface") + std::string(", round ") + std::to_string(round);
        const Course c(positions, seed + 30 + static_cast<std::uint64_t>(round), 0.2);
        const Mesh mesh = compact(kept);
        const std::vector<double> all(mesh.element_slots(), 0.15);
        Detector fresh = thick ? Detector(mesh, all) : Detector(mesh);
        const StepResult& expected = fresh.step(c.x0, c.x1);
        const StepResult& found = kept.step(c.x0, c.x1);
        EXPECT_EQ(expected.contacts, found.contacts) << what;
        EXPECT_GT(found.contacts.size(), 0u) << what;
        kept.edit(random_edit(kept, random, out, thick, positions));
        ASSERT_EQ(kept.mesh().vertex_count(), positions.size());
      }
    }
}

/// The shell of smallest id determines the orientation of a sheet: without it, all solids turn over.
TEST(Detector, ReplacesSolidsWhoseShellsTurnOver) {
  Shape shape;
  shape.positions = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(2, 0.5, 0)};
  shape.elements = {{.type = ElementType::triangle, .vertices = {1, 2, 0}, .id = 0},
                    {.type = ElementType::triangle, .vertices = {1, 2, 3}, .id = 1},
                    {.type = ElementType::triangle, .vertices = {1, 3, 4}, .id = 2}};
  Detector detector(shape.mesh(), std::vector<double>(3, 0.1));
  detector.edit({.removed = {0}});
  Detector fresh(compact(detector), std::vector<double>(2, 0.1));
  const Mesh &found = detector.topology().mesh(), &expected = fresh.topology().mesh();
  ASSERT_EQ(found.element_count(), expected.element_count());
  for (const std::int64_t id : {1, 2}) {
    const ElementSpec a = found.spec(found.find_element(id)), b = expected.spec(expected.find_element(id));
    EXPECT_EQ(a.vertices, b.vertices) << id;
  }
}

/// The exception of an action; an error for another type of exception, or for none.
template <class Exception, class Action>
Exception exception_of(Action&& action) {
  try {
    action();
  } catch (const Exception& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  if constexpr (std::is_same_v<Exception, InputError>)
    return InputError("", "", "");
  else
    return Exception("");
}

TEST(Detector, RefusesBadInputAndStaysUsable) {
  for (const bool thick : {false, true}) {
    const Shape shape = sheets();
    const std::vector<double> thickness(shape.elements.size(), 0.1);
    Detector detector = thick ? Detector(shape.mesh(), thickness) : Detector(shape.mesh());
    const Course c(shape.positions, 8, 0.2);
    const StepResult expected = detector.step(c.x0, c.x1);
    Course bad = c;
    bad.x1[2].y() = bad.xm[3].z() = std::numeric_limits<double>::quiet_NaN();
    const auto expect_input_error = [&](const char* source, const char* dataset, std::int64_t index, auto&& action) {
      const InputError error = exception_of<InputError>(action);
      EXPECT_EQ(error.source(), source) << error.what();
      EXPECT_EQ(error.dataset(), dataset) << error.what();
      EXPECT_EQ(error.index(), index) << error.what();
      StepResult again = detector.step(c.x0, c.x1);
      EXPECT_EQ(again.contacts, expected.contacts);
    };
    const std::span<const Vec3> x0 = c.x0;
    expect_input_error("motion", "x1", 2, [&] { detector.step(c.x0, bad.x1); });
    expect_input_error("motion", "x0", -1, [&] { detector.step(x0.subspan(1), c.x1); });
    expect_input_error("motion", "x1", -1, [&] { detector.first(c.x0, x0.subspan(1)); });
    expect_input_error("motion", "xm", 3, [&] { detector.step(c.x0, bad.xm, c.x1); });
    expect_input_error("edit", "removed", 1, [&] { detector.edit({.removed = {0, 77}}); });
    expect_input_error("edit", "removed", 2, [&] { detector.edit({.removed = {0, 1, 0}}); });
    const ElementSpec outside{.type = ElementType::triangle, .vertices = {0, 1, 999}, .id = 500};
    const std::vector<double> one(thick ? 1 : 0, 0.1), other(thick ? 0 : 1, 0.1);
    expect_input_error(thick ? "mesh" : "edit", thick ? "elements" : "added", thick ? 500 : 0,
                       [&] { detector.edit({.removed = {0}, .added = {outside}, .thickness = one}); });
    expect_input_error("edit", "thickness", -1, [&] {
      detector.edit({.removed = {0}, .added = {{ElementType::triangle, {0, 1, 2}}}, .thickness = other});
    });
    exception_of<ConfigError>([&] { detector.step(c.x0, c.x1, {}, 1.5); });
    expect_equal(expected, detector.step(c.x0, c.x1), "after all errors");
  }
  const Shape shape = sheets();
  std::vector<double> thickness(shape.elements.size(), 0.1);
  thickness[3] = -1;
  EXPECT_EQ(exception_of<InputError>([&] { Detector(shape.mesh(), thickness); }).index(), 3);
  thickness.pop_back();
  EXPECT_EQ(exception_of<InputError>([&] { Detector(shape.mesh(), thickness); }).dataset(), "thickness");
}

TEST(Detector, MovesAndGivesItsResultAway) {
  const Shape shape = shapes().front().second;
  const Course c(shape.positions, 9);
  Detector first(shape.mesh());
  const StepResult expected = first.step(c.x0, c.x1);
  Detector second = std::move(first);
  EXPECT_EQ(second.result().contacts, expected.contacts);
  expect_equal(expected, second.step(c.x0, c.x1), "moved");
  const StepResult taken = second.release_result();
  expect_equal(expected, taken, "taken");
  EXPECT_TRUE(second.result().contacts.empty());
  expect_equal(expected, second.step(c.x0, c.x1), "after the result was taken");
  EXPECT_GT(second.workspace_bytes(), 0u);
}

/// Allocations of a step in which all memory is kept from earlier ones.
std::size_t steady_step_allocations(const Shape& shape) {
  Executor& serial = serial_executor();
  const std::vector<double> thickness(shape.elements.size(), 0.05);
  Detector detector(shape.mesh(), thickness, {.executor = &serial});
  const Course c(shape.positions, 11, 0.1);
  std::size_t before = 0;
  for (int round = 0; round < 3; ++round) {
    if (round == 2) before = test::allocation_count();
    detector.step(c.x0, c.x1);
    detector.first(c.x0, c.x1);
  }
  return test::allocation_count() - before;
}

/// The result has memory for the names of the stages in the statistics, whose size does not depend on the mesh.
TEST(Detector, ASteadyStepAllocatesNothingButItsResult) {
  for (const ElementType type : {ElementType::tetrahedron, ElementType::quad})
    EXPECT_EQ(steady_step_allocations(block(type, 5, 5, 3)), steady_step_allocations(block(type, 1, 1, 1)))
        << to_string(type);
}

TEST(StepRunner, FollowsTopologiesOfTheCaller) {
  const Shape a = shapes().front().second, b = shapes().back().second;
  const Topology first(a.mesh()), second(b.mesh());
  const Registry registry = Registry::standard();
  StepRunner runner(Pipeline(registry, registry.pipeline("VolCCD+")), {.filter = ObjectFilter(PairScope::inter)});
  const Course ca(a.positions, 12), cb(b.positions, 13);
  const Motion ma = Motion::linear(ca.x0, ca.x1), mb = Motion::linear(cb.x0, cb.x1);
  for (int round = 0; round < 2; ++round) {
    expect_equal(run({first, ma, runner.filter()}, {}), runner.run(first, ma), "first");
    expect_equal(run({second, mb, runner.filter()}, {}), runner.run(second, mb), "second");
    EXPECT_THROW(runner.run(first, mb), InputError);
  }
}

}  // namespace
}  // namespace volccd::detector_test
