#include <volccd/pictures/text.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

#include <cairo.h>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

/// Number of bytes of the character that begins at `at`; 0 if there is none.
std::size_t character_size(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at);
  const std::size_t size = first < 0x80                    ? 1
                           : first >= 0xC2 && first < 0xE0 ? 2
                           : first >= 0xE0 && first < 0xF0 ? 3
                           : first >= 0xF0 && first < 0xF5 ? 4
                                                           : 0;
  for (std::size_t i = 1; i < size; ++i)
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  // Overlong forms, surrogates and values beyond Unicode are invalid UTF-8.
  const unsigned second = byte(at + 1);
  if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) || (first == 0xF0 && second < 0x90) ||
      (first == 0xF4 && second >= 0x90))
    return 0;
  return size;
}

/// Cairo refuses invalid UTF-8, and ends a text at a zero byte.
std::string printable(std::string_view text) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t size = character_size(text, at);
    if (size == 0 || text[at] == '\0')
      result += '?';
    else
      result.append(text, at, size);
    at += std::max<std::size_t>(size, 1);
  }
  return result;
}

/// A surface of 8-bit coverage, and a context with a font whose capitals are `height` pixels high.
class Canvas {
 public:
  Canvas(int width, int height, double capitals)
      : surface_(cairo_image_surface_create(CAIRO_FORMAT_A8, width, height), &cairo_surface_destroy),
        context_(cairo_create(surface_.get()), &cairo_destroy) {
    // Hinting is off, so that widths are proportional to the size.
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_set_font_options(context_.get(), options);
    cairo_font_options_destroy(options);
    cairo_select_font_face(context_.get(), "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context_.get(), 100);
    cairo_text_extents_t capital;
    cairo_text_extents(context_.get(), "H", &capital);
    if (!(capital.height > 0)) throw ConfigError("no font for pictures: install one (Debian: fonts-dejavu-core)");
    cairo_set_font_size(context_.get(), 100 * capitals / capital.height);
  }

  cairo_text_extents_t extents(const std::string& text) const {
    cairo_text_extents_t extents;
    cairo_text_extents(context_.get(), text.c_str(), &extents);
    return extents;
  }

  /// Draws the text, and calls visit(column, row, coverage) for each pixel, with a coverage of 0 to 1.
  template <class Visit>
  void draw(const std::string& text, double x, double y, const Visit& visit) {
    cairo_move_to(context_.get(), x, y);
    cairo_show_text(context_.get(), text.c_str());
    cairo_surface_flush(surface_.get());
    const unsigned char* const data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    for (int row = 0; row < cairo_image_surface_get_height(surface_.get()); ++row)
      for (int column = 0; column < cairo_image_surface_get_width(surface_.get()); ++column)
        if (const unsigned char cover = data[row * stride + column]; cover != 0) visit(column, row, cover / 255.0);
  }

 private:
  Surface surface_;
  Context context_;
};

}  // namespace

double text_width(std::string_view text, double height) {
  return Canvas(1, 1, height).extents(printable(text)).x_advance;
}

void draw_text(Image& image, std::string_view text, double x, double y, double height, Colour colour) {
  const std::string line = printable(text);
  const cairo_text_extents_t extents = Canvas(1, 1, height).extents(line);
  const int left = static_cast<int>(std::floor(x + extents.x_bearing)) - 2;
  const int top = static_cast<int>(std::floor(y + extents.y_bearing)) - 2;
  const int width = std::min(static_cast<int>(std::ceil(extents.width)) + 5, image.width() - left);
  const int rows = static_cast<int>(std::ceil(extents.height)) + 5;
  if (width <= 0) return;
  Canvas(width, rows, height).draw(line, x - left, y - top, [&](int column, int row, double cover) {
    image.blend(left + column, top + row, colour, cover);
  });
}

std::vector<std::string> wrap_text(std::string_view text, double height, double width) {
  const Canvas canvas(1, 1, height);
  const auto fits = [&](const std::string& line) { return canvas.extents(line).x_advance <= width; };
  std::vector<std::string> lines(1);
  const std::string all = printable(text);
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find(' ', at), all.size());
    std::string word = all.substr(at, end - at);
    at = end + 1;
    if (const std::string longer = lines.back().empty() ? word : lines.back() + ' ' + word; fits(longer)) {
      lines.back() = longer;
      continue;
    }
    if (!lines.back().empty()) lines.emplace_back();
    for (std::size_t c = 0; c < word.size();) {
      const std::string character = word.substr(c, character_size(word, c));
      if (!lines.back().empty() && !fits(lines.back() + character)) lines.emplace_back();
      lines.back() += character;
      c += character.size();
    }
  }
  return lines;
}

}  // namespace volccd
