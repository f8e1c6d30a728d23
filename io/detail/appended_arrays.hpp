// VTK XML PolyData (.vtp) with its arrays in the appended section.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include <fmt/format.h>

namespace volccd::detail {

/// Arrays in the file's appended section, and their descriptions.
class AppendedArrays {
 public:
  /// `values(row, component)` of each of `rows`.
  template <class T, class Values>
  std::string add(const char* type, const char* name, std::size_t rows, std::size_t components, Values&& values) {
    const std::string tag = fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        name, components, bytes_.size());
    append(static_cast<std::uint64_t>(rows * components * sizeof(T)));
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t c = 0; c < components; ++c) append(static_cast<T>(values(row, c)));
    return tag;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <class T>
  void append(T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
  }

  std::string bytes_;
};

/// The first lines of a file, to which the lines of one Piece follow. `comment` may be empty, or is a line of its own.
inline std::string polydata_head(const std::string& comment) {
  return "<?xml version=\"1.0\"?>\n" + comment +
         fmt::format(
             "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\">\n<PolyData>\n",
             std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian");
}
/// Between the Piece and the bytes of the arrays; and after these.
inline constexpr const char* kPolydataArrays = "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
inline constexpr const char* kPolydataEnd = "\n</AppendedData>\n</VTKFile>\n";

/// A comment of XML that says which steps are there; "--" may not occur in one.
std::string incomplete_comment(std::string text);

}  // namespace volccd::detail
