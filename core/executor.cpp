#include <volccd/core/executor.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <latch>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

unsigned thread_count(unsigned threads) {
  if (threads > kMaxThreads)
    throw ConfigError(
        fmt::format("threads: {} is more than {}; 0 takes as many as the machine has", threads, kMaxThreads));
  return threads != 0 ? threads : std::clamp(std::thread::hardware_concurrency(), 1u, kMaxThreads);
}

[[noreturn]] void refuse_thread(std::size_t made, std::size_t wanted, const std::system_error& error) {
  throw ConfigError(
      fmt::format("threads: the system refused thread {} of {} ({}); ask for fewer, or raise the limit on "
                  "the user's processes (ulimit -u)",
                  made + 2, wanted + 1, error.code().message()));
}

/// Creates `count` threads that exist at the same time, and ends them. Throws ConfigError if the system refuses one.
void try_threads(std::size_t count) {
  std::latch done(1);
  std::vector<std::jthread> threads;
  threads.reserve(count);
  try {
    while (threads.size() < count) threads.emplace_back([&done] { done.wait(); });
  } catch (const std::system_error& error) {
    done.count_down();
    refuse_thread(threads.size(), count, error);
  } catch (...) {
    done.count_down();
    throw;
  }
  done.count_down();
}

/// The grain, limited to n, so that sums of indices and grains do not overflow.
std::size_t fitting_grain(std::size_t grain, std::size_t n) {
  return std::clamp<std::size_t>(grain, 1, std::max<std::size_t>(n, 1));
}

class TbbExecutor final : public Executor {
 public:
  explicit TbbExecutor(unsigned threads) : arena_(static_cast<int>(threads)) {}

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
  tbb::task_arena arena_;
};

/// Runs one parallel_for() at a time; idle threads wait on a condition variable.
class ThreadExecutor final : public Executor {
 public:
  explicit ThreadExecutor(unsigned threads) : workers_(threads) {
    threads_.reserve(threads - 1);
    try {
      for (unsigned w = 1; w < threads; ++w) threads_.emplace_back([this, w] { serve(w); });
    } catch (const std::system_error& error) {
      end_threads();
      refuse_thread(threads_.size(), threads - 1, error);
    } catch (...) {
      end_threads();
      throw;
    }
  }

  ~ThreadExecutor() override { end_threads(); }

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
  void end_threads() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

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

Executor& serial_executor() {
  static SerialExecutor executor;
  return executor;
}

std::unique_ptr<Executor> make_executor(unsigned threads) {
  threads = thread_count(threads);
  // More slots than allowed threads would cause a warning of oneTBB.
  const std::size_t allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  threads = static_cast<unsigned>(std::min<std::size_t>(threads, allowed));
  if (threads <= 1) return std::make_unique<SerialExecutor>();
  try_threads(threads - 1);
  return std::make_unique<TbbExecutor>(threads);
}

std::unique_ptr<Executor> make_thread_executor(unsigned threads) {
  return std::make_unique<ThreadExecutor>(thread_count(threads));
}

}  // namespace volccd
