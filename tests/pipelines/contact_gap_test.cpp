// The gap of a contact, and its features at the end of the step, compared with distances of random points of the
// features.
#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/pipelines/step_runner.hpp>

#include "scenes.hpp"

namespace volccd::test {
namespace {

/// The points of both features of a contact with these weights, at t.
std::array<Vec3, 2> points_at(const Motion& motion, const Contact& contact, const std::array<double, 4>& weights,
                              double t) {
  std::array<Vec3, 2> points{Vec3::Zero(), Vec3::Zero()};
  for (std::size_t i = 0; i < 4; ++i) {
    const bool second = i >= (contact.kind == FeatureKind::vf ? 1u : 2u);
    points[second ? 1 : 0] += weights[i] * motion.position(contact.vertices[i], t);
  }
  return points;
}

std::array<double, 4> random_weights(FeatureKind kind, Random& random) {
  const double s = random.uniform(0, 1), u = random.uniform(0, 1);
  if (kind == FeatureKind::ee) return {1 - s, s, 1 - u, u};
  return {1, s * (1 - u), s * u, 1 - s};
}

/// No two points of the features are closer than the gap, and those with the weights are as close.
void expect_distance(const Motion& motion, const Contact& contact, const std::array<double, 4>& weights, double gap,
                     double t, Random& random) {
  const auto distance = [&](const std::array<double, 4>& of) {
    const auto [a, b] = points_at(motion, contact, of, t);
    return (a - b).norm();
  };
  EXPECT_NEAR(distance(weights), gap, 1e-12);
  for (int i = 0; i < 50; ++i) EXPECT_GE(distance(random_weights(contact.kind, random)), gap - 1e-12);
}

TEST(ContactGaps, AreDistancesOfTheFeatures) {
  const double separation = 0.05;
  Random random(1);
  int apart = 0;
  for (const char* narrow_phase : {"inclusion", "exact"})
    for (const Scene& scene : small_scenes(3, 0.02)) {
      PipelineSpec spec = registry().pipeline("VolCCD+");
      spec.narrow_phase = {narrow_phase};
      const double s = spec.narrow_phase.name == "exact" ? 0 : separation;
      StepRunner runner(Pipeline(registry(), spec), {.separation = s});
      const StepResult& found = runner.run(scene.topology, scene.motion, {.ends = true});
      ASSERT_EQ(found.ends.size(), found.contacts.size());
      EXPECT_GT(found.contacts.size(), 0u) << scene.name;
      for (std::size_t i = 0; i < found.contacts.size(); ++i) {
        const Contact& contact = found.contacts[i];
        const ContactEnd& end = found.ends[i];
        expect_distance(scene.motion, contact, contact.weights, contact.gap, contact.toi, random);
        expect_distance(scene.motion, contact, end.weights, end.gap, 1, random);
        const auto [a, b] = points_at(scene.motion, contact, end.weights, 1);
        EXPECT_LT((end.first - a).norm() + (end.second - b).norm(), 1e-12);
        EXPECT_LE(contact.gap, s * (1 + 1e-6) + 1e-6);
        apart += contact.gap > 0.5 * s ? 1 : 0;
      }
      EXPECT_TRUE(runner.run(scene.topology, scene.motion).ends.empty());
    }
  EXPECT_GT(apart, 100);
}

/// At coordinates that have to be scaled, too.
TEST(ContactGaps, AreInTheUnitOfTheCoordinates) {
  for (const double unit : {0x1p-200, 1.0, 0x1p200}) {
    const Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
    Shape both, other = shape;
    both.append(shape, 1);
    both.append(other.translate(Vec3(0, 0, 1.25)), 2);
    std::vector<Vec3> x0 = both.positions, x1;
    for (Vec3& p : x0) p *= unit;
    for (const Vec3& p : x0) x1.push_back(p.z() > 1.1 * unit ? Vec3(p - Vec3(0, 0, 0.125 * unit)) : p);
    const Topology topology(both.mesh());
    StepRunner runner(Pipeline(registry(), registry().pipeline("VolCCD+")),
                      {.separation = 0.1875 * unit, .filter = ObjectFilter(PairScope::inter)});
    const StepResult& found = runner.run(topology, Motion::linear(x0, x1), {.ends = true});
    ASSERT_GT(found.contacts.size(), 0u);
    for (const Contact& contact : found.contacts) EXPECT_NEAR(contact.gap / unit, 0.1875, 1e-9);
    for (const ContactEnd& end : found.ends) EXPECT_NEAR(end.gap / unit, 0.125, 1e-9);
  }
}

}  // namespace
}  // namespace volccd::test
