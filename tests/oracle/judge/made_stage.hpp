// Stages made of a function each, for the tests of the stage check.
#pragma once

#include <atomic>
#include <utility>

#include <volccd/query/roles/assignment.hpp>
#include <volccd/query/roles/broad_phase.hpp>
#include <volccd/query/roles/element_culling.hpp>
#include <volccd/query/roles/feature_filter.hpp>
#include <volccd/query/roles/narrow_phase.hpp>
#include <volccd/query/roles/orphan_source.hpp>

namespace volccd::test {

/// A stage made of a function.
template <class Interface, class Run>
class Made;

template <class Run>
class Made<FeatureFilter, Run> final : public FeatureFilter {
 public:
  explicit Made(Run run) : run_(run) {}
  void run(const Step& step, StageState&, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override {
    run_(step, worker, block, keep);
  }

 private:
  Run run_;
};

template <class Run>
class Made<ElementCulling, Run> final : public ElementCulling {
 public:
  explicit Made(Run run) : run_(run) {}
  void run(const Step& step, StageState&, unsigned worker, PairBatch& batch) const override {
    run_(step, worker, batch);
  }

 private:
  Run run_;
};

template <class Run>
class Made<NarrowPhase, Run> final : public NarrowPhase {
 public:
  explicit Made(Run run) : run_(run) {}
  int max_control_points() const override { return 3; }
  double time_tolerance() const override { return Inclusion(Inclusion::Config{}).time_tolerance(); }
  void run(const Step& step, StageState&, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    run_(step, worker, block, contacts, counters);
  }

 private:
  Run run_;
};

template <class Run>
class Made<Assignment, Run> final : public Assignment {
 public:
  explicit Made(Run run) : run_(run) {}
  std::unique_ptr<StageState> make_state() const override { return all_.make_state(); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    all_.prepare(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch,
           TestBatch& out) const override {
    const std::size_t begin = out.vf.size();
    all_.run(step, state, worker, batch, out);
    run_(begin, out);
  }

 private:
  AllPairs all_;
  Run run_;
};

template <class Run>
class Made<OrphanSource, Run> final : public OrphanSource {
 public:
  explicit Made(Run run) : run_(run) {}
  std::unique_ptr<StageState> make_state() const override { return set_.make_state(); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    set_.prepare(step, state, executor);
  }
  std::size_t blocks(const StageState& state) const override { return set_.blocks(state); }
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& out) const override {
    set_.run(step, state, worker, block, out);
    run_(block, out.tests);
  }

 private:
  OSetSource set_{OSetSource::Config{}};
  Run run_;
};

template <class Run>
class Made<BroadPhase, Run> final : public BroadPhase {
 public:
  explicit Made(Run run) : run_(run) {}
  std::unique_ptr<StageState> make_state() const override { return tree_.make_state(); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    tree_.prepare(step, state, executor);
  }
  /// Remembers the number of workers.
  std::size_t blocks(const Step& step, StageState& state, Executor& executor) const override {
    workers_ = executor.workers();
    return tree_.blocks(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override {
    Work own;
    tree_.run(step, state, worker, block, own);
    if (!own.pairs.empty()) run_(step, workers_, own.pairs, work.pairs);
  }

 private:
  mutable std::atomic<unsigned> workers_ = 1;
  KdopBvh tree_{KdopBvh::Config{}};
  Run run_;
};

}  // namespace volccd::test
