// The promises of the header of `inclusion`, on tests that nearly touch.
#include "conservative/inclusion_property.hpp"
#include "conservative/run_cases.hpp"

namespace volccd::test {
namespace {

using Promise = InclusionProperty::Promise;

using Others = InclusionProperty::Others;

InclusionProperty near_degenerate_property(Promise promise, Separation separation, Others others = Others::all) {
  return {promise, [separation](Choices& choices) { return near_degenerate_test(choices, separation); }, others};
}

TEST(InclusionProperty, MissesNothing) {
  InclusionProperty property = near_degenerate_property(Promise::complete, Separation::none);
  run_shrinking(20112, 500, property);
  run_seeds(1, 3000, property);
}
TEST(InclusionProperty, MissesNothingWithinTheSeparation) {
  InclusionProperty property = near_degenerate_property(Promise::complete, Separation::some);
  run_shrinking(20113, 300, property);
  run_seeds(1, 2000, property);
}
TEST(InclusionProperty, ReportsWhatComesNear) {
  InclusionProperty touching = near_degenerate_property(Promise::near, Separation::none);
  run_seeds(1, 3000, touching);
  InclusionProperty within = near_degenerate_property(Promise::near, Separation::some);
  run_seeds(1, 1000, within);
}
TEST(LongInclusionProperty, MissesNothing) {
  InclusionProperty property = near_degenerate_property(Promise::complete, Separation::none, Others::in_turn);
  run_seeds(20'000'000, 20'000, property);
}
TEST(LongInclusionProperty, MissesNothingWithinTheSeparation) {
  InclusionProperty property = near_degenerate_property(Promise::complete, Separation::some);
  run_seeds(20'000'000, 20'000, property);
}
TEST(LongInclusionProperty, ReportsWhatComesNear) {
  InclusionProperty touching = near_degenerate_property(Promise::near, Separation::none, Others::in_turn);
  run_seeds(20'000'000, 40'000, touching);
  InclusionProperty within = near_degenerate_property(Promise::near, Separation::some);
  run_seeds(20'000'000, 20'000, within);
}

}  // namespace
}  // namespace volccd::test
