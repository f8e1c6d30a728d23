#include <volccd/distributed/global_order.hpp>

#include <algorithm>
#include <span>
#include <utility>

#include <volccd/distributed/detail/bytes.hpp>

namespace volccd::distributed {

namespace {

/// Keys that each rank gives, from which all choose where the parts of the order begin.
constexpr std::size_t kSamples = 64;

using Pair = std::array<std::int64_t, 2>;
using ContactKey = std::array<std::int64_t, 5>;

ContactKey key_of(const RankContact& contact) {
  const auto& v = contact.vertices;
  return {static_cast<std::int64_t>(contact.kind), v[0], v[1], v[2], v[3]};
}
Pair key_of(const Pair& pair) { return pair; }

Bytes bytes_of(std::span<const RankContact> contacts) { return to_bytes(contacts); }
Bytes bytes_of(std::span<const Pair> pairs) {
  Bytes bytes;
  detail::put_values(bytes, pairs);
  return bytes;
}

void append(const Bytes& bytes, std::vector<RankContact>& contacts) {
  for (RankContact& contact : contacts_of(bytes)) contacts.push_back(std::move(contact));
}
void append(const Bytes& bytes, std::vector<Pair>& pairs) {
  for (const Pair& pair : detail::values_of<Pair>(bytes)) pairs.push_back(pair);
}

/// The least keys of the parts of ranks 1, 2, ...; the same on all ranks.
template <class Key, class Item>
std::vector<Key> part_begins(Exchange& exchange, const std::vector<Item>& items) {
  Bytes mine;
  const std::size_t count = std::min(kSamples, items.size());
  for (std::size_t i = 0; i < count; ++i) detail::put(mine, key_of(items[i * items.size() / count]));
  std::vector<Key> samples;
  for (const Bytes& bytes : exchange.allgather(std::move(mine)))
    for (const Key& key : detail::values_of<Key>(bytes)) samples.push_back(key);
  std::ranges::sort(samples);
  std::vector<Key> begins;
  const auto ranks = static_cast<std::size_t>(exchange.size());
  for (std::size_t r = 1; r < ranks && !samples.empty(); ++r) begins.push_back(samples[r * samples.size() / ranks]);
  return begins;
}

template <class Key, class Item>
std::vector<Item> sorted(Exchange& exchange, std::vector<Item> items) {
  const auto less = [](const Item& x, const Item& y) { return key_of(x) < key_of(y); };
  std::ranges::sort(items, less);
  const std::vector<Key> begins = part_begins<Key>(exchange, items);
  std::vector<int> destinations;
  std::vector<Bytes> messages;
  auto begin = items.begin();
  for (std::size_t r = 0; r <= begins.size(); ++r) {
    const auto end = r == begins.size() ? items.end() : std::partition_point(begin, items.end(), [&](const Item& x) {
      return key_of(x) < begins[r];
    });
    if (begin != end) {
      destinations.push_back(static_cast<int>(r));
      messages.push_back(bytes_of(std::span<const Item>(begin, end)));
    }
    begin = end;
  }
  const auto graph = exchange.connect(std::move(destinations));
  items.clear();
  for (const Bytes& bytes : graph->exchange(std::move(messages))) append(bytes, items);
  std::ranges::sort(items, less);
  return items;
}

}  // namespace

std::vector<RankContact> sort_over_ranks(Exchange& exchange, std::vector<RankContact> contacts) {
  return sorted<ContactKey>(exchange, std::move(contacts));
}

std::vector<Pair> sort_over_ranks(Exchange& exchange, std::vector<Pair> pairs) {
  return sorted<Pair>(exchange, std::move(pairs));
}

}  // namespace volccd::distributed
