#include <volccd/distributed/detail/lists.hpp>

#include <algorithm>
#include <compare>
#include <limits>
#include <utility>

#include <volccd/core/sort_unique.hpp>
#include <volccd/distributed/detail/bytes.hpp>
#include <volccd/pipelines/stage_clock.hpp>

namespace volccd::distributed::detail {

namespace {

/// Centres that each rank gives, at most, to divide space: every rank sorts those of all.
constexpr std::size_t kSamples = 512;

constexpr double kMax = std::numeric_limits<double>::max();

/// Finite, although a bound that a separation enlarges may be infinite.
Vec3 centre(const MotionBox& box) { return box.low.cwiseMax(-kMax) / 2 + box.high.cwiseMin(kMax) / 2; }

/// The box that is greater by the part `skin` of its longest side on each side. Contains the box.
MotionBox with_skin(const MotionBox& box, double skin) {
  if (skin == 0) return box;
  const double width = std::min(kMax, skin * (box.high - box.low).maxCoeff());
  return {box.low.array() - width, box.high.array() + width};
}

/// Appends an element to a message. is_complete(k): whether the receiver has all elements at elements.vertices[k].
template <class IsComplete>
void put_element(Bytes& bytes, const Home& home, std::size_t i, bool copy, IsComplete&& is_complete) {
  const Elements& elements = home.elements();
  const auto vertices = elements.vertices_of(i), faces = elements.faces_of(i);
  put(bytes, elements.types[i]);
  put(bytes, copy);
  put(bytes, elements.objects[i]);
  put(bytes, elements.ids[i]);
  put(bytes, static_cast<std::uint32_t>(vertices.size()));
  put(bytes, static_cast<std::uint32_t>(faces.size()));
  put_values(bytes, vertices);
  for (std::size_t k = elements.offsets[i]; k < elements.offsets[i + 1]; ++k) put(bytes, home.owner(k));
  for (std::size_t k = elements.offsets[i]; k < elements.offsets[i + 1]; ++k)
    put(bytes, static_cast<std::uint8_t>(is_complete(k) ? 1 : 0));
  put_values(bytes, faces);
}

void get_element(Reader& reader, ReceivedElements& result) {
  Elements& elements = result.elements;
  elements.types.push_back(reader.get<ElementType>());
  result.copies += reader.get<bool>() ? 1u : 0u;
  elements.objects.push_back(reader.get<std::int32_t>());
  elements.ids.push_back(reader.get<std::int64_t>());
  const auto vertices = reader.get<std::uint32_t>(), faces = reader.get<std::uint32_t>();
  reader.append(vertices, elements.vertices);
  reader.append(vertices, result.owners);
  reader.append(vertices, result.complete);
  reader.append(faces, elements.faces);
  elements.offsets.push_back(elements.vertices.size());
  elements.face_offsets.push_back(elements.faces.size());
}

/// Sends the elements in by_rank[r], as put_element() wrote them, to rank r.
ReceivedElements exchange_elements(Exchange& exchange, std::vector<Bytes> by_rank, double& seconds) {
  const std::vector<Received> received = send_to_ranks(exchange, std::move(by_rank));
  StageClock clock;
  const StageTimer timer(clock, seconds);
  ReceivedElements result;
  for (const auto& [source, bytes] : received) {
    for (Reader reader(bytes); !reader.at_end();) get_element(reader, result);
    if (source != exchange.rank()) result.bytes += bytes.size();
  }
  return result;
}

/// A vertex, by its position in a list or its id, and a rank that asks for its elements.
template <class T>
struct Asked {
  T vertex;
  int rank;

