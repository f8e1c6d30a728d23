#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <volccd/core/options.hpp>
#include <volccd/core/stage.hpp>

namespace volccd {
namespace {

enum class Axis { face, optimal };

struct Config {
  bool refit = true;
  int leaf_size = 4;
  double cell = 1.5;
  double gap = 0;
  Axis axis = Axis::optimal;
};

const Options<Config>& options() {
  static const Options<Config> table = [] {
    Options<Config> t;
    t.add("refit", &Config::refit, "refit the tree")
        .add("leaf_size", &Config::leaf_size, 1, 8, "elements a leaf")
        .add("cell", &Config::cell, 0.1, 10.0, "cell size")
        .add("gap", &Config::gap, 0.0, std::numeric_limits<double>::max(), "distance")
        .add("axis", &Config::axis, {{"face", Axis::face}, {"optimal", Axis::optimal}}, "separating axis");
    return t;
  }();
  return table;
}

/// The message of the ConfigError, or empty if none was thrown.
std::string refusal(const OptionValues& values) {
  try {
    options().parse(values);
    return {};
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(Options, NothingGivenIsTheDefault) {
  const Config config = options().parse({});
  EXPECT_TRUE(config.refit);
  EXPECT_EQ(config.leaf_size, 4);
  EXPECT_EQ(config.cell, 1.5);
  EXPECT_EQ(config.axis, Axis::optimal);
}

TEST(Options, EachKindIsParsed) {
  const Config config =
      options().parse({{"refit", "false"}, {"leaf_size", "8"}, {"cell", "0.25"}, {"gap", "1e-3"}, {"axis", "face"}});
  EXPECT_FALSE(config.refit);
  EXPECT_EQ(config.leaf_size, 8);
  EXPECT_EQ(config.cell, 0.25);
  EXPECT_EQ(config.gap, 1e-3);
  EXPECT_EQ(config.axis, Axis::face);
  EXPECT_TRUE(options().parse({{"refit", "1"}}).refit);
  EXPECT_FALSE(options().parse({{"refit", "0"}}).refit);
}

TEST(Options, BoundsAreInTheRange) {
  EXPECT_EQ(options().parse({{"leaf_size", "1"}}).leaf_size, 1);
  EXPECT_EQ(options().parse({{"cell", "10"}}).cell, 10.0);
  EXPECT_EQ(options().parse({{"gap", "0"}}).gap, 0.0);
}

TEST(Options, RefusesWhatIsNotWhollyAValue) {
  for (const char* text : {"", " 4", "4 ", "4x", "4.0", "+4", "four", "0", "9", "-1", "99999999999999999999"})
    EXPECT_NE(refusal({{"leaf_size", text}}), "") << "'" << text << "'";
  for (const char* text : {"", "1.5s", " 1.5", "1,5", "0x1", "nan", "inf", "-inf", "1e400", "0.05", "10.5", "-1"})
    EXPECT_NE(refusal({{"cell", text}}), "") << "'" << text << "'";
  for (const char* text : {"inf", "nan", "-1e-300"}) EXPECT_NE(refusal({{"gap", text}}), "") << text;
  for (const char* text : {"", "True", "yes", "2"}) EXPECT_NE(refusal({{"refit", text}}), "") << "'" << text << "'";
  for (const char* text : {"", "Face", "fac", "face|optimal"})
    EXPECT_NE(refusal({{"axis", text}}), "") << "'" << text << "'";
}

TEST(Options, RefusalNamesTheOptionTheTextAndWhatIsAllowed) {
  EXPECT_EQ(refusal({{"leaf_size", "9"}}), "option leaf_size: '9' is not a whole number from 1 to 8");
  EXPECT_EQ(refusal({{"axis", "best"}}), "option axis: 'best' is none of face|optimal");
  EXPECT_NE(refusal({{"cell", "11"}}).find("0.1 .. 10"), std::string::npos);
  EXPECT_NE(refusal({{"gap", "-2"}}).find("at least 0"), std::string::npos);
}

TEST(Options, UnknownNameListsTheKnownOnes) {
  EXPECT_EQ(refusal({{"leafsize", "4"}}),
            "no option 'leafsize'; there are refit, leaf_size, cell, gap, axis; did you mean 'leaf_size'?");
  EXPECT_EQ(refusal({{"other", "4"}}), "no option 'other'; there are refit, leaf_size, cell, gap, axis");
  EXPECT_THROW(Options<Config>().parse({{"any", "1"}}), ConfigError);
}

TEST(Options, FormerNameIsRefusedWithThePresentOne) {
  struct Limits {
    double max_share = 0.5;
  };
  const auto options =
      Options<Limits>().add("max_share", &Limits::max_share, 0, 1, "a share").renamed("most", "max_share");
  try {
    options.parse({{"most", "0.3"}});
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "option 'most' is called 'max_share' now");
  }
  EXPECT_EQ(options.parse({{"max_share", "0.3"}}).max_share, 0.3);
}

TEST(Options, ListedInTheOrderOfTheTableWithDefaults) {
  std::string listing;
  for (const OptionInfo& info : options().describe())
    listing += info.name + "=" + info.default_value + " (" + info.allowed + ")\n";
  EXPECT_EQ(listing,
            "refit=true (true|false)\n"
            "leaf_size=4 (1 .. 8)\n"
            "cell=1.5 (0.1 .. 10)\n"
            "gap=0 (at least 0)\n"
            "axis=optimal (face|optimal)\n");
}

// The default values that the table lists can be parsed, and give the defaults.
TEST(Options, ListedDefaultsAreAccepted) {
  OptionValues values;
  for (const OptionInfo& info : options().describe()) values[info.name] = info.default_value;
  const Config config = options().parse(values);
  EXPECT_EQ(config.cell, Config{}.cell);
  EXPECT_EQ(config.axis, Config{}.axis);
}

class Stage {
 public:
  virtual ~Stage() = default;
  virtual int value() const = 0;
};

class LeafStage final : public Stage {
 public:
  using Config = volccd::Config;
  static const Options<Config>& options() { return volccd::options(); }
  explicit LeafStage(const Config& config) : config_(config) {}
  int value() const override { return config_.leaf_size; }

 private:
  Config config_;
};

TEST(StageDescriptor, MakesTheStageFromOptions) {
  const auto descriptor = describe_stage<Stage, LeafStage>("leaf", "a stage", Guarantee::conservative);
  EXPECT_EQ(descriptor.name, "leaf");
  EXPECT_EQ(descriptor.options.size(), 5u);
  EXPECT_EQ(descriptor.make({})->value(), 4);
  EXPECT_EQ(descriptor.make({{"leaf_size", "2"}})->value(), 2);
  EXPECT_THROW(descriptor.make({{"leaf_size", "20"}}), ConfigError);
}

TEST(Guarantee, WeakestOfAPipeline) {
  EXPECT_EQ(weakest(Guarantee::exact, Guarantee::exact), Guarantee::exact);
  EXPECT_EQ(weakest(Guarantee::exact, Guarantee::conservative), Guarantee::conservative);
  EXPECT_EQ(weakest(Guarantee::approximate, Guarantee::conservative), Guarantee::approximate);
  EXPECT_STREQ(to_string(Guarantee::conservative), "conservative");
}

}  // namespace
}  // namespace volccd
