// `volccd verify` finds the errors that it is to find: a stage that loses contacts, wrong times, and ground truth that
// differs.
#include <volccd/experiments/verify/verify.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <volccd/io/sequence/stepper.hpp>
#include <volccd/mesh/shells.hpp>

#include "pipelines/scenes.hpp"
#include "support/all_stages.hpp"
#include "support/one_step.hpp"
#include "support/test_data.hpp"

namespace volccd {
namespace {

/// Loses every seventh test.
class LossyFilter final : public FeatureFilter {
 public:
  void run(const Step&, StageState&, unsigned, const TestBlock& block, std::span<std::uint8_t> keep) const override {
    for (std::size_t i = 0; i < block.size(); i += 7) keep[i] = 0;
  }
};

Registry lossy_registry() {
  Registry registry = test::all_stages();
  StageDescriptor<FeatureFilter> descriptor;
  descriptor.name = "lossy";
  descriptor.guarantee = Guarantee::approximate;
  descriptor.make = [](const OptionValues&) { return std::make_unique<LossyFilter>(); };
  registry.add(descriptor);
  PipelineSpec spec = registry.pipeline("VolCCD+");
  spec.name = "Lossy";
  spec.feature_filters.push_back({"lossy", {}});
  registry.add_pipeline(spec);
  return registry;
}

const test::Scene& scene() {
  static const test::Scene colliding = test::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 2, 1), 3, 0.1);
  return colliding;
}

TEST(Verify, CleanWhereNothingIsWrong) {
  Verifier verifier(test::all_stages(), {});
  SerialExecutor serial;
  const ObjectFilter filter;
  const StepVerdict verdict = verifier.check({scene().topology, scene().motion, filter}, serial);
  EXPECT_TRUE(verdict.clean());
  EXPECT_EQ(verdict.pipelines.size(), 4u);
  EXPECT_EQ(verifier.skipped_pipelines(), (std::vector<std::string>{"NavCCD-2011", "HashCCD-2011", "VolCCD-2011"}));
  EXPECT_GT(verdict.contacts, 0u);
  EXPECT_GT(verdict.fcl.hits, 0u);
}

TEST(Verify, FindsAStageThatLosesContacts) {
  Verifier verifier(lossy_registry(), {});
  SerialExecutor serial;
  const ObjectFilter filter;
  const StepVerdict verdict = verifier.check({scene().topology, scene().motion, filter}, serial);
  EXPECT_FALSE(verdict.clean());
  for (const PipelineVerdict& one : verdict.pipelines) {
    EXPECT_EQ(one.difference.empty(), one.pipeline != "Lossy") << one.pipeline;
    EXPECT_EQ(one.difference.extra.size() + one.difference.changed.size(), 0u) << one.pipeline;
  }
}

TEST(Verify, ShowsWhatApproximateNarrowPhasesMissAndDoesNotCountIt) {
  Registry registry = lossy_registry();
  PipelineSpec spec = registry.pipeline("Lossy");
  spec.name = "LossyProvot";
  spec.narrow_phase = {"provot", {}};
  registry.add_pipeline(spec);
  Verifier verifier(registry, {.fcl_times = {}, .approximate = true});
  SerialExecutor serial;
  const ObjectFilter filter;
  const StepVerdict verdict = verifier.check({scene().topology, scene().motion, filter}, serial);
  EXPECT_FALSE(verdict.clean());
  for (const PipelineVerdict& one : verdict.pipelines) {
    const bool lossy = one.pipeline.starts_with("Lossy");
    EXPECT_EQ(one.difference.missing.empty(), !lossy) << one.pipeline;
    EXPECT_TRUE(one.difference.changed.empty()) << one.pipeline << ": times agree within the tolerance";
    EXPECT_TRUE(one.refused.empty()) << one.refused;
    EXPECT_EQ(one.held, one.pipeline != "LossyProvot" && !one.pipeline.ends_with("-2011")) << one.pipeline;
    EXPECT_EQ(one.agrees(), one.pipeline != "Lossy") << one.pipeline;
  }
}

/// Drops pairs of odd elements, and reports them as disjoint.
class LyingCulling final : public ElementCulling {
 public:
  void run(const Step&, StageState&, unsigned, PairBatch& batch) const override {
    batch.cull([](ElementPair pair, FeatureMask&) {
      return (pair.a & pair.b & 1u) == 0 ? PairVerdict::keep : PairVerdict::disjoint;
    });
  }
};

