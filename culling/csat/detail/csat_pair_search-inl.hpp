// CSAT tests of whole element pairs; each vector lane processes one pair. Included once for each instruction set by
// foreach_target.h of Highway.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include <hwy/cache_control.h>

#include <volccd/culling/csat/csat.hpp>
#include <volccd/culling/csat/detail/csat_pair_simplex-inl.hpp>

#if defined(VOLCCD_CSAT_PAIR_SEARCH_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_CSAT_PAIR_SEARCH_INL
#undef VOLCCD_CSAT_PAIR_SEARCH_INL
#else
#define VOLCCD_CSAT_PAIR_SEARCH_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

enum class PairFinding : std::uint8_t {
  open,
  disjoint,
  kept  ///< none of the axes that the configuration allows separates the pair, by more than rounding errors
};

/// The axes `centroid` and `optimal` in single precision. The finding for a pair does not depend on the other pairs of
/// its block.
template <int kControlPoints>
class PairSearch {
 public:
  static constexpr std::size_t kBlock = 256;

  PairSearch(const Csat::Config& config, const CsatFrame& frame, const Step& step)
      : rounds_(config.axis == CsatAxis::optimal ? std::min(config.iterations, kMaxRounds) : 1),
        step_(step),
        group_(frame, step) {}

  PairFinding finding(std::size_t i) const { return findings_[i]; }

