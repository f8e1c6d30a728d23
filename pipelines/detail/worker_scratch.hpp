// What one worker does with tests and overlaps.
#pragma once

#include <span>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/narrowphase/overlap/initial_overlap.hpp>
#include <volccd/pipelines/detail/earliest_time.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/pipelines/test_chain.hpp>

namespace volccd::detail {

/// Scratch memory, counts and times of one worker.
struct alignas(64) WorkerScratch {
  Work work;  ///< what sources have handed out and is not processed yet
  PairBatch batch;
  TestChain chain;
  InitialOverlapTest overlap_test;
  std::vector<ElementPair> overlap_candidates, overlaps;
  std::vector<ElementPair> observed;        ///< the pairs before element culling, for an observer
  std::vector<std::uint8_t> observed_keep;  ///< which of them were kept
  Statistics sums;

  /// Removes the results of the last step, and sets counts and times to 0, for the stages of the pipeline and, at the
  /// end, the test of initial overlaps.
  void begin_step(const PipelineSpec& spec);
  /// Adds the counts of the chain to `sums`.
  void end_step();

  /// Finds initial overlaps among the pairs of the batch that are not proven to be disjoint.
  void test_overlaps(const Step& step);

  /// Runs the largest number of tests of each kind that is a multiple of `multiple`; the others remain for the next
  /// call.
  void run_tests(std::size_t multiple, EarliestTime& earliest);
  /// Runs all tests.
  void finish_tests(EarliestTime& earliest);

  std::size_t bytes() const;
};

}  // namespace volccd::detail
