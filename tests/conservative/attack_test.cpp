// Attacks on the narrow phases.
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <volccd/narrowphase/cubic/cubic.hpp>
#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/pipelines/registry.hpp>

#include "conservative/inclusion_property.hpp"
#include "conservative/run_cases.hpp"
#include <volccd/oracle/cases/instruction_sets.hpp>
#include "support/stages.hpp"

namespace volccd::test {
namespace {

/// Narrow phases that declare to lose no contact, with the default options of the registry: they report touching tests
/// and never late, on each instruction set. Exact ones report no other tests.
class NarrowPhaseProperty {
 public:
  NarrowPhaseProperty() {
    const Registry registry = Registry::standard();
    for (const auto& descriptor : registry.stages<NarrowPhase>())
      if (descriptor.guarantee != Guarantee::approximate)
        stages_.push_back({descriptor.name, descriptor.guarantee, descriptor.make({})});
  }

  std::string operator()(Choices& choices) {
    const Case c = any_attack_test(choices, touching_attacks());
    test_.set(c, 1);
    const ExactAnswer truth = exact_first_touch(Coordinates(c).motion());
    std::string wrong;
    targets_.with(cases_++, [&](const std::string& target) {
      for (const auto& [name, guarantee, stage] : stages_) {
        std::vector<Contact> contacts;
        NarrowCounters counters;
        run_stage(*stage, test_.step(), test_.kind(), test_.pairs(), contacts, counters);
        const bool found = !contacts.empty();
        if (truth.touches && !found) wrong += name + " misses it on " + target + ", ";
        if (truth.touches && found && contacts.front().toi > truth.toi) wrong += name + " is late on " + target + ", ";
        if (guarantee == Guarantee::exact && found != truth.touches)
          wrong += name + " is not exact on " + target + ", ";
      }
    });
    return wrong.empty() ? "" : wrong + "\n" + to_text(c);
  }

  std::set<std::string> names() const {
    std::set<std::string> names;
    for (const auto& stage : stages_) names.insert(stage.name);
    return names;
  }

 private:
  struct Named {
    std::string name;
    Guarantee guarantee;
    std::unique_ptr<NarrowPhase> stage;
  };

  std::vector<Named> stages_;
  VectorTargets targets_;
  std::size_t cases_ = 0;
  OneTest test_;
};

/// The promises of the header of `cubic`: touching tests are reported, at a time that is rarely late by more than
/// 1e-12, and the features of a reported test are within the tolerance at that time. Coordinates that span hundreds of
/// powers of two are left out, because doubles scaled to one size represent them too coarsely.
class CubicProperty {
 public:
  std::string operator()(Choices& choices) {
    const std::span<const Attack> attacks = touching_attacks();
    const Attack& attack = attacks[static_cast<std::size_t>(choices.below(static_cast<int>(attacks.size())))];
    const Case c = attack.make(choices, choices.below(2) ? FeatureKind::ee : FeatureKind::vf, 2);
    if (coordinate_bits(Coordinates(c).motion()) > kMaxBits) return "";
    test_.set(c, 1);
    const ExactAnswer truth = exact_first_touch(Coordinates(c).motion());
    std::string wrong;
    targets_.with_each([&](const std::string& target) {
      std::vector<Contact> contacts;
      NarrowCounters counters;
      run_stage(cubic_, test_.step(), test_.kind(), test_.pairs(), contacts, counters);
      const std::string what = judge(c, truth, contacts);
      if (!what.empty()) wrong += what + " on " + target + ", ";
    });
    return wrong.empty() ? "" : attack.name + (": " + wrong) + "\n" + to_text(c);
  }

  /// Fraction of the answers that are late by more than 1e-12.
  double late_share() const { return late_ / answers_; }

