// What a Workspace holds.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include <volccd/narrowphase/initial_overlap.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

namespace detail {

/// Seconds since it was made or last asked.
class StopWatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Scratch and sums of one worker.
struct WorkerScratch {
  PairBatch batch;
  TestBatch tests;
  TestBlock block;
  std::vector<std::uint8_t> keep;
  std::vector<Contact> contacts;
  NarrowCounters narrow;
  InitialOverlapTest overlap_test;
  std::vector<ElementPair> overlap_candidates, overlaps;
  Statistics sums;

  std::size_t bytes() const {
    return batch.pairs.capacity() * sizeof(ElementPair) + batch.masks.capacity() * sizeof(FeatureMask) +
           (tests.vf.capacity() + tests.ee.capacity()) * sizeof(FeaturePair) + contacts.capacity() * sizeof(Contact) +
           (overlap_candidates.capacity() + overlaps.capacity()) * sizeof(ElementPair) + overlap_test.bytes() +
           TestBlock::kCapacity * 36 * sizeof(double);
  }
};

}  // namespace detail

struct Workspace::Data {
  std::uint64_t pipeline = 0;  ///< id of the one that made it
  bool intact = false;         ///< false during a run, and for good if that throws: then the states are made anew
  std::unique_ptr<StageState> broad_phase, feature_culling;
  std::vector<std::unique_ptr<StageState>> element_culling;
  std::vector<std::unique_ptr<detail::WorkerScratch>> workers;
};

}  // namespace volccd
