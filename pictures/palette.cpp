#include <volccd/pictures/palette.hpp>

#include <array>

namespace volccd {

Colour object_colour(std::size_t index) {
  static constexpr std::array<Colour, 12> kColours = {{{232, 158, 82},
                                                       {126, 172, 206},
                                                       {102, 158, 118},
                                                       {238, 222, 150},
                                                       {178, 134, 176},
                                                       {196, 204, 212},
                                                       {88, 118, 164},
                                                       {206, 128, 112},
                                                       {158, 212, 190},
                                                       {158, 138, 108},
                                                       {224, 184, 196},
                                                       {134, 122, 184}}};
  const Colour base = kColours[index % kColours.size()];
  const std::size_t round = index / kColours.size() % 4;
  if (round == 0) return base;
  return round % 2 == 1 ? mix(base, {255, 255, 255}, 0.35) : mix(base, {40, 40, 48}, 0.14 * static_cast<double>(round));
}

}  // namespace volccd
