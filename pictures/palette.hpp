// Colours that colour-blind readers can distinguish, also in grey print.
#pragma once

#include <cstddef>

#include <volccd/pictures/image.hpp>

namespace volccd {

/// Muted colours of medium to high lightness, so that shading and marks are visible on them. Neighbours in the sequence
/// differ in lightness as well as in hue. The first twelve are followed by lighter and darker variants of them.
Colour object_colour(std::size_t index);

/// Colours of marks of contacts between objects and within an object: dark; the marks also differ in shape.
inline constexpr Colour kInterColour{200, 16, 46}, kIntraColour{24, 44, 120};
inline constexpr Colour kTextColour{30, 32, 38};

}  // namespace volccd
