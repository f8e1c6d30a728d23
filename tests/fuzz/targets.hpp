// The functions that are fuzzed. Each accepts any bytes, returns, and ends the process if a promise does not hold. Only
// exceptions that a header announces may leave the called functions. libFuzzer calls the targets (libfuzzer/entry.cpp),
// and the tests replay the committed corpora (replay_test.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace volccd::fuzz {

using Bytes = std::span<const std::uint8_t>;

/// Opens a sequence file (bytes that begin like HDF5), or a small valid file damaged by a script (hdf5_script.hpp),
/// reads it completely with its ground truth, and goes through its motions.
void sequence_reader(Bytes bytes);
/// Does the same with a query file.
void query_reader(Bytes bytes);
/// Reads lines of text: settings of a pipeline, and options of every stage.
void option_parser(Bytes bytes);
/// Compares every narrow phase and feature filter with exact_first_touch() on one test (narrow_phase_target.cpp).
void narrow_phase(Bytes bytes);
/// Makes small meshes, moves and edits them, and compares the contacts that VolCCD+ finds in their steps with exact
/// results (pipeline_target.cpp).
void pipeline(Bytes bytes);

/// Prints the reason, and aborts.
[[noreturn]] void promise_broken(const std::string& what);

}  // namespace volccd::fuzz
