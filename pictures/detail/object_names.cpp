#include <volccd/pictures/detail/object_names.hpp>

#include <algorithm>
#include <cctype>
#include <charconv>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/suggest.hpp>

namespace volccd::detail {

namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The words between semicolons or, if there is none, between commas, without blanks around them.
std::vector<std::string> split(const std::string& text) {
  const char separator = text.find(';') == std::string::npos ? ',' : ';';
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    const std::size_t first = text.find_first_not_of(' ', at);
    if (first < end) words.push_back(text.substr(first, text.find_last_not_of(' ', end - 1) + 1 - first));
    at = end + 1;
  }
  return words;
}

}  // namespace

void ObjectNames::add(const std::set<std::int32_t>& objects, const std::map<std::int32_t, std::string>& names) {
  objects_.insert(objects.begin(), objects.end());
  names_.insert(names.begin(), names.end());
  for (const auto& [object, name] : names) objects_.insert(object);
}

std::string ObjectNames::name_of(std::int32_t object) const {
  const auto found = names_.find(object);
  return found == names_.end() || found->second.empty() ? fmt::format("object {}", object) : found->second;
}

std::set<std::int32_t> ObjectNames::parse(const std::string& option, const std::string& text) const {
  std::set<std::int32_t> chosen;
  const bool is_name =
      std::any_of(names_.begin(), names_.end(), [&](const auto& entry) { return lower(entry.second) == lower(text); });
  for (const std::string& word : is_name ? std::vector{text} : split(text)) {
    std::int32_t id = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
    const bool is_id = error == std::errc() && end == word.data() + word.size();
    const std::size_t before = chosen.size();
    for (const std::int32_t object : objects_)
      if (is_id ? object == id : lower(name_of(object)) == lower(word)) chosen.insert(object);
    if (chosen.size() == before && !(is_id && chosen.contains(id)))
      throw ConfigError(fmt::format("{}: there is no object '{}'; there are {}{}", option, word, known(),
                                    did_you_mean(word, names())));
  }
  return chosen;
}

std::vector<std::string> ObjectNames::names() const {
  std::vector<std::string> names;
  for (const std::int32_t object : objects_) names.push_back(name_of(object));
  return names;
}

std::string ObjectNames::known() const {
  std::string known;
  for (const std::int32_t object : objects_) {
    const auto found = names_.find(object);
    known += fmt::format("{}{}{}", known.empty() ? "" : ", ", object, found == names_.end() ? "" : " " + found->second);
  }
  return known;
}

}  // namespace volccd::detail
