// Colours that stay apart for colour-blind eyes and in grey print.
#pragma once

#include <cstddef>

#include <volccd/pictures/image.hpp>

namespace volccd {

/// Muted, of medium to high lightness, so that shading and marks show on them. Neighbours in the sequence differ in
/// lightness as well as in hue. Twelve, then lighter and darker variants of these.
Colour part_colour(std::size_t index);

/// Contacts between parts, and within one: dark, and of different shapes as well.
inline constexpr Colour kInterColour{200, 16, 46}, kIntraColour{24, 44, 120};

}  // namespace volccd
