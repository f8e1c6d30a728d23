#include <volccd/experiments/tables/rows.hpp>

#include <array>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>

namespace volccd {
namespace {

using nlohmann::json;

json record(const std::vector<std::array<int, 3>>& rows) {
  json record = {{"rows", json::array()}};
  for (const auto& [a, b, value] : rows) record["rows"].push_back({{"a", a}, {"b", b}, {"value", value}});
  return record;
}

TEST(Rows, GroupsAreThoseOfNestedLoops) {
  const json all = record({{2, 7, 0}, {1, 8, 1}, {2, 8, 2}, {1, 7, 3}, {2, 7, 4}, {1, 8, 5}, {2, 9, 6}});
  const Rows rows(all);
  std::vector<Rows> nested;
  for (const json& a : rows.values("a"))
    for (const json& b : rows.with("a", a).values("b")) nested.push_back(rows.with("a", a).with("b", b));
  const std::vector<Rows> groups = rows.groups({"a", "b"});
  ASSERT_EQ(groups.size(), 5u);
  ASSERT_EQ(groups.size(), nested.size());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    EXPECT_EQ(groups[i].value("a"), nested[i].value("a"));
    EXPECT_EQ(groups[i].values("value"), nested[i].values("value"));
    EXPECT_EQ(groups[i].size(), nested[i].size());
  }
}

TEST(Rows, GroupsOfNothing) {
  EXPECT_EQ(Rows(record({{1, 2, 3}})).groups({}).size(), 1u);
  EXPECT_TRUE(Rows().groups({"a"}).empty());
}

TEST(Rows, AMissingColumnIsAnError) {
  const json all = record({{1, 2, 3}});
  EXPECT_THROW(Rows(all).groups({"c"}), InputError);
  EXPECT_THROW(Rows(all).value("c"), InputError);
}

}  // namespace
}  // namespace volccd
