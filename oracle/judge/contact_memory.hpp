// A narrow phase that performs each test once for several pipelines.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include <volccd/pipelines/registry.hpp>
#include <volccd/query/roles/narrow_phase.hpp>

namespace volccd {

/// The results of tests of one step. Since the result of a test depends on its coordinates alone, pipelines that
/// share this memory find the same contacts as without it. Thread-safe except for clear().
class ContactMemory {
 public:
  /// `inner`: the narrow phase that performs the tests; must be able to run without a state of its own.
  explicit ContactMemory(std::unique_ptr<NarrowPhase> inner) : inner_(std::move(inner)) {}

  const NarrowPhase& inner() const { return *inner_; }
  /// To be called before each step, and if the separation or the latest time changes.
  void clear() { results_.clear(); }
  /// Appends the contacts of the block, as NarrowPhase::run().
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters);

 private:
  using Key = std::pair<FeatureKind, std::array<Index, 4>>;
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };

  /// Performs the tests of the block that are not known.
  void add_unknown(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                   NarrowCounters& counters);

  std::unique_ptr<NarrowPhase> inner_;
  std::unordered_map<Key, std::optional<Contact>, Hash> results_;
  std::mutex mutex_;
};

/// The stage `remembered`, an `inclusion` that lets exact arithmetic decide what it cannot, with this memory.
StageDescriptor<NarrowPhase> describe_remembered(std::shared_ptr<ContactMemory> memory);

/// The memory for that stage.
std::shared_ptr<ContactMemory> make_contact_memory(const Registry& registry);

}  // namespace volccd
