// The C interface returns what the Detector returns, bit for bit.
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include <volccd/pipelines/detector.hpp>

#include "capi/support.hpp"

namespace volccd::capi_test {
namespace {

struct Course {
  std::vector<Vec3> x0, xm, x1;
  Course(const std::vector<Vec3>& positions, std::uint64_t seed, double jitter = 0.35)
      : x0(jittered(positions, jitter, seed)),
        xm(jittered(positions, jitter, seed + 1)),
        x1(jittered(positions, jitter, seed + 2)) {}
};

template <class T>
bool same(const T& from, const double* values) {
  return std::memcmp(from.data(), values, sizeof(double) * static_cast<std::size_t>(from.size())) == 0;
}

void expect_same(const std::vector<Contact>& expected, const std::vector<volccd_contact>& found, const Mesh& mesh) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Contact& e = expected[i];
    const volccd_contact& f = found[i];
    EXPECT_EQ(f.kind, e.kind == FeatureKind::vf ? VOLCCD_VF : VOLCCD_EE);
    EXPECT_EQ(f.at_start, e.at_start ? 1 : 0);
    for (std::size_t v = 0; v < 4; ++v) EXPECT_EQ(f.vertices[v], e.vertices[v]);
    for (std::size_t side = 0; side < 2; ++side) {
      EXPECT_EQ(f.elements[side], mesh.element_id(e.elements[side]));
      EXPECT_EQ(f.objects[side], mesh.object(e.elements[side]));
    }
    EXPECT_EQ(f.time, e.toi);
    EXPECT_EQ(f.gap, e.gap);
    EXPECT_TRUE(same(e.normal, f.normal) && same(e.point, f.point) && same(e.weights, f.weights)) << i;
  }
}

void expect_same(const Detector& expected, const Handle& found) {
  const StepResult& result = expected.result();
  const Mesh& mesh = expected.topology().mesh();
  expect_same(result.contacts, take(volccd_contacts, found), mesh);
  const auto ends = take(volccd_contact_ends, found);
  ASSERT_EQ(ends.size(), result.ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const ContactEnd& e = result.ends[i];
    EXPECT_TRUE(ends[i].gap == e.gap && same(e.weights, ends[i].weights) && same(e.first, ends[i].first) &&
                same(e.second, ends[i].second));
  }
  const auto overlaps = take(volccd_initial_overlaps, found, 2);
  ASSERT_EQ(overlaps.size(), 2 * result.initial_overlaps.size());
  for (std::size_t i = 0; i < result.initial_overlaps.size(); ++i) {
    EXPECT_EQ(overlaps[2 * i], mesh.element_id(result.initial_overlaps[i].a));
    EXPECT_EQ(overlaps[2 * i + 1], mesh.element_id(result.initial_overlaps[i].b));
  }
}

/// The Detector for the same arguments.
Detector reference(const Shape& shape, DetectorConfig config = {}) {
  Shape with_ids = shape;
  for (std::size_t i = 0; i < shape.elements.size(); ++i) with_ids.elements[i].id = 100 + static_cast<std::int64_t>(i);
  return Detector(with_ids.mesh(), config);
}

TEST(CResults, AreThoseOfTheDetectorForEveryElementType) {
  std::size_t contacts = 0, overlaps = 0;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge, ElementType::hexahedron,
        ElementType::polytope, ElementType::triangle, ElementType::quad}) {
    SCOPED_TRACE(to_string(type));
    const Shape shape = two_of(block(type, 2, 2, 1));
    const Course course(shape.positions, 3);
    Detector expected = reference(shape);
    const Handle found = create(shape.positions.size(), Arrays(shape).cells());
    const int flags = VOLCCD_STEP_INITIAL_OVERLAPS | VOLCCD_STEP_ENDS;
    const Request request{.initial_overlaps = true, .ends = true};
    expected.step(course.x0, course.x1, request);
    ASSERT_EQ(volccd_step(found.get(), count(course.x0), values(course.x0), values(course.x1), flags, 1), VOLCCD_OK);
    expect_same(expected, found);
    contacts += expected.result().contacts.size();
    overlaps += expected.result().initial_overlaps.size();
    expected.step(course.x0, course.xm, course.x1, {}, 0.5);
    ASSERT_EQ(volccd_step_quadratic(found.get(), count(course.x0), values(course.x0), values(course.xm),
                                    values(course.x1), VOLCCD_STEP_DEFAULT, 0.5),
              VOLCCD_OK);
    expect_same(expected, found);
  }
  EXPECT_GT(contacts, 100u);
  EXPECT_GT(overlaps, 5u);
}

