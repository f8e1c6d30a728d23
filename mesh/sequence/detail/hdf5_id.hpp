// Ownership of HDF5 identifiers, and silence of HDF5's own error printing.
#pragma once

#include <string>
#include <utility>

#include <hdf5.h>

namespace volccd::detail {

/// An identifier with the function that closes its kind. Negative: none.
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

  /// Returns false if HDF5 reports a failure (a file that cannot be flushed).
  bool reset();

  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// While it lives, HDF5 prints no errors from the calling thread; the caller's own handler is put back afterwards.
/// Every function of this layer holds one.
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

/// The innermost entry of the thread's error stack, " (HDF5: ...)", or nothing. To be asked under the QuietHdf5 under
/// which the call failed.
std::string hdf5_reason();

}  // namespace volccd::detail
