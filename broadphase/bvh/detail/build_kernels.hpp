// The inner loops of TreeBuilder, selected at run time for the instruction set of the processor.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>

namespace volccd::detail {

/// Lower ends along x, y and z, and from lane 4 on negated upper ends; lanes 3 and 7 have no meaning.
struct BuildBox {
  std::array<float, 8> ends;

  static BuildBox empty() {
    BuildBox box;
    box.ends.fill(std::numeric_limits<float>::infinity());
    return box;
  }
  void add(const BuildBox& other) {
    for (std::size_t c = 0; c < ends.size(); ++c) ends[c] = std::min(ends[c], other.ends[c]);
  }
  /// Twice the centre, which may overflow.
  float key(std::size_t axis) const { return ends[axis] - ends[4 + axis]; }
  /// In doubles, because differences of floats may overflow.
  double extent(std::size_t axis) const {
    return -static_cast<double>(ends[4 + axis]) - static_cast<double>(ends[axis]);
  }
  double half_area() const {
    const double x = extent(0), y = extent(1), z = extent(2);
    return x >= 0 ? x * y + y * z + z * x : 0;
  }
};

/// An element with its bounds and its position in the list.
struct BuildItem {
  BuildBox box;
  Index position;
};

/// Bins of equal size along each axis, for the keys of items.
struct BuildBins {
  static constexpr std::size_t kCount = 16;
  struct Bin {
    BuildBox box;
    Index count;
  };
  using Contents = std::array<std::array<Bin, kCount>, 3>;

  std::array<float, 4> first{}, scale{};  ///< scale: 0 for an axis that is not divided

  /// `keys`: the range of the keys. An axis on which it is a point or overflows is not divided.
  explicit BuildBins(const BuildBox& keys) {
    constexpr double max = std::numeric_limits<float>::max();
    for (std::size_t c = 0; c < 3; ++c)
      if (keys.extent(c) > 0 && keys.extent(c) <= 2 * max) {
        first[c] = keys.ends[c];
        scale[c] = static_cast<float>(std::min(kCount / keys.extent(c), max));
      }
  }
  bool none() const { return scale[0] == 0 && scale[1] == 0 && scale[2] == 0; }
  std::size_t bin(const BuildItem& item, std::size_t axis) const {
    return static_cast<std::size_t>(std::min((item.box.key(axis) - first[axis]) * scale[axis], kCount - 1.0f));
  }
};

/// Sets out[i] to the element at position begin + i of the list, with the box `gap` for a gap.
void make_items(const ElementList& list, const BoundsTable& vertices, Index begin, Index end, const BuildBox& gap,
                BuildItem* out);

/// The range of the keys of items along each axis, for at least one item.
BuildBox range_of_keys(std::span<const BuildItem> items);

/// Sets `contents` to the bins of these items.
void fill_bins(std::span<const BuildItem> items, const BuildBins& bins, BuildBins::Contents& contents);

}  // namespace volccd::detail
