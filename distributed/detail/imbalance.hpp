// Whether ranks should divide space anew, by measured times.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/distributed/exchange.hpp>

namespace volccd::distributed::detail {

/// Adds up the times of the ranks since the last cuts.
class Imbalance {
 public:
  explicit Imbalance(double max_ratio) : max_ratio_(max_ratio) {}

  /// Collective, unless the ratio is infinite.
  void add_step(Exchange& exchange, double seconds, std::uint64_t elements);
  /// The same on all ranks.
  bool wants_cuts() const { return slow_steps_ >= patience_; }
  void cuts_made();

  /// Seconds of an element in the piece of each rank, by rank. Collective.
  std::vector<double> density(Exchange& exchange) const;

 private:
  double max_ratio_;
  int slow_steps_ = 0;  ///< consecutive ones
  int patience_ = 3;    ///< doubled with each cut, because some imbalance remains with all cuts
  double seconds_ = 0;  ///< of this rank since the last cuts
  double elements_ = 0;
};

}  // namespace volccd::distributed::detail
