// `fcl-dynamic-tree`: DynamicAABBTreeCollisionManager of the Flexible Collision Library, in doubles, which represent
// the floats of the boxes exactly. There is one object for each element; FCL calls back for pairs of objects whose
// closed boxes overlap.
#include <limits>
#include <memory>
#include <vector>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/collision_geometry.h>
#include <fcl/narrowphase/collision_object.h>

#include <volccd/peers/detail/peer_phase.hpp>

namespace volccd::detail {

namespace {

using Manager = fcl::DynamicAABBTreeCollisionManager<double>;
using Object = fcl::CollisionObject<double>;

/// A geometry whose box is set by the adaptor. FCL uses only its box.
class SweptBox final : public fcl::CollisionGeometry<double> {
 public:
  void computeLocalAABB() override {}
};

struct FclState final : PeerState {
  Manager manager;
  std::vector<std::shared_ptr<SweptBox>> geometries;
  std::vector<Object> objects;  ///< indexed by position; the manager stores their addresses
  std::vector<Object*> addresses;

  /// Objects, geometries, two nodes and one entry of a hash table for each element.
  std::size_t peer_bytes() const override {
    constexpr std::size_t node = sizeof(Manager::DynamicAABBNode), entry = 4 * sizeof(void*);
    return objects.capacity() * (sizeof(Object) + sizeof(Object*) + sizeof(SweptBox) + 2 * sizeof(void*)) +
           objects.size() * (2 * node + entry);
  }
};

void make_objects(FclState& state) {
  const std::size_t count = state.slots.size();
  state.manager.clear();
  state.objects.clear();
  state.addresses.clear();
  while (state.geometries.size() < count) state.geometries.push_back(std::make_shared<SweptBox>());
  state.objects.reserve(count);
  for (std::size_t p = 0; p < count; ++p) {
    state.objects.emplace_back(state.geometries[p]);
    state.objects[p].setUserData(reinterpret_cast<void*>(p));
    state.addresses.push_back(&state.objects[p]);
  }
}

void set_boxes(FclState& state) {
  for (std::size_t p = 0; p < state.objects.size(); ++p) {
    fcl::AABB<double>& box = state.geometries[p]->aabb_local;
    const float *low = state.low(p), *high = state.high(p);
    box.min_ = {low[0], low[1], low[2]};
    box.max_ = {high[0], high[1], high[2]};
    state.objects[p].computeAABB();
  }
}

bool collect_pair(Object* a, Object* b, void* state) {
  const auto position = [](const Object* object) {
    return static_cast<Index>(reinterpret_cast<std::uintptr_t>(object->getUserData()));
  };
  static_cast<FclState*>(state)->push(position(a), position(b));
  return false;  // continue
}

class FclDynamicTree final : public PeerPhase {
 public:
  enum class Update { refit, build };

  struct Config {
    Update update = Update::refit;
  };
  static const Options<Config>& options() {
    static const Options<Config> options =
        Options<Config>().add("update", &Config::update, {{"refit", Update::refit}, {"build", Update::build}},
                              "from step to step: update() of the manager, which refits, or a new tree");
    return options;
  }

  explicit FclDynamicTree(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override { return std::make_unique<FclState>(); }

 protected:
  void update(PeerState& peer, bool changed, Executor&) const override {
    FclState& state = static_cast<FclState&>(peer);
    if (changed) make_objects(state);
    set_boxes(state);
    if (!changed && config_.update == Update::refit && state.manager.size() > 1) {
      state.manager.update();
      return;
    }
    state.manager.clear();
    state.manager.registerObjects(state.addresses);
  }

  void collide(PeerState& peer, Executor&) const override {
    FclState& state = static_cast<FclState&>(peer);
    state.manager.collide(&state, collect_pair);
  }

 private:
  Config config_;
};

}  // namespace

StageDescriptor<BroadPhase> describe_fcl_dynamic_tree() {
  return describe_stage<BroadPhase, FclDynamicTree>(
      "fcl-dynamic-tree", "FCL's DynamicAABBTreeCollisionManager over swept boxes", Guarantee::conservative);
}

}  // namespace volccd::detail
