// Writing HDF5: groups, attributes and datasets that grow. Every HDF5 call is checked.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <volccd/io/hdf5/detail/hdf5_id.hpp>

namespace volccd::detail {

/// A dataset to which rows are appended. Its rank is 1, or 2 if it has more than one column.
class GrowingDataset {
 public:
  void append(std::span<const std::int64_t> values) { append_raw(values.data(), values.size(), H5T_NATIVE_INT64); }
  void append(std::span<const double> values) { append_raw(values.data(), values.size(), H5T_NATIVE_DOUBLE); }

 private:
  friend class Hdf5Output;
  void append_raw(const void* values, std::size_t count, hid_t type);

  std::string file_, path_;
  const int* write_error_ = nullptr;
  Hdf5Id id_;
  std::int64_t rows_ = 0;
  hsize_t columns_ = 1;
};

/// A file open for writing. Errors are InputErrors that name the file `shown_as`, whatever its name on disk is, and the
/// reason that the system gives (for example disk full). After an error the file on disk is invalid; it can be closed
/// and removed.
class Hdf5Output {
 public:
  Hdf5Output(const std::string& name, std::string shown_as);

  void group(const std::string& path);
  /// Creates a dataset of unlimited size, with chunks, shuffle filter and gzip compression. `type` is the type in the
  /// file. Pre: `chunk_rows` >= 1.
  GrowingDataset growing(const std::string& path, hid_t type, std::int64_t columns, std::int64_t chunk_rows);
  /// Writes a whole dataset of shape [values.size()], or [values.size(), 1] with `as_column`. Datasets with more than
  /// 64 values are shuffled and gzip-compressed.
  void integers(const std::string& path, std::span<const std::int64_t> values, bool as_column = false) {
    whole(path, H5T_STD_I64LE, H5T_NATIVE_INT64, values.data(), values.size(), as_column);
  }
  void reals(const std::string& path, std::span<const double> values) {
    whole(path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), values.size(), false);
  }

  void string_attribute(const std::string& group, const std::string& name, const std::string& text);
  /// An array of integers, or a scalar if there is one value.
  void integer_attribute(const std::string& group, const std::string& name, std::span<const std::int64_t> values);

  /// Writes all buffers and closes the file. All datasets must have been closed before.
  void close();

 private:
  Hdf5Id create_dataset(const std::string& path, hid_t type, hid_t space, const hsize_t* chunk, int rank);
  void whole(const std::string& path, hid_t file_type, hid_t memory_type, const void* values, std::size_t count,
             bool as_column);
  void attribute(const std::string& group, const std::string& name, hid_t file_type, hid_t memory_type, hid_t space,
                 const void* value);
  /// Throws unless `done` is true and everything written so far has reached the file.
  void check(bool done, const std::string& path, const std::string& problem) const;

  std::string shown_as_;
  std::unique_ptr<int> write_error_;  ///< errno of the first failed write, or 0; outlives id_
  Hdf5Id id_;
};

}  // namespace volccd::detail
