#include <volccd/core/executor.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace volccd {

namespace {

unsigned thread_count(unsigned threads) {
  return threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
}

/// At most n, so that sums of indices and grains do not overflow.
std::size_t fitting_grain(std::size_t grain, std::size_t n) {
  return std::clamp<std::size_t>(grain, 1, std::max<std::size_t>(n, 1));
}

class TbbExecutor final : public Executor {
 public:
  explicit TbbExecutor(unsigned threads)
      : limit_(tbb::global_control::max_allowed_parallelism, threads), arena_(static_cast<int>(threads)) {}

  unsigned workers() const override { return static_cast<unsigned>(arena_.max_concurrency()); }

  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    grain = fitting_grain(grain, n);
    const std::size_t chunks = n / grain + (n % grain != 0 ? 1 : 0);
    arena_.execute([&] {
      tbb::parallel_for(
          tbb::blocked_range<std::size_t>(0, chunks, 1),
          [&](const tbb::blocked_range<std::size_t>& range) {
            const unsigned worker = static_cast<unsigned>(tbb::this_task_arena::current_thread_index());
            for (std::size_t c = range.begin(); c != range.end(); ++c)
              body(c * grain, std::min(n, (c + 1) * grain), worker);
          },
          tbb::simple_partitioner());
    });
  }

 private:
  tbb::global_control limit_;  ///< lets an arena have more threads than the machine has cores, as was asked for
  tbb::task_arena arena_;
};

/// One generation of work at a time; idle threads wait on a condition variable.
class ThreadExecutor final : public Executor {
 public:
  explicit ThreadExecutor(unsigned threads) : workers_(threads) {
    for (unsigned w = 1; w < threads; ++w) threads_.emplace_back([this, w] { serve(w); });
  }

  ~ThreadExecutor() override {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  unsigned workers() const override { return workers_; }

  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    {
      const std::lock_guard lock(mutex_);
      body_ = &body;
      n_ = n;
      grain_ = fitting_grain(grain, n);
      next_ = 0;
      error_ = nullptr;
      busy_ = workers_;
      ++generation_;
    }
    wake_.notify_all();
    drain(0);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return busy_ == 0; });
    if (error_) std::rethrow_exception(error_);
  }

 private:
  void serve(unsigned worker) {
    std::size_t seen = 0;
    for (;;) {
      {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, [&] { return stop_ || generation_ != seen; });
        if (stop_) return;
        seen = generation_;
      }
      drain(worker);
    }
  }

  void drain(unsigned worker) {
    try {
      for (;;) {
        const std::size_t begin = next_.fetch_add(grain_);
        if (begin >= n_) break;
        (*body_)(begin, std::min(n_, begin + grain_), worker);
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_) error_ = std::current_exception();
      next_ = n_;
    }
    const std::lock_guard lock(mutex_);
    if (--busy_ == 0) done_.notify_one();
  }

  const unsigned workers_;
  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  bool stop_ = false;
  std::size_t generation_ = 0, n_ = 0, grain_ = 1;
  std::atomic<std::size_t> next_{0};
  unsigned busy_ = 0;
  Body* body_ = nullptr;
  std::exception_ptr error_;
};

}  // namespace

void SerialExecutor::parallel_for(std::size_t n, std::size_t grain, Body body) {
  grain = fitting_grain(grain, n);
  for (std::size_t begin = 0; begin < n; begin += grain) body(begin, std::min(n, begin + grain), 0);
}

std::unique_ptr<Executor> make_executor(unsigned threads) {
  threads = thread_count(threads);
  if (threads == 1) return std::make_unique<SerialExecutor>();
  return std::make_unique<TbbExecutor>(threads);
}

std::unique_ptr<Executor> make_thread_executor(unsigned threads) {
  return std::make_unique<ThreadExecutor>(thread_count(threads));
}

}  // namespace volccd
