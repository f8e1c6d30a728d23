// Plain HDF5 calls for tests, which read and damage files without the module under test.
#pragma once

#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <hdf5.h>

namespace volccd::test {

/// A file open for reading and writing. Handles are left to the library, which closes them with the file.
class RawFile {
 public:
  explicit RawFile(const std::string& path, bool create = false) {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    id_ = check(create ? H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access)
                       : H5Fopen(path.c_str(), H5F_ACC_RDWR, access));
    H5Pclose(access);
  }
  RawFile(const RawFile&) = delete;
  RawFile& operator=(const RawFile&) = delete;
  ~RawFile() { H5Fclose(id_); }

  hid_t id() const { return id_; }
  hid_t open(const std::string& path) const { return check(H5Dopen2(id_, path.c_str(), H5P_DEFAULT)); }

  std::vector<hsize_t> shape(const std::string& path) const {
    const hid_t space = H5Dget_space(open(path));
    std::vector<hsize_t> dims(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, dims.data(), nullptr);
    return dims;
  }
  std::size_t count(const std::string& path) const {
    std::size_t n = 1;
    for (const hsize_t d : shape(path)) n *= d;
    return n;
  }
  std::vector<std::int64_t> integers(const std::string& path) const {
    std::vector<std::int64_t> values(count(path));
    check(H5Dread(open(path), H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
    return values;
  }
  std::vector<double> reals(const std::string& path) const {
    std::vector<double> values(count(path));
    check(H5Dread(open(path), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
    return values;
  }

  /// Overwrites one entry, counted through all axes.
  void poke(const std::string& path, std::size_t at, std::int64_t value) {
    auto values = integers(path);
    values.at(at) = value;
    check(H5Dwrite(open(path), H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
  }
  void poke(const std::string& path, std::size_t at, double value) {
    auto values = reals(path);
    values.at(at) = value;
    check(H5Dwrite(open(path), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
  }

  void remove(const std::string& path) { check(H5Ldelete(id_, path.c_str(), H5P_DEFAULT)); }
  void group(const std::string& path) { check(H5Gcreate2(id_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)); }

  /// Replaces a dataset, if there is one, by these values. Values in excess of the shape are ignored.
  void put(const std::string& path, const std::vector<hsize_t>& dims, hid_t type, std::vector<std::int64_t> values) {
    const hid_t data = make(path, dims, type);
    values.resize(size(dims));
    check(H5Dwrite(data, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
  }
  void put(const std::string& path, const std::vector<hsize_t>& dims, hid_t type, std::vector<double> values) {
    const hid_t data = make(path, dims, type);
    values.resize(size(dims));
    check(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
  }
  /// A dataset that is declared, but has no stored values.
  void put_empty(const std::string& path, const std::vector<hsize_t>& dims, hid_t type, bool chunked) {
    make(path, dims, type, chunked);
  }

  void put_attribute(const std::string& object, const std::string& name, const std::vector<std::int64_t>& values) {
    const hsize_t n = values.size();
    const hid_t attribute =
        make_attribute(object, name, H5T_STD_I64LE, n == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &n, nullptr));
    check(H5Awrite(attribute, H5T_NATIVE_INT64, values.data()));
  }
  void put_attribute(const std::string& object, const std::string& name, const std::string& text,
                     bool variable = false) {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, variable ? H5T_VARIABLE : text.size() + 3);
    const hid_t attribute = make_attribute(object, name, type, H5Screate(H5S_SCALAR));
    const char* pointer = text.c_str();
    const std::string padded = text + std::string(3, '\0');
    check(H5Awrite(attribute, type, variable ? static_cast<const void*>(&pointer) : padded.data()));
  }
  void remove_attribute(const std::string& object, const std::string& name) {
    check(H5Adelete_by_name(id_, object.c_str(), name.c_str(), H5P_DEFAULT));
  }

  /// Paths of all groups and datasets.
  std::set<std::string> objects() const {
    std::set<std::string> paths;
    H5Lvisit(
        id_, H5_INDEX_NAME, H5_ITER_INC,
        [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
          static_cast<std::set<std::string>*>(out)->insert(name);
          return 0;
        },
        &paths);
    return paths;
  }

 private:
  template <class T>
  static T check(T result) {
    if (result < 0) throw std::runtime_error("plain HDF5 call failed");
    return result;
  }
  static std::size_t size(const std::vector<hsize_t>& dims) {
    std::size_t n = 1;
    for (const hsize_t d : dims) n *= d;
    return n;
  }
  hid_t make(const std::string& path, const std::vector<hsize_t>& dims, hid_t type, bool chunked = false) {
    if (H5Lexists(id_, path.c_str(), H5P_DEFAULT) > 0) remove(path);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (chunked) {
      const std::vector<hsize_t> chunk(dims.size(), 1);
      H5Pset_chunk(creation, static_cast<int>(dims.size()), chunk.data());
    }
    const hid_t space =
        dims.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr);
    return check(H5Dcreate2(id_, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT));
  }
  hid_t make_attribute(const std::string& object, const std::string& name, hid_t type, hid_t space) {
    if (H5Aexists_by_name(id_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0) remove_attribute(object, name);
    return check(
        H5Acreate_by_name(id_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }

  hid_t id_;
};

}  // namespace volccd::test
