#include <volccd/capi/guard.hpp>

#include <new>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

namespace volccd::capi {

namespace {

/// Of one thread. `shown` is a part of `text`, or a constant.
struct Message {
  std::string text;
  const char* shown = "";
};

Message& message() noexcept {
  thread_local Message of_thread;
  return of_thread;
}

int store(int code, const char* text) noexcept {
  Message& stored = message();
  try {
    stored.text = text;
    stored.shown = stored.text.c_str();
  } catch (...) {
    stored.shown = "out of memory, also for the message of another error";
  }
  return code;
}

int store_out_of_memory() noexcept {
  message().shown = "out of memory";
  return VOLCCD_ERROR_MEMORY;
}

}  // namespace

int store_exception() noexcept {
  try {
    throw;
  } catch (const ArgumentError& error) {
    return store(VOLCCD_ERROR_ARGUMENT, error.what());
  } catch (const InputError& error) {
    return store(VOLCCD_ERROR_INPUT, error.what());
  } catch (const ConfigError& error) {
    return store(VOLCCD_ERROR_CONFIG, error.what());
  } catch (const std::bad_alloc&) {
    return store_out_of_memory();
  } catch (const std::length_error&) {  // of a vector: more than memory can hold
    return store_out_of_memory();
  } catch (const std::exception& error) {
    return store(VOLCCD_ERROR_INTERNAL, error.what());
  } catch (...) {
    return store(VOLCCD_ERROR_INTERNAL, "an exception of an unknown type");
  }
}

}  // namespace volccd::capi

const char* volccd_last_error(void) { return volccd::capi::message().shown; }
