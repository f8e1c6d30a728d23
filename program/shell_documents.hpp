// The manual page and the shell's completion, made from the same descriptions as --help.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace volccd {

/// Words that are completed at a place of the command line. Keys: "COMMAND" for positional arguments, as "scene
/// generate", or "COMMAND --option".
using KnownWords = std::map<std::string, std::vector<std::string>>;

/// For `man`: troff with the macros of man(7).
std::string manual_page(const CLI::App& app, const std::string& version);

/// A script for bash that completes commands, options, the values of options, `words`, and names of files elsewhere.
std::string bash_completion(const CLI::App& app, const KnownWords& words);

}  // namespace volccd
