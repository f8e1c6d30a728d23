// What a sample of vertices tells about motions that go on, vibrate, are asked about again, or jump.
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include <volccd/pipelines/lists/detail/motion_sample.hpp>

#include "pipelines/scenes.hpp"
#include "support/one_step.hpp"

namespace volccd::test {
namespace {

using Place = std::function<Vec3(const Vec3& rest, double time)>;

/// A block of 3 x 3 x 3 unit hexahedra whose vertices follow a path.
struct Path {
  ListPolicy::Motion step(double from, double to) {
    std::vector<Vec3> x0, x1;
    for (const Vec3& rest : shape.positions) x0.push_back(place(rest, from)), x1.push_back(place(rest, to));
    const Motion motion = Motion::linear(x0, x1);
    return sample.compare({topology, motion, kAllObjects}, policy);
  }

  Place place;
  Shape shape = block(ElementType::hexahedron, 3, 3, 3);
  Topology topology{shape.mesh()};
  ListPolicy policy = {};
  detail::MotionSample sample = {};
};

Vec3 along(double way) { return Vec3(way, 0, 0); }

TEST(MotionSample, FollowsAMotionThatGoesOn) {
  Path path{[](const Vec3& rest, double time) { return Vec3(rest + along(0.001 * time)); }};
  EXPECT_TRUE(std::isinf(path.step(0, 1).distance)) << "nothing is known yet";
  for (int k = 1; k <= 20; ++k) {
    const auto found = path.step(k, k + 1);
    EXPECT_NEAR(found.length, 0.001, 1e-15);
    EXPECT_LT(found.distance, 1e-12);
    EXPECT_NEAR(found.steps, k, 1e-9);
    EXPECT_NEAR(found.edge, 1, 0.5);
  }
}

TEST(MotionSample, KnowsHowFarVibrationsGet) {
  Path path{[](const Vec3& rest, double time) {
    return Vec3(rest + along(0.01 * time) + Vec3(0, 0.005 * std::sin(2 * time), 0));
  }};
  ListPolicy::Motion found = path.step(0, 1);
  for (int k = 1; k <= 16; ++k) found = path.step(k, k + 1);
  EXPECT_GT(found.steps, 10);
  EXPECT_GT(found.distance, 0.005);
  EXPECT_LT(found.distance, 0.2);
}

/// A solver asks about a step again, after it has changed its end a little.
TEST(MotionSample, KnowsStepsThatAreAskedAgain) {
  Path path{[](const Vec3& rest, double time) { return Vec3(rest + along(0.01 * time)); }};
  path.step(0, 1);
  path.step(0, 0.98);
  for (int k = 1; k <= 10; ++k) {
    path.step(k - 0.02, k + 1);
    const auto found = path.step(k - 0.02, k + 0.98);
    EXPECT_LT(found.distance, 1e-12);
    EXPECT_NEAR(found.steps, std::max(1.0, k + 0.0), 0.05);
  }
}

TEST(MotionSample, BeginsAnewAfterAJump) {
  Path path{
      [](const Vec3& rest, double time) { return Vec3(rest + along(0.01 * time) + Vec3(0, time > 5 ? 100 : 0, 0)); }};
  for (int k = 0; k < 4; ++k) path.step(k, k + 1);
  EXPECT_TRUE(std::isinf(path.step(6, 7).distance));
  const auto found = path.step(7, 8);
  EXPECT_LT(found.distance, 1e-10);
  EXPECT_NEAR(found.steps, 1, 1e-6);
}

/// When a prediction gets too far, what was known before holds once more, so that a list can follow at once.
TEST(MotionSample, TellsWhatWasKnownWhenItBeginsAnew) {
  Path path{
      [](const Vec3& rest, double time) { return Vec3(rest + along(0.001 * time) + Vec3(0, 1e-4 * time * time, 0)); }};
  ListPolicy::Motion before = path.step(0, 1), found = path.step(1, 2);
  int k = 2;
  for (; k < 100 && found.steps >= before.steps; ++k) before = found, found = path.step(k, k + 1);
  ASSERT_LT(k, 100);
  EXPECT_GT(before.steps, 10);
  EXPECT_LE(before.distance, path.policy.max_budget() * before.edge);
}

/// Of the three vertices for each vertex of a shell, only two are in use. Every ninth vertex is none of these.
TEST(MotionSample, SeesThickenedShells) {
  std::vector<Vec3> rest;
  Mesh mesh;
  mesh.add_vertices(2100);
  for (Index i = 0; i < 2100; ++i) rest.emplace_back(i % 3, i / 3 % 2, i / 6);
  for (Index i = 0; i + 6 <= 2100; i += 6)
    mesh.add_element({.type = ElementType::tetrahedron, .vertices = {i + 1, i + 2, i + 4, i + 5}, .id = i});
  const Topology topology(std::move(mesh));
  std::vector<Vec3> moved = rest;
  for (Vec3& x : moved) x.x() += 0.5;
  const Motion motion = Motion::linear(rest, moved);
  detail::MotionSample sample = {};
  EXPECT_NEAR(sample.compare({topology, motion, kAllObjects}, ListPolicy()).length, 0.5, 1e-12);
}

}  // namespace
}  // namespace volccd::test
