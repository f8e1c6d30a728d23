// Options of commands that look for contacts and write them.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <volccd/distributed/detector.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/program/query_options.hpp>

namespace volccd {

/// What is read, the query, --pipeline, --set, --contacts, --overlaps, --stats, --first, --substeps, --lists. Must outlive
/// the parsing.
struct ContactQueryOptions {
  SequenceOptions sequence;
  QueryOptions query;
  std::string pipeline = "VolCCD+", contacts, overlaps, stats, lists;
  std::vector<std::string> settings;
  bool first = false;
  int substeps = 1;  ///< of each motion; substep i of step k is numbered k * substeps + i in files

  void add_to(CLI::App& command);
  Request request() const;
  /// Throws ConfigError for an unknown pipeline or setting.
  PipelineSpec spec(const Registry& registry) const { return registry.pipeline(pipeline, settings); }
  /// Throws ConfigError if --lists is malformed.
  ListConfig list_config() const;
  distributed::Config rank_config(Executor& executor) const;
  /// Throws ConfigError if the substeps of these steps cannot be numbered.
  void check_numbers(const StepRange& steps) const;
};

}  // namespace volccd
