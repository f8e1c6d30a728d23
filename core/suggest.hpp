// Suggests known names that are similar to an unknown one.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace volccd {

/// The least number of insertions, deletions, replacements and exchanges of neighbours that turn `a` into `b`, with no
/// part of `a` edited twice (optimal string alignment). Letters of either case are equal. O(|a| |b|).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The names in `known` that are nearest to `text`, at most three, in the order of `known`. Their edit distance is at
/// most a third of the longer name; if there are none, names that begin with `text`.
std::vector<std::string> near_names(std::string_view text, const std::vector<std::string>& known);

/// "; did you mean 'VolCCD'?", to be put at the end of a message; empty if no name is near.
std::string did_you_mean(std::string_view text, const std::vector<std::string>& known);
/// The same with names separated by ", " or "|".
std::string did_you_mean(std::string_view text, std::string_view known);

/// "'VolCD' is none of VolCCD, NavCCD; did you mean 'VolCCD'?"
std::string none_of(std::string_view text, const std::vector<std::string>& known);

}  // namespace volccd
