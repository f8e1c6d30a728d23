// The legend below a picture.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <volccd/pictures/image.hpp>
#include <volccd/pictures/renderer.hpp>

namespace volccd::detail {

/// A swatch of the colour or, if it has a shape, a mark.
struct LegendEntry {
  std::string text;
  std::optional<Colour> colour = {};
  std::optional<MarkShape> mark = {};
};

/// Entries in centred rows, from left to right. At most kMaxRows rows are drawn, and the remaining entries are counted.
class Legend {
 public:
  static constexpr int kMaxRows = 4;

  Legend() = default;
  /// `width`: of the picture, in pixels; `text_height`: of capitals.
  Legend(std::vector<LegendEntry> entries, int width, double text_height);

  /// In pixels; 0 without entries.
  int height() const;
  /// `top`: of the legend in the image.
  void draw(Image& image, int top) const;

 private:
  struct Placed {
    LegendEntry entry;
    double x = 0;
    int row = 0;
  };

  std::vector<Placed> placed_;
  double text_height_ = 0;
};

}  // namespace volccd::detail
