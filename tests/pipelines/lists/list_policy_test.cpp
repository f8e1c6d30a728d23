// Lists are made where made-up times say that they pay, and cost little where they do not.
#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include <volccd/pipelines/lists/list_policy.hpp>

namespace volccd::test {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// A made-up solver: what fresh steps, lists and their uses take, and how many steps a list covers.
struct Solver {
  double fresh = 1, list = 2, use = 0.1, waste = 0.5;
  int covered = 50;
  ListPolicy::Motion motion{.length = 0.002, .distance = 0, .steps = 1, .edge = 1};

  /// The time of `steps` steps.
  double run(ListPolicy& policy, int steps) {
    double sum = 0;
    for (int k = 0; k < steps; ++k) sum += step(policy, k == 0);
    return sum;
  }

  double step(ListPolicy& policy, bool first) {
    if (left > 0) {
      --left;
      return used(policy);
    }
    if (listed) policy.record_end(0, 1, 0.01), listed = false;
    if (!policy.has_credit() || !policy.plan(motion)) {
      policy.record_fresh(first ? 20 * fresh : fresh);
      return first ? 0 : fresh;
    }
    ++lists, listed = true;
    policy.record_list(list);
    left = covered - 1;
    return list + used(policy);
  }

  double used(ListPolicy& policy) {
    policy.record_use(use, waste * use);
    if (!policy.is_worthwhile()) policy.record_end(0, 0, 0), left = 0, listed = false;
    return use;
  }

