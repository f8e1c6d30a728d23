// How the command line reads and explains itself: help within 100 columns, near names for unknown ones, `volccd help`.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <volccd/program/commands.hpp>

namespace volccd {

/// Help of `app` and all of its commands in lines of kTextWidth.
void use_help_formatter(CLI::App& app);

/// One of `choices`, else a ConfigError's text with the near ones.
CLI::Validator one_of(std::vector<std::string> choices);

/// `volccd help [COMMAND...]`; --manual-page and --completion print what CMake installs.
void add_help_command(CLI::App& app, const Registry& registry, Action& action);

/// Throws ConfigError for a word in the place of a command that is none: the parser would only say that a command is
/// missing.
void check_command_names(const CLI::App& app, int argc, const char* const* argv);

/// What to say of arguments that the parser did not expect, with near names of options.
std::string unexpected_arguments(const CLI::App& app);

}  // namespace volccd
