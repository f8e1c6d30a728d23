// Enumerations whose values have names for users: in options of the program and of Python, and in records.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <volccd/core/error.hpp>
#include <volccd/core/suggest.hpp>

namespace volccd {

/// Beside an enumeration E, `names_of(E)` returns an array of these, in the order of help texts.
template <class E>
struct NamedValue {
  const char* name;
  E value;
};

template <class E>
std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const NamedValue<E>& named : names_of(E{})) names.emplace_back(named.name);
  return names;
}

/// Empty if the value has no name.
template <class E>
const char* name_of(E value) {
  for (const NamedValue<E>& named : names_of(E{}))
    if (named.value == value) return named.name;
  return "";
}

/// Throws ConfigError, which begins with `option`, if no value has this name.
template <class E>
E value_named(std::string_view name, const std::string& option) {
  for (const NamedValue<E>& named : names_of(E{}))
    if (name == named.name) return named.value;
  throw ConfigError(option + ": " + none_of(name, all_names<E>()));
}

}  // namespace volccd
