// Reading HDF5: files, datasets and attributes, each call checked. Whatever goes wrong is an InputError that names the
// file, the dataset (or attribute, "group@name") and, where there is one, the row.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <volccd/mesh/sequence/detail/hdf5_id.hpp>

namespace volccd::detail {

enum class NumberKind { integer, real };

/// A dataset of numbers, rank 1 to 3. What it declares is checked on opening: type, rank, columns, and that its size is
/// in proportion to the bytes that are stored, so that a few bytes cannot make a reader allocate without end.
class Hdf5Dataset {
 public:
  const std::string& path() const { return path_; }
  std::int64_t rows() const { return rows_; }
  std::int64_t columns() const { return columns_; }
  /// Numbers in a row.
  std::int64_t width() const { return columns_ * depth_; }

  /// Replaces `out` by rows [first, first + count), row by row. Integers of up to 8 bytes, converted; reals of up to 8
  /// bytes, widened. Throws if the range is not within [0, rows()].
  void read(std::int64_t first, std::int64_t count, std::vector<std::int64_t>& out) const;
  void read(std::int64_t first, std::int64_t count, std::vector<double>& out) const;

  /// An error at one of its rows.
  [[noreturn]] void fail(std::int64_t row, const std::string& problem) const;
  [[noreturn]] void fail(const std::string& problem) const;

 private:
  friend class Hdf5File;
  void check_type(NumberKind kind);
  void check_shape(std::int64_t columns, std::int64_t depth);
  void check_size(std::int64_t file_bytes) const;
  void read_raw(std::int64_t first, std::int64_t count, hid_t type, void* out) const;
  template <class T>
  void resize(std::vector<T>& out, std::int64_t first, std::int64_t count) const;

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
  /// Throws InputError: not there, not a regular file, not HDF5, damaged.
  explicit Hdf5File(const std::string& name);

  const std::string& name() const { return name_; }

  /// Whether the path leads to an object. Soft links that dangle do not.
  bool has(const std::string& path) const;
  bool has_attribute(const std::string& group, const std::string& name) const;
  /// Names of all links at the root, ascending.
  std::vector<std::string> root_names() const;

  /// `columns` is the extent of the second axis; 1 stands for [n] and [n, 1] alike. With `depth` > 1 there is a third.
  Hdf5Dataset dataset(const std::string& path, NumberKind kind, std::int64_t columns = 1, std::int64_t depth = 1) const;
  /// All of a dataset with exactly `rows` rows.
  std::vector<std::int64_t> integers(const std::string& path, std::int64_t rows) const;

  /// A string of fixed or variable length.
  std::string string_attribute(const std::string& group, const std::string& name) const;
  /// Exactly `count` integers.
  std::vector<std::int64_t> integer_attribute(const std::string& group, const std::string& name,
                                              std::size_t count) const;

  [[noreturn]] void fail(const std::string& path, const std::string& problem) const;

 private:
  Hdf5Id open_attribute(const std::string& group, const std::string& name) const;

  std::string name_;
  std::int64_t bytes_ = 0;
  Hdf5Id id_;
};

}  // namespace volccd::detail
