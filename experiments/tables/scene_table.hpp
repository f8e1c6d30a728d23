// Comparison of scenes: size, motion, contacts, edits, and time and energy balance of their simulation.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

/// The record of a scene: {"scene", "machine", "simulation": record of its baking or null, "steps": statistics of the
/// file}. `bake_record`: file that bake() wrote, or empty. Returns nothing if `go_on(done, steps)` returned false.
/// Throws InputError.
std::optional<nlohmann::json> scene_record(const std::string& name, const std::string& sequence,
                                           const std::string& bake_record, Executor& executor,
                                           const std::function<bool(std::size_t done, std::size_t steps)>& go_on);

/// A table without a title, with one row for each record, with the paper's number of elements if the paper has the
/// scene.
TitledTable scene_table(const std::vector<nlohmann::json>& records);

}  // namespace volccd
