// Threads. Stages receive an executor and never create threads themselves.
#pragma once

#include <cstddef>
#include <memory>

#include <volccd/core/function_ref.hpp>

namespace volccd {

/// Runs chunks of an index range. The body must not depend on which worker runs a chunk, nor on the order of the
/// chunks: its output is either indexed by the chunk, or merged and sorted into canonical order afterwards (invariant
/// 5: the output is the same for any number of threads).
class Executor {
 public:
  using Body = FunctionRef<void(std::size_t begin, std::size_t end, unsigned worker)>;

  virtual ~Executor() = default;

  /// Number of workers. `worker` in the body is less than this number; chunks that run at the same time have different
  /// workers.
  virtual unsigned workers() const = 0;

  /// Calls body on disjoint chunks [begin, end) that cover [0, n), each of at most max(grain, 1) indices, and returns
  /// when all chunks are done. Rethrows the first exception that a body throws. Must not be called from inside a body.
  virtual void parallel_for(std::size_t n, std::size_t grain, Body body) = 0;
};

/// Runs all chunks on the calling thread, in ascending order, as worker 0.
class SerialExecutor final : public Executor {
 public:
  unsigned workers() const override { return 1; }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override;
};

/// A SerialExecutor for any thread: it has no state. The default of functions that need not run on several threads.
Executor& serial_executor();

/// Largest number of threads that a caller may request.
inline constexpr unsigned kMaxThreads = 1024;

/// The executor for production: serial for one thread, a oneTBB arena for more. `threads` = 0 takes the number of
/// hardware threads. An arena never has more threads than oneTBB allows in this process, which is the number of
/// hardware threads unless the program has set another limit with tbb::global_control; workers() is the smaller of the
/// two numbers. The program's own use of oneTBB is not limited by the arena.
///
/// Throws ConfigError if `threads` exceeds kMaxThreads, or if the system refuses to create that many threads now.
/// (oneTBB creates its threads in the first loop and terminates the program if the system refuses; therefore this
/// function first creates that many threads as a trial.)
std::unique_ptr<Executor> make_executor(unsigned threads);

/// A pool of exactly `threads` std::thread objects. It starts a chunk more slowly than oneTBB, but avoids the false
/// races that ThreadSanitizer reports inside a stock oneTBB. `threads` = 0 takes the number of hardware threads. Throws
/// ConfigError under the same conditions as make_executor().
std::unique_ptr<Executor> make_thread_executor(unsigned threads);

}  // namespace volccd
