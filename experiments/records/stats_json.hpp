// stats.json: the record of a run.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

/// What the figures depend on: version, commit, compiler, build type, CPU, cores, date (UTC).
nlohmann::json machine_facts();

/// Stages with their options, and the guarantee.
nlohmann::json to_json(const Pipeline& pipeline);
/// The stages of a pipeline by role, with the options that the spec has.
nlohmann::json to_json(const PipelineSpec& spec);

/// Counts, earliest_toi (null without contacts), seconds, and per stage: role, name, in, out, seconds.
nlohmann::json to_json(const Statistics& statistics);

/// Null if `path` is empty. Throws InputError.
nlohmann::json read_json_file(const std::string& path);

}  // namespace volccd