TEST(Verify, FindsAListOfInitialOverlapsThatIsNotThatOfTheReference) {
  Registry registry = test::all_stages();
  StageDescriptor<ElementCulling> descriptor;
  descriptor.name = "lying";
  descriptor.guarantee = Guarantee::approximate;
  descriptor.make = [](const OptionValues&) { return std::make_unique<LyingCulling>(); };
  registry.add(descriptor);
  PipelineSpec spec = registry.pipeline("VolCCD+");
  spec.name = "Lying";
  spec.element_culling = {{"lying", {}}};
  registry.add_pipeline(spec);
  const test::Scene overlapping = test::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 2, 1), 3, 0.5);
  Verifier verifier(registry, {});
  SerialExecutor serial;
  const ObjectFilter filter;
  const StepVerdict verdict = verifier.check({overlapping.topology, overlapping.motion, filter}, serial);
  EXPECT_FALSE(verdict.clean());
  EXPECT_TRUE(verdict.initial.clean());
  EXPECT_GT(verdict.initial.hits, 0u);
  EXPECT_GE(verdict.initial_overlaps, verdict.initial.hits);
  for (const PipelineVerdict& one : verdict.pipelines) {
    EXPECT_EQ(one.missing_overlaps.empty(), one.pipeline != "Lying") << one.pipeline;
    EXPECT_TRUE(one.extra_overlaps.empty()) << one.pipeline;
  }
}

/// Two quads of a sheet that folds, thickened. When it is nearly closed, the prisms of the halves overlap.
TEST(Verify, LeavesOutShellNeighboursInAllPipelinesAlike) {
  const Shape sheet = block(ElementType::quad, 2, 1, 1);
  std::vector<Vec3> start = sheet.positions, end = sheet.positions;
  double middle = 0;
  for (const Vec3& p : sheet.positions) middle = std::max(middle, p.x() / 2);
  for (std::size_t i = 0; i < end.size(); ++i) {
    const double r = sheet.positions[i].x() - middle;
    if (r <= 0) continue;
    start[i] = Vec3(middle + r * std::cos(0.2), start[i].y(), r * std::sin(0.2));
    end[i] = Vec3(middle + r * std::cos(3.0), end[i].y(), r * std::sin(3.0));
  }
  const Mesh shells = sheet.mesh();
  const ShellThickener thickener(shells);
  const Topology topology(thickener.solid_mesh(shells));
  const std::vector<double> thickness(shells.element_slots(), 0.3);
  std::vector<Vec3> x0, x1;
  thickener.positions(start, thickness, x0);
  thickener.positions(end, thickness, x1);
  Motion motion;
  motion.set_linear(x0, x1);
  SerialExecutor serial;
  const ObjectFilter filter;
  Verifier verifier(test::all_stages(), {});
  Step step{topology, motion, filter};
  std::vector<Contact> expected, contacts;
  EXPECT_TRUE(verifier.check(step, serial, &expected).clean());
  step.leave_out_shell_neighbours = true;
  EXPECT_TRUE(verifier.check(step, serial, &contacts).clean());
  std::erase_if(expected, [](const Contact& c) { return share_shell_vertex(c.kind, c.vertices); });
  EXPECT_EQ(contacts, expected);
  EXPECT_LT(contacts.size(), verifier.check({topology, motion, filter}, serial).contacts);

  Verifier lossy(lossy_registry(), {.fcl_times = {}});
  for (const PipelineVerdict& one : lossy.check(step, serial).pipelines)
    EXPECT_EQ(one.agrees(), one.pipeline != "Lossy") << one.pipeline;
}

TEST(Verify, PipelinesThatCannotRunTheStepAreRefusedNotDifferent) {
  Registry registry = test::all_stages();
  PipelineSpec limited = registry.pipeline("VolCCD");
  limited.name = "Limited";
  registry.apply_setting(limited, "narrow-phase=cubic");
  registry.add_pipeline(limited);
  Verifier verifier(registry, {.brute_force_limit = 0, .fcl_times = {}, .approximate = true});
  SerialExecutor serial;
  const ObjectFilter filter;
  const StepVerdict verdict = verifier.check({scene().topology, scene().motion, filter, 0.1}, serial);
  EXPECT_EQ(verdict.reference, "NavCCD");
  EXPECT_TRUE(verdict.clean());
  for (const PipelineVerdict& one : verdict.pipelines)
    EXPECT_EQ(one.refused.empty(), one.pipeline != "Limited" && !one.pipeline.ends_with("-2011")) << one.pipeline;
}

TEST(Compare, TellsMissingExtraAndChanged) {
  const auto contact = [](Index v, double toi) {
    return Contact{FeatureKind::vf, {v, 10, 11, 12}, toi, Vec3::Zero(), {}, Vec3::Zero()};
  };
  const std::vector<Contact> expected = {contact(1, 0.1), contact(2, 0.2), contact(4, 0.4)};
  const std::vector<Contact> found = {contact(2, 0.2), contact(3, 0.3), contact(4, 0.5)};
  const ContactDifference d = compare_contacts(expected, found);
  ASSERT_EQ(d.missing.size(), 1u);
  ASSERT_EQ(d.extra.size(), 1u);
  ASSERT_EQ(d.changed.size(), 1u);
  EXPECT_EQ(d.missing[0].vertices[0], 1u);
  EXPECT_EQ(d.extra[0].vertices[0], 3u);
  EXPECT_EQ(d.changed[0].second.toi, 0.5);
  EXPECT_TRUE(compare_contacts(expected, expected).empty());
}

