// `cgal-box-intersection`: box_self_intersection_d of CGAL (Zomorodian and Edelsbrunner 2002), in floats, with closed
// boxes. It keeps nothing from step to step; all of its work is in run(). It assumes that no box reaches the greatest
// floats; therefore boxes that come near them are scaled, and the adaptor compares the pairs itself. Licence: a program
// that contains this file is under the GPL.
#include <vector>

#include <CGAL/box_intersection_d.h>

#include <volccd/peers/detail/peer_phase.hpp>

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
  std::vector<CgalBox> intervals, points;  ///< the same boxes twice, because CGAL reorders them

  std::size_t peer_bytes() const override { return heap_bytes(intervals, points); }
};

class CgalBoxIntersection final : public PeerPhase {
 public:
  struct Config {
    int cutoff = 10;
  };
  static const Options<Config>& options() {
    static const Options<Config> options = Options<Config>().add(
        "cutoff", &Config::cutoff, 1, 100000, "boxes below which CGAL scans a list in place of a segment tree");
    return options;
  }

  explicit CgalBoxIntersection(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override { return std::make_unique<CgalState>(); }

 protected:
  void update(PeerState& peer, bool, Executor&) const override {
    CgalState& state = static_cast<CgalState&>(peer);
    state.set_scale();
    state.intervals.resize(state.slots.size());
    for (std::size_t p = 0; p < state.slots.size(); ++p) {
      CgalBox& box = state.intervals[p];
      for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = state.low(p)[axis] * state.scale;
        box.high[axis] = state.high(p)[axis] * state.scale;
      }
      box.position = static_cast<Index>(p);
    }
    state.points = state.intervals;
  }

  void collide(PeerState& peer, Executor&) const override {
    CgalState& state = static_cast<CgalState&>(peer);
    // The same as box_self_intersection_d, without the copy that it makes in each call.
    CGAL::box_intersection_d(
        state.intervals.begin(), state.intervals.end(), state.points.begin(), state.points.end(),
        [&](const CgalBox& a, const CgalBox& b) {
          if (state.scale == 1 || state.overlap(a.position, b.position)) state.push(a.position, b.position);
        },
        CGAL::Box_intersection_d::Box_traits_d<CgalBox>(), config_.cutoff, CGAL::Box_intersection_d::CLOSED,
        CGAL::Box_intersection_d::COMPLETE);
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
