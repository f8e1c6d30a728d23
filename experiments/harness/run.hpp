// The harness: runs an experiment's plan and fills its record.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/harness/plan.hpp>
#include <volccd/experiments/records/record_file.hpp>

namespace volccd {

/// Runs the windows of the plan that the record does not have, and adds their rows, a window at a time.
///
/// A round of a window goes to the motion before it first, with all entrants and without measuring, so that states are
/// up to the frame before and a topology edit falls into the measurement, in every round. Then it goes from motion to
/// motion: all entrants run on each, in an order that shifts by one from round to round. A window that begins with
/// motion 0 runs that motion unmeasured instead. Where a window of several motions has no edits, later rounds begin at
/// once: the state of its last motion is as near as that of the motion before. Every entrant keeps its workspace
/// through the windows of a run.
///
/// A row is one (scene, motion, entrant, round); its columns are in docs/reproducing.md. `progress(done, total)` counts
/// measured runs, and may throw to stop: what is in the record stays. Throws what reading and the pipelines throw.
void run_experiment(const Registry& registry, const ExperimentPlan& plan, Executor& executor, RecordFile& record,
                    const std::function<void(std::size_t done, std::size_t total)>& progress = {});

/// Entrants of a run that have the same narrow phase must find the same contacts, bit for bit, if none of their other
/// stages is approximate; those on the boundary alone are not compared. Returns a line for each that differs from the
/// first such entrant, with the first motion that shows it; `undecided` tests, which the narrow phase reports unless a
/// filter proves them apart, are the usual cause. Rows are all of a record of this plan.
std::vector<std::string> contact_differences(const Registry& registry, const ExperimentPlan& plan,
                                             const std::vector<nlohmann::json>& rows);

/// What a reader of the rows must know: build (with a hash of the program), machine, load, plan with all options, and
/// hashes of the input files. Throws InputError for a file that cannot be read.
nlohmann::json provenance(const ExperimentPlan& plan, const Executor& executor);

}  // namespace volccd
