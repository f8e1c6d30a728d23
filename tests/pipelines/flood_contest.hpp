// Compares `VolCCD+` with a flood that declines no step with the same pipeline without a flood.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "pipelines/scenes.hpp"

namespace volccd::test {

inline const ObjectFilter kNoFilter;

/// Undecided tests are left out, because a pipeline may leave out one that another stage has proven apart.
inline PipelineSpec spec_of(const char* flood) {
  PipelineSpec spec = registry().pipeline("VolCCD+");
  registry().apply_setting(spec, std::string("flood=") + flood);
  if (spec.flood)
    spec.flood->options = {{"max_boundary_fraction", "1"},
                           {"max_divided_fraction", "1"},
                           {"max_suspect_fraction", "1"},
                           {"max_pairs", "1e9"}};  // no step is left to the other stages
  spec.narrow_phase = {"inclusion", {{"undecided", "exact"}}};
  return spec;
}

class Contest {
 public:
  explicit Contest(const PipelineSpec& flooded = spec_of("boundary-flood"))
      : plain_(registry(), spec_of("none")),
        flooded_(registry(), flooded),
        plain_workspace_(plain_.make_workspace()),
        flooded_workspace_(flooded_.make_workspace()) {}

  /// Returns the number of contacts. The pipeline without a flood knows nothing of the step's piece.
  std::size_t compare(const Step& step, const std::string& what, const Request& request = {}) {
    SerialExecutor serial;
    StepResult expected, found;
    Step alone = step;
    alone.piece = {};
    plain_.run(alone, plain_workspace_, serial, expected, request);
    flooded_.run(step, flooded_workspace_, serial, found, request);
    const ContactDifference d = compare_contacts(expected.contacts, found.contacts);
    EXPECT_TRUE(d.empty()) << what << ": " << d.missing.size() << " of " << expected.contacts.size() << " missing, "
                           << d.extra.size() << " extra, " << d.changed.size() << " changed";
    EXPECT_EQ(expected.initial_overlaps, found.initial_overlaps) << what;
    initial_overlaps_ = expected.initial_overlaps.size();
    return expected.contacts.size();
  }
  /// Of the last step that was compared.
  std::size_t initial_overlaps() const { return initial_overlaps_; }

 private:
  Pipeline plain_, flooded_;
  Workspace plain_workspace_, flooded_workspace_;
  std::size_t initial_overlaps_ = 0;
};

}  // namespace volccd::test
