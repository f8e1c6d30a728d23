#include <volccd/program/command_line.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/suggest.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/build_facts.hpp>
#include <volccd/program/shell_documents.hpp>

namespace volccd {

namespace {

constexpr std::size_t kNameWidth = 30;  ///< columns of the names of options and commands

/// Former and present names, for messages.
constexpr std::pair<const char*, const char*> kRenamedOptions[] = {
    {"--parts", "--objects"}, {"--step", "--frames"}, {"--steps", "--frames"}, {"--mesh-step", "--mesh-frame"}};

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(kNameWidth); }

  std::string make_description(const CLI::App* app) const override {
    return wrapped(CLI::Formatter::make_description(app));
  }
  std::string make_usage(const CLI::App* app, std::string name) const override {
    return wrapped(CLI::Formatter::make_usage(app, std::move(name)));
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(CLI::Formatter::make_option_desc(option), kTextWidth - kNameWidth);
  }
  std::string make_subcommand(const CLI::App* command) const override {
    std::stringstream out;
    CLI::detail::format_help(out, command->get_display_name(true),
                             wrapped(command->get_description(), kTextWidth - kNameWidth), kNameWidth);
    return out.str();
  }
  std::string make_footer(const CLI::App* app) const override {
    // A command without a footer has inherited the footer of its parent.
    if (app->get_parent() && app->get_parent()->get_footer() == app->get_footer()) return "";
    return wrapped_footer(CLI::Formatter::make_footer(app));
  }

 private:
  /// A long example is continued after a backslash, so that it can be copied.
  static std::string wrapped_footer(const std::string& text) {
    std::string result;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("  volccd ")) {
        result += wrapped(line) + "\n";
        continue;
      }
      while (line.size() > kTextWidth) {
        const std::size_t blank = line.rfind(' ', kTextWidth - 2);
        result += line.substr(0, blank) + " \\\n";
        line = "      " + line.substr(blank + 1);
      }
      result += line + "\n";
    }
    return result;
  }
};

void use(const std::shared_ptr<HelpFormatter>& formatter, CLI::App& app) {
  app.formatter(formatter);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) use(formatter, *command);
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

const CLI::App* find_command(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (command->get_name() == name) return command;
  return nullptr;
}

/// `path`: "" or "scene ". Throws ConfigError.
const CLI::App& command_of(const CLI::App& app, const std::string& name, const std::string& path) {
  const CLI::App* command = find_command(app, name);
  if (command) return *command;
  const std::vector<std::string> known = command_names(app);
  throw ConfigError(
      fmt::format("no command '{}{}'; there are {}{}", path, name, fmt::join(known, ", "), did_you_mean(name, known)));
}

int print_help(const CLI::App& app, const std::vector<std::string>& names) {
  const CLI::App* command = &app;
  std::string before, path;
  for (const std::string& name : names) {
    before += (before.empty() ? "" : " ") + command->get_name();
    command = &command_of(*command, name, path);
    path += name + " ";
  }
  // App::help() would show the command that is being parsed, this one.
  const auto formatter = std::dynamic_pointer_cast<CLI::Formatter>(app.get_formatter());
  const std::string name = before.empty() ? command->get_name() : before + " " + command->get_name();
  fmt::print("{}", formatter->make_help(command, name, CLI::AppFormatMode::Normal));
  return kDone;
}

struct HelpOptions {
  std::vector<std::string> names;
  std::string completion;
  bool manual_page = false;
};

KnownWords known_words(const CLI::App& app, const Registry& registry) {
  KnownWords words;
  words["help"] = command_names(app);
  for (const PipelineSpec& spec : registry.pipelines()) words["detect --pipeline"].push_back(spec.name);
  std::vector<std::string>& stages = words["check"];
  const auto add = [&](const auto& list) {
    for (const auto& stage : list) stages.push_back(stage.name);
  };
  add(registry.stages<BroadPhase>()), add(registry.stages<ElementCulling>()), add(registry.stages<Assignment>());
  add(registry.stages<OrphanSource>()), add(registry.stages<Flood>()), add(registry.stages<FeatureFilter>());
  add(registry.stages<NarrowPhase>());
  for (const SimulatedScene& scene : simulated_scenes()) words["scene generate"].push_back(scene.name);
  for (const SceneDescriptor& scene : scenes()) words["scene generate"].push_back(scene.name);
  for (const ExperimentKind& kind : experiment_kinds())
    for (const char* command : {"experiment run", "experiment table"}) words[command].emplace_back(kind.name);
  return words;
}

}  // namespace

