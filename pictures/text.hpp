// Text in pictures, in a built-in font of strokes: any size, no font files.
#pragma once

#include <string>
#include <string_view>

#include <volccd/pictures/image.hpp>

namespace volccd {

/// Width of the text in pixels, with capitals `height` pixels high. ASCII; anything else is drawn as a box.
double text_width(std::string_view text, double height);

/// Left end of the base line at (x, y). Capitals reach up to y - height; a p goes down to y + height / 3.
void draw_text(Image& image, std::string_view text, double x, double y, double height, Colour colour);

/// As much of the text as is no wider than `width`, with dots at the end if something is left out.
std::string fit_text(std::string_view text, double height, double width);

}  // namespace volccd
