// Settings of pipelines by name, and what a registry refuses.
#include <volccd/pipelines/registry.hpp>

#include <string>

#include <gtest/gtest.h>

#include "pipelines/scenes.hpp"

namespace volccd {
namespace {

using test::registry;

TEST(Registry, SettingsChangeAPipeline) {
  PipelineSpec spec = registry().pipeline("VolCCD");
  registry().apply_setting(spec, "csat.axis=centroid");
  EXPECT_EQ(spec.element_culling.front().options.at("axis"), "centroid");
  registry().apply_setting(spec, "feature-filter=feature-kdop,coplanarity");
  EXPECT_EQ(spec.feature_filters.size(), 2u);
  registry().apply_setting(spec, "element-culling=none");
  EXPECT_TRUE(spec.element_culling.empty());
  registry().apply_setting(spec, "orphans=none");
  EXPECT_FALSE(spec.orphans.has_value());
  registry().apply_setting(spec, "orphans=o-set");
  registry().apply_setting(spec, "o-set.kind=literal");
  EXPECT_EQ(spec.orphans->options.at("kind"), "literal");
  registry().apply_setting(spec, "assignment=all-pairs");
  EXPECT_EQ(spec.assignment.name, "all-pairs");
  registry().apply_setting(spec, "broad-phase=spatial-hash");
  EXPECT_EQ(spec.broad_phase.name, "spatial-hash");
  for (const char* wrong : {"csat.axis=centroid", "x", "=x", "broad-phase=none", "assignment=none",
                            "orphans=o-set,o-set", "no-role=x", "kdop-bvh.k=18"})
    EXPECT_THROW(registry().apply_setting(spec, wrong), ConfigError) << wrong;
}

TEST(Registry, NamesAreUnique) {
  Registry own = Registry::standard();
  StageDescriptor<FeatureFilter> again;
  again.name = "kdop-bvh";
  EXPECT_THROW(own.add(again), ConfigError);
  EXPECT_THROW(own.add_pipeline(own.pipelines().front()), ConfigError);
  EXPECT_THROW(own.pipeline("nothing"), ConfigError);
}

TEST(Registry, APipelineWithAnUnknownStageIsRefused) {
  Registry own = Registry::standard();
  for (const char* role :
       {"broad-phase", "element-culling", "assignment", "orphans", "flood", "feature-filter", "narrow-phase"}) {
    PipelineSpec spec = own.pipeline("VolCCD+");
    spec.name = "Mine";
    own.apply_setting(spec, std::string(role) + "=no-such-stage");
    try {
      own.add_pipeline(spec);
      ADD_FAILURE() << role;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find("pipeline Mine: no stage 'no-such-stage'"), std::string::npos)
          << error.what();
    }
  }
  EXPECT_THROW(own.pipeline("Mine"), ConfigError) << "a refused pipeline is not registered";
  PipelineSpec other_role = own.pipeline("VolCCD");
  other_role.name = "Other";
  other_role.element_culling = {{"kdop-bvh"}};
  EXPECT_THROW(own.add_pipeline(other_role), ConfigError);
}

}  // namespace
}  // namespace volccd
