// Help texts of the command line: lines of at most 100 columns, suggestions for unknown names, `volccd help`.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <volccd/core/named_values.hpp>
#include <volccd/program/commands.hpp>

namespace volccd {

/// Help of `app` and all of its commands in lines of kTextWidth.
void use_help_formatter(CLI::App& app);

/// A check that accepts the `choices`; otherwise the message of a ConfigError with similar names.
CLI::Validator one_of(std::vector<std::string> choices);

/// An option with one of the named values of an enumeration. The present value is the default.
template <class E>
CLI::Option* add_choice(CLI::App& command, const std::string& option, E& value, const std::string& help) {
  return command
      .add_option_function<std::string>(
          option, [option, &value](const std::string& name) { value = value_named<E>(name, option); }, help)
      ->check(one_of(all_names<E>()))
      ->default_str(name_of(value));
}

/// Accepts finite numbers that are at least `min`; the message says so.
CLI::Validator at_least(double min);

/// Description, usage and commands, in a few lines.
std::string short_help(const CLI::App& app);

/// `volccd help [COMMAND...]`; --manual-page and --completion print what CMake installs.
void add_help_command(CLI::App& app, const Registry& registry, Action& action);

/// Throws ConfigError for a word that stands in the place of a command and is none; the parser itself would only report
/// that a command is missing.
void check_command_names(const CLI::App& app, int argc, const char* const* argv);

/// The message for arguments that the parser did not expect, with similar names of options.
std::string unexpected_arguments(const CLI::App& app);

}  // namespace volccd
