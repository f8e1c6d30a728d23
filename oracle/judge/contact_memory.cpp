#include <volccd/oracle/judge/contact_memory.hpp>

#include <volccd/core/random.hpp>

namespace volccd {

namespace {

class Remembered final : public NarrowPhase {
 public:
  explicit Remembered(std::shared_ptr<ContactMemory> memory) : memory_(std::move(memory)) {}

  int max_control_points() const override { return memory_->inner().max_control_points(); }
  bool handles_separation() const override { return memory_->inner().handles_separation(); }
  double time_tolerance() const override { return memory_->inner().time_tolerance(); }
  std::unique_ptr<StageState> make_state() const override { return memory_->inner().make_state(); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    memory_->inner().prepare(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    memory_->run(step, state, worker, block, contacts, counters);
  }

 private:
  std::shared_ptr<ContactMemory> memory_;
};

}  // namespace

std::size_t ContactMemory::Hash::operator()(const Key& key) const {
  const auto& v = key.second;
  const std::uint64_t kind = key.first == FeatureKind::vf ? 0 : 1;
  return hash_ids((std::uint64_t{v[0]} << 32 | v[1]) ^ kind << 63, std::uint64_t{v[2]} << 32 | v[3]);
}

void ContactMemory::run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                        std::vector<Contact>& contacts, NarrowCounters& counters) {
  const std::scoped_lock lock(mutex_);
  add_unknown(step, state, worker, block, counters);
  for (std::size_t i = 0; i < block.size(); ++i) {
    const std::optional<Contact>& known = results_.find({block.kind(), block.vertices(i)})->second;
    if (known && known->toi <= step.t_max) contacts.push_back(*known);
  }
}

void ContactMemory::add_unknown(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                                NarrowCounters& counters) {
  std::array<std::uint8_t, TestBlock::kCapacity> unknown{};
  bool any = false;
  for (std::size_t i = 0; i < block.size(); ++i) {
    unknown[i] = results_.try_emplace({block.kind(), block.vertices(i)}).second;
    any = any || unknown[i];
  }
  if (!any) return;
  TestBlock rest;
  rest.append_kept(block, unknown);
  std::vector<Contact> found;
  inner_->run(step, state, worker, rest, found, counters);
  for (const Contact& contact : found) results_[{contact.kind, contact.vertices}] = contact;
}

StageDescriptor<NarrowPhase> describe_remembered(std::shared_ptr<ContactMemory> memory) {
  StageDescriptor<NarrowPhase> descriptor;
  descriptor.name = "remembered";
  descriptor.guarantee = Guarantee::conservative;
  descriptor.make = [memory = std::move(memory)](const OptionValues&) { return std::make_unique<Remembered>(memory); };
  return descriptor;
}

std::shared_ptr<ContactMemory> make_contact_memory(const Registry& registry) {
  return std::make_shared<ContactMemory>(registry.stage<NarrowPhase>("inclusion").make({{"undecided", "exact"}}));
}

}  // namespace volccd
