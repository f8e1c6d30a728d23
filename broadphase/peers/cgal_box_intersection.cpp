// `cgal-box-intersection`: box_self_intersection_d of CGAL (Zomorodian and Edelsbrunner 2002), in floats, closed. It keeps
// nothing from step to step: all of its work is in run(). GPL: a program with this file in it is under the GPL.
#include <algorithm>
#include <cstdint>
#include <vector>

#include <CGAL/box_intersection_d.h>

#include <volccd/broadphase/peers/detail/peer_phase.hpp>

namespace volccd::detail {

namespace {

/// A model of CGAL's concept BoxIntersectionBox_d.
struct CgalBox {
  using NT = float;
  using ID = std::size_t;

  float low[3], high[3];
  Index position;

  static int dimension() { return 3; }
  ID id() const { return position; }
  NT min_coord(int axis) const { return low[axis]; }
  NT max_coord(int axis) const { return high[axis]; }
};

struct CgalState final : PeerState {
  std::vector<CgalBox> boxes_of_cgal;

  /// CGAL makes a copy of the boxes while it runs.
  std::size_t peer_bytes() const override { return 2 * boxes_of_cgal.capacity() * sizeof(CgalBox); }
};

class CgalBoxIntersection final : public PeerPhase {
 public:
  struct Config {
    int cutoff = 10;
  };
  static const Options<Config>& options() {
    static const Options<Config> options = [] {
      Options<Config> o;
      o.add("cutoff", &Config::cutoff, 1, 100000, "boxes below which CGAL scans a list in place of a segment tree");
      return o;
    }();
    return options;
  }

  explicit CgalBoxIntersection(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override { return std::make_unique<CgalState>(); }

 protected:
  void update(PeerState& peer, bool, Executor&) const override {
    CgalState& state = static_cast<CgalState&>(peer);
    state.boxes_of_cgal.resize(state.list.size());
    for (std::size_t p = 0; p < state.list.size(); ++p) {
      CgalBox& box = state.boxes_of_cgal[p];
      std::copy_n(state.low(p), 3, box.low);
      std::copy_n(state.high(p), 3, box.high);
      box.position = static_cast<Index>(p);
    }
  }

  void collide(PeerState& peer, const PairRules& rules, Executor&) const override {
    CgalState& state = static_cast<CgalState&>(peer);
    const PeerOutput output(rules, state.list.slots(), state.writers[0]);
    CGAL::box_self_intersection_d(
        state.boxes_of_cgal.begin(), state.boxes_of_cgal.end(),
        [&](const CgalBox& a, const CgalBox& b) { output.push(a.position, b.position); },
        CGAL::Box_intersection_d::Box_traits_d<CgalBox>(), config_.cutoff, CGAL::Box_intersection_d::CLOSED);
  }

 private:
  Config config_;
};

}  // namespace

StageDescriptor<BroadPhase> describe_cgal_box_intersection() {
  return describe_stage<BroadPhase, CgalBoxIntersection>(
      "cgal-box-intersection", "CGAL's box_self_intersection_d over swept boxes", Guarantee::conservative);
}

}  // namespace volccd::detail
