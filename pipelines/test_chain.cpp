#include <volccd/pipelines/test_chain.hpp>

#include <algorithm>
#include <stdexcept>

#include <volccd/pipelines/detail/mark_kept.hpp>

namespace volccd {

void TestChain::start(const Step& step, const TestStages& stages, std::span<StageStatistics> statistics,
                      unsigned worker) {
  step_ = &step;
  stages_ = &stages;
  statistics_ = statistics;
  worker_ = worker;
  t_max_ = step.t_max;
  for (Blocks& list : blocks_) {
    list.resize(stages.filters.size() + 1);
    for (TestBlock& block : list) block.clear();
  }
  collected_.clear();
  contacts_.clear();
  counters_ = {};
  tests_ = {};
  clock_ = {};
}

std::size_t TestChain::bytes() const {
  std::size_t sum = heap_bytes(contacts_, collected_.vf, collected_.ee);
  for (const Blocks& list : blocks_) sum += list.size() * sizeof(TestBlock);
  return sum;
}

void TestChain::add(FeatureKind kind, std::span<FeaturePair> tests) {
  if (drops_first()) {
    const auto excluded = [&](FeaturePair pair) { return !step_->asks_for(kind, pair); };
    tests = {tests.begin(), std::remove_if(tests.begin(), tests.end(), excluded)};
  }
  StageTimer timer(clock_, statistics_[0].seconds);
  if (!stages_->given && !stages_->filters.empty()) tests = select(kind, tests);
  const bool starts = finds_at_start();
  while (!tests.empty()) {
    const std::size_t taken = std::min(tests.size(), TestBlock::kCapacity);
    TestBlock& block = starts ? given_ : blocks(kind)[0];
    block.gather(*step_, kind, tests.first(taken));
    starts ? find_at_start() : run(kind, 0);
    tests = tests.subspan(taken);
  }
}

/// Without filters, the narrow phase sees all tests anyway.
bool TestChain::finds_at_start() const {
  return stages_->given && !stages_->collect && !stages_->filters.empty() && step_->separation > 0 &&
         step_->piece.region.is_all();
}

/// Finds contacts at the start among the tests in given_, and passes the others on to the filters.
void TestChain::find_at_start() {
  const FeatureKind kind = given_.kind();
  std::array<std::uint8_t, TestBlock::kCapacity> keep, found{};
  keep.fill(1);
  const std::size_t before = contacts_.size(), narrow = stages_->filters.size();
  {
    const StageTimer timer(clock_, statistics_[narrow].seconds);
    stages_->narrow_phase.find_at_start(*step_, given_, contacts_, keep);
    name_features(given_, before, found);
    const auto unasked = [&](const Contact& c) { return !step_->asks_for(kind, c.features); };
    if (!drops_first() && !step_->asks_for_all())
      contacts_.erase(std::remove_if(contacts_.begin() + static_cast<std::ptrdiff_t>(before), contacts_.end(), unasked),
                      contacts_.end());
  }
  const std::size_t count = contacts_.size() - before;
  tests_[static_cast<std::size_t>(kind)] += count;
  statistics_[narrow].in += count;
  statistics_[narrow].out += count;
  observe_found(before);
  TestBlock& next = blocks(kind)[0];
  for (std::size_t begin = 0; begin < given_.size();) {
    begin = next.append_kept(given_, keep, begin);
    if (next.full()) run(kind, 0);
  }
}

/// Whether tests that are not asked for are dropped before the filters, and not after them. Most tests are asked for,
/// except where the scope of pairs is restricted, and after the filters fewer need to be looked up.
bool TestChain::drops_first() const {
  const ObjectFilter& rule = step_->filter;
  return rule.scope() != PairScope::all || (stages_->filters.empty() && !rule.trivial());
}

/// The tests that the first filter does not drop before their coordinates are gathered. It sees the others again.
std::span<FeaturePair> TestChain::select(FeatureKind kind, std::span<FeaturePair> tests) {
  if (stages_->observer) observed_.assign(tests.begin(), tests.end());
  const std::size_t left = stages_->filters[0]->select(step_->until(t_max_), *stages_->states[0], worker_, kind, tests);
  statistics_[0].in += tests.size() - left;
  if (stages_->observer) observe_dropped(kind, tests.first(left));
  return tests.first(left);
}

void TestChain::finish() {
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (std::size_t stage = 0; stage < blocks(kind).size(); ++stage)
      if (!blocks(kind)[stage].empty()) run(kind, stage);
}

void TestChain::run(FeatureKind kind, std::size_t stage) {
  StageTimer timer(clock_, statistics_[stage].seconds);
  TestBlock& block = blocks(kind)[stage];
  statistics_[stage].in += block.size();
  if (stage < stages_->filters.size())
    run_filter(kind, stage);
  else if (stages_->collect)
    collect(block);
  else
    run_narrow_phase(block);
  block.clear();
}

void TestChain::run_filter(FeatureKind kind, std::size_t stage) {
  const TestBlock& block = blocks(kind)[stage];
  std::array<std::uint8_t, TestBlock::kCapacity> flags;
  flags.fill(1);
  const auto keep = std::span(flags).first(block.padded_size());
  stages_->filters[stage]->run(step_->until(t_max_), *stages_->states[stage], worker_, block, keep);
  const auto dropped = std::count(keep.begin(), keep.begin() + static_cast<std::ptrdiff_t>(block.size()), 0);
  statistics_[stage].out += block.size() - static_cast<std::size_t>(dropped);
  observe(stage, block, keep);
  const bool last = stage + 1 == stages_->filters.size();
  if (last && !drops_first() && !step_->asks_for_all())
    for (std::size_t i = 0; i < block.size(); ++i)
      if (keep[i] != 0 && !step_->asks_for(kind, block.pair(i))) keep[i] = 0;
  TestBlock& next = blocks(kind)[stage + 1];
  for (std::size_t begin = 0; begin < block.size();) {
    begin = next.append_kept(block, keep, begin);
    if (next.full()) run(kind, stage + 1);
  }
}

void TestChain::collect(const TestBlock& block) {
  std::vector<FeaturePair>& list = block.kind() == FeatureKind::vf ? collected_.vf : collected_.ee;
  list.insert(list.end(), block.pairs().begin(), block.pairs().end());
}

void TestChain::run_narrow_phase(const TestBlock& block) {
  tests_[static_cast<std::size_t>(block.kind())] += block.size();
  const std::size_t before = contacts_.size();
  const std::size_t stage = stages_->filters.size();
  stages_->narrow_phase.run(*step_, *stages_->states[stage], worker_, block, contacts_, counters_);
  statistics_[stage].out += contacts_.size() - before;
  std::array<std::uint8_t, TestBlock::kCapacity> found{};
  name_features(block, before, found);
  if (stages_->filters.empty()) drop_shell_neighbours(before);
  observe(stage, block, found);
}

/// Sets the features of the contacts from `first` on, which are in the order of the block, and found[i] for their
/// tests.
void TestChain::name_features(const TestBlock& block, std::size_t first, std::span<std::uint8_t> found) {
  std::size_t test = 0;
  for (Contact& contact : std::span(contacts_).subspan(first)) {
    while (test < block.size() && block.vertices(test) != contact.vertices) ++test;
    if (test == block.size())
      throw std::logic_error("the contacts of a narrow phase are not those of its block, or not in its order");
    contact.features = block.pair(test);
    found[test++] = 1;
  }
}

/// Removes contacts that are not asked for, from `first` on: without filters, to look up all tests would take as long
/// as to perform those that are not asked for.
void TestChain::drop_shell_neighbours(std::size_t first) {
  if (!step_->leave_out_shell_neighbours) return;
  const auto begin = contacts_.begin() + static_cast<std::ptrdiff_t>(first);
  contacts_.erase(
      std::remove_if(begin, contacts_.end(), [](const Contact& c) { return share_shell_vertex(c.kind, c.vertices); }),
      contacts_.end());
}

void TestChain::observe(std::size_t stage, const TestBlock& block, std::span<const std::uint8_t> keep) {
  if (!stages_->observer) return;
  const StageTimer none(clock_);
  stages_->observer->observe(stages_->first_stage + stage, worker_, *step_, block.kind(), block.pairs(),
                             keep.first(block.size()));
}

/// Tells of the tests whose contacts, from `first` on, were found before the filters.
void TestChain::observe_found(std::size_t first) {
  if (!stages_->observer || first == contacts_.size()) return;
  const StageTimer none(clock_);
  const std::span<const Contact> contacts = std::span(contacts_).subspan(first);
  observed_.clear();
  for (const Contact& contact : contacts) observed_.push_back(contact.features);
  observed_keep_.assign(contacts.size(), 1);
  stages_->observer->observe(stages_->first_stage + stages_->filters.size(), worker_, *step_, contacts[0].kind,
                             observed_, observed_keep_);
}

/// Tells of the tests in observed_ that are not in `kept`.
void TestChain::observe_dropped(FeatureKind kind, std::span<const FeaturePair> kept) {
  const StageTimer none(clock_);
  detail::mark_kept<FeaturePair>(observed_, kept, observed_keep_);
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < observed_.size(); ++i)
    if (observed_keep_[i] == 0) observed_[dropped++] = observed_[i];
  observed_keep_.assign(dropped, 0);
  stages_->observer->observe(stages_->first_stage, worker_, *step_, kind, std::span(observed_).first(dropped),
                             observed_keep_);
}

}  // namespace volccd
