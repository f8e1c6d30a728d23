#include <volccd/io/hdf5/detail/hdf5_file.hpp>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <new>
#include <type_traits>

#include <volccd/core/error.hpp>

namespace volccd::detail {

namespace {

constexpr std::int64_t kMebi = std::int64_t{1} << 20;
/// Declared size of a dataset up to which the stored bytes are not checked.
constexpr std::int64_t kFreeBytes = 64 * kMebi;
/// Deflate compresses by a factor of at most 1032; the rest is a margin for other filters.
constexpr std::int64_t kGreatestRatio = 4096;
/// Largest size of a chunk, since a chunk is always decoded as a whole.
constexpr std::int64_t kGreatestChunk = 1024 * kMebi;
constexpr std::size_t kLongestString = std::size_t{1} << 20;

std::string attribute_path(const std::string& group, const std::string& name) {
  return (group == "/" ? "" : group) + "@" + name;
}

/// The text of a fixed-length string of HDF5, without its padding.
std::string unpadded(std::string text, H5T_str_t padding) {
  text.resize(std::min(text.size(), text.find('\0')));
  if (padding == H5T_STR_SPACEPAD) text.resize(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace

void Hdf5Dataset::fail(std::int64_t row, const std::string& problem) const {
  throw InputError(file_, path_, row, problem);
}
void Hdf5Dataset::fail(const std::string& problem) const { throw InputError(file_, path_, problem); }

void Hdf5Dataset::check_type(NumberKind kind) {
  const Hdf5Id type(H5Dget_type(id_.get()), H5Tclose);
  if (!type) fail("has no readable type" + hdf5_reason());
  const H5T_class_t want = kind == NumberKind::integer ? H5T_INTEGER : H5T_FLOAT;
  if (H5Tget_class(type.get()) != want)
    fail(kind == NumberKind::integer ? "is not of integers" : "is not of floating-point numbers");
  item_bytes_ = H5Tget_size(type.get());
  if (item_bytes_ == 0 || item_bytes_ > 8)
    fail("has numbers of " + std::to_string(item_bytes_) + " bytes, at most 8 are read");
  unsigned64_ = kind == NumberKind::integer && item_bytes_ == 8 && H5Tget_sign(type.get()) == H5T_SGN_NONE;
}

void Hdf5Dataset::check_shape(std::int64_t columns, std::int64_t depth) {
  const Hdf5Id space(H5Dget_space(id_.get()), H5Sclose);
  if (!space) fail("has no readable shape" + hdf5_reason());
  rank_ = H5Sget_simple_extent_type(space.get()) == H5S_SIMPLE ? H5Sget_simple_extent_ndims(space.get()) : 0;
  const int min = depth > 1 ? 3 : columns > 1 ? 2 : 1, max = depth > 1 ? 3 : 2;
  if (rank_ < min || rank_ > max) fail("has rank " + std::to_string(rank_) + ", but must have " + std::to_string(min));
  hsize_t extent[3] = {0, 1, 1};
  if (H5Sget_simple_extent_dims(space.get(), extent, nullptr) < 0) fail("has no readable shape" + hdf5_reason());
  if (extent[1] != static_cast<hsize_t>(columns))
    fail("has " + std::to_string(extent[1]) + " columns, but must have " + std::to_string(columns));
  if (extent[2] != static_cast<hsize_t>(depth))
    fail("has " + std::to_string(extent[2]) + " numbers in each column, but must have " + std::to_string(depth));
  if (extent[0] > static_cast<hsize_t>(std::numeric_limits<std::int64_t>::max() / 8 / (columns * depth)))
    fail("declares " + std::to_string(extent[0]) + " rows: too many");
  rows_ = static_cast<std::int64_t>(extent[0]);
  columns_ = columns;
  depth_ = depth;
}

void Hdf5Dataset::check_size(std::int64_t file_bytes) const {
  const std::int64_t declared = rows_ * width() * static_cast<std::int64_t>(item_bytes_);
  const hsize_t reported = H5Dget_storage_size(id_.get());
  const std::int64_t stored = static_cast<std::int64_t>(std::min<hsize_t>(reported, static_cast<hsize_t>(file_bytes)));
  if (declared > kFreeBytes && declared / kGreatestRatio > stored)
    fail("declares " + std::to_string(rows_) + " rows but only " + std::to_string(stored) + " bytes are stored");

  const Hdf5Id creation(H5Dget_create_plist(id_.get()), H5Pclose);
  if (!creation || H5Pget_layout(creation.get()) != H5D_CHUNKED) return;
  hsize_t chunk[3] = {0, 1, 1};
  if (H5Pget_chunk(creation.get(), 3, chunk) != rank_) fail("has no readable chunk shape" + hdf5_reason());
  hsize_t room = static_cast<hsize_t>(kGreatestChunk) / item_bytes_;
  for (const hsize_t extent : chunk) room = extent == 0 ? 0 : room / extent;
  if (room == 0) fail("has chunks of more than 1 GiB");
}

void Hdf5Dataset::read_raw(std::int64_t first, std::int64_t count, hid_t type, void* out) const {
  if (count == 0) return;
  const QuietHdf5 quiet;
  const hsize_t start[3] = {static_cast<hsize_t>(first), 0, 0};
  const hsize_t extent[3] = {static_cast<hsize_t>(count), static_cast<hsize_t>(columns_), static_cast<hsize_t>(depth_)};
  const Hdf5Id file_space(H5Dget_space(id_.get()), H5Sclose);
  const Hdf5Id memory_space(H5Screate_simple(rank_, extent, nullptr), H5Sclose);
  if (!file_space || !memory_space ||
      H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start, nullptr, extent, nullptr) < 0 ||
      H5Dread(id_.get(), type, memory_space.get(), file_space.get(), H5P_DEFAULT, out) < 0)
    fail(first, "cannot be read from here on: the file is damaged" + hdf5_reason());
}

template <class T>
void Hdf5Dataset::read(std::int64_t first, std::int64_t count, std::vector<T>& out) const {
  if (first < 0 || count < 0 || first > rows_ - count)
    fail(first, "rows " + std::to_string(first) + " .. +" + std::to_string(count) + " are wanted, there are " +
                    std::to_string(rows_));
  try {
    out.resize(static_cast<std::size_t>(count * width()));
  } catch (const std::bad_alloc&) {
    fail(first, std::to_string(count) + " rows do not fit into memory");
  }
  read_raw(first, count, std::is_same_v<T, double> ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64, out.data());
  if (!unsigned64_) return;
  // HDF5 replaces values out of range by the limits of the range.
  const auto clamped = std::find(out.begin(), out.end(), std::numeric_limits<std::int64_t>::max());
  if (clamped != out.end()) fail(first + (clamped - out.begin()) / width(), "exceeds the range of a 64-bit integer");
}
template void Hdf5Dataset::read(std::int64_t, std::int64_t, std::vector<std::int64_t>&) const;
template void Hdf5Dataset::read(std::int64_t, std::int64_t, std::vector<double>&) const;

Hdf5File::Hdf5File(const std::string& name) : name_(name) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(name, error);
  if (status.type() == std::filesystem::file_type::none)
    throw InputError(name, "", "cannot be opened: " + error.message());
  if (!std::filesystem::exists(status)) throw InputError(name, "", "cannot be opened: No such file or directory");
  // Opening a pipe or a device could block, or reading could never end.
  if (!std::filesystem::is_regular_file(status)) throw InputError(name, "", "is not a regular file");
  bytes_ = static_cast<std::int64_t>(std::filesystem::file_size(name, error));
  if (error) throw InputError(name, "", "cannot be opened: " + error.message());

  const QuietHdf5 quiet;
  id_ = Hdf5Id(H5Fopen(name.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (id_) return;
  const std::string reason = hdf5_reason();
  const htri_t is_hdf5 = H5Fis_hdf5(name.c_str());
  throw InputError(name, "", (is_hdf5 > 0 ? "is damaged or truncated" : "is not a readable HDF5 file") + reason);
}

bool Hdf5File::has(const std::string& path) const {
  const QuietHdf5 quiet;
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    const std::string part = path.substr(0, end);
    if (!found(part, H5Lexists(id_.get(), part.c_str(), H5P_DEFAULT))) return false;
    if (!found(part, H5Oexists_by_name(id_.get(), part.c_str(), H5P_DEFAULT))) return false;
    if (end == std::string::npos) return true;
    H5O_info_t info;
    found(part, H5Oget_info_by_name2(id_.get(), part.c_str(), &info, H5O_INFO_BASIC, H5P_DEFAULT));
    if (info.type != H5O_TYPE_GROUP) fail(part, "is not a group");
  }
}

bool Hdf5File::has_attribute(const std::string& group, const std::string& name) const {
  if (group != "/" && !has(group)) return false;
  const QuietHdf5 quiet;
  return found(attribute_path(group, name), H5Aexists_by_name(id_.get(), group.c_str(), name.c_str(), H5P_DEFAULT));
}

bool Hdf5File::found(const std::string& path, htri_t answer) const {
  if (answer < 0) fail(path, "cannot be looked up: the file is damaged" + hdf5_reason());
  return answer > 0;
}

std::vector<std::string> Hdf5File::root_names() const {
  const QuietHdf5 quiet;
  std::vector<std::string> names;
  const auto append_name = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  if (H5Literate(id_.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr, append_name, &names) < 0)
    fail("/", "cannot be listed: the file is damaged" + hdf5_reason());
  return names;
}

Hdf5Dataset Hdf5File::dataset(const std::string& path, NumberKind kind, std::int64_t columns,
                              std::int64_t depth) const {
  if (!has(path)) fail(path, "is missing");
  const QuietHdf5 quiet;
  Hdf5Dataset result;
  result.file_ = name_;
  result.path_ = path;
  result.id_ = Hdf5Id(H5Dopen2(id_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!result.id_) fail(path, "is not a readable dataset" + hdf5_reason());
  result.check_type(kind);
  result.check_shape(columns, depth);
  result.check_size(bytes_);
  return result;
}

template <class T>
std::vector<T> Hdf5File::values(const std::string& path, std::int64_t rows, const std::string& of) const {
  const Hdf5Dataset data = dataset(path, std::is_same_v<T, double> ? NumberKind::real : NumberKind::integer);
  if (data.rows() != rows)
    data.fail("has " + std::to_string(data.rows()) + " entries" + (of.empty() ? ", but must have " : " for ") +
              std::to_string(rows) + of);
  std::vector<T> values;
  data.read(0, rows, values);
  return values;
}
template std::vector<std::int64_t> Hdf5File::values(const std::string&, std::int64_t, const std::string&) const;
template std::vector<double> Hdf5File::values(const std::string&, std::int64_t, const std::string&) const;

struct Hdf5File::Attribute {
  std::string path;
  Hdf5Id id, type, space;
};

Hdf5File::Attribute Hdf5File::open_attribute(const std::string& group, const std::string& name) const {
  const std::string path = attribute_path(group, name);
  if (!has_attribute(group, name)) fail(path, "is missing");
  Hdf5Id id(H5Aopen_by_name(id_.get(), group.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!id) fail(path, "cannot be opened" + hdf5_reason());
  Hdf5Id type(H5Aget_type(id.get()), H5Tclose), space(H5Aget_space(id.get()), H5Sclose);
  if (!type || !space) fail(path, "cannot be read" + hdf5_reason());
  return {path, std::move(id), std::move(type), std::move(space)};
}

std::string Hdf5File::string_attribute(const std::string& group, const std::string& name) const {
  const QuietHdf5 quiet;
  const auto [path, attribute, type, space] = open_attribute(group, name);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1)
    fail(path, "is not a string");
  const std::size_t size = H5Tget_size(type.get());
  if (H5Tis_variable_str(type.get()) > 0) {
    const Hdf5Id memory_type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(memory_type.get(), H5T_VARIABLE);
    H5Tset_cset(memory_type.get(), H5Tget_cset(type.get()));
    char* text = nullptr;
    if (H5Aread(attribute.get(), memory_type.get(), &text) < 0) fail(path, "cannot be read" + hdf5_reason());
    const std::string result = text ? text : "";
    H5free_memory(text);
    return result;
  }
  if (size > kLongestString) fail(path, "is a string of " + std::to_string(size) + " bytes: too long");
  std::string text(size, '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) fail(path, "cannot be read" + hdf5_reason());
  return unpadded(std::move(text), H5Tget_strpad(type.get()));
}

std::vector<std::int64_t> Hdf5File::integer_attribute(const std::string& group, const std::string& name,
                                                      std::size_t count) const {
  const QuietHdf5 quiet;
  const auto [path, attribute, type, space] = open_attribute(group, name);
  const hssize_t points = H5Sget_simple_extent_npoints(space.get());
  if (H5Tget_class(type.get()) != H5T_INTEGER || points < 0 || static_cast<std::size_t>(points) != count)
    fail(path, count == 1 ? "is not one integer" : "is not an array of " + std::to_string(count) + " integers");
  std::vector<std::int64_t> values(count);
  if (H5Aread(attribute.get(), H5T_NATIVE_INT64, values.data()) < 0) fail(path, "cannot be read" + hdf5_reason());
  return values;
}

void Hdf5File::fail(const std::string& path, const std::string& problem) const {
  throw InputError(name_, path, problem);
}
void Hdf5File::fail(const std::string& path, std::size_t row, const std::string& problem) const {
  throw InputError(name_, path, static_cast<std::int64_t>(row), problem);
}

}  // namespace volccd::detail
