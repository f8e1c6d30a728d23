// Options of a stage are data: a Config struct with named defaults, and one table that parses, checks and lists the
// options.
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <volccd/core/error.hpp>

namespace volccd {

/// Options as the caller gives them: from option name to text, e.g. {"leaf_size", "4"}.
using OptionValues = std::map<std::string, std::string>;

/// What `volccd stages` prints about one option.
struct OptionInfo {
  std::string name;
  std::string default_value;
  std::string allowed;      ///< "face|centroid|optimal", "1 .. 8", "true|false", "number > 0"
  std::string description;  ///< one line
};

namespace detail {
std::string to_text(bool value);
std::string to_text(int value);
std::string to_text(double value);
bool parse_bool(const std::string& name, const std::string& text);
int parse_int(const std::string& name, const std::string& text, int low, int high);
double parse_number(const std::string& name, const std::string& text, double low, double high);
std::string range_text(double low, double high);
[[noreturn]] void unknown_choice(const std::string& name, const std::string& text, const std::string& allowed);
[[noreturn]] void renamed_option(const std::string& former, const std::string& present);
[[noreturn]] void unknown_option(const std::string& name, const std::vector<OptionInfo>& known);
}  // namespace detail

/// The option table of a Config struct.
///
///     Options<Config> options;
///     options.add("leaf_size", &Config::leaf_size, 1, 8, "elements per leaf");
///     options.add("axis", &Config::axis, {{"face", Axis::face}, {"optimal", Axis::optimal}}, "separating axis");
///     Config config = options.parse({{"axis", "optimal"}});
///
/// parse() throws ConfigError for an unknown option name (the message lists the known names) and for a value out of
/// range.
template <class Config>
class Options {
 public:
  Options& add(std::string name, bool Config::*member, std::string description) {
    push({name, detail::to_text(Config{}.*member), "true|false", std::move(description)},
         [=](Config& c, const std::string& text) { c.*member = detail::parse_bool(name, text); });
    return *this;
  }

  Options& add(std::string name, int Config::*member, int low, int high, std::string description) {
    push({name, detail::to_text(Config{}.*member), detail::to_text(low) + " .. " + detail::to_text(high),
          std::move(description)},
         [=](Config& c, const std::string& text) { c.*member = detail::parse_int(name, text, low, high); });
    return *this;
  }

  /// Adds an option whose value is a finite number in [low, high].
  Options& add(std::string name, double Config::*member, double low, double high, std::string description) {
    push({name, detail::to_text(Config{}.*member), detail::range_text(low, high), std::move(description)},
         [=](Config& c, const std::string& text) { c.*member = detail::parse_number(name, text, low, high); });
    return *this;
  }

  /// Adds an option whose value is one of several named choices.
  template <class T>
  Options& add(std::string name, T Config::*member, std::vector<std::pair<std::string, T>> choices,
               std::string description) {
    std::string allowed, chosen;
    for (const auto& [text, value] : choices) {
      allowed += (allowed.empty() ? "" : "|") + text;
      if (value == Config{}.*member) chosen = text;
    }
    push({name, chosen, allowed, std::move(description)}, [=](Config& c, const std::string& text) {
      for (const auto& [key, value] : choices)
        if (key == text) {
          c.*member = value;
          return;
        }
      detail::unknown_choice(name, text, allowed);
    });
    return *this;
  }

  /// An option was renamed: its former name is refused with a message that has the present one.
  Options& renamed(std::string former, std::string present) {
    renamed_.emplace_back(std::move(former), std::move(present));
    return *this;
  }

  Config parse(const OptionValues& values) const {
    Config config;
    for (const auto& [name, text] : values) {
      for (const auto& [former, present] : renamed_)
        if (name == former) detail::renamed_option(former, present);
      bool found = false;
      for (std::size_t i = 0; i < infos_.size() && !found; ++i)
        if (infos_[i].name == name) {
          setters_[i](config, text);
          found = true;
        }
      if (!found) detail::unknown_option(name, infos_);
    }
    return config;
  }

  const std::vector<OptionInfo>& describe() const { return infos_; }

 private:
  void push(OptionInfo info, std::function<void(Config&, const std::string&)> setter) {
    infos_.push_back(std::move(info));
    setters_.push_back(std::move(setter));
  }

  std::vector<std::pair<std::string, std::string>> renamed_;  ///< former and present names
  std::vector<OptionInfo> infos_;
  std::vector<std::function<void(Config&, const std::string&)>> setters_;
};

}  // namespace volccd
