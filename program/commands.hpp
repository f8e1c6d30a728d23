// The subcommands of `volccd`. Each adds itself to the app; its callback does the work and returns the exit code.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

#include <volccd/pipelines/registry.hpp>

namespace volccd {

/// The function that runs the command after the command line has been parsed.
using Action = std::function<int()>;

void add_info_command(CLI::App& app, Action& action);
void add_detect_command(CLI::App& app, const Registry& registry, Action& action);
void add_verify_command(CLI::App& app, const Registry& registry, Action& action);
void add_check_command(CLI::App& app, const Registry& registry, Action& action);
void add_queries_command(CLI::App& app, const Registry& registry, Action& action);
void add_stages_command(CLI::App& app, const Registry& registry, Action& action);
void add_scene_command(CLI::App& app, Action& action);
void add_generate_command(CLI::App& scene, Action& action);  ///< below `volccd scene`
void add_picture_command(CLI::App& scene, Action& action);   ///< below `volccd scene`
void add_export_command(CLI::App& scene, Action& action);    ///< below `volccd scene`
void add_report_command(CLI::App& app, const Registry& registry, Action& action);
void add_view_command(CLI::App& app, const Registry& registry, Action& action);
void add_experiment_command(CLI::App& app, const Registry& registry, Action& action);
void add_experiment_run_command(CLI::App& experiment, const Registry& registry, Action& action);  ///< below it

inline constexpr int kDone = 0, kDifferent = 1, kBadInput = 2, kInterrupted = 130;

}  // namespace volccd
