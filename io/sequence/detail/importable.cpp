#include <volccd/io/sequence/detail/importable.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

#include <volccd/core/error.hpp>
#include <volccd/io/hdf5/detail/hdf5_file.hpp>

namespace volccd::detail {

namespace {

// What volccd-import reads (tools/importer/series.py), and decks whose results it reads.
constexpr std::array kExtensions = {".vtu", ".pvtu", ".pvd", ".vtk", ".msh", ".ply", ".obj", ".inp", ".bdf", ".fem",
                                    ".nas", ".xdmf", ".xmf", ".e",   ".exo", ".ex2", ".frd", ".k",   ".key"};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// As the shell reads it as one word.
std::string quoted(const std::string& word) {
  constexpr std::string_view plain = "/._-+,=:@%";
  const bool safe = std::all_of(word.begin(), word.end(), [&](unsigned char c) {
    return std::isalnum(c) != 0 || plain.find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (safe) return word;
  std::string result = "'";
  for (const char c : word) result += c == '\'' ? "'\\''" : std::string(1, c);
  return result + "'";
}

bool is_vtkhdf(const std::string& file) {
  try {
    return Hdf5File(file).has("VTKHDF");
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::string import_command(const std::string& file) {
  const std::filesystem::path path(file);
  const std::string extension = lower(path.extension().string());
  const bool d3plot = lower(path.filename().string()).ends_with("d3plot");
  if (!d3plot && std::find(kExtensions.begin(), kExtensions.end(), extension) == kExtensions.end()) return "";
  const bool deck = extension == ".k" || extension == ".key";  // its results are in another file
  const std::string source = deck ? (path.parent_path() / "d3plot").string() : file;
  return "volccd-import " + quoted(source) + " -o " +
         quoted(std::filesystem::path(path.filename()).replace_extension(".vtkhdf").string());
}

void refuse_importable(const std::string& file) {
  const std::string command = import_command(file);
  std::error_code ignored;
  if (command.empty() || !std::filesystem::is_regular_file(file, ignored) || is_vtkhdf(file)) return;
  throw InputError(file, "", "is no sequence (VTKHDF); this makes one of it: " + command);
}

}  // namespace volccd::detail
