#include <volccd/distributed/agreement.hpp>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <vector>

#include <fmt/format.h>

namespace volccd::distributed {

RankError::RankError(int rank, int ranks, const std::string& where, const std::string& problem)
    : Error(fmt::format("rank {} of {}: {}: {}", rank, ranks, where, problem)) {}

std::string problem_of(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error)) return "out of memory";
  return error.what();
}

void run_on_all(Exchange& exchange, const char* where, FunctionRef<void()> work, std::span<std::uint64_t> maxima) {
  std::string problem;
  try {
    work();
  } catch (const RankError& error) {
    problem = error.what();
  } catch (const std::exception& error) {
    problem = RankError(exchange.rank(), exchange.size(), where, problem_of(error)).what();
  }
  std::vector<std::uint64_t> values{problem.empty() ? 0u : 1u};
  values.insert(values.end(), maxima.begin(), maxima.end());
  exchange.allreduce(values, Reduction::max);
  if (values[0] != 0) {
    for (const Bytes& text : exchange.allgather(to_bytes(problem)))
      if (!text.empty()) throw RankError(text_of(text));
  }
  std::copy(values.begin() + 1, values.end(), maxima.begin());
}

void require_same(Exchange& exchange, const std::string& what, const std::string& text) {
  const std::vector<Bytes> all = exchange.allgather(to_bytes(text));
  for (std::size_t r = 1; r < all.size(); ++r)
    if (all[r] != all[0])
      throw RankError(fmt::format("the {} must be the same on all ranks: rank 0 has {}; rank {} has {}", what,
                                  text_of(all[0]), r, text_of(all[r])));
}

}  // namespace volccd::distributed
