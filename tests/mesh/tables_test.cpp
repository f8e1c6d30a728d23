#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include <volccd/core/executor.hpp>
#include <volccd/core/random.hpp>
#include <volccd/mesh/detail/incidences.hpp>
#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/tables/slot_table.hpp>
#include <volccd/mesh/tables/tuple_table.hpp>

namespace volccd::detail {
namespace {

/// Keys by slot with a hash that the test chooses: a bad hash gives long probes, also around the end of the table.
struct Keys {
  std::uint32_t (*hash)(std::uint64_t);
  std::map<Index, std::uint64_t> key_of;
  auto hash_of() const {
    return [this](Index slot) { return hash(key_of.at(slot)); };
  }
};

void compare_with_map(std::uint32_t (*hash)(std::uint64_t), std::uint64_t distinct, std::uint64_t seed) {
  SlotTable table;
  Keys keys{hash, {}};
  std::map<std::uint64_t, Index> reference;
  std::set<Index> free;
  Random random(seed);
  Index next = 0;
  for (int step = 0; step < 6000; ++step) {
    const std::uint64_t key = random.below(distinct);
    const auto same = [&](Index slot) { return keys.key_of.at(slot) == key; };
    const auto known = reference.find(key);
    ASSERT_EQ(table.find(hash(key), same), known == reference.end() ? kNone : known->second);
    const bool shrinking = step / 1500 % 2 == 1;
    if (known != reference.end() && random.below(shrinking ? 1 : 4) == 0) {
      table.erase(known->second, keys.hash_of());
      keys.key_of.erase(known->second);
      free.insert(known->second);
      reference.erase(known);
    } else if (known == reference.end() && (!shrinking || random.below(8) == 0)) {
      const Index slot = free.empty() ? next++ : *free.begin();
      free.erase(slot);
      ASSERT_EQ(table.find_or_insert(hash(key), slot, same, keys.hash_of()), slot);
      keys.key_of[slot] = key;
      reference[key] = slot;
    }
    ASSERT_EQ(table.size(), reference.size());
  }
  for (const auto& [key, slot] : reference)
    ASSERT_EQ(table.find(hash(key), [&, k = key](Index s) { return keys.key_of.at(s) == k; }), slot);
}

TEST(SlotTable, EqualsAMap) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    compare_with_map([](std::uint64_t key) { return static_cast<std::uint32_t>(mix(key)); }, 700, seed);
    compare_with_map([](std::uint64_t key) { return static_cast<std::uint32_t>(key % 3) * 0x55555555u; }, 60, seed);
    // all keys belong to the last position, so that every probe continues at the beginning
    compare_with_map([](std::uint64_t) { return ~0u; }, 60, seed);
    compare_with_map([](std::uint64_t key) { return ~0u - static_cast<std::uint32_t>(key % 5) * 0x02000000u; }, 90,
                     seed);
  }
}

TEST(SlotTableThreads, FillingEqualsInserting) {
  using Hash = std::uint32_t (*)(Index);
  const Hash hashes[] = {[](Index slot) { return static_cast<std::uint32_t>(mix(slot)); },
                         [](Index slot) { return slot % 3 * 0x55555555u; },
                         [](Index) { return ~0u; },  // every probe continues at the beginning
                         [](Index slot) { return (slot % 7 << 28) - slot % 2; }};
  const auto executor = make_thread_executor(3);
  for (const Hash hash : hashes)
    for (const Index n : {0u, 1u, 2u, 1000u, hash == hashes[0] ? 100000u : 3000u}) {
      SlotTable table;
      table.find_or_insert(
          5, 7, [](Index) { return false; }, hash);
      table.fill(n, hash, *executor);
      ASSERT_EQ(table.size(), n);
      for (Index slot = 0; slot < n; ++slot)
        ASSERT_EQ(table.find(hash(slot), [&](Index other) { return other == slot; }), slot);
      for (Index slot = 0; slot < n; slot += 2) table.erase(slot, hash);
      for (Index slot = 0; slot < n; ++slot)
        ASSERT_EQ(table.find(hash(slot), [&](Index other) { return other == slot; }), slot % 2 == 0 ? kNone : slot);
    }
}

TEST(SlotTable, StaysSmall) {
  SlotTable table;
  const auto hash = [](Index slot) { return static_cast<std::uint32_t>(mix(slot) >> 32); };
  const auto none = [](Index) { return false; };
  for (Index slot = 0; slot < 100000; ++slot) table.find_or_insert(hash(slot), slot, none, hash);
  EXPECT_LE(table.bytes(), 100000u * 4u * 3u);
  const std::size_t bytes = table.bytes();
  for (int round = 0; round < 20; ++round) {  // without tombstones, removing and inserting does not make the table grow
    for (Index slot = 0; slot < 1000; ++slot) table.erase(slot, hash);
    for (Index slot = 0; slot < 1000; ++slot) table.find_or_insert(hash(slot), slot, none, hash);
  }
  EXPECT_EQ(table.bytes(), bytes);
}