  friend auto operator<=>(const Asked&, const Asked&) = default;
};

/// Passes the questions of all ranks on to the ranks whose elements have the vertices. Returns those to this rank, with
/// positions of Home::used().
std::vector<Asked<Index>> ask(Exchange& exchange, const Home& home, std::span<const std::int64_t> ids,
                              std::span<const int> owners) {
  std::vector<Bytes> to_owners(static_cast<std::size_t>(exchange.size())), to_users(to_owners.size());
  for (std::size_t i = 0; i < ids.size(); ++i) put(to_owners[static_cast<std::size_t>(owners[i])], ids[i]);
  std::vector<Asked<Index>> questions;  // with positions in home.vertices()
  for (const auto& [source, bytes] : send_to_ranks(exchange, std::move(to_owners)))
    for (const std::int64_t id : values_of<std::int64_t>(bytes)) questions.push_back({home.own().find(id), source});
  std::ranges::sort(questions);
  for (const auto& [vertex, user] : home.users()) {
    const auto [begin, end] = std::ranges::equal_range(questions, vertex, {}, &Asked<Index>::vertex);
    for (auto at = begin; at != end; ++at)
      put(to_users[static_cast<std::size_t>(user)], Asked<std::int64_t>{home.vertices()[vertex], at->rank});
  }
  questions.clear();
  for (const auto& [source, bytes] : send_to_ranks(exchange, std::move(to_users)))
    for (const auto& [id, rank] : values_of<Asked<std::int64_t>>(bytes))
      questions.push_back({static_cast<Index>(std::ranges::lower_bound(home.used(), id) - home.used().begin()), rank});
  std::ranges::sort(questions);
  return questions;
}

}  // namespace

Regions divide(Exchange& exchange, std::span<const MotionBox> boxes, const Regions& present,
               std::span<const double> density) {
  const std::size_t stride = std::max<std::size_t>(1, (boxes.size() + kSamples - 1) / kSamples);
  Bytes mine;
  for (std::size_t begin = 0; begin < boxes.size(); begin += stride) {
    double weight = 0;
    for (std::size_t i = begin; i < std::min(begin + stride, boxes.size()); ++i)
      weight += density.empty() ? 1 : density[static_cast<std::size_t>(present.at(centre(boxes[i])))];
    const Vec3 point = centre(boxes[begin + (std::min(begin + stride, boxes.size()) - begin) / 2]);
    for (int axis = 0; axis < 3; ++axis) put(mine, point[axis]);
    put(mine, weight);
  }
  std::vector<Vec3> points;
  std::vector<double> weights;
  for (const Bytes& bytes : exchange.allgather(std::move(mine)))
    for (Reader reader(bytes); !reader.at_end();) {
      Vec3& point = points.emplace_back();
      for (double& x : point) x = reader.get<double>();
      weights.push_back(reader.get<double>());
    }
  return Regions(points, weights, exchange.size());
}

Targets::Targets(std::span<const MotionBox> boxes, double skin, const Regions& regions) {
  begins_.reserve(boxes.size() + 1);
  ranks_.reserve(boxes.size());
  for (const MotionBox& box : boxes) {
    regions.meeting(with_skin(box, skin), [&](int r) { ranks_.push_back(r); });
    begins_.push_back(ranks_.size());
  }
}

bool Targets::cover(std::span<const MotionBox> boxes, const Regions& regions) const {
  bool covered = true;
  for (std::size_t i = 0; covered && i < boxes.size(); ++i) {
    const std::span<const int> ranks = (*this)[i];
    if (regions.region(ranks[0]).contains(boxes[i])) continue;
    regions.meeting(boxes[i], [&](int r) { covered = covered && std::ranges::find(ranks, r) != ranks.end(); });
  }
  return covered;
}

bool Targets::too_many(std::span<const MotionBox> boxes, double skin, const Regions& regions) const {
  std::size_t present = 0, needed = 0;
  for (std::size_t i = 0; i < boxes.size(); i += 1 + boxes.size() / 1024) {
    present += (*this)[i].size();
    regions.meeting(with_skin(boxes[i], skin), [&](int) { ++needed; });
  }
  return present > needed + needed / 4;
}

ReceivedElements distribute(Exchange& exchange, const Home& home, std::span<const MotionBox> boxes,
                            const Targets& targets, const Regions& regions, double& seconds) {
  std::vector<Bytes> by_rank(static_cast<std::size_t>(exchange.size()));
  {
    StageClock clock;
    const StageTimer timer(clock, seconds);
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const int rank_of_centre = regions.at(centre(boxes[i]));
      for (const int r : targets[i])
        put_element(by_rank[static_cast<std::size_t>(r)], home, i, r != rank_of_centre,
                    [&](std::size_t k) { return regions.region(r).meets(home.box(k)); });
    }
  }
  return exchange_elements(exchange, std::move(by_rank), seconds);
}

ReceivedElements elements_at(Exchange& exchange, const Home& home, std::span<const std::int64_t> ids,
                             std::span<const int> owners, double& seconds) {
  const std::vector<Asked<Index>> questions = ask(exchange, home, ids, owners);
  std::vector<Bytes> by_rank(static_cast<std::size_t>(exchange.size()));
  {
    StageClock clock;
    const StageTimer timer(clock, seconds);
    const Elements& elements = home.elements();
    std::vector<int> askers;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      askers.clear();
      for (std::size_t k = elements.offsets[i]; k < elements.offsets[i + 1]; ++k)
        for (const auto& asked : std::ranges::equal_range(questions, home.corner(k), {}, &Asked<Index>::vertex))
          askers.push_back(asked.rank);
      sort_unique(askers);
      for (const int r : askers)
        put_element(by_rank[static_cast<std::size_t>(r)], home, i, false, [](std::size_t) { return false; });
    }
  }
  return exchange_elements(exchange, std::move(by_rank), seconds);
}

}  // namespace volccd::distributed::detail