void use_help_formatter(CLI::App& app) { use(std::make_shared<HelpFormatter>(), app); }

CLI::Validator one_of(std::vector<std::string> choices) {
  std::string list;
  for (const std::string& choice : choices) list += (list.empty() ? "" : ",") + choice;
  return CLI::Validator(
      [choices = std::move(choices)](std::string& text) {
        if (std::find(choices.begin(), choices.end(), text) != choices.end()) return std::string();
        return none_of(text, choices);
      },
      "{" + list + "}");
}

CLI::Validator at_least(double min) {
  return CLI::Validator(
      [min](std::string& text) {
        double value = 0;
        if (!CLI::detail::lexical_cast(text, value)) return fmt::format("'{}' is not a number", text);
        if (std::isfinite(value) && value >= min) return std::string();
        return fmt::format("must be at least {:g}{}, and is {}", min, std::isinf(value) ? " and finite" : "", text);
      },
      "");
}

std::string short_help(const CLI::App& app) {
  const auto formatter = std::dynamic_pointer_cast<CLI::Formatter>(app.get_formatter());
  return fmt::format(
      "{}\nUsage: {} COMMAND ...\n{}\n`{} help COMMAND` has options and examples, `{} --help` the rest.\n",
      formatter->make_description(&app), app.get_name(), formatter->make_subcommands(&app, CLI::AppFormatMode::Normal),
      app.get_name(), app.get_name());
}

void add_help_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("help", "prints the help of a command, as --help does");
  const auto options = std::make_shared<HelpOptions>();
  command->add_option("COMMAND", options->names, "the command; without it, all commands are listed")->type_name("");
  command->add_flag("--manual-page", options->manual_page, "print the manual page of all commands, for `man`");
  command->add_option("--completion", options->completion, "print a script that completes commands and options")
      ->check(one_of({"bash"}));
  command->footer(
      "Examples:\n  volccd help\n  volccd help scene generate\n  volccd help --manual-page\n"
      "  volccd help --completion bash");
  command->callback([options, &app, &registry, &action] {
    action = [options, &app, &registry] {
      if (options->manual_page)
        fmt::print("{}", manual_page(app, build_facts().version));
      else if (!options->completion.empty())
        fmt::print("{}", bash_completion(app, known_words(app, registry)));
      else
        return print_help(app, options->names);
      return kDone;
    };
  });
}

void check_command_names(const CLI::App& app, int argc, const char* const* argv) {
  const CLI::App* command = &app;
  std::string path;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    if (command->get_require_subcommand_min() == 0) return;
    command = &command_of(*command, argv[i], path);
    path += std::string(argv[i]) + " ";
  }
}

std::string unexpected_arguments(const CLI::App& app) {
  const CLI::App* command = &app;
  std::string path = app.get_name();
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    path += " " + command->get_name();
  }
  const std::vector<std::string> extras = app.remaining(true);
  const auto option =
      std::find_if(extras.begin(), extras.end(), [](const std::string& o) { return o.starts_with("-"); });
  if (option == extras.end())
    return fmt::format("{}: '{}' is not expected; `{} --help` lists what is", path, fmt::join(extras, " "), path);
  const std::string name = option->substr(0, option->find('='));
  std::vector<std::string> known;
  for (const CLI::Option* one : command->get_options()) {
    for (const std::string& long_name : one->get_lnames()) known.push_back("--" + long_name);
    for (const std::string& short_name : one->get_snames()) known.push_back("-" + short_name);
  }
  for (const auto& [former, present] : kRenamedOptions)
    if (name == former && std::find(known.begin(), known.end(), present) != known.end())
      return fmt::format("{}: option '{}' is called '{}' now", path, former, present);
  return fmt::format("{} has no option '{}'{}; `{} --help` lists them", path, name, did_you_mean(name, known), path);
}

}  // namespace volccd
