// What pipelines refuse: unsound combinations of stages, and steps that they cannot run.
#include <volccd/pipelines/pipeline.hpp>

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "pipelines/scenes.hpp"
#include "support/one_step.hpp"

namespace volccd {
namespace {

using test::registry;
using test::Scene;

TEST(Pipelines, RefuseWhatIsUnsound) {
  PipelineSpec spec = registry().pipeline("VolCCD");
  const auto refused = [](const PipelineSpec& refused_spec, const std::string& reason) {
    try {
      const Pipeline pipeline(registry(), refused_spec);
      return false;
    } catch (const ConfigError& error) {
      return std::string(error.what()).find(reason) != std::string::npos;
    }
  };
  spec.assignment.name = "static-assignment";
  EXPECT_TRUE(refused(spec, "gives some feature pairs to adjacent elements"));
  spec.orphans.reset();
  EXPECT_FALSE(refused(spec, ""));
  spec.assignment.name = "dynamic-assignment";
  EXPECT_TRUE(refused(spec, "has no owner"));
  spec.assignment.name = "all-pairs";
  EXPECT_FALSE(refused(spec, ""));
  spec.assignment.name = "no-such-stage";
  EXPECT_TRUE(refused(spec, "no-such-stage"));
  spec = registry().pipeline("VolCCD");
  spec.broad_phase.options["k"] = "17";
  EXPECT_THROW(Pipeline(registry(), spec), ConfigError);
}

TEST(Pipelines, RefuseStepsTheyCannotRun) {
  const Scene scene = std::move(test::small_scenes(1, 0.1).front());
  PipelineSpec spec = registry().pipeline("VolCCD");
  registry().apply_setting(spec, "narrow-phase=cubic");
  const Pipeline pipeline(registry(), spec);
  Workspace workspace = pipeline.make_workspace();
  SerialExecutor serial;
  StepResult result;
  const Motion other(scene.motion.vertex_count() + 1, 2), quadratic(scene.motion.vertex_count(), 3);
  EXPECT_THROW(pipeline.run({scene.topology, other, test::kAllObjects}, workspace, serial, result), InputError);
  EXPECT_THROW(pipeline.run({scene.topology, quadratic, test::kAllObjects}, workspace, serial, result), ConfigError);
  EXPECT_THROW(pipeline.run({scene.topology, scene.motion, test::kAllObjects, 0.1}, workspace, serial, result),
               ConfigError);
  EXPECT_THROW(pipeline.run({scene.topology, scene.motion, test::kAllObjects, -1}, workspace, serial, result),
               ConfigError);
}

/// A stage that declares to accept motions of every degree.
class AnyDegree final : public NarrowPhase {
 public:
  int max_control_points() const override { return 9; }
  void run(const Step&, StageState&, unsigned, const TestBlock&, std::vector<Contact>&,
           NarrowCounters&) const override {}
};

TEST(Pipelines, RefuseMotionThatBlocksOfTestsDoNotHold) {
  const Scene scene = std::move(test::small_scenes(1, 0.1).front());
  Registry own = Registry::standard();
  StageDescriptor<NarrowPhase> descriptor;
  descriptor.name = "any-degree";
  descriptor.guarantee = Guarantee::approximate;
  descriptor.make = [](const OptionValues&) { return std::make_unique<AnyDegree>(); };
  own.add(descriptor);
  PipelineSpec spec = own.pipeline("VolCCD+");
  spec.narrow_phase = {"any-degree", {}};
  const Pipeline pipeline(own, spec);
  Workspace workspace = pipeline.make_workspace();
  SerialExecutor serial;
  StepResult result;
  for (const int points : {1, 2, 3, 4}) {
    const Motion motion(scene.motion.vertex_count(), points);
    const Step step{scene.topology, motion, test::kAllObjects};
    if (points == 2 || points == 3)
      EXPECT_NO_THROW(pipeline.run(step, workspace, serial, result)) << points;
    else
      EXPECT_THROW(pipeline.run(step, workspace, serial, result), ConfigError) << points;
  }
}

TEST(Pipelines, RefuseSeparationsThatAreNotFinite) {
  const Scene scene = std::move(test::small_scenes(1, 0.1).front());
  const Pipeline pipeline(registry(), registry().pipeline("VolCCD+"));
  Workspace workspace = pipeline.make_workspace();
  SerialExecutor serial;
  StepResult result;
  for (const double separation : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(pipeline.run({scene.topology, scene.motion, test::kAllObjects, separation}, workspace, serial, result),
                 ConfigError);
}

}  // namespace
}  // namespace volccd
