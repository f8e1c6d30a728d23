// Whether ranks should divide space anew, by measured times.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/distributed/exchange.hpp>

namespace volccd::distributed::detail {

/// Adds up what the slowest rank costs the others, and what new cuts would cost.
class Imbalance {
 public:
  explicit Imbalance(double max_ratio) : max_ratio_(max_ratio) {}

  /// `seconds`: of this rank's pipeline; `all_seconds`: with its boxes, lists and piece. `after_cuts`: the first step
  /// with its regions, the same on all ranks; its time is the price of cuts. Collective, unless the ratio is infinite.
  void add_step(Exchange& exchange, double seconds, double all_seconds, std::uint64_t elements, bool after_cuts);
  /// Whether the steps since the last cuts have lost their price: the time of the slowest rank beyond max_ratio times
  /// the mean. So cuts that gain nothing cost at most as much as what they were made for; and as some imbalance remains
  /// with all cuts, the price is doubled with each. The first cuts, made without times, are replaced for a 16th.
  /// The same on all ranks.
  bool needs_cuts() const { return lost_ > price_; }

  /// Seconds of an element in the piece of each rank, by rank. Collective.
  std::vector<double> density(Exchange& exchange) const;

 private:
  double max_ratio_;
  double lost_ = 0, price_ = 0;
  double factor_ = 1.0 / 16;  ///< of the price
  double seconds_ = 0;        ///< of this rank since the last cuts
  double elements_ = 0;
};

}  // namespace volccd::distributed::detail
