#include <volccd/program/shell_documents.hpp>

#include <cctype>
#include <sstream>

#include <fmt/format.h>

namespace volccd {

namespace {

std::vector<const CLI::App*> subcommands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<const CLI::Option*> options_of(const CLI::App& app, bool positional) {
  return app.get_options([=](const CLI::Option* option) { return option->get_positional() == positional; });
}

/// Text for troff: no line begins with a request, backslashes are escaped, and hyphens can be copied.
std::string troff(const std::string& text) {
  std::string result;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!result.empty()) result += "\n";
    if (line.starts_with(".") || line.starts_with("'")) result += "\\&";
    for (const char c : line) {
      if (c == '\\')
        result += "\\e";
      else if (c == '-')
        result += "\\-";
      else
        result += c;
    }
  }
  return result;
}

/// "all,inter,intra", or empty.
std::string choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return "";
  return type.substr(open + 1, close - open - 1);
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

/// " N", and for a choice " all|inter|intra".
std::string value_of(const CLI::Option& option) {
  if (!takes_value(option)) return "";
  std::string choices = choices_of(option);
  if (choices.empty()) {
    // A description of the check follows after a colon; "A:B" is a form of the value.
    const std::string type = option.get_type_name();
    const std::size_t colon = type.find(':');
    return type.empty() ? type : " " + (colon + 2 < type.size() ? type.substr(0, colon) : type);
  }
  for (char& c : choices)
    if (c == ',') c = '|';
  return " " + choices;
}

std::string option_entry(const CLI::Option& option) {
  std::string text = option.get_description();
  if (!option.get_default_str().empty() && takes_value(option))
    text += fmt::format(" (default: {})", option.get_default_str());
  const std::string name = option.get_positional() ? option.get_name(true) : option.get_name(false, true);
  return fmt::format(".TP\n.B {}\n{}\n", troff(name.substr(0, name.find('{')) + value_of(option)), troff(text));
}

std::string footer_of(const CLI::App& app) {
  if (app.get_parent() && app.get_parent()->get_footer() == app.get_footer()) return "";  // inherited
  return app.get_footer().empty() ? "" : fmt::format(".PP\n.nf\n{}\n.fi\n", troff(app.get_footer()));
}

/// The command and its subcommands. `path`: "volccd scene".
std::string command_entry(const CLI::App& command, const std::string& path) {
  std::string text;
  if (subcommands(command).empty()) {
    std::string usage = path;
    for (const CLI::Option* option : options_of(command, true)) usage += " " + option->get_name(true);
    text += fmt::format(".SS {} [options]\n{}\n", troff(usage), troff(command.get_description()));
    for (const bool positional : {true, false})
      for (const CLI::Option* option : options_of(command, positional))
        if (option != command.get_help_ptr()) text += option_entry(*option);
    text += footer_of(command);
  }
  for (const CLI::App* below : subcommands(command)) text += command_entry(*below, path + " " + below->get_name());
  return text;
}

/// The text in single quotes, for the shell.
std::string quoted(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return "'" + text + "'";
}

std::vector<std::string> separate(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream stream(list);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
  return words;
}

/// Branches of the script's three tables.
struct Tables {
  std::string commands, values, words;
};

/// `path`: "" or "scene".
void add_to(Tables& tables, const CLI::App& command, const std::string& path, const KnownWords& known) {
  std::vector<std::string> words;
  for (const CLI::App* below : subcommands(command)) {
    const std::string whole = path.empty() ? below->get_name() : path + " " + below->get_name();
    words.push_back(below->get_name());
    tables.commands += fmt::format("      '{}:{}') path='{}' ;;\n", path, below->get_name(), whole);
    add_to(tables, *below, whole, known);
  }
  for (const CLI::Option* option : options_of(command, false))
    for (const std::string& name : option->get_lnames()) {
      words.push_back("--" + name);
      std::vector<std::string> values = separate(choices_of(*option));
      if (const auto found = known.find(path + " --" + name); found != known.end()) values = found->second;
      if (!values.empty())
        tables.values += fmt::format("    '{}:--{}') words={} ;;\n", path, name, quoted(values));
      else if (takes_value(*option))
        tables.values += fmt::format("    '{}:--{}') files=yes ;;\n", path, name);
    }
  if (const auto found = known.find(path); found != known.end())
    words.insert(words.end(), found->second.begin(), found->second.end());
  tables.words += fmt::format("    '{}') words={} ;;\n", path, quoted(words));
}

}  // namespace

std::string manual_page(const CLI::App& app, const std::string& version) {
  const std::string name = troff(app.get_name());
  std::string title = name;
  for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string text = fmt::format(".TH {} 1 \"\" \"{} {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n", title, name,
                                 version, name, troff(app.get_description()));
  text += fmt::format(".SH SYNOPSIS\n.B {}\n.I command\n[options]\n.SH COMMANDS\n", name);
  text += command_entry(app, app.get_name());
  return text + (app.get_footer().empty() ? "" : ".SH EXAMPLES AND EXIT CODES\n" + footer_of(app));
}

std::string bash_completion(const CLI::App& app, const KnownWords& words) {
  Tables tables;
  add_to(tables, app, "", words);
  return "# bash completion of volccd, made by `volccd help --completion bash`\n"
         "_volccd() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} path='' words='' files='' word\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    case \"$path:$word\" in\n" +
         tables.commands +
         "    esac\n"
         "  done\n"
         "  case \"$path:$before\" in\n" +
         tables.values +
         "  esac\n"
         "  if [[ -z $words && -z $files ]]; then case \"$path\" in\n" +
         tables.words +
         "  esac; fi\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  [[ -n $path && ${#COMPREPLY[@]} -eq 0 ]] && COMPREPLY=($(compgen -f -- \"$current\"))\n"
         "  return 0\n"
         "}\n"
         "complete -o filenames -F _volccd volccd\n";
}

}  // namespace volccd
