// Bodies for candidate lists, and what steps with lists have in common with fresh ones.
#pragma once

#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "pipelines/scenes.hpp"
#include "support/two_bodies.hpp"

namespace volccd::test {

inline Vec3 random_vector(Random& random, double amount) {
  return amount * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
}

inline Shape two_bodies(const Shape& shape) { return two_bodies(shape, 0.1); }

inline void expect_equal(const StepResult& fresh, const StepResult& listed, const std::string& what) {
  EXPECT_EQ(fresh.contacts, listed.contacts) << what;
  EXPECT_EQ(fresh.initial_overlaps, listed.initial_overlaps) << what;
  EXPECT_EQ(fresh.statistics.earliest_toi, listed.statistics.earliest_toi) << what;
}

/// How many steps used a list as it was, and how many refreshed one.
struct Uses {
  std::uint64_t reused = 0, refreshed = 0;
  Uses& operator+=(const Uses& other) {
    reused += other.reused, refreshed += other.refreshed;
    return *this;
  }
};

}  // namespace volccd::test
