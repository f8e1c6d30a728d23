// Names of the values of enumerations.
#include <volccd/core/named_values.hpp>

#include <array>

#include <gtest/gtest.h>

namespace volccd {
namespace {

enum class Colour { red, green, hidden };
constexpr std::array<NamedValue<Colour>, 2> names_of(Colour) {
  return {{{"red", Colour::red}, {"green", Colour::green}}};
}

TEST(NamedValues, NameAndValueBelongTogether) {
  EXPECT_STREQ("green", name_of(Colour::green));
  EXPECT_STREQ("", name_of(Colour::hidden));
  EXPECT_EQ(Colour::green, value_named<Colour>("green", "--colour"));
  EXPECT_EQ((std::vector<std::string>{"red", "green"}), all_names<Colour>());
}

TEST(NamedValues, AnotherNameIsAnErrorThatNamesTheNearOne) {
  try {
    value_named<Colour>("geen", "--colour");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_STREQ("--colour: 'geen' is none of red, green; did you mean 'green'?", error.what());
  }
}

}  // namespace
}  // namespace volccd
