#include <string>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/core/function_ref.hpp>

namespace volccd {
namespace {

TEST(InputError, NamesSourceDatasetAndIndex) {
  EXPECT_STREQ(InputError("a.vtkhdf", "Points", 7, "not finite").what(), "a.vtkhdf: Points[7]: not finite");
  EXPECT_STREQ(InputError("a.vtkhdf", "Points", "missing").what(), "a.vtkhdf: Points: missing");
  EXPECT_STREQ(InputError("a.vtkhdf", "", "not HDF5").what(), "a.vtkhdf: not HDF5");
  EXPECT_STREQ(InputError("", "vertices", 0, "out of range").what(), "vertices[0]: out of range");
}

TEST(InputError, KeepsItsPartsAndIsCaughtAsError) {
  try {
    throw InputError("mesh", "vertices", 0, "twice");
  } catch (const Error& error) {
    const auto* input = dynamic_cast<const InputError*>(&error);
    ASSERT_NE(input, nullptr);
    EXPECT_EQ(input->source(), "mesh");
    EXPECT_EQ(input->dataset(), "vertices");
    EXPECT_EQ(input->index(), 0);
  }
  EXPECT_EQ(InputError("mesh", "", "empty").index(), InputError::kNoIndex);
}

TEST(FunctionRef, CallsTheObjectItself) {
  int calls = 0;
  auto counter = [&calls, inside = 0](int by) mutable {
    inside += by;
    calls = inside;
    return inside;
  };
  const FunctionRef<int(int)> reference = counter;
  const FunctionRef<int(int)> copy = reference;
  EXPECT_EQ(reference(2), 2);
  EXPECT_EQ(copy(3), 5) << "no copy of the callable is made";
  EXPECT_EQ(calls, 5);
}

TEST(FunctionRef, PassesReferencesThrough) {
  std::string text = "a";
  auto append = [](std::string& to, const std::string& what) -> std::string& { return to += what; };
  const FunctionRef<std::string&(std::string&, const std::string&)> reference = append;
  EXPECT_EQ(&reference(text, "b"), &text);
  EXPECT_EQ(text, "ab");
}

}  // namespace
}  // namespace volccd
