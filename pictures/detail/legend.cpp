#include <volccd/pictures/detail/legend.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <volccd/pictures/palette.hpp>
#include <volccd/pictures/text.hpp>

namespace volccd::detail {

Legend::Legend(std::vector<LegendEntry> entries, int width, double text_height) : text_height_(text_height) {
  const double h = text_height, gap = 1.6 * h;
  const auto width_of = [&](const LegendEntry& entry) { return gap + 1.9 * h + text_width(entry.text, 0.86 * h); };
  for (std::size_t begin = 0, row = 0; begin < entries.size(); ++row) {
    double row_width = -gap;
    std::size_t end = begin;
    for (; end < entries.size(); ++end) {
      const double more = width_of(entries[end]);
      if (end > begin && row_width + more > width - 2 * h) break;
      row_width += more;
    }
    double x = std::max(h, (width - row_width) / 2);
    for (; begin < end; ++begin) {
      const double next = x + width_of(entries[begin]);
      placed_.push_back({std::move(entries[begin]), x, static_cast<int>(row)});
      x = next;
    }
  }
  std::size_t hidden = 0;
  for (; !placed_.empty() && placed_.back().row >= kMaxRows; ++hidden) placed_.pop_back();
  if (hidden > 0) placed_.back().entry = {.text = fmt::format("and {} more", hidden + 1)};
}

int Legend::height() const {
  return placed_.empty() ? 0 : static_cast<int>(std::lround(text_height_ * (1.0 + 2.1 * (placed_.back().row + 1))));
}

void Legend::draw(Image& image, int top) const {
  const double h = text_height_;
  for (const auto& [entry, x, row] : placed_) {
    const double base = top + h * (1.5 + 2.1 * row);
    if (entry.mark) {
      draw_mark(image, x + 0.6 * h, base - 0.45 * h, 0.42 * h, *entry.mark, *entry.colour);
    } else if (entry.colour) {
      const int side = static_cast<int>(std::lround(1.2 * h)), left = static_cast<int>(x),
                y = static_cast<int>(base - 1.05 * h);
      image.fill_rectangle(left, y, side, side, mix(*entry.colour, kTextColour, 0.55));
      image.fill_rectangle(left + 1, y + 1, side - 2, side - 2, *entry.colour);
    }
    draw_text(image, entry.text, x + (entry.colour ? 1.9 * h : 0), base, 0.86 * h, kTextColour);
  }
}

}  // namespace volccd::detail
