// What `cubic` promises although it is approximate, on difficult tests: check_stage() only counts where it is wrong.
#include <algorithm>
#include <string>
#include <vector>

#include <volccd/narrowphase/cubic/cubic.hpp>
#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>

#include "support/one_test.hpp"
#include "support/run_seeds.hpp"
#include "support/stages.hpp"

namespace volccd::test::cubic_promises {
namespace {

using cases::Attack;
using cases::Case;
using cases::Choices;
using cases::Coordinates;
using cases::InstructionSets;
using cases::touching_attacks;

/// The promises of the header of `cubic`: touching tests are reported, at a time that is rarely late by more than
/// 1e-12, and the features of a reported test are within the tolerance at that time. Coordinates that span hundreds of
/// powers of two are left out, because doubles scaled to one size represent them too coarsely.
class CubicKeepsItsPromises {
 public:
  std::string operator()(Choices& choices) {
    const std::span<const Attack> attacks = touching_attacks();
    const Attack& attack = attacks[static_cast<std::size_t>(choices.below(static_cast<int>(attacks.size())))];
    const Case c = attack.make(choices, choices.below(2) ? FeatureKind::ee : FeatureKind::vf, 2);
    if (coordinate_bits(Coordinates(c).motion()) > kMaxBits) return "";
    test_.set(c, 1);
    const ExactAnswer truth = exact_first_touch(Coordinates(c).motion());
    std::string wrong;
    sets_.with_each([&](const std::string& set) {
      std::vector<Contact> contacts;
      NarrowCounters counters;
      run_stage(cubic_, test_.step(), test_.kind(), test_.pairs(), contacts, counters);
      const std::string what = judge(c, truth, contacts);
      if (!what.empty()) wrong += what + " on " + set + ", ";
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
  InstructionSets sets_;
  OneTest test_;
  double answers_ = 0, late_ = 0;
};

TEST(CubicPromises, AreKept) {
  CubicKeepsItsPromises property;
  run_seeds(1, 5000, property);
  EXPECT_LT(property.late_share(), 1e-3);
}
TEST(LongCubicPromises, AreKept) {
  CubicKeepsItsPromises property;
  run_seeds(50'000'000, 50'000, property);
  EXPECT_LT(property.late_share(), 1e-3);
}

}  // namespace
}  // namespace volccd::test::cubic_promises
