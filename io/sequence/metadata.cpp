#include <volccd/io/sequence/metadata.hpp>

#include <algorithm>
#include <charconv>
#include <string_view>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

}  // namespace

std::string format_object_names(const std::map<std::int32_t, std::string>& names) {
  std::string text;
  for (const auto& [id, given] : names) {
    std::string name = given;
    std::replace(name.begin(), name.end(), ';', ',');
    text += (text.empty() ? "" : "; ") + std::to_string(id) + " " + name;
  }
  return text;
}

std::map<std::int32_t, std::string> parse_object_names(const std::string& source, const std::string& text) {
  std::map<std::int32_t, std::string> names;
  std::string_view rest = text;
  for (std::int64_t entry = 0; !trimmed(rest).empty(); ++entry) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string_view item = trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    std::int32_t id = 0;
    const auto [after, error] = std::from_chars(item.data(), item.data() + item.size(), id);
    const std::string_view name(after, static_cast<std::size_t>(item.data() + item.size() - after));
    if (error != std::errc{} || (!name.empty() && name.front() != ' '))
      throw InputError(source, "@Parts", entry, "is not the number and the name of an object");
    if (!names.emplace(id, trimmed(name)).second)
      throw InputError(source, "@Parts", entry, "names object " + std::to_string(id) + " again");
  }
  return names;
}

}  // namespace volccd
