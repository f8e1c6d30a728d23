// An executor that adds the time of its chunks to a stage.
#pragma once

#include <volccd/core/executor.hpp>
#include <volccd/pipelines/detail/workspace_data.hpp>

namespace volccd::detail {

/// Wraps another executor and adds the time of its chunks to the statistics of one stage, separately for each worker.
/// Idle time is not included.
class ChargedExecutor final : public Executor {
 public:
  ChargedExecutor(Executor& executor, std::span<const std::unique_ptr<WorkerScratch>> workers, std::size_t stage)
      : executor_(executor), workers_(workers), stage_(stage) {}

  unsigned workers() const override { return executor_.workers(); }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    const StageTimer caller(caller_clock_, in_parallel_);
    if (workers() == 1) {
      const StageTimer timer(workers_[0]->chain.clock(), workers_[0]->sums.stages[stage_].seconds);
      return executor_.parallel_for(n, grain, body);
    }
    executor_.parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned w) {
      WorkerScratch& worker = *workers_[w];
      const StageTimer timer(worker.chain.clock(), worker.sums.stages[stage_].seconds);
      body(begin, end, w);
    });
  }

  /// Wall-clock time spent in parallel_for().
  double in_parallel() const { return in_parallel_; }

 private:
  Executor& executor_;
  std::span<const std::unique_ptr<WorkerScratch>> workers_;
  std::size_t stage_;
  StageClock caller_clock_;
  double in_parallel_ = 0;
};

}  // namespace volccd::detail
