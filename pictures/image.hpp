// A picture in memory, and PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace volccd {

/// An sRGB colour, as in an image file.
struct Colour {
  std::uint8_t r = 255, g = 255, b = 255;

  friend bool operator==(const Colour&, const Colour&) = default;
};

/// Linear interpolation from a (share 0) to b (share 1).
Colour mix(Colour a, Colour b, double share);

/// Rows from the top, three bytes for each pixel. Pixel (x, y) covers [x, x+1) x [y, y+1); coordinates inside pixels
/// are doubles in the same frame.
class Image {
 public:
  static constexpr int kMaxSide = 20000;
  static constexpr std::int64_t kMaxPixels = 100'000'000;

  /// Throws ConfigError unless 1 <= sides <= kMaxSide and there are at most kMaxPixels.
  Image(int width, int height, Colour fill = {});

  int width() const { return width_; }
  int height() const { return height_; }
  Colour at(int x, int y) const { return pixels_[offset(x, y)]; }
  void set(int x, int y, Colour colour) { pixels_[offset(x, y)] = colour; }
  /// Blends the colour into the pixel with weight `cover`, 0 to 1. Does nothing outside the image.
  void blend(int x, int y, Colour colour, double cover);
  void fill_rectangle(int x, int y, int width, int height, Colour colour);
  /// Copies `other` into this image, with its upper left corner at (x, y); parts outside are left out.
  void paste(const Image& other, int x, int y);

  std::span<const Colour> pixels() const { return pixels_; }
  friend bool operator==(const Image&, const Image&) = default;

 private:
  std::size_t offset(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }

  int width_, height_;
  std::vector<Colour> pixels_;
};

/// The bytes of a PNG file, with eight bits for each channel. The same image gives the same bytes.
std::string encode_png(const Image& image);

/// Writes a PNG file atomically: an existing file is replaced by a complete one or not changed. Throws InputError
/// naming the file.
void write_png(const Image& image, const std::string& file);

}  // namespace volccd
