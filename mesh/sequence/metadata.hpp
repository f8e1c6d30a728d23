// What a sequence file says about itself, beside its numbers.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace volccd {

/// Attributes at the root of the file, all of them optional; an empty text is not written.
struct SequenceMetadata {
  std::string title, source, license;
  std::string units;      ///< of length, as text: "mm (mass in g)"
  std::string time_unit;  ///< "microsecond"
  /// Names of the part ids, attribute `Parts`: "1 Projectile; 2 Plate".
  std::map<std::int32_t, std::string> part_names;
  /// Attribute `Incomplete`: which steps there are of those that were meant to be, and why no more. SequenceWriter
  /// takes it at finish() alone.
  std::string incomplete = {};

  friend bool operator==(const SequenceMetadata&, const SequenceMetadata&) = default;
};

/// The text of the attribute `Parts`. A ';' in a name becomes ','.
std::string format_part_names(const std::map<std::int32_t, std::string>& names);

/// The reverse. Throws InputError (`source`, "@Parts", number of the entry) for an entry that is not "<id> <name>", or
/// an id given twice.
std::map<std::int32_t, std::string> parse_part_names(const std::string& source, const std::string& text);

}  // namespace volccd
