// Runs a property, which is a function from Choices to "" or a description of the error, on many generated cases.
#pragma once

#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include <volccd/oracle/cases/near_degenerate.hpp>

#include "support/trials.hpp"

namespace volccd::test {

/// Runs trials(cases) seeds, from the first one on; stops at the first failure.
template <class Property>
void run_seeds(std::uint64_t first, int cases, Property&& property) {
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(trials(cases)); ++seed) {
    cases::Choices choices(seed);
    const std::string failure = property(choices);
    if (failure.empty()) continue;
    ADD_FAILURE() << "seed " << seed << ": " << failure;
    return;
  }
}

}  // namespace volccd::test
