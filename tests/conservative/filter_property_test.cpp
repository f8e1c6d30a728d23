// No feature filter drops a test that touches, and the generator's tests have the properties that it states.
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/pipelines/registry.hpp>

#include "conservative/inclusion_property.hpp"
#include "conservative/one_test.hpp"
#include "conservative/run_cases.hpp"
#include <volccd/oracle/cases/instruction_sets.hpp>
#include "support/stages.hpp"

namespace volccd::test {
namespace {

struct Named {
  std::string name;
  std::unique_ptr<FeatureFilter> filter;
};

std::vector<Named> all_filters() {
  const Registry registry = Registry::standard();
  std::vector<Named> filters;
  const auto add = [&](const std::string& name, const OptionValues& options) {
    std::string text = name;
    for (const auto& [key, value] : options) text += " " + key + "=" + value;
    filters.push_back({text, registry.stage<FeatureFilter>(name).make(options)});
  };
  for (const char* bounds : {"swept", "relative"})
    for (const char* k : {"6", "14", "16", "18", "24", "26"}) add("feature-kdop", {{"k", k}, {"bounds", bounds}});
  add("coplanarity", {});
  for (const char* axes : {"first", "ends", "wide"}) add("feature-csat", {{"axes", axes}});
  return filters;
}

class FilterProperty {
 public:
  explicit FilterProperty(Separation separation)
      : FilterProperty([separation](Choices& choices) { return near_degenerate_test(choices, separation); }) {}
  explicit FilterProperty(Generator generator) : generator_(std::move(generator)), filters_(all_filters()) {}

  std::string operator()(Choices& choices) {
    const double until = choices.below(64) / 64.0;
    const int which = choices.below(4);
    const Case c = generator_(choices);
    const double t_max = which == 2 && c.touch >= 0 ? c.touch : which == 3 ? until : 1;
    test_.set(c, t_max);
    std::string dropped;
    // One instruction set for each case, in turn.
    targets_.with(static_cast<std::size_t>(all_), [&](const char* target) {
      for (const auto& [name, filter] : filters_) {
        std::uint8_t keep[8] = {1, 1, 1, 1, 1, 1, 1, 1};
        run_stage(*filter, test_.step(), test_.block(), keep);
        if (!keep[0]) dropped += name + " " + target + ", ";
      }
    });
    all_ += 1;
    if (dropped.empty()) return "";
    dropped_ += 1;
    judged_ += !Coordinates(c).apart_along_an_axis();
    if (!touches(c, t_max)) return "";
    return "dropped by " + dropped + "t_max " + std::to_string(t_max) + "\n" + to_text(c);
  }

  double dropped_share() const { return dropped_ / all_; }
  double judged_share() const { return judged_ / all_; }

 private:
  Generator generator_;
  std::vector<Named> filters_;
  VectorTargets targets_;
  OneTest test_;
  double all_ = 0, dropped_ = 0, judged_ = 0;
};

TEST(NearDegenerate, TouchesAsItSays) {
  run_seeds(1'000'000, 3000, [](Choices& choices) -> std::string {
    const Case c = near_degenerate_test(choices);
    if (c.touch < 0) return "";
    const ExactAnswer answer = exact_first_touch(Coordinates(c).motion());
    return answer.touches && answer.toi <= c.touch ? "" : to_text(c);
  });
  run_seeds(2'000'000, 3000, [](Choices& choices) -> std::string {
    const Case c = near_degenerate_test(choices, Separation::some);
    if (c.touch < 0 || compare_distance(Coordinates(c).motion(), c.touch, c.separation) <= 0) return "";
    return to_text(c);
  });
}

TEST(NearDegenerate, HasEveryCase) {
  double at_start = 0, crossing = 0, grazing = 0, coplanar = 0, degenerate = 0, apart = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    Choices choices(seed);
    const ExactAnswer answer = exact_first_touch(Coordinates(near_degenerate_test(choices)).motion());
    at_start += answer.reason == TouchCase::at_start;
    crossing += answer.reason == TouchCase::crossing;
    grazing += answer.reason == TouchCase::grazing;
    coplanar += answer.reason == TouchCase::coplanar;
    apart += answer.reason == TouchCase::apart;
    degenerate += answer.degenerate;
  }
  for (const double cases : {at_start, crossing, grazing, coplanar, apart, degenerate}) EXPECT_GT(cases, 60);
}

TEST(FilterProperty, TouchingTestsAreKept) {
  FilterProperty property(Separation::none);
  run_shrinking(20110, 4000, property);
  run_seeds(1, 80'000, property);
}
TEST(FilterProperty, TestsWithinTheSeparationAreKept) {
  FilterProperty property(Separation::some);
  run_shrinking(20111, 4000, property);
  run_seeds(1, 40'000, property);
}
TEST(FilterProperty, HasEveryFilterThatLosesNothing) {
  std::set<std::string> registered, tested;
  const Registry registry = Registry::standard();
  for (const auto& descriptor : registry.stages<FeatureFilter>())
    if (descriptor.guarantee != Guarantee::approximate) registered.insert(descriptor.name);
  for (const Named& filter : all_filters()) tested.insert(filter.name.substr(0, filter.name.find(' ')));
  EXPECT_EQ(tested, registered);
}
TEST(FilterProperty, AttacksAreKept) {
  FilterProperty touching([](Choices& choices) { return any_attack_test(choices, touching_attacks()); });
  run_seeds(1, 10'000, touching);
  FilterProperty within([](Choices& choices) { return any_attack_test(choices, separation_attacks()); });
  run_seeds(1, 10'000, within);
}
TEST(LongFilterProperty, AttacksAreKept) {
  FilterProperty touching([](Choices& choices) { return any_attack_test(choices, touching_attacks()); });
  run_seeds(10'000'000, 100'000, touching);
  FilterProperty within([](Choices& choices) { return any_attack_test(choices, separation_attacks()); });
  run_seeds(10'000'000, 100'000, within);
}
TEST(LongFilterProperty, TouchingTestsAreKept) {
  FilterProperty property(Separation::none);
  run_seeds(10'000'000, 1'000'000, property);
  EXPECT_GT(property.dropped_share(), 0.03);
  EXPECT_GT(property.judged_share(), 0.01) << "nearly touching tests are missing";
}
TEST(LongFilterProperty, TestsWithinTheSeparationAreKept) {
  FilterProperty property(Separation::some);
  run_seeds(10'000'000, 800'000, property);
  EXPECT_GT(property.dropped_share(), 0.03);
}

}  // namespace
}  // namespace volccd::test
