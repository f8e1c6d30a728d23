// Descriptive metadata of a sequence file.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace volccd {

/// Attributes at the root of the file. All of them are optional; an empty text is not written.
struct SequenceMetadata {
  std::string title, source, license;
  std::string units;      ///< unit of length, as text: "mm (mass in g)"
  std::string time_unit;  ///< unit of time, as text: "microsecond"
  /// Names of the objects, attribute `Parts`: "1 Projectile; 2 Plate".
  std::map<std::int32_t, std::string> object_names;
  /// Attribute `Incomplete`: which of the intended frames the file contains, and why the others are missing. For
  /// output, it is set by SequenceWriter::finish() only.
  std::string incomplete = {};

  friend bool operator==(const SequenceMetadata&, const SequenceMetadata&) = default;
};

/// The text of the attribute `Parts`. A ';' in a name is replaced by ','.
std::string format_object_names(const std::map<std::int32_t, std::string>& names);

/// The inverse of format_object_names(). Throws InputError (`source`, "@Parts", number of the entry) for an entry that
/// is not of the form "<id> <name>", and for a repeated id.
std::map<std::int32_t, std::string> parse_object_names(const std::string& source, const std::string& text);

}  // namespace volccd