  int left = 0, lists = 0;
  bool listed = false;
};

TEST(ListPolicy, MakesListsWhereTheyPay) {
  ListPolicy policy;
  Solver solver;
  EXPECT_LT(solver.run(policy, 1000), 200);
  EXPECT_GT(solver.lists, 10);
}

/// Whatever lists cost and are good for, steps take 3 % longer at most, but for the first attempt.
TEST(ListPolicy, CostsLittleWhereListsDoNotPay) {
  for (const double list : {0.5, 3.0, 20.0, 300.0})
    for (const double use : {0.05, 0.5, 0.99, 3.0})
      for (const int covered : {1, 2, 5, 20}) {
        ListPolicy policy;
        Solver solver{.list = list, .use = use, .covered = covered};
        const int steps = 20000;
        EXPECT_LT(solver.run(policy, steps), 1.03 * steps + list + use) << list << ' ' << use << ' ' << covered;
      }
}

TEST(ListPolicy, MakesNoneForFastOrUnsteadyMotions) {
  for (const ListPolicy::Motion motion :
       {ListPolicy::Motion{.length = 0.2, .distance = 0, .steps = 1, .edge = 1},
        ListPolicy::Motion{.length = 0.002, .distance = 0.02, .steps = 1, .edge = 1},
        ListPolicy::Motion{.length = 0.002, .distance = kNever, .steps = 1, .edge = 1}}) {
    ListPolicy policy;
    Solver solver{.motion = motion};
    EXPECT_EQ(solver.run(policy, 1000), 999);
    EXPECT_EQ(solver.lists, 0);
  }
}

/// A policy after so many fresh steps that a list can be paid.
ListPolicy ready() {
  ListPolicy policy;
  policy.record_fresh(20);
  for (int k = 0; k < 20; ++k) policy.record_fresh(1);
  return policy;
}

/// The first fresh step builds tables and tells nothing. After it, the first list is made at once, and the next one
/// when that has been paid.
TEST(ListPolicy, WaitsUntilAListIsPaid) {
  ListPolicy policy;
  const ListPolicy::Motion motion{.length = 0.002, .distance = 0, .steps = 1, .edge = 1};
  for (const double seconds : {20.0, 1.0}) {
    EXPECT_FALSE(policy.plan(motion));
    policy.record_fresh(seconds);
  }
  EXPECT_TRUE(policy.plan(motion));
  policy.record_list(2);
  policy.record_use(0.5, 0.5);
  policy.record_end(0, 1, 0);
  for (int k = 0; k < 30; ++k) {
    EXPECT_FALSE(policy.plan(motion));
    policy.record_fresh(1);
  }
  EXPECT_TRUE(ready().plan(motion));
}

/// Lists with many tests in vain become shorter, lists that cost more than their tests become longer.
TEST(ListPolicy, BalancesTheCostOfListsAndOfTests) {
  const auto steps_after = [](double list, double use) {
    ListPolicy policy = ready();
    const ListPolicy::Motion motion{.length = 0.002, .distance = 0, .steps = 100, .edge = 1};
    const double before = policy.plan(motion)->steps;
    for (int i = 0; i < 4; ++i) {
      const auto plan = policy.plan(motion);
      policy.record_list(list);
      for (double k = 0; k < plan->steps; ++k) policy.record_use(use, use);
      policy.record_end(0, 0, 0);
    }
    return policy.plan(motion)->steps / before;
  };
  EXPECT_GT(steps_after(2, 0.001), 2);
  EXPECT_LT(steps_after(2, 0.5), 0.5);
}

/// A longer list that does not make steps faster, as one that ends early anyway, is followed by shorter ones.
TEST(ListPolicy, TakesBackWhatDidNotPay) {
  ListPolicy policy = ready();
  double before = policy.max_travel();
  for (const double list : {1.0, 1.0, 2.0}) {
    before = policy.max_travel();
    policy.record_list(list);
    for (int k = 0; k < 20; ++k) policy.record_use(0.01, 0.01);
    policy.record_end(0, 0, 0);
  }
  EXPECT_LT(policy.max_travel(), before);
}

/// A motion that was followed for ten steps may be expected to stay as near for ten more; one that was followed for a
/// single step may not.
TEST(ListPolicy, TrustsWhatItHasSeen) {
  ListPolicy::Motion motion{.length = 0.01, .distance = 0.02, .steps = 1, .edge = 1};
  EXPECT_FALSE(ready().plan(motion));
  motion.steps = 10;
  const auto plan = ready().plan(motion);
  ASSERT_TRUE(plan);
  EXPECT_GE(plan->steps, 8);
  EXPECT_GE(plan->budget, motion.distance);
  motion.distance = 1.1 * ListPolicy().max_budget();
  EXPECT_FALSE(ready().plan(motion));
}

/// A list that was too dear is tried again when what it cost has been forgotten and paid.
TEST(ListPolicy, ForgetsWhatAListCost) {
  ListPolicy policy = ready();
  policy.record_list(30);
  policy.record_use(0.1, 0.1);
  policy.record_end(0, 1, 0);
  int steps = 0;
  for (; !policy.has_credit() && steps < 10000; ++steps) policy.record_fresh(1);
  EXPECT_GT(steps, 900);
  EXPECT_LT(steps, 1100);
  EXPECT_NEAR(policy.max_travel(), ListPolicy().max_travel(), 1e-6);
}

TEST(ListPolicy, BudgetsFollowTheDistances) {
  const ListPolicy::Motion steady{.length = 0.002, .distance = 0, .steps = 1, .edge = 1};
  const auto budget_after = [&](double covered_share, double missed_share) {
    ListPolicy policy = ready();
    const double before = policy.plan(steady)->budget;
    policy.record_list(1);
    for (int k = 0; k < 4; ++k) policy.record_use(0.5, 1);
    policy.record_end(covered_share * before, missed_share * before, 0);
    const auto after = policy.plan(steady);
    return after->budget / after->steps;
  };
  const double same = budget_after(0.5, 0);
  EXPECT_GT(budget_after(0.9, 1.5), 1.5 * same) << "a list that ended early";
  EXPECT_EQ(budget_after(0.9, 100), same) << "a jump, for which no budget would do";
  EXPECT_LT(budget_after(0.01, 0), 0.7 * same) << "a budget that was not used";
}

}  // namespace
}  // namespace volccd::test
