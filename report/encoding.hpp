// Encoding of numbers in a script that a browser loads from disk: byte planes, deflate, base64.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace volccd {

/// Maps a signed difference to an unsigned number that is small if the difference is small: 0, -1, 1, -2, ... become
/// 0, 1, 2, 3, ...
constexpr std::uint32_t zigzag(std::int32_t value) {
  return (static_cast<std::uint32_t>(value) << 1) ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t unzigzag(std::uint32_t code) {
  return static_cast<std::int32_t>(code >> 1) ^ -static_cast<std::int32_t>(code & 1);
}

/// Appends the lowest `bytes` bytes (1 to 4) of all values: first the lowest byte of each value, then the next byte of
/// each value, and so on. Deflate compresses such planes better than whole numbers.
void append_planes(std::string& out, std::span<const std::uint32_t> values, int bytes);

/// The coding of a sequence of frames: [frame][value]. Each value is predicted by the value before it in its frame
/// (order 0), by the same value one frame earlier (order 1), or on a straight line through two frames (order 2:
/// 2 v1 - v2), modulo 2^16. The order with the smallest sum of differences is chosen for each frame. The zigzag codes
/// of the differences are written by append_planes() as two bytes each. `orders` gets the order of each frame. All
/// frames have one size.
void append_frames(std::string& out, std::span<const std::vector<std::uint16_t>> frames, std::vector<int>& orders);

/// A zlib stream (RFC 1950), which browsers read as "deflate". Throws std::bad_alloc.
std::string deflated(std::string_view bytes);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace volccd
