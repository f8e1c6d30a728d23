// An executor that is interrupted.
#pragma once

#include <stdexcept>

#include <volccd/core/executor.hpp>

namespace volccd {

/// Ends in one of its loops, after the work, as Ctrl-C does.
class EndsInLoop final : public Executor {
 public:
  explicit EndsInLoop(int loop) : left_(loop) {}
  unsigned workers() const override { return 1; }
  void parallel_for(std::size_t n, std::size_t, Body body) override {
    if (n > 0) body(0, n, 0);
    if (left_-- == 0) throw std::runtime_error("interrupted");
  }

 private:
  int left_;
};

}  // namespace volccd
