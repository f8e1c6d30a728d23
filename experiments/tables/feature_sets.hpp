// Effects on a simulation of colliding fewer features: Figure 3 of the paper, in numbers.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

/// Measures of the sequence of a simulation with hexahedra (and wedges into which they break), motion by motion:
/// {"scene", "machine", "simulation": record of its baking or null, "motions": [{"time": at its end, "contacts",
/// "interior": those of which a feature lies inside, "overlaps": pairs of elements, not adjacent, that overlap at its
/// start (exact): {"inter", "intra"}, "inverted": elements with a corner turned over, "pieces": {"striker", "target"}
/// that hang together by vertices, "velocity", "travel": of the striker's centre of mass along its first motion}]}.
///
/// The striker is object 0, the target all other objects. Contacts are those of the pipeline VolCCD+ among all
/// features, whichever the simulation has resisted. If `go_on(done, motions)` returns false, the work stops and nothing
/// is returned. Throws InputError for other elements, and the exceptions of the reader.
std::optional<nlohmann::json> feature_set_record(
    const std::string& name, const std::string& sequence, const std::string& bake_record, Executor& executor,
    const std::function<bool(std::size_t done, std::size_t motions)>& go_on);

/// A table without a title, with one row for each record.
TitledTable feature_set_table(const std::vector<nlohmann::json>& records);

}  // namespace volccd
