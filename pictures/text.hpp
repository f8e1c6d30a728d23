// Text in pictures: Cairo draws it, in the font that fontconfig has for DejaVu Sans.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <volccd/pictures/image.hpp>

namespace volccd {

/// Advance width of the text (UTF-8) in pixels, with capitals `height` pixels high. Bytes that are not UTF-8 count as
/// question marks.
double text_width(std::string_view text, double height);

/// Draws the text with the left end of its base line at (x, y). Capitals reach up to y - height, descenders down to
/// about y + height / 3. Parts outside the image are left out.
void draw_text(Image& image, std::string_view text, double x, double y, double height, Colour colour);

/// The text in lines that are no wider than `width`, broken at blanks; a word that is wider than that is broken
/// anywhere. An empty text has one empty line.
std::vector<std::string> wrap_text(std::string_view text, double height, double width);

}  // namespace volccd
