// The O-Set part that all feature-culling strategies have in common.
#pragma once

#include <optional>

#include <volccd/core/options.hpp>
#include <volccd/culling/o_set.hpp>

namespace volccd::detail {

/// The option `oset` of a Config with a member of that name.
template <class Config>
void add_o_set_option(Options<Config>& options) {
  options.add("oset", &Config::oset,
              {{"none", OSetKind::none}, {"minimal", OSetKind::minimal}, {"literal", OSetKind::literal}},
              "pairs that no pair of non-adjacent elements covers: none, the minimal set, or Algorithm 3's");
}

/// An O-Set, or none.
class Orphans {
 public:
  explicit Orphans(OSetKind kind) {
    if (kind != OSetKind::none) set_.emplace(kind);
  }
  void update(const Topology& topology) {
    if (set_) set_->update(topology);
  }
  std::size_t blocks() const { return set_ ? set_->blocks() : 0; }
  void append(std::size_t block, TestBatch& out) const { set_->append(block, out); }
  std::size_t bytes() const { return set_ ? set_->bytes() : 0; }

 private:
  std::optional<OSet> set_;
};

}  // namespace volccd::detail