TEST(TupleTable, SpreadsTheTuplesOfAGrid) {
  // Meshes consist of small, neighbouring numbers, whose hashes must differ.
  TupleTable<3> table;
  std::vector<std::array<Index, 3>> tuples;
  for (Index a = 0; a < 30; ++a)
    for (Index b = a + 1; b < 40; ++b)
      for (Index c = b + 1; c < 40; ++c) {
        const auto slot = static_cast<Index>(tuples.size());
        ASSERT_EQ(table.find_or_insert({a, b, c}, slot, tuples), slot);
        tuples.push_back({a, b, c});
      }
  for (Index slot = 0; slot < tuples.size(); ++slot) ASSERT_EQ(table.find(tuples[slot], tuples), slot);
  for (Index slot = 0; slot < tuples.size(); slot += 2) table.erase(slot, tuples);
  for (Index slot = 0; slot < tuples.size(); ++slot)
    ASSERT_EQ(table.find(tuples[slot], tuples), slot % 2 == 0 ? kNone : slot);
}

std::vector<Index> random_values(Random& random, std::size_t max, Index range) {
  std::set<Index> values;
  for (std::size_t n = 1 + random.below(max); n != 0; --n) values.insert(static_cast<Index>(random.below(range)));
  return {values.begin(), values.end()};
}

TEST(IncidencePool, EqualsAVectorOfSets) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Random random(seed);
    const std::vector<Index> lengths = {3, 0, 7, 1};
    IncidencePool pool;
    SerialExecutor executor;
    pool.set_lengths(lengths, executor);
    std::vector<std::set<Index>> reference(lengths.size());
    for (std::size_t i = 0, at = 0; i < lengths.size(); ++i)
      for (Index k = 0; k < lengths[i]; ++k) {
        pool.entries()[at++] = 10 * k;
        reference[i].insert(10 * k);
      }
    std::size_t max = 0;
    for (int step = 0; step < 20000; ++step) {
      if (step % 100 == 0 && reference.size() < 120) {
        reference.emplace_back();
        pool.extend(reference.size());
      }
      const std::size_t i = random.below(reference.size());
      std::vector<Index> values = random_values(random, 6, i % 10 == 0 ? 500 : 60);
      const bool shrinking = step / 5000 % 2 == 1;
      if (random.below(200) == 0) {
        pool.assign(i, values);
        reference[i] = {values.begin(), values.end()};
      } else if (shrinking || random.below(3) == 0) {
        std::erase_if(values, [&](Index v) { return !reference[i].contains(v); });
        for (Index v : values) reference[i].erase(v);
        if (!values.empty()) pool.erase(i, values);
      } else {
        std::erase_if(values, [&](Index v) { return reference[i].contains(v); });
        reference[i].insert(values.begin(), values.end());
        pool.insert(i, values);
      }
      pool.compact_if_sparse();
      ASSERT_TRUE(std::ranges::equal(pool[i], reference[i]));
      if (step % 500 != 0) continue;
      std::size_t used = 0;
      for (std::size_t k = 0; k < reference.size(); ++k) {
        ASSERT_TRUE(std::ranges::equal(pool[k], reference[k])) << "list " << k;
        used += reference[k].size();
      }
      max = std::max(max, used);
    }
    EXPECT_LT(pool.bytes(), 5 * 4 * max + 12 * 200 + 8192);
  }
}

TEST(Incidences, AreGroupedInOrder) {
  for (const auto& [n, range] : {std::pair{20u, 10u}, {255u, 40u}, {256u, 40u}, {5000u, 3000u}, {5000u, ~0u}}) {
    Random random(n);
    Incidences incidences;
    std::map<Index, std::set<Index>> reference, found;
    for (Index element = 0; element < n; ++element)
      for (Index feature : random_values(random, 5, range)) {
        incidences.add(feature, element);
        reference[feature].insert(element);
      }
    Index last = 0;
    incidences.sort();
    incidences.group([&](Index feature, std::span<const Index> elements) {
      EXPECT_TRUE(found.empty() || feature > last);
      EXPECT_TRUE(std::ranges::is_sorted(elements));
      found[feature] = {elements.begin(), elements.end()};
      last = feature;
    });
    EXPECT_EQ(found, reference);
  }
}

}  // namespace
}  // namespace volccd::detail
