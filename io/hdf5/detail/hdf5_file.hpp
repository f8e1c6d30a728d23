// Reading HDF5 files, datasets and attributes. Every HDF5 call is checked. Every error is an InputError that names the
// file, the dataset (or the attribute, as "group@name") and, if there is one, the row.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <volccd/io/hdf5/detail/hdf5_id.hpp>

namespace volccd::detail {

enum class NumberKind { integer, real };

/// A dataset of numbers of rank 1 to 3. When it is opened, its type, its rank, its number of columns, and the ratio of
/// its declared size to the stored bytes are checked, so that a small file cannot cause a huge allocation.
class Hdf5Dataset {
 public:
  const std::string& path() const { return path_; }
  std::int64_t rows() const { return rows_; }

  /// Replaces `out` by the rows [first, first + count), one row after another. Integers of up to 8 bytes are converted,
  /// real numbers of up to 8 bytes are widened. T is int64 or double. Throws if the range is not within [0, rows()].
  template <class T>
  void read(std::int64_t first, std::int64_t count, std::vector<T>& out) const;

  /// Throws an InputError, for one of the rows if `row` is given.
  [[noreturn]] void fail(std::int64_t row, const std::string& problem) const;
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  friend class Hdf5File;
  /// Number of values per row.
  std::int64_t width() const { return columns_ * depth_; }
  void check_type(NumberKind kind);
  void check_shape(std::int64_t columns, std::int64_t depth);
  void check_size(std::int64_t file_bytes) const;
  void read_raw(std::int64_t first, std::int64_t count, hid_t type, void* out) const;

  std::string file_, path_;
  Hdf5Id id_;
  std::int64_t rows_ = 0, columns_ = 1, depth_ = 1;
  int rank_ = 1;
  std::size_t item_bytes_ = 0;
  bool unsigned64_ = false;
};

/// An HDF5 file open for reading.
class Hdf5File {
 public:
  /// Throws InputError if the file does not exist, is not a regular file, is not an HDF5 file, or is damaged.
  explicit Hdf5File(const std::string& name);

  const std::string& name() const { return name_; }

  /// Whether there is an object at the path; false for a dangling soft link.
  bool has(const std::string& path) const;
  bool has_attribute(const std::string& group, const std::string& name) const;
  /// Names of all links in the root group, ascending.
  std::vector<std::string> root_names() const;

  /// Opens a dataset. `columns` is the size of the second dimension; for 1, the shapes [n] and [n, 1] are accepted.
  /// `depth` > 1 is the size of a third dimension.
  Hdf5Dataset dataset(const std::string& path, NumberKind kind, std::int64_t columns = 1, std::int64_t depth = 1) const;
  /// All values of a dataset that must have exactly `rows` rows, for int64 and double. `of` names in the error what has
  /// one row each, " pairs" for example.
  template <class T>
  std::vector<T> values(const std::string& path, std::int64_t rows, const std::string& of = "") const;

  /// The text of an attribute, a string of fixed or variable length.
  std::string string_attribute(const std::string& group, const std::string& name) const;
  /// The values of an attribute that must have exactly `count` integers.
  std::vector<std::int64_t> integer_attribute(const std::string& group, const std::string& name,
                                              std::size_t count) const;

  [[noreturn]] void fail(const std::string& path, const std::string& problem) const;
  [[noreturn]] void fail(const std::string& path, std::size_t row, const std::string& problem) const;

 private:
  struct Attribute;
  Attribute open_attribute(const std::string& group, const std::string& name) const;
  /// Whether HDF5 answered yes; throws if it could not look up the path.
  bool found(const std::string& path, htri_t answer) const;

  std::string name_;
  std::int64_t bytes_ = 0;
  Hdf5Id id_;
};

}  // namespace volccd::detail
