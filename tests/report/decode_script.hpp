// Reads the scripts of a report as its page does.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>
#include <nlohmann/json.hpp>

#include <volccd/report/encoding.hpp>
#include <volccd/report/surface_track.hpp>

namespace volccd::test {

inline std::string decoded_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    group = group << 6 | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) {
      bits -= 8;
      bytes += static_cast<char>(group >> bits & 0xff);
    }
  }
  return bytes;
}

inline std::string inflated(const std::string& bytes, std::size_t size) {
  std::string out(size, '\0');
  uLongf length = size;
  EXPECT_EQ(Z_OK, uncompress(reinterpret_cast<Bytef*>(out.data()), &length,
                             reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size())));
  out.resize(length);
  return out;
}

/// Reads what append_planes() wrote, as the page does.
class Planes {
 public:
  explicit Planes(std::string bytes) : bytes_(std::move(bytes)) {}
  std::vector<std::uint32_t> take(std::size_t count, int width) {
    std::vector<std::uint32_t> values(count);
    for (int plane = 0; plane < width; ++plane)
      for (std::uint32_t& value : values)
        value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes_.at(at_++))) << (8 * plane);
    return values;
  }
  std::string text(std::size_t size) {
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  std::vector<std::vector<std::uint16_t>> frames(const std::vector<int>& orders, std::size_t size) {
    std::vector<std::vector<std::uint16_t>> frames;
    for (std::size_t f = 0; f < orders.size(); ++f) {
      const std::vector<std::uint32_t> codes = take(size, 2);
      std::vector<std::uint16_t> frame(size);
      for (std::size_t i = 0; i < size; ++i) {
        const int prediction = orders[f] == 0   ? (i > 0 ? frame[i - 1] : 0)
                               : orders[f] == 1 ? frames[f - 1][i]
                                                : 2 * frames[f - 1][i] - frames[f - 2][i];
        frame[i] = static_cast<std::uint16_t>(prediction + unzigzag(codes[i]));
      }
      frames.push_back(std::move(frame));
    }
    return frames;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

/// The contents of a script.
struct Decoded {
  nlohmann::json header;
  std::vector<TrackedTriangle> triangles;
  std::vector<std::set<std::uint32_t>> shown;
  std::vector<std::vector<std::uint16_t>> frames;
  std::vector<std::uint32_t> marks[4], flags;
  std::vector<std::uint32_t> pair_columns[6], pair_kinds;

  /// The distance between neighbouring quantized positions of centroids.
  double pair_unit() const {
    return header.at("box").at("scale").get<double>() / ((1 << header.at("pair_bits").get<int>()) - 1);
  }
  Vec3 pair_end(std::size_t i, bool second) const {
    const double unit = pair_unit();
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) {
      std::int32_t value = static_cast<std::int32_t>(pair_columns[axis][i]);
      if (second) value += unzigzag(pair_columns[3 + axis][i]);
      p[axis] = header.at("box").at("low")[axis].get<double>() + unit * value;
    }
    return p;
  }

  Vec3 place(std::size_t frame, std::size_t vertex) const {
    const double unit = header.at("box").at("scale").get<double>() / ((1 << header.at("bits").get<int>()) - 1);
    const std::size_t n = header.at("vertices").get<std::size_t>();
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = header.at("box").at("low")[axis].get<double>() + unit * frames[frame][axis * n + vertex];
    return p;
  }
};

inline Decoded decode(const std::string& script) {
  Decoded d;
  const std::size_t begin = script.find(", \"") + 3;
  Planes in(inflated(decoded_base64(script.substr(begin, script.size() - begin - 4)), 200'000'000));
  d.header = nlohmann::json::parse(in.text(in.take(1, 4)[0]));
  const auto count = [&](const char* key) { return d.header.at(key).get<std::size_t>(); };
  std::vector<std::uint32_t> columns[3];
  for (auto& column : columns) column = in.take(count("triangles"), 4);
  const auto parts = in.take(count("triangles"), 2), edges = in.take(count("triangles"), 1);
  Index first = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    first += static_cast<Index>(unzigzag(columns[0][i]));
    d.triangles.push_back({{first, first + static_cast<Index>(unzigzag(columns[1][i])),
                            first + static_cast<Index>(unzigzag(columns[2][i]))},
                           static_cast<std::uint16_t>(parts[i]),
                           static_cast<std::uint8_t>(edges[i])});
  }
  const auto deltas = in.take(count("changes"), 4);
  std::size_t at = 0;
  std::vector<int> orders;
  std::set<std::uint32_t> now;
  for (const nlohmann::json& frame : d.header.at("frames")) {
    orders.push_back(frame.at("order").get<int>());
    std::uint32_t i = 0;
    for (int k = frame.at("added").get<int>(); k > 0; --k) EXPECT_TRUE(now.insert(i += deltas.at(at++)).second);
    i = 0;
    for (int k = frame.at("removed").get<int>(); k > 0; --k) EXPECT_EQ(1u, now.erase(i += deltas.at(at++)));
    d.shown.push_back(now);
  }
  d.frames = in.frames(orders, 3 * count("vertices"));
  for (auto& column : d.marks) column = in.take(count("marks"), 2);
  d.flags = in.take(count("marks"), 1);
  for (auto& column : d.pair_columns) column = in.take(count("pairs"), 2);
  d.pair_kinds = in.take(count("pairs"), 1);
  EXPECT_TRUE(in.at_end());
  return d;
}

}  // namespace volccd::test
