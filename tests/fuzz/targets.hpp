// What is fuzzed. Each target takes any bytes, returns, and ends the process if a promise does not hold; nothing but
// the exceptions that a header announces may come out of what it calls. libFuzzer drives them (libfuzzer/entry.cpp);
// the tests replay the committed corpora (replay_test.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace volccd::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// A sequence file (bytes that begin like HDF5), or a script of edits to a small valid one (hdf5_script.hpp): opened,
/// read whole, ground truth included, and stepped through.
void sequence_reader(Bytes bytes);
/// The same for a query file.
void query_reader(Bytes bytes);
/// Lines of text: settings of a pipeline, and options of every stage.
void option_parser(Bytes bytes);
/// One elementary test (narrow_phase_target.cpp): every narrow phase and feature filter against exact_first_touch().
void narrow_phase(Bytes bytes);

/// Prints why, and aborts.
[[noreturn]] void promise_broken(const std::string& what);

}  // namespace volccd::fuzz
