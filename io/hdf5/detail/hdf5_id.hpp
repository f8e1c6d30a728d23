// Ownership of HDF5 identifiers, and suppression of the messages that HDF5 prints.
#pragma once

#include <string>
#include <utility>

#include <hdf5.h>

namespace volccd::detail {

/// An identifier with the function that closes it. A negative identifier is empty.
class Hdf5Id {
 public:
  using Close = herr_t (*)(hid_t);

  Hdf5Id() = default;
  Hdf5Id(hid_t id, Close close) : id_(id), close_(close) {}
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Id() { reset(); }

  /// Closes the identifier. Returns false if HDF5 reports a failure (for example if a file cannot be flushed).
  bool reset();

  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// During its lifetime, HDF5 prints no errors of the calling thread. The destructor restores the caller's error
/// handler. Every function of this layer has such an object.
class QuietHdf5 {
 public:
  QuietHdf5();
  ~QuietHdf5();
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t handler_ = nullptr;
  void* data_ = nullptr;
};

/// The innermost entry of the thread's error stack, as " (HDF5: ...)", or an empty string. To be called while the
/// QuietHdf5 object of the failed call exists.
std::string hdf5_reason();

}  // namespace volccd::detail
