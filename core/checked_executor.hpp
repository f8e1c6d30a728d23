// Threads whose floating-point environment is the standard one.
#pragma once

#include <volccd/core/executor.hpp>
#include <volccd/core/floating_point.hpp>

namespace volccd {

/// Wraps another executor whose threads must have the standard floating-point environment. The environment belongs to a
/// thread, hence it is checked once per chunk. parallel_for() throws ConfigError if a thread has a different one.
class CheckedExecutor final : public Executor {
 public:
  explicit CheckedExecutor(Executor& executor) : executor_(executor) {}

  unsigned workers() const override { return executor_.workers(); }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    executor_.parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned worker) {
      require_standard_floating_point();
      body(begin, end, worker);
    });
  }

 private:
  Executor& executor_;
};

}  // namespace volccd
