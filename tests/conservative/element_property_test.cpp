// Elements whose features touch are emitted by every broad phase, and no conservative element culling drops them or
// masks those features.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <volccd/oracle/cases/element_pairs.hpp>
#include <volccd/pipelines/registry.hpp>

#include "conservative/run_cases.hpp"
#include <volccd/oracle/cases/instruction_sets.hpp>
#include "support/stages.hpp"

namespace volccd::test {
namespace {

struct NamedCulling {
  std::string name;
  std::unique_ptr<ElementCulling> stage;
};

/// All conservative stages; `csat` with each axis in each mode.
std::vector<NamedCulling> all_cullings() {
  const Registry registry = Registry::standard();
  std::vector<NamedCulling> all;
  for (const auto& descriptor : registry.stages<ElementCulling>())
    if (descriptor.guarantee != Guarantee::approximate && descriptor.name != "csat")
      all.push_back({descriptor.name, descriptor.make({})});
  for (const char* axis : {"face", "predetermined", "velocity", "centroid", "optimal"})
    for (const std::string mode : {"features", "pair", "both"}) {
      OptionValues options{{"axis", axis}, {"mode", mode}, {"edges_of_b", mode == "both" ? "true" : "false"}};
      all.push_back({"csat " + std::string(axis) + " " + mode, registry.stage<ElementCulling>("csat").make(options)});
    }
  return all;
}

struct NamedBroadPhase {
  std::string name;
  std::unique_ptr<BroadPhase> stage;
};

std::vector<NamedBroadPhase> all_broad_phases() {
  const Registry registry = Registry::standard();
  std::vector<NamedBroadPhase> all;
  for (const auto& descriptor : registry.stages<BroadPhase>()) {
    all.push_back({descriptor.name, descriptor.make({})});
    for (const OptionInfo& option : descriptor.options)
      if (option.name == "k")
        for (const char* k : {"6", "14", "16", "18", "24", "26"})
          all.push_back({descriptor.name + " " + k, descriptor.make({{"k", k}})});
  }
  return all;
}

/// Data of both properties: a case, and a part of the step.
class ElementProperty {
 public:
  ElementProperty(ElementType type, Separation separation)
      : ElementProperty(type, nearly_degenerate_elements(separation)) {}
  ElementProperty(ElementType type, ElementGenerator generator) : scene_(type), generator_(std::move(generator)) {}

  std::string operator()(Choices& choices) {
    const double until = choices.below(64) / 64.0;
    const int which = choices.below(4);
    const FeatureKind kind = choices.below(2) ? FeatureKind::ee : FeatureKind::vf;
    const int control_points = 2 + choices.below(2);
    const Case c = scene_.choose(choices, 0, kind, control_points, generator_);
    const double t_max = which == 2 && c.touch >= 0 ? c.touch : which == 3 ? until : 1;
    const std::string lost = loses(c, scene_.step(c, t_max));
    if (lost.empty() || !touches(c, t_max)) return "";
    return lost + "t_max " + std::to_string(t_max) + "\n" + to_text(c);
  }

 protected:
  ~ElementProperty() = default;

  ElementPairs scene_;
  VectorTargets targets_;  ///< one stage for each case, in turn
  std::size_t cases_ = 0;

 private:
  /// The stages that lose the contact of the case.
  virtual std::string loses(const Case& c, const Step& step) = 0;

  ElementGenerator generator_;
};

constexpr ElementPair kPair[] = {{0, 1}};

class ElementCullingProperty final : public ElementProperty {
 public:
  using ElementProperty::ElementProperty;

 private:
  std::string loses(const Case&, const Step& step) override {
    std::string lost;
    targets_.with(cases_++, [&](const std::string& target) {
      for (const auto& [name, stage] : cullings_) {
        PairBatch batch;
        batch.assign(kPair);
        run_stage(*stage, step, batch);
        if (batch.size() == 0) lost += name + " drops on " + target + ", ";
        if (batch.size() == 1 && scene_.masked(0, batch.masks[0])) lost += name + " masks on " + target + ", ";
      }
    });
    return lost;
  }