TEST(CResults, FollowTheOptions) {
  const Shape shape = two_of(mixed_block(1, 1));
  const Course course(shape.positions, 8, 0.7);
  const char* const settings[] = {"element-culling=csat", "csat.axis=optimal"};
  const std::int32_t excluded[] = {1, 1};
  volccd_options options{};
  options.pipeline = "VolCCD";
  options.settings = settings;
  options.setting_count = 2;
  options.threads = 2;
  options.separation = 0.01;
  options.pairs = VOLCCD_PAIRS_INTRA;
  options.excluded = excluded;
  options.excluded_count = 1;
  options.edges = VOLCCD_EDGES_POLYTOPE;
  options.lists = VOLCCD_LISTS_ALWAYS;
  options.list_budget = 10;
  DetectorConfig config{.pipeline = "VolCCD",
                        .settings = {"element-culling=csat", "csat.axis=optimal"},
                        .separation = 0.01,
                        .filter = ObjectFilter(PairScope::intra),
                        .edge_set = EdgeSet::polytope};
  config.filter.exclude(1, 1);
  Detector expected = reference(shape, config);
  const Handle found = create(shape.positions.size(), Arrays(shape).cells(), options);
  expected.step(course.x0, course.x1);
  ASSERT_EQ(volccd_step(found.get(), count(course.x0), values(course.x0), values(course.x1), 0, 1), VOLCCD_OK);
  expect_same(expected, found);
  EXPECT_GT(expected.result().contacts.size(), 5u);
  double lists = 0;
  ASSERT_EQ(volccd_statistic_value(found.get(), "list_steps", &lists), VOLCCD_OK);
  EXPECT_EQ(lists, 1) << "a list is made in each step that no list covers";
  const char* guarantee = nullptr;
  ASSERT_EQ(volccd_guarantee(found.get(), &guarantee), VOLCCD_OK);
  EXPECT_STREQ(guarantee, "conservative");
}

TEST(CResults, OfTheEarliestContact) {
  const Shape shape = two_of(block(ElementType::tetrahedron, 2, 2, 1));
  std::vector<Vec3> x1 = shape.positions;
  for (Index v = 0; v < x1.size(); ++v)
    if (shape.positions[v].z() > 1.1) x1[v].z() -= 0.7;
  Detector expected = reference(shape);
  const Handle found = create(shape.positions.size(), Arrays(shape).cells());
  volccd_contact contact{};
  std::int32_t is_found = -1;
  const auto first = [&](const std::vector<Vec3>& end) {
    return volccd_first(found.get(), count(end), values(shape.positions), values(end), &contact, &is_found);
  };
  ASSERT_EQ(first(x1), VOLCCD_OK);
  ASSERT_EQ(is_found, 1);
  expect_same({expected.first(shape.positions, x1).value()}, {contact}, expected.topology().mesh());
  contact.kind = 77;
  volccd_options options{};
  options.pairs = VOLCCD_PAIRS_INTER;
  const Handle between = create(shape.positions.size(), Arrays(shape).cells(), options);
  ASSERT_EQ(
      volccd_first(between.get(), count(x1), values(shape.positions), values(shape.positions), &contact, &is_found),
      VOLCCD_OK);
  EXPECT_EQ(is_found, 0);
  EXPECT_EQ(contact.kind, 77) << "without a contact it is unchanged";
}

TEST(CResults, OfThickenedShells) {
  const Shape shape = two_of(block(ElementType::triangle, 3, 3, 1));
  const Course course(shape.positions, 4);
  const std::vector<double> thickness(shape.elements.size(), 1);
  Shape with_ids = shape;
  for (std::size_t i = 0; i < shape.elements.size(); ++i) with_ids.elements[i].id = 100 + static_cast<std::int64_t>(i);
  Detector expected(with_ids.mesh(), thickness);
  const Arrays arrays(shape);
  volccd_cells cells = arrays.cells();
  cells.thickness = thickness.data();
  const Handle found = create(shape.positions.size(), cells);
  expected.step(course.x0, course.x1);
  ASSERT_EQ(volccd_step(found.get(), count(course.x0), values(course.x0), values(course.x1), 0, 1), VOLCCD_OK);
  expect_same(expected, found);
  EXPECT_FALSE(expected.result().contacts.empty());
}

