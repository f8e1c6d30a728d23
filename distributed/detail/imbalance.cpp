#include <volccd/distributed/detail/imbalance.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/distributed/detail/bytes.hpp>

namespace volccd::distributed::detail {

namespace {
constexpr int kMaxPatience = 1 << 20;
}

void Imbalance::add_step(Exchange& exchange, double seconds, std::uint64_t elements) {
  if (std::isinf(max_ratio_) || exchange.size() == 1) return;
  const auto nanoseconds = static_cast<std::uint64_t>(1e9 * std::max(0.0, seconds));
  std::uint64_t slowest = nanoseconds, sum = nanoseconds;
  exchange.allreduce({&slowest, 1}, Reduction::max);
  exchange.allreduce({&sum, 1}, Reduction::sum);
  seconds_ += seconds;
  elements_ += static_cast<double>(elements);
  const double mean = static_cast<double>(sum) / exchange.size();
  slow_steps_ = static_cast<double>(slowest) > max_ratio_ * mean ? slow_steps_ + 1 : 0;
}

void Imbalance::cuts_made() {
  if (wants_cuts()) patience_ = std::min(2 * patience_, kMaxPatience);
  slow_steps_ = 0;
  seconds_ = elements_ = 0;
}

std::vector<double> Imbalance::density(Exchange& exchange) const {
  Bytes mine;
  put(mine, seconds_ / std::max(1.0, elements_));
  std::vector<double> result;
  for (const Bytes& bytes : exchange.allgather(std::move(mine))) result.push_back(Reader(bytes).get<double>());
  return result;
}

}  // namespace volccd::distributed::detail
