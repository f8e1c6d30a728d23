#include <volccd/core/suggest.hpp>

#include <algorithm>

namespace volccd {

namespace {

constexpr std::size_t kMaxNames = 3;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool begins_with(std::string_view name, std::string_view text) {
  return text.size() <= name.size() &&
         std::equal(text.begin(), text.end(), name.begin(), [](char a, char b) { return lower(a) == lower(b); });
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Rows i - 2, i - 1 and i of the table of distances between prefixes of a and b.
  std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const char x = lower(a[i - 1]), y = lower(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (x == y ? 0 : 1)});
      if (i > 1 && j > 1 && x == lower(b[j - 2]) && lower(a[i - 2]) == y) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = last;
    last.swap(row);
  }
  return last[b.size()];
}

std::vector<std::string> near_names(std::string_view text, const std::vector<std::string>& known) {
  std::vector<std::string> names;
  std::size_t min = 0;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(text, name);
    if (distance > std::max(text.size(), name.size()) / 3) continue;
    if (names.empty() || distance < min) names.clear(), min = distance;
    if (distance == min && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  if (names.empty() && !text.empty())
    for (const std::string& name : known)
      if (begins_with(name, text)) names.push_back(name);
  if (names.size() > kMaxNames) names.resize(kMaxNames);
  return names;
}

std::string did_you_mean(std::string_view text, const std::vector<std::string>& known) {
  std::string names;
  for (const std::string& name : near_names(text, known)) names += (names.empty() ? "'" : " or '") + name + "'";
  return names.empty() ? names : "; did you mean " + names + "?";
}

std::string did_you_mean(std::string_view text, std::string_view known) {
  std::vector<std::string> names;
  while (!known.empty()) {
    const std::size_t end = std::min(known.find_first_of(",|"), known.size());
    if (end > 0) names.emplace_back(known.substr(0, end));
    known.remove_prefix(std::min(end + 1, known.size()));
    while (!known.empty() && known.front() == ' ') known.remove_prefix(1);
  }
  return did_you_mean(text, names);
}

std::string none_of(std::string_view text, const std::vector<std::string>& known) {
  std::string all;
  for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
  return "'" + std::string(text) + "' is none of " + all + did_you_mean(text, known);
}

}  // namespace volccd
