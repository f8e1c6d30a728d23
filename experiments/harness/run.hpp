// The harness: runs the plan of an experiment and writes its record.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/harness/plan.hpp>
#include <volccd/experiments/records/record_file.hpp>

namespace volccd {

/// Runs the windows of the plan that are not in the record yet, and adds their rows, window by window. If the rounds
/// are divided among several processes, it runs those of the first process for which windows are missing. Returns
/// whether the record has all windows of all processes; if not, it is for another process to call this again.
///
/// Each round of a window runs forward from its start: first the step before the window with all entrants, without
/// measuring, so that their states are those of the step before, and a topology edit is measured in every round; then
/// all entrants on each step of the window, in an order that shifts by one from round to round. For a window that
/// begins with step 0, that step itself is run unmeasured first. Every entrant keeps its workspace through the windows
/// of a run. The time of its very first step is a column of its own (`first_seconds`).
///
/// If a step took more than three times the fastest of its rounds, and a millisecond more, the window is measured
/// again, up to twice, and the faster row takes the place of the stalled one, which keeps the replaced time
/// (`stalled_seconds`). The rounds of one process are judged together.
///
/// A row is one (scene, step, entrant, round); its columns are in docs/record.schema.json. `progress(done, total)`
/// counts measured runs, and may throw to stop; rows already in the record are kept. Throws the exceptions of the
/// reader and of the pipelines.
bool run_experiment(const Registry& registry, const ExperimentPlan& plan, Executor& executor, RecordFile& record,
                    const std::function<void(std::size_t done, std::size_t total)>& progress = {});

/// Compares the contacts of the entrants of each run. Entrants with the same narrow phase must find the same contacts,
/// bit for bit, if none of their other stages is approximate; those on the boundary alone are not compared. Returns a
/// line for each entrant that differs from the first one, with the first such step. The usual cause are undecided
/// tests, which the narrow phase reports unless a filter proves them apart. `rows`: all rows of a record of this plan.
std::vector<std::string> contact_differences(const Registry& registry, const ExperimentPlan& plan,
                                             const std::vector<nlohmann::json>& rows);

/// The provenance of the rows: build (with a hash of the program), machine, load, the plan with all options, and hashes
/// of the input files. Throws InputError for a file that cannot be read.
nlohmann::json provenance(const ExperimentPlan& plan, const Executor& executor);

/// The parts of a provenance that two runs have in common if their rows may stand in one record: plan, threads, commit,
/// program, compiler, flags, CPU and inputs.
nlohmann::json identity_of(const nlohmann::json& provenance);

/// The record in the file if it is complete and has this identity; nothing if it is another one, not readable, or not
/// there.
std::optional<nlohmann::json> complete_record(const std::string& file, const nlohmann::json& identity);

}  // namespace volccd
