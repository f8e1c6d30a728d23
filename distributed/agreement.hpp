// Errors and options on which all ranks agree.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <volccd/core/error.hpp>
#include <volccd/core/function_ref.hpp>
#include <volccd/distributed/exchange.hpp>

namespace volccd::distributed {

/// An error of one rank, or of several together, which all ranks throw with the same text: "rank 3 of 16: step: ...".
class RankError : public Error {
 public:
  /// `where`: the operation, such as "step".
  RankError(int rank, int ranks, const std::string& where, const std::string& problem);
  /// Of several ranks, which the text names.
  explicit RankError(const std::string& text) : Error(text) {}
};

/// Runs `work` on each rank. It calls no collective operation. If it throws a std::exception on some rank, all ranks
/// throw a RankError with the text of the lowest of them. Otherwise, `maxima` are replaced by their maxima over all
/// ranks. Collective; one reduction.
void run_on_all(Exchange& exchange, const char* where, FunctionRef<void()> work, std::span<std::uint64_t> maxima = {});

/// Throws a RankError that names two ranks if the text is not the same on all ranks. `what`: "options", for example.
/// Collective.
void require_same(Exchange& exchange, const std::string& what, const std::string& text);

/// The text that users read for an exception.
std::string problem_of(const std::exception& error);

}  // namespace volccd::distributed
