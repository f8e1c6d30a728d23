// Work on one step after another that can be stopped, and keeps what is complete.
#pragma once

#include <cstdio>
#include <string>

#include <volccd/core/function_ref.hpp>
#include <volccd/core/step_text.hpp>
#include <volccd/program/query_options.hpp>

namespace volccd {

/// Calls `work`, which counts in `steps.done`. An Interrupted, another Error or std::bad_alloc that it throws ends up
/// in steps.stopped_by; where no step is complete, it is thrown on, an Interrupted with a message that says so.
void keep_complete_steps(StepsDone& steps, FunctionRef<void()> work);

/// Calls work(k) for each k of `range`, with progress ("detecting: 3 of 8 steps"). Ctrl-C, an error, and memory that
/// does not suffice end it by the rules above: work on that step is abandoned. To be called under an InterruptGuard.
StepsDone run_steps(const std::string& title, StepRange range, FunctionRef<void(int)> work);

/// 0 for complete ones, 130 after Ctrl-C, else 2.
int exit_code(const StepsDone& steps);

/// "incomplete: steps ..." on `report`, unless it is null, and on stderr; nothing if they are complete.
void print_incomplete(const StepsDone& steps, std::FILE* report);

}  // namespace volccd
