#include <volccd/program/step_loop.hpp>

#include <new>

#include <fmt/format.h>

#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>

namespace volccd {

void keep_complete_steps(StepsDone& steps, FunctionRef<void()> work) {
  try {
    work();
  } catch (const Interrupted&) {
    if (steps.done == steps.begin) throw Interrupted("interrupted before the first step was complete: no result");
    steps.stopped_by = kStoppedByUser;
  } catch (const Error& error) {
    if (steps.done == steps.begin) throw;
    steps.stopped_by = error.what();
  } catch (const std::bad_alloc&) {
    if (steps.done == steps.begin) throw;
    steps.stopped_by = "out of memory";
  }
}

StepsDone run_steps(const std::string& title, StepRange range, FunctionRef<void(int)> work) {
  StepsDone steps{range.begin, range.begin, range.end};
  Progress progress(title, static_cast<std::size_t>(range.end - range.begin), "steps");
  keep_complete_steps(steps, [&] {
    while (steps.done < range.end) {
      InterruptGuard::check();
      work(steps.done);
      ++steps.done;
      progress.advance(static_cast<std::size_t>(steps.done - range.begin));
    }
  });
  return steps;
}

int exit_code(const StepsDone& steps) {
  if (steps.complete()) return kDone;
  return steps.stopped_by == kStoppedByUser ? kInterrupted : kBadInput;
}

void print_incomplete(const StepsDone& steps, std::FILE* report) {
  if (steps.complete()) return;
  if (report) fmt::print(report, "\nincomplete: {}\n", steps.text());
  if (report != stderr) fmt::print(stderr, "volccd: incomplete: {}\n", steps.text());
}

}  // namespace volccd
