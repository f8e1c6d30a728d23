#include <volccd/distributed/region_filter.hpp>

#include <algorithm>
#include <array>

namespace volccd::distributed {

namespace {

/// Lower corner around all control points of some vertices.
Vec3 low_of(const Motion& motion, std::span<const Index> vertices) {
  Box box;
  extend(box, motion, vertices, motion.control_points());
  return box.low;
}

}  // namespace

std::size_t RegionFilter::select(const Step& step, StageState&, unsigned, FeatureKind kind,
                                 std::span<FeaturePair> tests) const {
  const std::size_t first = kind == FeatureKind::vf ? 1 : 2;  // vertices of the first feature
  const auto elsewhere = [&](FeaturePair pair) {
    const std::array<Index, 4> vertices = test_vertices(step.features(), kind, pair);
    const auto all = std::span(vertices);
    return !region_.contains(reference_point(low_of(step.motion, all.first(first)),
                                             low_of(step.motion, all.subspan(first)), step.separation));
  };
  return static_cast<std::size_t>(std::remove_if(tests.begin(), tests.end(), elsewhere) - tests.begin());
}

void RegionFilter::run(const Step&, StageState&, unsigned, const TestBlock&, std::span<std::uint8_t>) const {}

StageDescriptor<FeatureFilter> describe_region_filter(const Region& region) {
  return {"region",
          "tests whose reference point is in the region of the rank",
          Guarantee::exact,
          {},
          [&region](const OptionValues&) -> std::unique_ptr<FeatureFilter> {
            return std::make_unique<RegionFilter>(region);
          }};
}

}  // namespace volccd::distributed
