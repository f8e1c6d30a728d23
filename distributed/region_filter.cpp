#include <volccd/distributed/region_filter.hpp>

#include <algorithm>
#include <array>
#include <vector>

#include <volccd/core/heap_bytes.hpp>

namespace volccd::distributed {

namespace {

/// Vertices whose bounds a worker computes in one go.
constexpr std::size_t kVertices = 4096;

/// By vertex: the lower bounds of its control points, enlarged. These bounds are monotone, so that the reference point
/// follows from them by minima and maxima (query/region.hpp).
struct State final : StageState {
  std::size_t bytes() const override { return heap_bytes(low); }

  std::vector<Vec3> low;
};

}  // namespace

std::unique_ptr<StageState> RegionFilter::make_state() const { return std::make_unique<State>(); }

void RegionFilter::prepare(const Step& step, StageState& state, Executor& executor) const {
  auto& low = static_cast<State&>(state).low;
  low.resize(step.motion.vertex_count());
  executor.parallel_for(low.size(), kVertices, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t v = begin; v < end; ++v) {
      const double* p = step.motion.at(static_cast<Index>(v));
      for (int i = 0; i < 3; ++i) {
        double lowest = p[i];
        for (int c = 1; c < step.motion.control_points(); ++c) lowest = std::min(lowest, p[3 * c + i]);
        low[v][i] = enlarged_low(lowest, step.separation);
      }
    }
  });
}

void RegionFilter::run(const Step& step, StageState& state, unsigned, const TestBlock& block,
                       std::span<std::uint8_t> keep) const {
  const auto& low = static_cast<const State&>(state).low;
  const bool vf = block.kind() == FeatureKind::vf;
  const Region region = step.piece.region;
  for (std::size_t test = 0; test < block.size(); ++test) {
    const std::array<Index, 4> v = block.vertices(test);
    const auto &p = low[v[0]], &q = low[v[1]], &r = low[v[2]], &s = low[v[3]];
    Vec3 point;
    for (int i = 0; i < 3; ++i) {
      const double second = std::min(r[i], s[i]);
      point[i] = vf ? std::max(p[i], std::min(q[i], second)) : std::max(std::min(p[i], q[i]), second);
    }
    if (!region.contains(point)) keep[test] = 0;
  }
}

StageDescriptor<FeatureFilter> describe_region_filter() {
  return {"region",
          "tests whose reference point is in the region of the rank",
          Guarantee::exact,
          {},
          [](const OptionValues&) -> std::unique_ptr<FeatureFilter> { return std::make_unique<RegionFilter>(); }};
}

}  // namespace volccd::distributed
