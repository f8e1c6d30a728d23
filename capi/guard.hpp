// The border between C++ exceptions and the error codes of the C interface.
#pragma once

#include <volccd/capi/volccd.h>
#include <volccd/core/error.hpp>

namespace volccd::capi {

/// An argument that the C interface itself refuses; the message names it.
class ArgumentError : public Error {
 public:
  using Error::Error;
};

/// The code of the exception that is being handled. Stores its message for volccd_last_error() of this thread.
int store_exception() noexcept;

/// Runs the body and returns VOLCCD_OK, or the code of its exception.
template <class Body>
int guarded(Body&& body) noexcept {
  try {
    body();
    return VOLCCD_OK;
  } catch (...) {
    return store_exception();
  }
}

}  // namespace volccd::capi
