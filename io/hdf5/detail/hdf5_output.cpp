#include <volccd/io/hdf5/detail/hdf5_output.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

#include <volccd/core/error.hpp>
#include <volccd/io/hdf5/detail/hdf5_write_driver.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kPlainEntries = 64;
constexpr unsigned kDeflate = 6;

/// The reason that the system gave if it refused to write, otherwise that of HDF5.
std::string reason(int write_error) {
  return write_error != 0 ? std::string(": ") + std::strerror(write_error) : hdf5_reason();
}

}  // namespace

void GrowingDataset::append_raw(const void* values, std::size_t count, hid_t type) {
  if (count == 0) return;
  const QuietHdf5 quiet;
  const int rank = columns_ > 1 ? 2 : 1;
  const hsize_t added[2] = {count / columns_, columns_};
  const hsize_t start[2] = {static_cast<hsize_t>(rows_), 0};
  const hsize_t extent[2] = {start[0] + added[0], columns_};
  bool done = H5Dset_extent(id_.get(), extent) >= 0;
  const Hdf5Id file_space(H5Dget_space(id_.get()), H5Sclose);
  const Hdf5Id memory_space(H5Screate_simple(rank, added, nullptr), H5Sclose);
  done = done && file_space && memory_space &&
         H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start, nullptr, added, nullptr) >= 0 &&
         H5Dwrite(id_.get(), type, memory_space.get(), file_space.get(), H5P_DEFAULT, values) >= 0;
  if (!done || *write_error_ != 0) throw InputError(file_, path_, rows_, "cannot be written" + reason(*write_error_));
  rows_ += static_cast<std::int64_t>(added[0]);
}

Hdf5Output::Hdf5Output(const std::string& name, std::string shown_as)
    : shown_as_(std::move(shown_as)), write_error_(std::make_unique<int>(0)) {
  const QuietHdf5 quiet;
  const Hdf5Id access = write_driver_access(write_error_.get());
  if (access) id_ = Hdf5Id(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose);
  check(static_cast<bool>(id_), "", "cannot be written");
}

void Hdf5Output::group(const std::string& path) {
  const QuietHdf5 quiet;
  const Hdf5Id id(H5Gcreate2(id_.get(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  check(static_cast<bool>(id), path, "cannot be made");
}

Hdf5Id Hdf5Output::create_dataset(const std::string& path, hid_t type, hid_t space, const hsize_t* chunk, int rank) {
  const Hdf5Id creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  // The same data give the same bytes: records identify their inputs by a hash of the file.
  check(H5Pset_obj_track_times(creation.get(), false) >= 0, path, "cannot be made");
  if (chunk)
    check(H5Pset_chunk(creation.get(), rank, chunk) >= 0 && H5Pset_shuffle(creation.get()) >= 0 &&
              H5Pset_deflate(creation.get(), kDeflate) >= 0,
          path, "cannot be made");
  Hdf5Id id(H5Dcreate2(id_.get(), path.c_str(), type, space, H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Dclose);
  check(static_cast<bool>(id), path, "cannot be made");
  return id;
}

GrowingDataset Hdf5Output::growing(const std::string& path, hid_t type, std::int64_t columns, std::int64_t chunk_rows) {
  const QuietHdf5 quiet;
  GrowingDataset result;
  result.file_ = shown_as_;
  result.path_ = path;
  result.write_error_ = write_error_.get();
  result.columns_ = static_cast<hsize_t>(columns);
  const int rank = columns > 1 ? 2 : 1;
  const hsize_t extent[2] = {0, result.columns_};
  const hsize_t greatest[2] = {H5S_UNLIMITED, result.columns_};
  const hsize_t chunk[2] = {static_cast<hsize_t>(chunk_rows), result.columns_};
  const Hdf5Id space(H5Screate_simple(rank, extent, greatest), H5Sclose);
  result.id_ = create_dataset(path, type, space.get(), chunk, rank);
  return result;
}

void Hdf5Output::whole(const std::string& path, hid_t file_type, hid_t memory_type, const void* values,
                       std::size_t count, bool as_column) {
  const QuietHdf5 quiet;
  const int rank = as_column ? 2 : 1;
  const hsize_t extent[2] = {count, 1};
  const hsize_t chunk[2] = {std::min<hsize_t>(count, 16384), 1};
  const Hdf5Id space(H5Screate_simple(rank, extent, nullptr), H5Sclose);
  const Hdf5Id id = create_dataset(path, file_type, space.get(), count > kPlainEntries ? chunk : nullptr, rank);
  check(H5Dwrite(id.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0, path, "cannot be written");
}

void Hdf5Output::attribute(const std::string& group, const std::string& name, hid_t file_type, hid_t memory_type,
                           hid_t space, const void* value) {
  const Hdf5Id id(H5Acreate_by_name(id_.get(), group.c_str(), name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT,
                                    H5P_DEFAULT),
                  H5Aclose);
  check(id && H5Awrite(id.get(), memory_type, value) >= 0, (group == "/" ? "" : group) + "@" + name,
        "cannot be written");
}

void Hdf5Output::string_attribute(const std::string& group, const std::string& name, const std::string& text) {
  const QuietHdf5 quiet;
  const bool ascii = std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 128; });
  const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), std::max<std::size_t>(text.size(), 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8);
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  attribute(group, name, type.get(), type.get(), space.get(), text.c_str());
}

void Hdf5Output::integer_attribute(const std::string& group, const std::string& name,
                                   std::span<const std::int64_t> values) {
  const QuietHdf5 quiet;
  const hsize_t extent = values.size();
  const Hdf5Id space(extent == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &extent, nullptr), H5Sclose);
  attribute(group, name, H5T_STD_I64LE, H5T_NATIVE_INT64, space.get(), values.data());
}

void Hdf5Output::close() {
  const QuietHdf5 quiet;
  const bool flushed = H5Fflush(id_.get(), H5F_SCOPE_LOCAL) >= 0;
  check(id_.reset() && flushed, "", "cannot be written");
}

void Hdf5Output::check(bool done, const std::string& path, const std::string& problem) const {
  if (!done || *write_error_ != 0) throw InputError(shown_as_, path, problem + reason(*write_error_));
}

}  // namespace volccd::detail
