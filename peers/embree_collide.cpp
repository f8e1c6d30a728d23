// `embree-collide`: rtcCollide of Embree 3 on a scene of user geometries, one primitive for each element.
//
// Embree reports a pair in both orders, and also pairs of primitives whose leaves overlap; the adaptor keeps one order
// and compares the two boxes. Embree ignores primitives whose coordinates exceed about 2e18, and treats subnormal
// numbers as zero in some places. Therefore boxes with such coordinates are scaled by a power of two, and subnormal
// numbers are replaced by zero. Both operations are monotone, so that overlapping boxes still overlap.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <embree3/rtcore.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <volccd/core/error.hpp>
#include <volccd/peers/detail/peer_phase.hpp>

namespace volccd::detail {

namespace {

struct EmbreeState final : PeerState {
  EmbreeState() : device(rtcNewDevice(nullptr)) {
    if (!device) throw ConfigError("embree-collide: Embree makes no device on this machine");
    rtcSetDeviceMemoryMonitorFunction(
        device,
        [](void* state, ssize_t bytes, bool) {
          static_cast<EmbreeState*>(state)->device_bytes += bytes;
          return true;
        },
        this);
  }
  EmbreeState(const EmbreeState&) = delete;
  EmbreeState& operator=(const EmbreeState&) = delete;
  ~EmbreeState() override {
    release();
    rtcReleaseDevice(device);
  }

  void release() {
    if (scene) rtcReleaseScene(scene);
    if (geometry) rtcReleaseGeometry(geometry);
    scene = nullptr;
    geometry = nullptr;
  }

  /// Throws std::bad_alloc or Error if an Embree call has failed since the last check.
  void check() const {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (error != RTC_ERROR_NONE) throw ConfigError("embree-collide: Embree reports error " + std::to_string(error));
  }

  std::size_t peer_bytes() const override {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(device_bytes.load(), 0));
  }

  RTCDevice device;
  RTCScene scene = nullptr;
  RTCGeometry geometry = nullptr;
  std::atomic<std::ptrdiff_t> device_bytes{0};
  std::optional<tbb::task_arena> arena;
  unsigned arena_workers = 0;
};

/// Embree's loops run in the arena of the calling thread. This arena has as many threads as there are workers, or as
/// oneTBB allows.
tbb::task_arena& arena_of(EmbreeState& state, unsigned workers) {
  if (state.arena_workers != workers) {
    const auto max = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    state.arena.emplace(static_cast<int>(std::min<std::size_t>(workers, max)));
    state.arena_workers = workers;
  }
  return *state.arena;
}

float without_subnormal(float x) { return std::abs(x) < std::numeric_limits<float>::min() ? 0.0f : x; }

void bound_primitive(const RTCBoundsFunctionArguments* arguments) {
  const EmbreeState& state = *static_cast<const EmbreeState*>(arguments->geometryUserPtr);
  const float *low = state.low(arguments->primID), *high = state.high(arguments->primID), scale = state.scale;
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = without_subnormal(low[0] * scale), bounds.upper_x = without_subnormal(high[0] * scale);
  bounds.lower_y = without_subnormal(low[1] * scale), bounds.upper_y = without_subnormal(high[1] * scale);
  bounds.lower_z = without_subnormal(low[2] * scale), bounds.upper_z = without_subnormal(high[2] * scale);
}

/// Data that the threads of a query share.
struct Query {
  EmbreeState* state;
  std::mutex mutex;
  std::exception_ptr failure;  ///< exception of the sink, which Embree would not propagate
  std::atomic<bool> failed{false};
};

void collect_pairs(void* user, RTCCollision* collisions, unsigned count) {
  Query& query = *static_cast<Query*>(user);
  if (query.failed.load(std::memory_order_relaxed)) return;
  EmbreeState& state = *query.state;
  const auto worker = static_cast<unsigned>(tbb::this_task_arena::current_thread_index());
  try {
    for (unsigned i = 0; i < count; ++i) {
      const Index p = collisions[i].primID0, q = collisions[i].primID1;
      if (p < q && state.overlap(p, q)) state.push(p, q, worker);
    }
  } catch (...) {
    const std::lock_guard lock(query.mutex);
    if (!query.failed.exchange(true)) query.failure = std::current_exception();
  }
}

class EmbreeCollide final : public PeerPhase {
 public:
  enum class Update { refit, build };

  struct Config {
    Update update = Update::refit;
    RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM;
  };
  static const Options<Config>& options() {
    static const Options<Config> options =
        Options<Config>()
            .add("update", &Config::update, {{"refit", Update::refit}, {"build", Update::build}},
                 "from step to step: RTC_BUILD_QUALITY_REFIT, or a new tree")
            .add("quality", &Config::quality,
                 {{"low", RTC_BUILD_QUALITY_LOW},
                  {"medium", RTC_BUILD_QUALITY_MEDIUM},
                  {"high", RTC_BUILD_QUALITY_HIGH}},
                 "of trees that are built: RTC_BUILD_QUALITY_LOW, _MEDIUM or _HIGH");
    return options;
  }

  explicit EmbreeCollide(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override { return std::make_unique<EmbreeState>(); }

 protected:
  void update(PeerState& peer, bool changed, Executor& executor) const override {
    EmbreeState& state = static_cast<EmbreeState&>(peer);
    if (changed) make_scene(state);
    if (!state.scene) return;
    state.set_scale();
    rtcCommitGeometry(state.geometry);
    arena_of(state, executor.workers()).execute([&] { rtcCommitScene(state.scene); });
    state.check();
  }

  void collide(PeerState& peer, Executor& executor) const override {
    EmbreeState& state = static_cast<EmbreeState&>(peer);
    Query query;
    query.state = &state;
    arena_of(state, executor.workers()).execute([&] { rtcCollide(state.scene, state.scene, collect_pairs, &query); });
    if (query.failure) std::rethrow_exception(query.failure);
    state.check();
  }

 private:
  /// Creates a scene with as many primitives as there are elements; no scene if there are none.
  void make_scene(EmbreeState& state) const {
    state.release();
    if (state.slots.size() == 0) return;
    state.scene = rtcNewScene(state.device);
    state.geometry = rtcNewGeometry(state.device, RTC_GEOMETRY_TYPE_USER);
    const bool refit = config_.update == Update::refit;
    // Embree refits only geometries in scenes of low quality, which are trees of trees; here there is one geometry.
    rtcSetSceneBuildQuality(state.scene, refit ? RTC_BUILD_QUALITY_LOW : config_.quality);
    if (refit) rtcSetSceneFlags(state.scene, RTC_SCENE_FLAG_DYNAMIC);
    rtcSetGeometryBuildQuality(state.geometry, refit ? RTC_BUILD_QUALITY_REFIT : config_.quality);
    rtcSetGeometryUserPrimitiveCount(state.geometry, static_cast<unsigned>(state.slots.size()));
    rtcSetGeometryUserData(state.geometry, &state);
    rtcSetGeometryBoundsFunction(state.geometry, bound_primitive, nullptr);
    rtcAttachGeometry(state.scene, state.geometry);
    state.check();
  }

  Config config_;
};

}  // namespace

StageDescriptor<BroadPhase> describe_embree_collide() {
  return describe_stage<BroadPhase, EmbreeCollide>("embree-collide", "Embree's rtcCollide over swept boxes",
                                                   Guarantee::conservative);
}

}  // namespace volccd::detail
