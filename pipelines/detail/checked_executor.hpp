// Looks at the floating-point environment of the threads that work.
#pragma once

#include <volccd/core/executor.hpp>
#include <volccd/core/floating_point.hpp>

namespace volccd::detail {

/// Another executor whose threads must have the standard floating-point environment: checked once a chunk, because a
/// thread's environment is its own. parallel_for() throws ConfigError if one has another.
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

}  // namespace volccd::detail
