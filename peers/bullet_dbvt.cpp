// `bullet-dbvt`: btDbvt of Bullet, in floats, without margins. The tree calls back for pairs of leaves whose closed
// boxes overlap, each unordered pair once. Its builder fails if the volume of a box overflows; therefore boxes that are
// too large are scaled, and the adaptor compares the pairs itself.
#include <algorithm>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <volccd/peers/detail/peer_phase.hpp>

namespace volccd::detail {

namespace {

struct BulletState final : PeerState {
  btDbvt tree;
  std::vector<btDbvtNode*> leaves;  ///< indexed by position
  std::vector<btDbvtNode*> inner;   ///< children before parents

  std::size_t peer_bytes() const override {
    return 2 * leaves.size() * sizeof(btDbvtNode) + heap_bytes(leaves, inner) +
           static_cast<std::size_t>(tree.m_stkStack.capacity()) * sizeof(btDbvt::sStkNN);
  }

  btDbvtVolume volume(std::size_t position) const {
    const float *lo = low(position), *hi = high(position), s = scale;
    return btDbvtVolume::FromMM({lo[0] * s, lo[1] * s, lo[2] * s}, {hi[0] * s, hi[1] * s, hi[2] * s});
  }
};

void set_leaves(BulletState& state) {
  for (std::size_t p = 0; p < state.leaves.size(); ++p) state.leaves[p]->volume = state.volume(p);
}

/// Lists the inner nodes in an order in which they can be refitted.
void order_nodes(BulletState& state) {
  state.inner.clear();
  if (state.tree.m_root && state.tree.m_root->isinternal()) state.inner.push_back(state.tree.m_root);
  for (std::size_t i = 0; i < state.inner.size(); ++i)
    for (btDbvtNode* child : state.inner[i]->childs)
      if (child->isinternal()) state.inner.push_back(child);
  std::reverse(state.inner.begin(), state.inner.end());
}

/// The same operation as btSoftBody::updateNode(), without recursion.
void refit(BulletState& state) {
  set_leaves(state);
  for (btDbvtNode* node : state.inner) Merge(node->childs[0]->volume, node->childs[1]->volume, node->volume);
}

struct PairCollector final : btDbvt::ICollide {
  explicit PairCollector(BulletState& state_) : state(state_) {}
  using btDbvt::ICollide::Process;
  void Process(const btDbvtNode* a, const btDbvtNode* b) override {
    const Index p = static_cast<Index>(a->dataAsInt), q = static_cast<Index>(b->dataAsInt);
    if (state.scale == 1 || state.overlap(p, q)) state.push(p, q);
  }
  BulletState& state;
};

class BulletDbvt final : public PeerPhase {
 public:
  enum class Update { refit, leaves, build };

  struct Config {
    Update update = Update::refit;
    int bottom_up = 3;
  };
  static const Options<Config>& options() {
    static const Options<Config> options =
        Options<Config>()
            .add("update", &Config::update,
                 {{"refit", Update::refit}, {"leaves", Update::leaves}, {"build", Update::build}},
                 "from step to step: all nodes are refitted as in btSoftBody, each leaf is inserted anew by "
                 "btDbvt::update, or the tree is built by optimizeTopDown")
            .add("bottom_up", &Config::bottom_up, 3, 1024,
                 "leaves below which optimizeTopDown clusters bottom-up, in cubic time; Bullet's default is 128");
    return options;
  }

  explicit BulletDbvt(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override { return std::make_unique<BulletState>(); }

 protected:
  void update(PeerState& peer, bool changed, Executor&) const override {
    BulletState& state = static_cast<BulletState&>(peer);
    state.set_scale();
    if (changed)
      make_leaves(state);
    else if (config_.update == Update::refit)
      refit(state);
    else if (config_.update == Update::leaves)
      for (std::size_t p = 0; p < state.leaves.size(); ++p) {
        btDbvtVolume volume = state.volume(p);
        state.tree.update(state.leaves[p], volume);
      }
    else
      build(state);
  }

  void collide(PeerState& peer, Executor&) const override {
    BulletState& state = static_cast<BulletState&>(peer);
    PairCollector collector(state);
    state.tree.collideTTpersistentStack(state.tree.m_root, state.tree.m_root, collector);
  }

 private:
  void make_leaves(BulletState& state) const {
    state.tree.clear();
    state.leaves.clear();
    for (std::size_t p = 0; p < state.slots.size(); ++p) {
      state.leaves.push_back(state.tree.insert(state.volume(p), nullptr));
      state.leaves[p]->dataAsInt = static_cast<int>(p);
    }
    build(state);
  }

  void build(BulletState& state) const {
    set_leaves(state);
    state.tree.optimizeTopDown(config_.bottom_up);
    order_nodes(state);
  }

  Config config_;
};

}  // namespace

StageDescriptor<BroadPhase> describe_bullet_dbvt() {
  return describe_stage<BroadPhase, BulletDbvt>("bullet-dbvt", "Bullet's btDbvt over swept boxes",
                                                Guarantee::conservative);
}

}  // namespace volccd::detail
