#include <string>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/core/floating_point.hpp>

#include "support/floating_point_environment.hpp"

namespace volccd {
namespace {

TEST(FloatingPoint, TheStandardEnvironmentIsTaken) {
  EXPECT_EQ(floating_point_problem(), "");
  EXPECT_EQ(detail::probed_floating_point_problem(), "");
  EXPECT_NO_THROW(require_standard_floating_point());
}

TEST(FloatingPoint, ChangesAreFoundByFlagsAndByArithmetic) {
  for (const auto& [change, problem] : test::environments()) {
    std::string found, probed, message;
    {
      const test::ChangedEnvironment changed(change);
      found = floating_point_problem();
      probed = detail::probed_floating_point_problem();
      try {
        require_standard_floating_point();
      } catch (const ConfigError& error) {
        message = error.what();
      }
    }
    EXPECT_NE(found.find(problem), std::string::npos) << found;
    EXPECT_EQ(found, probed);
    EXPECT_NE(message.find(problem), std::string::npos) << message;
    EXPECT_EQ(floating_point_problem(), "") << "the environment is back";
  }
}

}  // namespace
}  // namespace volccd
