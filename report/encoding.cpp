#include <volccd/report/encoding.hpp>

#include <algorithm>
#include <cstdlib>
#include <new>

#include <zlib.h>

namespace volccd {

namespace {

/// The difference between `value` and its prediction of this order, as a signed number of 16 bits.
std::int32_t residual(std::span<const std::vector<std::uint16_t>> frames, std::size_t f, std::size_t i, int order) {
  std::int32_t prediction = 0;
  if (order == 0) prediction = i >= 1 ? frames[f][i - 1] : 0;
  if (order == 1) prediction = frames[f - 1][i];
  if (order == 2) prediction = 2 * frames[f - 1][i] - frames[f - 2][i];
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(frames[f][i] - prediction));
}

int best_order(std::span<const std::vector<std::uint16_t>> frames, std::size_t f) {
  int best = 0;
  std::uint64_t min = ~std::uint64_t{0};
  for (int order = 0; order <= static_cast<int>(std::min<std::size_t>(f, 2)); ++order) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < frames[f].size(); ++i)
      sum += static_cast<std::uint64_t>(std::abs(residual(frames, f, i, order)));
    if (sum >= min) continue;
    min = sum;
    best = order;
  }
  return best;
}

}  // namespace

void append_planes(std::string& out, std::span<const std::uint32_t> values, int bytes) {
  for (int plane = 0; plane < bytes; ++plane)
    for (const std::uint32_t value : values) out += static_cast<char>(value >> (8 * plane) & 0xff);
}

void append_frames(std::string& out, std::span<const std::vector<std::uint16_t>> frames, std::vector<int>& orders) {
  orders.clear();
  std::vector<std::uint32_t> codes;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    orders.push_back(best_order(frames, f));
    codes.clear();
    for (std::size_t i = 0; i < frames[f].size(); ++i)
      codes.push_back(zigzag(residual(frames, f, i, orders.back())) & 0xffff);
    append_planes(out, codes, 2);
  }
}

std::string deflated(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), 6) != Z_OK)
    throw std::bad_alloc();
  out.resize(size);
  return out;
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace volccd