  std::vector<NamedCulling> cullings_ = all_cullings();
};

class BroadPhaseProperty final : public ElementProperty {
 public:
  using ElementProperty::ElementProperty;

 private:
  std::string loses(const Case&, const Step& step) override {
    std::string lost;
    targets_.with(cases_++, [&](const std::string& target) {
      for (const auto& [name, stage] : stages_) {
        const auto state = prepared(*stage, step);
        std::size_t pairs = 0;
        stage->run(step, *state, PairRange::nonadjacent, executor_,
                   [&](std::span<const ElementPair> batch, unsigned) { pairs += batch.size(); });
        if (pairs != 1) lost += name + " emits " + std::to_string(pairs) + " on " + target + ", ";
      }
    });
    return lost;
  }

  std::vector<NamedBroadPhase> stages_ = all_broad_phases();
  SerialExecutor executor_;
};

TEST(ElementCullingProperty, TouchingTetrahedraAreKept) {
  ElementCullingProperty property(ElementType::tetrahedron, Separation::none);
  run_shrinking(20114, 1500, property);
  run_seeds(1, 15'000, property);
}
TEST(ElementCullingProperty, HexahedraWithinTheSeparationAreKept) {
  ElementCullingProperty property(ElementType::hexahedron, Separation::some);
  run_shrinking(20115, 1000, property);
  run_seeds(1, 5'000, property);
}
TEST(BroadPhaseProperty, TouchingTetrahedraAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::none);
  run_shrinking(20116, 1000, property);
  run_seeds(1, 8'000, property);
}
TEST(BroadPhaseProperty, TetrahedraWithinTheSeparationAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::some);
  run_shrinking(20117, 1000, property);
  run_seeds(1, 8'000, property);
}
TEST(ElementCullingProperty, AttackedElementsAreKept) {
  ElementCullingProperty touching(ElementType::tetrahedron, attacking_elements(touching_attacks()));
  run_seeds(1, 3000, touching);
  ElementCullingProperty within(ElementType::hexahedron, attacking_elements(separation_attacks()));
  run_seeds(1, 1500, within);
}
TEST(BroadPhaseProperty, AttackedElementsAreEmitted) {
  BroadPhaseProperty touching(ElementType::tetrahedron, attacking_elements(touching_attacks()));
  run_seeds(1, 3000, touching);
  BroadPhaseProperty within(ElementType::tetrahedron, attacking_elements(separation_attacks()));
  run_seeds(1, 3000, within);
}
TEST(LongElementCullingProperty, AttackedElementsAreKept) {
  ElementCullingProperty touching(ElementType::tetrahedron, attacking_elements(touching_attacks()));
  run_seeds(30'000'000, 30'000, touching);
  ElementCullingProperty within(ElementType::hexahedron, attacking_elements(separation_attacks()));
  run_seeds(30'000'000, 10'000, within);
}
TEST(LongBroadPhaseProperty, AttackedElementsAreEmitted) {
  BroadPhaseProperty touching(ElementType::tetrahedron, attacking_elements(touching_attacks()));
  run_seeds(30'000'000, 30'000, touching);
  BroadPhaseProperty within(ElementType::tetrahedron, attacking_elements(separation_attacks()));
  run_seeds(30'000'000, 30'000, within);
}
TEST(LongElementCullingProperty, TouchingTetrahedraAreKept) {
  ElementCullingProperty property(ElementType::tetrahedron, Separation::none);
  run_seeds(30'000'000, 200'000, property);
}
TEST(LongElementCullingProperty, TouchingHexahedraAreKept) {
  ElementCullingProperty property(ElementType::hexahedron, Separation::none);
  run_seeds(30'000'000, 40'000, property);
}
TEST(LongElementCullingProperty, TetrahedraWithinTheSeparationAreKept) {
  ElementCullingProperty property(ElementType::tetrahedron, Separation::some);
  run_seeds(30'000'000, 120'000, property);
}
TEST(LongBroadPhaseProperty, TouchingTetrahedraAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::none);
  run_seeds(30'000'000, 100'000, property);
}
TEST(LongBroadPhaseProperty, TetrahedraWithinTheSeparationAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::some);
  run_seeds(30'000'000, 100'000, property);
}

}  // namespace
}  // namespace volccd::test
