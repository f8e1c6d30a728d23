#include <volccd/distributed/detail/imbalance.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/distributed/detail/bytes.hpp>

namespace volccd::distributed::detail {

namespace {

/// The greatest and the mean of the times of all ranks.
struct Times {
  double slowest, mean;
};

Times times_of(Exchange& exchange, double seconds) {
  const auto nanoseconds = static_cast<std::uint64_t>(1e9 * std::max(0.0, seconds));
  std::uint64_t slowest = nanoseconds, sum = nanoseconds;
  exchange.allreduce({&slowest, 1}, Reduction::max);
  exchange.allreduce({&sum, 1}, Reduction::sum);
  return {1e-9 * static_cast<double>(slowest), 1e-9 * static_cast<double>(sum) / exchange.size()};
}

}  // namespace

void Imbalance::add_step(Exchange& exchange, double seconds, double all_seconds, std::uint64_t elements,
                         bool after_cuts) {
  if (std::isinf(max_ratio_) || exchange.size() == 1) return;
  if (after_cuts) {
    price_ = factor_ * times_of(exchange, all_seconds).slowest;
    factor_ = std::max(1.0, 2 * factor_);
    lost_ = seconds_ = elements_ = 0;
    return;
  }
  const Times times = times_of(exchange, seconds);
  lost_ += std::max(0.0, times.slowest - max_ratio_ * times.mean);
  seconds_ += seconds;
  elements_ += static_cast<double>(elements);
}

std::vector<double> Imbalance::density(Exchange& exchange) const {
  Bytes mine;
  put(mine, seconds_ / std::max(1.0, elements_));
  std::vector<double> result;
  for (const Bytes& bytes : exchange.allgather(std::move(mine))) result.push_back(Reader(bytes).get<double>());
  return result;
}

}  // namespace volccd::distributed::detail
