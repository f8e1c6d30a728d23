// A loop over steps that can be interrupted and keeps the results of complete steps.
#pragma once

#include <cstdio>
#include <string>

#include <volccd/core/function_ref.hpp>
#include <volccd/io/step_text.hpp>
#include <volccd/program/query_options.hpp>

namespace volccd {

/// Calls `work`, which counts complete steps in `steps.done`. If it throws Interrupted, another Error or
/// std::bad_alloc, the reason is stored in steps.stopped_by. If no step is complete, the exception is thrown again; the
/// message of an Interrupted then says so.
void keep_complete_steps(StepsDone& steps, FunctionRef<void()> work);

/// Calls work(k) for each k of `range`, with progress ("detecting: 3 of 8 steps"). Ctrl-C, an error and
/// insufficient memory end the loop by the rules above, and the present step is discarded. Requires an InterruptGuard.
StepsDone run_steps(const std::string& title, StepRange range, FunctionRef<void(int)> work);

/// Exit code: 0 if all steps are complete, 130 after Ctrl-C, otherwise 2.
int exit_code(const StepsDone& steps);

/// Prints "incomplete: steps ..." on `report`, unless it is null, and on stderr. Prints nothing if all steps are
/// complete.
void print_incomplete(const StepsDone& steps, std::FILE* report);

}  // namespace volccd
