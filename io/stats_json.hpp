// stats.json, the statistics of a run.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

/// Build and machine, on which the times depend: version, commit, compiler, build type, CPU, cores, those that this
/// process may run on, kernel, load average of the last minute, date (UTC).
nlohmann::json machine_facts();

/// The stages of a pipeline with their options, and its guarantee.
nlohmann::json to_json(const Pipeline& pipeline);
/// The stages of a pipeline by role, with the options that the spec has.
nlohmann::json to_json(const PipelineSpec& spec);

/// Counts, earliest_toi (null without contacts), seconds, and for each stage: role, name, in, out, seconds.
nlohmann::json to_json(const Statistics& statistics);

/// Reads a JSON file; null if `path` is empty. Throws InputError.
nlohmann::json read_json_file(const std::string& path);

}  // namespace volccd
