// Edit distances, and the names that are suggested.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/suggest.hpp>

namespace volccd {
namespace {

using Names = std::vector<std::string>;

TEST(Suggest, EditDistance) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("volccd", "VolCCD"), 0u);
  EXPECT_EQ(edit_distance("detcet", "detect"), 1u) << "two neighbours are exchanged";
  EXPECT_EQ(edit_distance("ca", "abc"), 3u) << "what is exchanged is not edited again";
}

TEST(Suggest, TheNearestOnly) {
  EXPECT_EQ(near_names("VolCD", {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"}), Names{"VolCCD"});
  EXPECT_EQ(near_names("axle", {"axis", "axes", "mode"}), (Names{})) << "two of four letters are too many";
  EXPECT_EQ(near_names("ocatpi", {"octopi", "octopi", "liver"}), Names{"octopi"});
  EXPECT_EQ(near_names("steps", {"stages", "step", "stop"}), Names{"step"});
}

TEST(Suggest, Beginnings) {
  EXPECT_EQ(near_names("exp", {"experiment", "export", "info"}), (Names{"experiment", "export"}));
  EXPECT_EQ(near_names("", {"experiment"}), Names{});
}

TEST(Suggest, Text) {
  EXPECT_EQ(did_you_mean("inof", "info, detect"), "; did you mean 'info'?");
  EXPECT_EQ(did_you_mean("optimla", "face|centroid|optimal"), "; did you mean 'optimal'?");
  EXPECT_EQ(did_you_mean("ab", Names{"ac", "bb"}), "");
  EXPECT_EQ(did_you_mean("abc", Names{"abd", "abe"}), "; did you mean 'abd' or 'abe'?");
  EXPECT_EQ(did_you_mean("something", "info, detect"), "");
}

}  // namespace
}  // namespace volccd