TEST(CResults, FollowEdits) {
  Shape shape = two_of(block(ElementType::tetrahedron, 2, 2, 1));
  Detector expected = reference(shape);
  const Handle found = create(shape.positions.size(), Arrays(shape).cells());
  const Course before(shape.positions, 6);
  ASSERT_EQ(volccd_step(found.get(), count(before.x0), values(before.x0), values(before.x1), 0, 1), VOLCCD_OK);
  const auto of_step = take(volccd_contacts, found);
  // An element is replaced by one with a new vertex, and another one is removed.
  const ElementSpec gone = expected.mesh().spec(3);
  ElementSpec added = gone;
  added.id = 1000;
  added.vertices[0] = static_cast<Index>(shape.positions.size());
  shape.positions.push_back(Vec3(0.5, 0.5, 0.5));
  const std::vector<std::int64_t> removed = {gone.id, 100};
  expected.edit({.removed = removed, .new_vertices = 1, .added = {added}});
  const Arrays arrays(std::vector{added});
  const volccd_cells cells = arrays.cells();
  ASSERT_EQ(volccd_edit(found.get(), removed.data(), 2, 1, &cells), VOLCCD_OK) << volccd_last_error();
  const auto after = take(volccd_contacts, found);
  ASSERT_EQ(of_step.size(), after.size());
  EXPECT_EQ(std::memcmp(of_step.data(), after.data(), of_step.size() * sizeof(volccd_contact)), 0)
      << "the results of the step stay";
  std::int64_t vertices = 0, elements = 0;
  ASSERT_EQ(volccd_size(found.get(), &vertices, &elements), VOLCCD_OK);
  EXPECT_EQ(vertices, count(shape.positions));
  EXPECT_EQ(elements, static_cast<std::int64_t>(shape.elements.size()) - 1);
  const Course course(shape.positions, 9);
  expected.step(course.x0, course.x1);
  ASSERT_EQ(volccd_step(found.get(), count(course.x0), values(course.x0), values(course.x1), 0, 1), VOLCCD_OK);
  expect_same(expected, found);
}

TEST(CResults, HaveStatisticsByName) {
  const Shape shape = two_of(block(ElementType::tetrahedron, 2, 2, 1));
  const Course course(shape.positions, 3);
  Detector expected = reference(shape);
  const Handle found = create(shape.positions.size(), Arrays(shape).cells());
  EXPECT_TRUE(take(volccd_statistics, found).empty()) << "before the first step";
  const Statistics& s = expected.step(course.x0, course.x1).statistics;
  ASSERT_EQ(volccd_step(found.get(), count(course.x0), values(course.x0), values(course.x1), 0, 1), VOLCCD_OK);
  const auto value = [&](const std::string& name) {
    double result = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(volccd_statistic_value(found.get(), name.c_str(), &result), VOLCCD_OK) << volccd_last_error();
    return result;
  };
  EXPECT_EQ(value("contacts"), static_cast<double>(s.contacts));
  EXPECT_EQ(value("vf_tests"), static_cast<double>(s.vf_tests));
  EXPECT_EQ(value("ee_tests"), static_cast<double>(s.ee_tests));
  EXPECT_EQ(value("earliest_toi"), s.earliest_toi);
  EXPECT_GT(value("seconds"), 0);
  for (const StageStatistics& stage : s.stages) {
    EXPECT_EQ(value(stage.name + ".in"), static_cast<double>(stage.in));
    EXPECT_EQ(value(stage.name + ".out"), static_cast<double>(stage.out));
  }
  std::vector<std::string> names;
  for (const volccd_statistic& entry : take(volccd_statistics, found)) names.emplace_back(entry.name);
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end()) << "names are distinct";
}

}  // namespace
}  // namespace volccd::capi_test
