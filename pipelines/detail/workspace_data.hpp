// The contents of a Workspace.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/narrowphase/overlap/initial_overlap.hpp>
#include <volccd/pipelines/detail/contact_order.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/pipelines/test_chain.hpp>

namespace volccd {

namespace detail {

/// Scratch memory, counts and times of one worker.
struct alignas(64) WorkerScratch {
  PairBatch batch;
  TestBatch tests;
  TestChain chain;
  InitialOverlapTest overlap_test;
  std::vector<ElementPair> overlap_candidates, overlaps;
  std::vector<Contact> left_out;
  std::vector<ElementPair> observed;        ///< the pairs before element culling, for an observer
  std::vector<std::uint8_t> observed_keep;  ///< which of them were kept
  Statistics sums;

  std::size_t bytes() const {
    return sizeof(*this) + heap_bytes(batch, tests.vf, tests.ee, chain, overlap_test, overlap_candidates, overlaps,
                                      left_out, observed, observed_keep);
  }
};

}  // namespace detail

struct Workspace::Data {
  std::uint64_t pipeline = 0;  ///< id of the pipeline that created the workspace
  bool intact = false;         ///< false during a run, and after a run that threw; then the states are recreated
  std::vector<std::unique_ptr<StageState>> states;  ///< in the order of the stages
  std::unique_ptr<StageState> flood_broad_phase;    ///< state of the broad phase for steps that a flood accepts
  std::vector<std::unique_ptr<detail::WorkerScratch>> workers;
  detail::ContactOrder order;
  std::vector<std::span<const Contact>> contacts_of, left_out_of;  ///< by worker, when a run collects its result
};

}  // namespace volccd
