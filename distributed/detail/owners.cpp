#include <volccd/distributed/detail/owners.hpp>

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include <volccd/core/random.hpp>
#include <volccd/distributed/agreement.hpp>
#include <volccd/distributed/detail/bytes.hpp>

namespace volccd::distributed::detail {

namespace {

using Ids = std::vector<std::int64_t>;
using Owner = std::pair<std::int64_t, int>;  ///< of an id

std::size_t keeper_of(std::int64_t id, int ranks) {
  return mix(static_cast<std::uint64_t>(id)) % static_cast<std::uint64_t>(ranks);
}

/// Ids by the rank that keeps their owners.
std::vector<Ids> by_keeper(std::span<const std::int64_t> ids, int ranks) {
  std::vector<Ids> result(static_cast<std::size_t>(ranks));
  for (const std::int64_t id : ids) result[keeper_of(id, ranks)].push_back(id);
  return result;
}

/// A graph to the ranks with ids, and the messages for it.
std::pair<std::unique_ptr<Neighbourhood>, std::vector<Bytes>> messages(Exchange& exchange,
                                                                       const std::vector<Ids>& ids) {
  std::vector<int> destinations;
  std::vector<Bytes> bytes;
  for (std::size_t r = 0; r < ids.size(); ++r) {
    if (ids[r].empty()) continue;
    destinations.push_back(static_cast<int>(r));
    put_values(bytes.emplace_back(), ids[r]);
  }
  return {exchange.connect(std::move(destinations)), std::move(bytes)};
}

/// The owners of the ids that this rank keeps, ascending.
std::vector<Owner> gather_owners(Exchange& exchange, const std::string& what, std::span<const std::int64_t> owned) {
  auto [graph, bytes] = messages(exchange, by_keeper(owned, exchange.size()));
  std::vector<Owner> owners;
  const std::vector<Bytes> received = graph->exchange(std::move(bytes));
  for (std::size_t i = 0; i < received.size(); ++i)
    for (const std::int64_t id : values_of<std::int64_t>(received[i])) owners.emplace_back(id, graph->sources()[i]);
  std::ranges::sort(owners);
  run_on_all(exchange, "mesh", [&] {
    const auto twice = std::ranges::adjacent_find(owners, {}, &Owner::first);
    if (twice == owners.end()) return;
    const int first = twice->second, second = (twice + 1)->second;
    throw RankError(first == second ? fmt::format("mesh: {} id {} is given twice by rank {}", what, twice->first, first)
                                    : fmt::format("mesh: {} id {} is given by rank {} and by rank {}", what,
                                                  twice->first, first, second));
  });
  return owners;
}

}  // namespace

std::vector<int> find_owners(Exchange& exchange, const std::string& what, std::span<const std::int64_t> owned,
                             std::span<const std::int64_t> asked) {
  const std::vector<Owner> owners = gather_owners(exchange, what, owned);
  auto [questions, bytes] = messages(exchange, by_keeper(asked, exchange.size()));
  const std::vector<Bytes> received = questions->exchange(std::move(bytes));
  std::vector<Bytes> answers;
  for (const Bytes& ids : received) {
    Bytes& answer = answers.emplace_back();
    for (const std::int64_t id : values_of<std::int64_t>(ids)) {
      const auto at = std::ranges::lower_bound(owners, id, {}, &Owner::first);
      put(answer, at != owners.end() && at->first == id ? at->second : kNoRank);
    }
  }
  const auto sources = questions->sources();
  const auto replies = exchange.connect({sources.begin(), sources.end()});
  std::vector<std::vector<int>> found(static_cast<std::size_t>(exchange.size()));
  const std::vector<Bytes> given = replies->exchange(std::move(answers));
  for (std::size_t i = 0; i < given.size(); ++i)
    found[static_cast<std::size_t>(replies->sources()[i])] = values_of<int>(given[i]);
  std::vector<int> result;
  std::vector<std::size_t> next(found.size(), 0);
  for (const std::int64_t id : asked) {
    const std::size_t keeper = keeper_of(id, exchange.size());
    result.push_back(found[keeper][next[keeper]++]);
  }
  return result;
}

IdTable::IdTable(std::span<const std::int64_t> ids) {
  entries_.reserve(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) entries_.emplace_back(ids[i], static_cast<Index>(i));
  std::ranges::sort(entries_);
}

Index IdTable::find(std::int64_t id) const {
  const auto at = std::ranges::lower_bound(entries_, id, {}, &std::pair<std::int64_t, Index>::first);
  return at != entries_.end() && at->first == id ? at->second : kNone;
}

}  // namespace volccd::distributed::detail
