#include <volccd/pictures/image.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <png.h>

#include <volccd/core/error.hpp>
#include <volccd/io/output_file.hpp>

namespace volccd {

Colour mix(Colour a, Colour b, double share) {
  const auto channel = [&](std::uint8_t x, std::uint8_t y) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(x + (y - x) * share), 0L, 255L));
  };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

Image::Image(int width, int height, Colour fill) : width_(width), height_(height) {
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide || std::int64_t{width} * height > kMaxPixels)
    throw ConfigError(fmt::format("a picture of {} x {} pixels: sides are 1 to {}, and at most {} pixels in all", width,
                                  height, kMaxSide, kMaxPixels));
  pixels_.assign(static_cast<std::size_t>(width) * height, fill);
}

void Image::blend(int x, int y, Colour colour, double cover) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_ || cover <= 0) return;
  set(x, y, mix(at(x, y), colour, std::min(cover, 1.0)));
}

void Image::fill_rectangle(int x, int y, int width, int height, Colour colour) {
  for (int row = std::max(y, 0); row < std::min(y + height, height_); ++row)
    for (int column = std::max(x, 0); column < std::min(x + width, width_); ++column) set(column, row, colour);
}

void Image::paste(const Image& other, int x, int y) {
  for (int row = std::max(0, -y); row < std::min(other.height_, height_ - y); ++row)
    for (int column = std::max(0, -x); column < std::min(other.width_, width_ - x); ++column)
      set(x + column, y + row, other.at(column, row));
}

std::string encode_png(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width());
  header.height = static_cast<png_uint_32>(image.height());
  header.format = PNG_FORMAT_RGB;
  static_assert(sizeof(Colour) == 3);
  // With this bound, libpng can fail only if there is not enough memory.
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(header), '\0');
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels().data(), 0, nullptr))
    throw Error(fmt::format("PNG cannot be made: {}", header.message));
  bytes.resize(size);
  return bytes;
}

void write_png(const Image& image, const std::string& file) { write_text_file(file, encode_png(image)); }

}  // namespace volccd