TEST(Truth, TellsMissingExtraAndWrongTimes) {
  Mesh mesh;
  mesh.add_vertices(20);
  const auto contact = [](Index v, double toi) {
    return Contact{FeatureKind::vf, {v, 10, 11, 12}, toi, Vec3::Zero(), {}, Vec3::Zero()};
  };
  const auto answer = [](std::int64_t v, bool collides, double toi) {
    return KnownAnswer{FeatureKind::vf, {v, 10, 11, 12}, collides, toi};
  };
  const std::vector<KnownAnswer> truth = {answer(1, true, 0.1), answer(2, true, 0.2), answer(3, false, NAN),
                                          answer(4, true, 0.4)};
  const std::vector<Contact> contacts = {contact(1, 0.1), contact(3, 0.3), contact(4, 0.5)};
  const TruthVerdict verdict = check_against_truth(mesh, contacts, truth, 1e-6);
  EXPECT_EQ(verdict.colliding, 3u);
  ASSERT_EQ(verdict.missing.size(), 1u);
  EXPECT_EQ(verdict.missing[0].ids[0], 2);
  ASSERT_EQ(verdict.extra.size(), 1u);
  EXPECT_EQ(verdict.extra[0].ids[0], 3);
  ASSERT_EQ(verdict.wrong_time.size(), 1u);
  EXPECT_NEAR(verdict.largest_time_error, 0.1, 1e-12);
}

/// Contacts of some motions of a real run, compared with those of an independent program.
void expect_reference_contacts(const std::string& name, const std::vector<int>& steps,
                               const std::string& pipeline_name) {
  VOLCCD_NEEDS_DATA(file, name + ".vtkhdf");
  VOLCCD_NEEDS_DATA(reference_file, "reference/" + name + ".csv");
  const Registry registry = test::all_stages();
  const Pipeline pipeline(registry, registry.pipeline(pipeline_name));
  Workspace workspace = pipeline.make_workspace();
  SequenceReader reader(file);
  SequenceStepper stepper(reader);
  SerialExecutor serial;
  const ObjectFilter filter;
  std::vector<ContactRow> reference = read_contacts_csv(reference_file);
  std::erase_if(reference, [&](const ContactRow& row) {
    return std::find(steps.begin(), steps.end(), static_cast<int>(row.step)) == steps.end();
  });
  std::sort(reference.begin(), reference.end(), [](const auto& x, const auto& y) { return canonical_less(x, y); });
  std::vector<ContactRow> found;
  for (const int k : steps) {
    stepper.go_to(k);
    StepResult result;
    pipeline.run({stepper.topology(), stepper.motion(), filter}, workspace, serial, result);
    for (const Contact& contact : result.contacts) found.push_back(contact_row(k, contact, stepper.topology().mesh()));
  }
  std::sort(found.begin(), found.end(), [](const auto& x, const auto& y) { return canonical_less(x, y); });
  ASSERT_EQ(found.size(), reference.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].step, reference[i].step);
    ASSERT_EQ(found[i].kind, reference[i].kind);
    ASSERT_EQ(found[i].ids, reference[i].ids);
    ASSERT_NEAR(found[i].toi, reference[i].toi, 1e-6);
  }
}

TEST(ReferenceContacts, Projectile) {
  expect_reference_contacts("ls-dyna-projectile", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}, "VolCCD+");
}
TEST(LongReferenceContacts, ProjectileByThePapersPipeline) {
  expect_reference_contacts("ls-dyna-projectile", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}, "VolCCD");
}
TEST(ReferenceContacts, Bullet) {
  expect_reference_contacts("openradioss-bullet", {10, 20, 30, 40, 50, 60, 70, 80}, "VolCCD+");
}
TEST(ReferenceContacts, Crash) { expect_reference_contacts("openradioss-crash", {20, 45, 60, 80}, "VolCCD+"); }
TEST(ReferenceContacts, Airbag) { expect_reference_contacts("openradioss-airbag", {40, 80, 118}, "VolCCD+"); }

TEST(LongSymbolicTruth, RodTwist) {
  VOLCCD_NEEDS_DATA(file, "rod-twist.vtkhdf");
  SequenceReader reader(file);
  SequenceStepper stepper(reader);
  stepper.go_to(0);
  const StepResult result = test::run_step({stepper.topology(), stepper.motion(), test::kAllObjects});
  const auto truth = read_ground_truth(reader);
  ASSERT_TRUE(truth);
  const TruthVerdict verdict = check_against_truth(stepper.topology().mesh(), result.contacts, *truth, 1e-9);
  EXPECT_TRUE(verdict.clean());
  EXPECT_EQ(verdict.colliding, 4944u);
}

}  // namespace
}  // namespace volccd
