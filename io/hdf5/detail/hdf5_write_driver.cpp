#include <volccd/io/hdf5/detail/hdf5_write_driver.hpp>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <mutex>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

// HDF5 1.14 and later have a separate header for the interface of drivers.
#if __has_include(<H5FDdevelop.h>)
#include <H5FDdevelop.h>
#endif

namespace volccd::detail {

namespace {

/// `base` must be the first member, because HDF5 accesses only that.
struct DriverFile {
  H5FD_t base;
  int descriptor;
  haddr_t eoa, eof;
  int* error;
};

DriverFile& file_of(H5FD_t* base) { return *reinterpret_cast<DriverFile*>(base); }
const DriverFile& file_of(const H5FD_t* base) { return *reinterpret_cast<const DriverFile*>(base); }

void record_error(int* error) {
  if (*error == 0) *error = errno;
}

H5FD_t* open_file(const char* name, unsigned flags, hid_t access, haddr_t) {
  // The data that write_driver_access() passes to HDF5 are a pointer to the error.
  int* const* const error = static_cast<int* const*>(H5Pget_driver_info(access));
  if (!error) return nullptr;
  int mode = (flags & H5F_ACC_RDWR) != 0 ? O_RDWR : O_RDONLY;
  if ((flags & H5F_ACC_CREAT) != 0) mode |= O_CREAT;
  if ((flags & H5F_ACC_TRUNC) != 0) mode |= O_TRUNC;
  const int descriptor = ::open(name, mode | O_CLOEXEC, 0666);
  struct stat status {};
  if (descriptor < 0 || ::fstat(descriptor, &status) != 0) {
    record_error(*error);
    if (descriptor >= 0) ::close(descriptor);
    return nullptr;
  }
  DriverFile* const file = new DriverFile{};
  file->descriptor = descriptor;
  file->eof = static_cast<haddr_t>(status.st_size);
  file->error = *error;
  return &file->base;
}

herr_t close_file(H5FD_t* base) {
  DriverFile* const file = &file_of(base);
  if (::close(file->descriptor) != 0) record_error(file->error);
  delete file;
  return 0;
}

herr_t query_features(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t get_eoa(const H5FD_t* base, H5FD_mem_t) { return file_of(base).eoa; }

herr_t set_eoa(H5FD_t* base, H5FD_mem_t, haddr_t address) {
  file_of(base).eoa = address;
  return 0;
}

haddr_t get_eof(const H5FD_t* base, H5FD_mem_t) { return file_of(base).eof; }

/// Calls io, which is pread or pwrite, until all bytes are transferred, the file ends, or the system refuses. Returns
/// the number of bytes that are left.
template <class Io, class Byte>
std::size_t transfer(const DriverFile& file, Io io, Byte* at, std::size_t size, haddr_t address) {
  while (size > 0) {
    const ssize_t done = io(file.descriptor, at, size, static_cast<off_t>(address));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) record_error(file.error);
    if (done <= 0) break;
    at += done;
    address += static_cast<haddr_t>(done);
    size -= static_cast<std::size_t>(done);
  }
  return size;
}

/// Returns zeros for bytes that have not been written.
herr_t read_bytes(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* buffer) {
  char* const to = static_cast<char*>(buffer);
  const std::size_t left = transfer(file_of(base), ::pread, to, size, address);
  std::memset(to + (size - left), 0, left);
  return 0;
}

herr_t write_bytes(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, const void* buffer) {
  DriverFile& file = file_of(base);
  file.eof = std::max(file.eof, address + size);
  transfer(file, ::pwrite, static_cast<const char*>(buffer), size, address);
  return 0;
}

herr_t truncate_file(H5FD_t* base, hid_t, hbool_t) {
  DriverFile& file = file_of(base);
  if (file.eof == file.eoa) return 0;
  if (::ftruncate(file.descriptor, static_cast<off_t>(file.eoa)) != 0) record_error(file.error);
  file.eof = file.eoa;
  return 0;
}

H5FD_class_t driver_class() {
  H5FD_class_t driver{};
#ifdef H5FD_CLASS_VERSION
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(600);  // from the range for tests and private use
#endif
  driver.name = "volccd_write";
  driver.maxaddr = static_cast<haddr_t>(std::numeric_limits<off_t>::max());
  driver.fc_degree = H5F_CLOSE_WEAK;
  driver.fapl_size = sizeof(int*);
  driver.open = open_file;
  driver.close = close_file;
  driver.query = query_features;
  driver.get_eoa = get_eoa;
  driver.set_eoa = set_eoa;
  driver.get_eof = get_eof;
  driver.read = read_bytes;
  driver.write = write_bytes;
  driver.truncate = truncate_file;
  const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(map), std::end(map), driver.fl_map);
  return driver;
}

/// Registered once, and again if the application has closed the HDF5 library since.
hid_t registered_driver() {
  static const H5FD_class_t driver = driver_class();
  static std::mutex mutex;
  static hid_t id = -1;
  const std::lock_guard lock(mutex);
  if (id < 0 || H5Iget_type(id) != H5I_VFL) id = H5FDregister(&driver);
  return id;
}

}  // namespace

Hdf5Id write_driver_access(int* error) {
  const hid_t driver = registered_driver();
  Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (driver < 0 || !access || H5Pset_driver(access.get(), driver, &error) < 0) return {};
  return access;
}

}  // namespace volccd::detail
