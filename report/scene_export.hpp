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

/// The script is volccd_scene("NAME", "DATA"). DATA is base64 of a zlib stream of these parts, whose numbers are stored
/// in byte planes: the lowest bytes of a column first, then the next ones.
/// - length of the header, 4 bytes
/// - header, JSON: box, bits, objects, frames, motions with statistics, notes, provenance
/// - triangles: three columns of 4 bytes: first vertex less that of the triangle before, second and third less
///   the first (zigzag); object, 2 bytes; edges of elements, 1 byte
/// - changes: for each frame, triangles that appear and that disappear, ascending, as differences, 4 bytes
/// - positions: for each frame, all x, all y, all z, 2 bytes, as differences from a prediction by the frames before
///   (encoding.hpp)
/// - contacts: x, y, z and time, 2 bytes each, over all steps; flags, 1 byte: 1 edge-edge, 2 between objects, 4 at the
///   start
/// - pairs: x, y, z of the first centroid and differences to the second one (zigzag), of 12 bits (`pair_bits`) in
///   2 bytes each, over all steps, in each by stage, dropped before kept; kind, 1 byte: 0 elements, 1 VF, 2 EE
struct ExportedScene {
  std::string script;
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
