// Statistics of a sequence for tables of scenes: sizes, motion, contacts and edits, motion by motion.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/mesh/element_type.hpp>

namespace volccd {

/// Numbers of contacts of a step. adjacent: every element of the one feature is adjacent to every element of the
/// other (Section 5.1). inter and intra: other contacts, between objects and within an object.
struct ContactCounts {
  std::uint64_t inter = 0, intra = 0, adjacent = 0;
};

/// Statistics of step k, from frame k to k+1, on the elements of frame k+1.
struct StepStatistics {
  double time = 0;                                               ///< of frame k
  std::map<ElementType, std::uint64_t> elements;                 ///< of frame k+1
  std::uint64_t removed = 0, added = 0;                          ///< elements, in step k; a changed one is both
  double mean_edge = 0;                                          ///< at frame k
  double median_motion = 0, p99_motion = 0, largest_motion = 0;  ///< of vertices in use, in mean edges
  ContactCounts contacts;                                        ///< without those of shell neighbours
  std::uint64_t contacts_at_start = 0;                           ///< of them, at t = 0
};

/// Statistics of all steps of a file, with contacts of the pipeline VolCCD+; shells are solid if the file has their
/// thickness. `go_on(done)` is called after each step; if it returns false, the work ends early. Throws the
/// exceptions of the reader and of the pipeline.
std::vector<StepStatistics> sequence_statistics(SequenceReader& reader, Executor& executor,
                                                const std::function<bool(int done)>& go_on = {});

nlohmann::json to_json(const std::vector<StepStatistics>& steps);

}  // namespace volccd
