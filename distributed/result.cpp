#include <volccd/distributed/result.hpp>

#include <algorithm>

#include <volccd/distributed/detail/bytes.hpp>

namespace volccd::distributed {

Bytes to_bytes(std::span<const RankContact> contacts) {
  Bytes bytes;
  for (const RankContact& contact : contacts) {
    detail::put(bytes, contact.kind);
    detail::put(bytes, contact.vertices);
    detail::put(bytes, contact.elements);
    detail::put(bytes, contact.objects);
    detail::put(bytes, contact.toi);
    detail::put_values(bytes, std::span<const double>(contact.normal.data(), 3));
    detail::put(bytes, contact.weights);
    detail::put_values(bytes, std::span<const double>(contact.point.data(), 3));
    detail::put(bytes, contact.at_start);
    detail::put(bytes, contact.gap);
  }
  return bytes;
}

std::vector<RankContact> contacts_of(const Bytes& bytes) {
  std::vector<RankContact> contacts;
  for (detail::Reader reader(bytes); !reader.at_end();) {
    RankContact& contact = contacts.emplace_back();
    contact.kind = reader.get<FeatureKind>();
    contact.vertices = reader.get<std::array<std::int64_t, 4>>();
    contact.elements = reader.get<std::array<std::int64_t, 2>>();
    contact.objects = reader.get<std::array<std::int32_t, 2>>();
    contact.toi = reader.get<double>();
    for (double& x : contact.normal) x = reader.get<double>();
    contact.weights = reader.get<std::array<double, 4>>();
    for (double& x : contact.point) x = reader.get<double>();
    contact.at_start = reader.get<bool>();
    contact.gap = reader.get<double>();
  }
  return contacts;
}

RankStatistics& RankStatistics::operator+=(const RankStatistics& other) {
  elements += other.elements;
  copies += other.copies;
  halo += other.halo;
  tests += other.tests;
  contacts += other.contacts;
  seconds += other.seconds;
  piece_seconds += other.piece_seconds;
  lists += other.lists;
  bytes_received += other.bytes_received;
  neighbours = std::max(neighbours, other.neighbours);
  return *this;
}

}  // namespace volccd::distributed
