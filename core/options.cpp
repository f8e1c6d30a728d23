#include <volccd/core/options.hpp>

#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <volccd/core/suggest.hpp>

namespace volccd::detail {

std::string to_text(bool value) { return value ? "true" : "false"; }
std::string to_text(int value) { return std::to_string(value); }
std::string to_text(double value) { return fmt::format("{}", value); }

bool parse_bool(const std::string& name, const std::string& text) {
  if (text == "true" || text == "1") return true;
  if (text == "false" || text == "0") return false;
  unknown_choice(name, text, "true|false");
}

int parse_int(const std::string& name, const std::string& text, int low, int high) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < low || value > high)
    throw ConfigError(fmt::format("option {}: '{}' is not a whole number from {} to {}", name, text, low, high));
  return value;
}

double parse_number(const std::string& name, const std::string& text, double low, double high) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value) || value < low || value > high)
    throw ConfigError(fmt::format("option {}: '{}' is not a number, {}", name, text, range_text(low, high)));
  return value;
}

std::string range_text(double low, double high) {
  constexpr double max = std::numeric_limits<double>::max();
  if (high < max) return low > -max ? fmt::format("{} .. {}", low, high) : fmt::format("at most {}", high);
  return low > -max ? fmt::format("at least {}", low) : "any finite number";
}

void unknown_choice(const std::string& name, const std::string& text, const std::string& allowed) {
  throw ConfigError(fmt::format("option {}: '{}' is none of {}{}", name, text, allowed, did_you_mean(text, allowed)));
}

void renamed_option(const std::string& former, const std::string& present) {
  throw ConfigError(fmt::format("option '{}' is called '{}' now", former, present));
}

void unknown_option(const std::string& name, const std::vector<OptionInfo>& known) {
  std::string names;
  for (const OptionInfo& info : known) names += (names.empty() ? "" : ", ") + info.name;
  throw ConfigError(fmt::format("no option '{}'; {}{}", name, names.empty() ? "there are none" : "there are " + names,
                                did_you_mean(name, names)));
}

}  // namespace volccd::detail
