#include <atomic>
#include <chrono>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <volccd/core/error.hpp>
#include <volccd/core/executor.hpp>

namespace volccd {
namespace {

struct Maker {
  std::string name;
  std::unique_ptr<Executor> (*make)(unsigned);
  unsigned threads;
};

unsigned max_of_tbb() {
  return static_cast<unsigned>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void PrintTo(const Maker& maker, std::ostream* out) { *out << maker.name << maker.threads; }

// All executors satisfy the same contract. ThreadSanitizer can judge the instances named Threads.
class ExecutorContract : public testing::TestWithParam<Maker> {
 protected:
  std::unique_ptr<Executor> executor_ = GetParam().make(GetParam().threads);
};

INSTANTIATE_TEST_SUITE_P(Production, ExecutorContract,
                         testing::Values(Maker{"serial", make_executor, 1}, Maker{"tbb", make_executor, 2},
                                         Maker{"tbb", make_executor, 4}),
                         testing::PrintToStringParamName());
INSTANTIATE_TEST_SUITE_P(Threads, ExecutorContract,
                         testing::Values(Maker{"pool", make_thread_executor, 1}, Maker{"pool", make_thread_executor, 2},
                                         Maker{"pool", make_thread_executor, 5}),
                         testing::PrintToStringParamName());

TEST_P(ExecutorContract, ReportsTheThreadsAskedFor) {
  unsigned threads = GetParam().threads;
  if (GetParam().make == make_executor) threads = std::min(threads, max_of_tbb());
  EXPECT_EQ(executor_->workers(), threads);
}

TEST_P(ExecutorContract, ChunksCoverEachIndexOnce) {
  for (const std::size_t n : {0u, 1u, 2u, 7u, 64u, 1000u})
    for (const std::size_t grain : std::vector<std::size_t>{0, 1, 3, 64, 5000, SIZE_MAX / 2 + 1, SIZE_MAX}) {
      std::vector<std::atomic<int>> visits(n);
      std::atomic<int> bad_chunks = 0;
      executor_->parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned worker) {
        const bool good =
            begin < end && end <= n && end - begin <= std::max<std::size_t>(grain, 1) && worker < executor_->workers();
        if (!good) ++bad_chunks;
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      EXPECT_EQ(bad_chunks, 0) << n << " indices, grain " << grain;
      for (std::size_t i = 0; i < n; ++i)
        ASSERT_EQ(visits[i], 1) << "index " << i << " of " << n << ", grain " << grain;
    }
}

TEST_P(ExecutorContract, ConcurrentChunksHaveDifferentWorkers) {
  std::vector<std::atomic<bool>> busy(executor_->workers());
  std::atomic<int> clashes = 0;
  executor_->parallel_for(400, 1, [&](std::size_t, std::size_t, unsigned worker) {
    if (busy[worker].exchange(true)) ++clashes;
    std::this_thread::yield();
    busy[worker] = false;
  });
  EXPECT_EQ(clashes, 0);
}

// Uses buffers for each worker without locks and merges them afterwards, as stages do. ThreadSanitizer checks that the
// executor orders the chunks of one worker, and the caller after all of them.
TEST_P(ExecutorContract, ResultsDoNotDependOnTheExecutor) {
  constexpr std::size_t n = 5000;
  std::vector<std::uint64_t> values(n), sums(executor_->workers());
  for (int round = 0; round < 20; ++round) {
    executor_->parallel_for(n, 13, [&](std::size_t begin, std::size_t end, unsigned worker) {
      for (std::size_t i = begin; i < end; ++i) {
        values[i] = values[i] * 31 + i;
        sums[worker] += values[i];
      }
    });
  }
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    std::uint64_t value = 0;
    for (int round = 0; round < 20; ++round) {
      value = value * 31 + i;
      sum += value;
    }
    ASSERT_EQ(values[i], value) << i;
  }
  EXPECT_EQ(std::accumulate(sums.begin(), sums.end(), std::uint64_t{0}), sum);
}

TEST_P(ExecutorContract, ManyShortLoopsFinish) {
  std::size_t done = 0;
  std::atomic<std::size_t> chunks = 0;
  for (std::size_t loop = 0; loop < 3000; ++loop) {
    executor_->parallel_for(loop % 4, 1, [&](std::size_t, std::size_t, unsigned) { ++chunks; });
    done += loop % 4;
  }
  EXPECT_EQ(chunks, done);
}

TEST_P(ExecutorContract, ExceptionReachesTheCallerAndTheExecutorLives) {
  for (const std::size_t thrower : {0u, 17u, 99u}) {
    std::string caught;
    try {
      executor_->parallel_for(100, 1, [&](std::size_t begin, std::size_t, unsigned) {
        if (begin == thrower) throw std::out_of_range("chunk " + std::to_string(begin));
      });
    } catch (const std::out_of_range& error) {
      caught = error.what();
    }
    EXPECT_EQ(caught, "chunk " + std::to_string(thrower));

    std::atomic<std::size_t> visits = 0;
    executor_->parallel_for(100, 7, [&](std::size_t begin, std::size_t end, unsigned) { visits += end - begin; });
    EXPECT_EQ(visits, 100u) << "after an exception";
  }
}

TEST_P(ExecutorContract, OneOfManyExceptionsReachesTheCaller) {
  for (int round = 0; round < 50; ++round)
    EXPECT_THROW(
        executor_->parallel_for(64, 1, [](std::size_t, std::size_t, unsigned) { throw std::runtime_error("all"); }),
        std::runtime_error);
}

TEST(Executor, SerialRunsInOrder) {
  SerialExecutor executor;
  std::vector<std::size_t> begins;
  executor.parallel_for(10, 4, [&](std::size_t begin, std::size_t, unsigned) { begins.push_back(begin); });
  EXPECT_EQ(begins, (std::vector<std::size_t>{0, 4, 8}));
}

TEST(Executor, ZeroThreadsTakesTheHardwares) {
  const unsigned hardware = std::max(1u, std::thread::hardware_concurrency());
  EXPECT_EQ(make_executor(0)->workers(), std::min(hardware, max_of_tbb()));
  EXPECT_EQ(make_thread_executor(0)->workers(), hardware);
}

TEST(Executor, TheNumberOfThreadsIsBounded) {
  for (const auto make : {make_executor, make_thread_executor})
    for (const unsigned threads : {kMaxThreads + 1, 100000u, ~0u}) {
      try {
        make(threads);
        ADD_FAILURE() << threads << " threads were taken";
      } catch (const ConfigError& error) {
        EXPECT_EQ(error.what(),
                  "threads: " + std::to_string(threads) + " is more than 1024; 0 takes as many as the machine has");
      }
    }
  EXPECT_GE(make_executor(kMaxThreads)->workers(), 1u);
}

TEST(Executor, DoesNotLimitWhatTheProgramItselfDoesWithTbb) {
  const unsigned before = max_of_tbb();
  const auto less = make_executor(2), more = make_executor(before + 7);
  EXPECT_EQ(max_of_tbb(), before);
  // The limit that the host program has set is used.
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 3);
  EXPECT_EQ(make_executor(5)->workers(), 3u);
  EXPECT_EQ(make_executor(2)->workers(), 2u);
}

constexpr int kRefused = 3, kMade = 4, kCannotLimit = 5;

/// For a child process: makes an executor as a user who may have `limit` threads (root may have any number).
void make_under_limit(std::unique_ptr<Executor> (*make)(unsigned), unsigned threads, rlim_t limit) {
  constexpr unsigned kNobody = 65534;
  if (geteuid() == 0 && (setgid(kNobody) != 0 || setuid(kNobody) != 0)) _exit(kCannotLimit);
  const rlimit processes{limit, limit};
  if (setrlimit(RLIMIT_NPROC, &processes) != 0) _exit(kCannotLimit);
  try {
    make(threads);
  } catch (const ConfigError& error) {
    std::fputs(error.what(), stderr);
    _exit(kRefused);
  }
  _exit(kMade);
}

TEST(ExecutorDeathTest, AThreadThatTheSystemRefusesIsAnError) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  // Makes a pool, and an arena that needs a thread beside the calling one. The limit is for all processes of the user,
  // so that an unknown, smaller number of threads can be made.
  struct {
    std::unique_ptr<Executor> (*make)(unsigned);
    unsigned threads;
    rlim_t limit;
  } const cases[] = {{make_thread_executor, 2, 1}, {make_thread_executor, 300, 60}, {make_executor, 2, 1}};
  for (const auto& c : cases) {
    if (c.make == make_executor && max_of_tbb() < 2) continue;
    int code = -1;
    const auto exited = [&code](int status) {
      code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      return code != -1;
    };
    EXPECT_EXIT(make_under_limit(c.make, c.threads, c.limit), exited, "");
    if (code == kCannotLimit) GTEST_SKIP() << "this user cannot limit the number of threads";
    EXPECT_EQ(code, kRefused) << c.threads << " threads under a limit of " << c.limit;
    EXPECT_EXIT(make_under_limit(c.make, c.threads, c.limit), exited,
                "threads: the system refused thread [0-9]+ of " + std::to_string(c.threads) + " .*ulimit -u");
  }
}

TEST(ExecutorThreads, ChunksRunAtTheSameTime) {
  const auto executor = make_thread_executor(2);
  std::atomic<int> arrived = 0;
  std::atomic<bool> met = true;
  executor->parallel_for(2, 1, [&](std::size_t, std::size_t, unsigned) {
    ++arrived;
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (arrived < 2 && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
    if (arrived < 2) met = false;
  });
  EXPECT_TRUE(met) << "each chunk waits for the other: one thread alone cannot finish them";
}

}  // namespace
}  // namespace volccd
