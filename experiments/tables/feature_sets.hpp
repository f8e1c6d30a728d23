// Effects on a simulation of colliding fewer features: Figure 3 of the paper, in numbers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// The bullet and its variants, for their inputs only: the plan has no windows.
ExperimentPlan feature_set_plan(const PlanContext& context);

/// feature_set_motions() of these scenes, with the columns that figures need (scene, motion_model, pipeline, "variant":
/// the features that collide), and with the numbers of their simulation for each step: "splits" and "breaks",
/// "simulation_seconds".
void feature_set_rows(const PlanContext& context, RecordFile& record);

/// One table, with one row for each scene.
std::vector<TitledTable> feature_set_tables(const nlohmann::json& record);

/// Measures of the sequence of a simulation with hexahedra (and wedges into which they break), one row for each step:
/// {"step", "elements", "time": at its end, "contacts", "interior": those of which a feature lies inside,
/// "overlaps_inter", "overlaps_intra": pairs of non-adjacent elements that overlap at its start (exact), "inverted":
/// elements with a negative corner volume at its end, "pieces_striker", "pieces_target": pieces connected by vertices,
/// "velocity", "travel": of the striker's centre of mass along its first step}.
///
/// The striker is object 0, the target all other objects. Contacts are those of the pipeline VolCCD+ among all
/// features, whichever the simulation has resisted. `check` is called before each step, and may throw to stop. Throws
/// InputError for other elements, and the exceptions of the reader.
std::vector<nlohmann::json> feature_set_motions(const std::string& sequence, Executor& executor,
                                                const std::function<void()>& check);

}  // namespace volccd
