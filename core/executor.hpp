// Threads, in one place. A stage is handed an executor and never makes a thread of its own.
#pragma once

#include <cstddef>
#include <memory>

#include <volccd/core/function_ref.hpp>

namespace volccd {

/// Runs chunks of an index range. The body must not depend on which worker runs a chunk or in what order: whatever it
/// produces is either indexed by the chunk or merged and put in canonical order afterwards (invariant 5: same output
/// for any number of threads).
class Executor {
 public:
  using Body = FunctionRef<void(std::size_t begin, std::size_t end, unsigned worker)>;

  virtual ~Executor() = default;

  /// Number of workers; `worker` in the body is below it, and two chunks that run at the same time have different ones.
  virtual unsigned workers() const = 0;

  /// Calls body on disjoint chunks [begin, end) that cover [0, n), each of at most max(grain, 1) indices, and returns
  /// when all are done. The first exception of a body is rethrown here. Not to be called from inside a body.
  virtual void parallel_for(std::size_t n, std::size_t grain, Body body) = 0;
};

/// Everything on the calling thread, in order, worker 0.
class SerialExecutor final : public Executor {
 public:
  unsigned workers() const override { return 1; }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override;
};

/// Most threads that may be asked for.
inline constexpr unsigned kMaxThreads = 1024;

/// The executor for production: serial for one thread, an arena of oneTBB above. `threads` = 0 takes the hardware's
/// number. An arena never has more threads than oneTBB allows in this process, which is the hardware's number unless
/// the program has set another with tbb::global_control: workers() is the smaller of both. The program's own use of
/// oneTBB is not limited by it.
///
/// Throws ConfigError if `threads` exceeds kMaxThreads, or if the system refuses to make that many threads now. (oneTBB
/// makes its threads in the first loop and ends the program when it is refused; therefore as many are tried here.)
std::unique_ptr<Executor> make_executor(unsigned threads);

/// A pool of std::thread, exactly as many as asked for. Slower to start a chunk than oneTBB, but free of the false
/// races that ThreadSanitizer reports inside a stock oneTBB. `threads` = 0 takes the hardware's number. Throws
/// ConfigError as make_executor() does.
std::unique_ptr<Executor> make_thread_executor(unsigned threads);

}  // namespace volccd