  /// Computes the findings for at most kBlock pairs. Elements with more than 8 vertices and self pairs remain open.
  void judge(std::span<const ElementPair> pairs) {
    std::fill_n(findings_, pairs.size(), PairFinding::open);
    open_count_ = 0;
    look_up(pairs);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (i + 2 * PairList::kPairs < pairs.size()) prefetch(i + 2 * PairList::kPairs);
      enqueue(pairs, i, false);
    }
    test(false);
    for (std::size_t i = 0; i < open_count_; ++i) enqueue(pairs, open_[i], true);
    test(true);
  }

 private:
  static constexpr int kMaxRounds = 8;
  static constexpr int kEnough = 4;  ///< minimum number of pairs for a search in their group

  struct Vertices {
    const Index* data;
    std::size_t count;
  };

  /// Looks up the vertices of all pairs before any pair is tested, so that memory accesses overlap.
  void look_up(std::span<const ElementPair> pairs) {
    const auto of = [this](Index o) {
      const auto vertices = step_.mesh().vertices(o);
      hwy::Prefetch(vertices.data());
      return Vertices{vertices.data(), vertices.size()};
    };
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      vertices_[0][i] = of(pairs[i].a);
      vertices_[1][i] = of(pairs[i].b);
    }
  }

  void prefetch(std::size_t i) const {
    for (const auto& side : vertices_)
      for (std::size_t v = 0; v < side[i].count; ++v) hwy::Prefetch(step_.motion.at(side[i].data[v]));
  }

  void enqueue(std::span<const ElementPair> pairs, std::size_t i, bool search) {
    const Vertices a = vertices_[0][i], b = vertices_[1][i];
    if (pairs[i].a == pairs[i].b || std::max(a.count, b.count) > PairList::kVertices) return;
    if (list_.size == PairList::kPairs || a.count != list_.counts[0] || b.count != list_.counts[1]) {
      test(search);
      list_.counts[0] = a.count;
      list_.counts[1] = b.count;
    }
    list_.first[list_.size] = pairs[i].a;
    list_.vertices[0][list_.size] = a.data;
    list_.vertices[1][list_.size] = b.data;
    list_.index[list_.size++] = static_cast<std::uint8_t>(i);
  }

  /// Tests the pairs of the list and empties it. Unless `search`, tests the first axis; if few remain, defers them.
  void test(bool search) {
    if (list_.size == 0) return;
    group_.gather(list_);
    std::uint32_t left = (1u << list_.size) - 1;
    if (!search) left &= ~(group_.count() == 4 ? first_axis<4>() : first_axis<0>());
    for (std::size_t lane = 0; left >> lane != 0 && rounds_ > 1; lane += hn::Lanes(PairTag())) {
      std::uint32_t bits = left >> lane & ((1u << hn::Lanes(PairTag())) - 1);
      if (search || std::popcount(bits) >= kEnough)
        this->search(bits, lane);
      else
        for (; bits != 0; bits &= bits - 1) open_[open_count_++] = list_.index[lane + std::countr_zero(bits)];
    }
    list_.size = 0;
  }

  void set(std::uint32_t lanes, PairFinding finding) {
    for (; lanes != 0; lanes &= lanes - 1) findings_[list_.index[std::countr_zero(lanes)]] = finding;
  }

  /// Tests the line between the centroids. Returns the bits of the lanes that it separates.
  template <std::size_t kCount>
  std::uint32_t first_axis() {
    std::uint32_t apart = 0, missed = 0;
    for (std::size_t lane = 0; lane < list_.size; lane += hn::Lanes(PairTag())) {
      const PairLanes3 axis = group_.centroid_difference(lane);
      const PairThreshold threshold = group_.threshold(axis, group_.extent(lane));
      const PairLanes gap = group_.template gap<kCount>(axis, lane);
      apart |= lane_bits(threshold.exceeded(gap)) << lane;
      if (rounds_ == 1) missed |= lane_bits(threshold.missed(gap)) << lane;
    }
    const std::uint32_t all = (1u << list_.size) - 1;
    set(apart & all, PairFinding::disjoint);
    set(missed & all, PairFinding::kept);
    return apart;
  }

  /// A pair that the search leaves open is often a pair of adjacent elements, which no axis separates at the common
  /// vertex.
  void search(std::uint32_t bits, std::size_t lane) {
    for (std::uint32_t open = search_axis(bits, lane); open != 0; open &= open - 1) {
      const std::size_t i = lane + static_cast<std::size_t>(std::countr_zero(open));
      if (list_.adjacent(i)) findings_[list_.index[i]] = PairFinding::kept;
    }
  }

  /// Gilbert-Johnson-Keerthi iterations that start with the line between the centroids, as in Separator::search().
  /// Returns the bits of those requested lanes that remain open.
  std::uint32_t search_axis(std::uint32_t bits, std::size_t lane) {
    const PairLanes3 extent = group_.extent(lane);
    const PairLanes size = greatest_coordinate(extent);
    const PairLanes scale = hn::Div(in_lanes(1), size);
    PairLanes3 axis = scaled(group_.centroid_difference(lane), scale), support;
    PairSimplex simplex(axis);
    const PairMask in_range = hn::And(hn::Gt(size, in_lanes(kMinSize)), hn::Lt(size, in_lanes(kGreatestSize)));
    const PairLanes near = hn::Sub(hn::Mul(scale, in_lanes(0.999f * group_.separation())), in_lanes(1e-5f));
    std::uint32_t open = bits;
    bits &= lane_bits(in_range);
    for (int round = 0; bits != 0; ++round) {
      const PairLanes gap = group_.support(axis, lane, support);
      const std::uint32_t apart = bits & lane_bits(group_.threshold(axis, extent).exceeded(gap));
      set(apart << lane, PairFinding::disjoint);
      bits &= open &= ~apart;
      if (bits == 0 || round + 1 == rounds_) break;
      support = scaled(support, scale);
      bits &= ~lane_bits(simplex.contains(support));  // no axis has a larger gap
      const PairMask inside = simplex.extend(support, axis);
      const std::uint32_t kept = bits & lane_bits(hn::Or(inside, simplex.nearer_than(near)));
      set(kept << lane, PairFinding::kept);
      bits &= open &= ~kept;
    }
    return open;
  }

  static HWY_INLINE std::uint32_t lane_bits(PairMask mask) { return mask_bits(PairTag(), mask); }

  /// Outside of this range of sizes, products of the search could underflow or overflow; these pairs are tested in
  /// doubles.
  static constexpr float kMinSize = 0x1p-60f, kGreatestSize = 0x1p60f;

  int rounds_;
  const Step& step_;
  PairGroup<kControlPoints> group_;
  PairList list_;
  Vertices vertices_[2][kBlock];
  PairFinding findings_[kBlock];
  std::uint8_t open_[kBlock];
  std::size_t open_count_ = 0;
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
