// Ranks in one process, for tests and measurements.
#pragma once

#include <memory>

#include <volccd/core/function_ref.hpp>
#include <volccd/distributed/exchange.hpp>

namespace volccd::distributed {

/// N ranks, each a thread of this process during run(). Only one of them computes at a time: it goes on until it waits
/// in an operation of its exchange, and then the next one does, in ascending order. So a rank may use all workers of an
/// executor that the ranks share, and its times are those of a rank that has the machine for itself.
class InProcessRanks {
 public:
  /// Throws ConfigError for less than one rank.
  explicit InProcessRanks(int ranks);
  ~InProcessRanks();
  InProcessRanks(InProcessRanks&&) noexcept;
  InProcessRanks& operator=(InProcessRanks&&) noexcept;

  int size() const;

  /// Calls body(exchange) once for each rank. Exchanges and their neighbourhoods are the same in later runs.
  ///
  /// If a body throws, those of the other ranks are ended at the operation in which they wait, or at the next one (by
  /// an exception that is no std::exception), and the run throws a RankError that names the rank, the problem, and the
  /// last operation of the rank; a RankError is thrown on as it is. The same happens if a rank ends, or calls another
  /// operation, while others wait for it. Throws ConfigError if the system refuses the threads.
  void run(FunctionRef<void(Exchange& exchange)> body);

 private:
  class Hub;
  class Rank;
  class Graph;
  std::unique_ptr<Hub> hub_;
};

}  // namespace volccd::distributed
