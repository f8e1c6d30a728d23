// Runs a property, which is a function from Choices to "" or a description of the error.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <volccd/oracle/cases/near_degenerate.hpp>

namespace volccd::test {

using namespace cases;

/// Runs many cases fast: seeds first, first + 1, ...; stops at the first failure.
template <class Property>
void run_seeds(std::uint64_t first, int cases, Property&& property) {
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(cases); ++seed) {
    Choices choices(seed);
    const std::string failure = property(choices);
    if (failure.empty()) continue;
    ADD_FAILURE() << "seed " << seed << ": " << failure;
    return;
  }
}

/// Runs fewer cases, and reduces the first failure to the simplest one that rapidcheck finds.
template <class Property>
void run_shrinking(std::uint64_t seed, int cases, Property&& property) {
  rc::detail::TestParams params;
  params.seed = seed;
  params.maxSuccess = cases;
  params.maxSize = 240;
  std::string failure;
  const auto testable = [&] {
    const auto list =
        *rc::gen::container<std::vector<std::uint32_t>>(100, rc::gen::inRange<std::uint32_t>(0, 0xffff'ffffu));
    Choices choices(list);
    const std::string what = property(choices);
    if (!what.empty()) failure = what;  // the last failure is the simplest
    RC_ASSERT(what.empty());
  };
  const auto result = rc::detail::checkTestable(testable, rc::detail::TestMetadata(), params);
  EXPECT_TRUE(result.template is<rc::detail::SuccessResult>()) << failure;
}

}  // namespace volccd::test
