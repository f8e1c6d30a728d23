// The O-Set (Section 5.1, Algorithm 3) as an orphan source.
#pragma once

#include <volccd/culling/o_set/o_set.hpp>
#include <volccd/query/roles/orphan_source.hpp>

namespace volccd {

/// The state contains an OSet, which is built for the first topology and updated after edits (OSet::update). With the
/// minimal set and dynamic assignment each test is generated exactly once; the literal set repeats some tests.
class OSetSource final : public OrphanSource {
 public:
  struct Config {
    OSetKind kind = OSetKind::minimal;
  };
  static const Options<Config>& options();

  explicit OSetSource(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  std::size_t blocks(const StageState& state) const override;
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& out) const override;

 private:
  Config config_;
};

StageDescriptor<OrphanSource> describe_o_set();

}  // namespace volccd
