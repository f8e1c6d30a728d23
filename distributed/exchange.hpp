// What ranks tell each other: the only interface through which the ranks of a detector communicate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace volccd::distributed {

using Bytes = std::vector<std::byte>;

/// A text as bytes, and back.
inline Bytes to_bytes(std::string_view text) {
  const auto* const data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}
inline std::string text_of(const Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

enum class Reduction { min, max, sum };

/// Messages from each rank to some others, along a graph that is fixed when it is made (Exchange::connect).
class Neighbourhood {
 public:
  virtual ~Neighbourhood() = default;

  /// The ranks that this rank sends to, and those that it receives from; ascending.
  std::span<const int> destinations() const { return destinations_; }
  std::span<const int> sources() const { return sources_; }

  /// Sends messages[i], which may be empty, to destinations()[i]. Returns one message from each of sources(), in their
  /// order. Collective.
  virtual std::vector<Bytes> exchange(std::vector<Bytes> messages) = 0;

 protected:
  Neighbourhood(std::vector<int> destinations, std::vector<int> sources)
      : destinations_(std::move(destinations)), sources_(std::move(sources)) {}

 private:
  std::vector<int> destinations_, sources_;
};

/// One rank's view of all ranks. Every operation is collective: all ranks call the same operations in the same order.
/// Ranks run on machines with the same representation of numbers.
///
/// If a rank cannot go on, the operations of the others do not return; whoever made the exchange ends them: with an
/// exception (InProcessRanks), or by ending all processes (MpiExchange). run_on_all() reports an error to all ranks.
///
/// Not thread-safe: a rank calls from one thread at a time. Outlives its neighbourhoods.
class Exchange {
 public:
  virtual ~Exchange() = default;

  virtual int rank() const = 0;  ///< in 0 .. size() - 1
  virtual int size() const = 0;

  /// The graph in which this rank sends to `destinations`: distinct, ascending; it may be one of them.
  virtual std::unique_ptr<Neighbourhood> connect(std::vector<int> destinations) = 0;
  /// The bytes of all ranks, by rank. For small values: every rank receives all of them.
  virtual std::vector<Bytes> allgather(Bytes bytes) = 0;
  /// Replaces each value by the minimum, maximum or sum (modulo 2^64) of those of all ranks. The number of values is
  /// the same on all ranks.
  virtual void allreduce(std::span<std::uint64_t> values, Reduction reduction) = 0;
};

/// A message, and the rank from which it came.
struct Received {
  int source;
  Bytes bytes;
};

/// Sends by_rank[r] to each rank r for which it is not empty. Returns the messages for this rank, by ascending source.
/// Collective.
inline std::vector<Received> send_to_ranks(Exchange& exchange, std::vector<Bytes> by_rank) {
  std::vector<int> destinations;
  std::vector<Bytes> messages;
  for (std::size_t r = 0; r < by_rank.size(); ++r) {
    if (by_rank[r].empty()) continue;
    destinations.push_back(static_cast<int>(r));
    messages.push_back(std::move(by_rank[r]));
  }
  const auto graph = exchange.connect(std::move(destinations));
  std::vector<Bytes> bytes = graph->exchange(std::move(messages));
  std::vector<Received> received;
  for (std::size_t s = 0; s < bytes.size(); ++s) received.push_back({graph->sources()[s], std::move(bytes[s])});
  return received;
}

}  // namespace volccd::distributed