 private:
  std::string judge(const Case& c, const ExactAnswer& truth, const std::vector<Contact>& contacts) {
    answers_ += 1;
    if (contacts.empty()) return truth.touches ? "missed at " + std::to_string(truth.toi) : "";
    const double toi = contacts.front().toi, late = truth.touches ? toi - truth.toi : 0;
    late_ += late > 1e-12;
    if (late > 1e-6) return "late: it is at " + std::to_string(truth.toi);
    // The tolerance, plus the distance that the features move in 1e-12 of the step.
    const double size = std::min(Coordinates(c).size(), 0x1p1023);
    if (size < 0x1p-900) return "";
    return compare_distance(Coordinates(c).motion(), toi, 1.1e-10 * size) <= 0 ? "" : "reported, and not near";
  }

  static constexpr int kMaxBits = 300;

  Cubic cubic_;
  VectorTargets targets_;
  OneTest test_;
  double answers_ = 0, late_ = 0;
};

class InclusionAttack : public testing::TestWithParam<Attack> {
 protected:
  void run(std::uint64_t first, int cases, InclusionProperty::Others others) {
    InclusionProperty property(
        InclusionProperty::Promise::complete, [](Choices& choices) { return attack_test(choices, GetParam()); },
        others);
    run_seeds(first, cases, property);
  }
};
class LongInclusionAttack : public InclusionAttack {};

TEST_P(InclusionAttack, KeepsItsPromise) {
  run(1, GetParam().cases, InclusionProperty::Others::all);
}
TEST_P(LongInclusionAttack, KeepsItsPromise) {
  run(40'000'000, 5 * GetParam().cases, InclusionProperty::Others::in_turn);
}

std::vector<Attack> all_attacks() {
  std::vector<Attack> all(touching_attacks().begin(), touching_attacks().end());
  all.insert(all.end(), separation_attacks().begin(), separation_attacks().end());
  return all;
}
std::string attack_name(const testing::TestParamInfo<Attack>& info) { return info.param.name; }

TEST(AttackCases, AreFiniteAndManyTouch) {
  for (const Attack& attack : all_attacks()) {
    int known = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
      Choices choices(seed);
      const Case c = attack_test(choices, attack);
      bool finite = std::isfinite(c.separation);
      for (const auto& set : c.sets)
        for (const Curve& p : set)
          for (const Vec3& x : p) finite = finite && x.allFinite();
      ASSERT_TRUE(finite) << attack.name << " " << seed;
      known += c.touch >= 0;
    }
    // the time is rounded, and not known exactly
    const std::set<std::string> nearly = {"NearMiss", "FarOff", "NearlyAtTheSeparation"};
    EXPECT_TRUE(known > 100 || nearly.count(attack.name)) << attack.name << " " << known;
  }
}

INSTANTIATE_TEST_SUITE_P(Families, InclusionAttack, testing::ValuesIn(all_attacks()), attack_name);
INSTANTIATE_TEST_SUITE_P(Families, LongInclusionAttack, testing::ValuesIn(all_attacks()), attack_name);

TEST(InclusionAttacks, AreMadeSimple) {
  InclusionProperty touching(InclusionProperty::Promise::complete,
                             [](Choices& choices) { return any_attack_test(choices, touching_attacks()); });
  run_shrinking(20118, 300, touching);
  InclusionProperty within(InclusionProperty::Promise::complete,
                           [](Choices& choices) { return any_attack_test(choices, separation_attacks()); });
  run_shrinking(20119, 300, within);
}

TEST(NarrowPhaseAttack, NothingIsMissed) {
  NarrowPhaseProperty property;
  EXPECT_EQ(property.names(), (std::set<std::string>{"exact", "inclusion"}))
      << "a new one belongs into InclusionAttack, too";
  run_seeds(1, 1500, property);
}

TEST(CubicAttack, KeepsItsPromise) {
  CubicProperty property;
  run_seeds(1, 5000, property);
  EXPECT_LT(property.late_share(), 1e-3);
}
TEST(LongCubicAttack, KeepsItsPromise) {
  CubicProperty property;
  run_seeds(50'000'000, 50'000, property);
  EXPECT_LT(property.late_share(), 1e-3);
}

}  // namespace
}  // namespace volccd::test
