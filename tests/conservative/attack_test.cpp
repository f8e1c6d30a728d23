// Attacks on the narrow phases.
#include <cmath>
#include <string>

#include <volccd/narrowphase/cubic.hpp>

#include "conservative/attack_cases.hpp"
#include "conservative/inclusion_property.hpp"
#include "conservative/run_cases.hpp"

namespace volccd::test {
namespace {

using Promise = InclusionProperty::Promise;

std::string test_name(const testing::TestParamInfo<Attack>& info) {
  std::string name;
  for (const char* c = info.param.name; *c; ++c)
    if (*c != ' ') name += *c;
  return name;
}

class InclusionAttack : public testing::TestWithParam<Attack> {
 public:
  void run(std::uint64_t first, int cases) {
    InclusionProperty property(Promise::complete,
                               [&](Choices& choices) { return attack_test(choices, GetParam()); });
    run_seeds(first, cases, property);
  }
};

TEST_P(InclusionAttack, KeepsItsPromise) { run(1, 500); }

INSTANTIATE_TEST_SUITE_P(Touching, InclusionAttack, testing::ValuesIn(touching_attacks().begin(), touching_attacks().end()), test_name);
INSTANTIATE_TEST_SUITE_P(Separation, InclusionAttack, testing::ValuesIn(separation_attacks().begin(), separation_attacks().end()), test_name);

}  // namespace
}  // namespace volccd::test
