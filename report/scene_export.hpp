// A sequence as a script that the report's page plays: surface, contacts and counts of the stages.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/pipelines/registry.hpp>

namespace volccd {

struct SceneExportConfig {
  /// The pipeline whose contacts, counts and pairs are shown; empty: none of these are shown, and no pipeline is run.
  std::optional<PipelineSpec> pipeline;
  std::size_t max_bytes =
      16'000'000;  ///< approximate limit of the script; beyond, positions are coarser and frames fewer
  std::size_t max_triangles = 250'000;  ///< of a frame; if there are more, vertices are clustered
  std::size_t max_contacts = 2'000;     ///< of a step that are shown; all are counted
  /// Pairs of a step that are shown for each stage, dropped ones and kept ones each; all are counted. Fewer if the
  /// pairs would take more than a sixth of max_bytes.
  std::size_t max_pairs = 200;
};

struct ExportedScene {
  std::string script;  ///< volccd_scene("NAME", "BASE64"): docs/report.md has the layout
  nlohmann::json summary;  ///< entry in the list of scenes: title, frames, triangles, contacts, what was left out
};

/// Reads the sequence `file` and writes it under `name`. Elements are taken as the tables take them (table_config()):
/// shells as solids where the file has their thickness; the surface shown is that of the elements in the file.
///
/// The positions are quantized in one box around all frames, to 16 bits; where the script becomes larger than
/// `max_bytes`, to 14 and 12 bits, and then every second, third, ... frame is kept. The "notes" of the summary say in
/// whole sentences what is left out.
///
/// `progress(done, total)` is called after each step that was run, and may throw to stop. Throws what reading and the
/// pipeline throw, and ConfigError for a sequence in which no element has a surface.
ExportedScene export_scene(const std::string& name, const std::string& file, const Registry& registry,
                           const SceneExportConfig& config, Executor& executor,
                           const std::function<void(std::size_t done, std::size_t total)>& progress = {});

}  // namespace volccd
