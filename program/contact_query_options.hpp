// Options of commands that look for contacts and write them.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <volccd/pipelines/pipeline.hpp>
#include <volccd/program/query_options.hpp>

namespace volccd {

/// What is read, the query, --pipeline, --set, --contacts, --overlaps, --stats, --first. Must outlive the parsing.
struct ContactQueryOptions {
  SequenceOptions sequence;
  QueryOptions query;
  std::string pipeline = "VolCCD+", contacts, overlaps, stats;
  std::vector<std::string> settings;
  bool first = false;

  void add_to(CLI::App& command);
  Request request() const;
  /// Throws ConfigError for an unknown pipeline or setting.
  PipelineSpec spec(const Registry& registry) const { return registry.pipeline(pipeline, settings); }
};

}  // namespace volccd
