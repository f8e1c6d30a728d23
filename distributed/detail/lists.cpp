#include <volccd/distributed/detail/lists.hpp>

#include <algorithm>
#include <compare>
#include <limits>
#include <utility>

#include <volccd/core/random.hpp>
#include <volccd/core/sort_unique.hpp>
#include <volccd/distributed/detail/bytes.hpp>
#include <volccd/pipelines/stage_clock.hpp>

namespace volccd::distributed::detail {

namespace {

/// How many elements stand for all when space is divided, because every rank sorts their centres: at most so many in
/// all, or of each rank.
constexpr std::size_t kAllSamples = std::size_t{1} << 15, kSamples = 512;

constexpr double kMax = std::numeric_limits<double>::max();

/// Finite, although a bound that a separation enlarges may be infinite.
Vec3 centre(const MotionBox& box) { return box.low.cwiseMax(-kMax) / 2 + box.high.cwiseMin(kMax) / 2; }

/// How much greater a box is on each side with a skin, the part `skin` of its longest side.
double skin_width(const MotionBox& box, double skin) {
  return skin == 0 ? 0 : std::min(kMax, skin * (box.high - box.low).maxCoeff());
}

/// The box that is greater by `width` on each side, and contains the box. Monotone, so that the box of an element with
/// a skin is the common box of its vertices' boxes with this skin.
MotionBox with_skin(const MotionBox& box, double width) {
  return width == 0 ? box : MotionBox{box.low.array() - width, box.high.array() + width};
}

/// The boxes inside a region.
MotionBox inside(const Region& region) {
  MotionBox box{region.low, region.high};
  for (int i = 0; i < 3; ++i) box.high[i] = std::nextafter(region.high[i], -std::numeric_limits<double>::infinity());
  return box;
}

bool contains(const MotionBox& outer, const MotionBox& box) {
  return (outer.low.array() <= box.low.array()).all() && (box.high.array() <= outer.high.array()).all();
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

/// A rank that asks for the elements at a vertex, which is given by its position in a list.
struct Question {
  Index vertex;
  int rank;

  friend auto operator<=>(const Question&, const Question&) = default;
};

std::span<const Question> about(const std::vector<Question>& sorted, Index vertex) {
  const auto begin = std::ranges::lower_bound(sorted, vertex, {}, &Question::vertex);
  return {begin, std::ranges::upper_bound(begin, sorted.end(), vertex, {}, &Question::vertex)};
}

/// Passes the questions of all ranks on to the ranks whose elements have the vertices. Returns those to this rank, with
/// positions of Home::used(), ascending.
std::vector<Question> ask(Exchange& exchange, const Home& home, std::span<const std::int64_t> ids,
                          std::span<const int> owners) {
  std::vector<Bytes> to_owners(static_cast<std::size_t>(exchange.size())), to_users(to_owners.size());
  for (std::size_t i = 0; i < ids.size(); ++i) put(to_owners[static_cast<std::size_t>(owners[i])], ids[i]);
  std::vector<Question> to_owner, to_user;
  for (const auto& [source, bytes] : send_to_ranks(exchange, std::move(to_owners)))
    for (const std::int64_t id : values_of<std::int64_t>(bytes)) to_owner.push_back({home.own().find(id), source});
  std::ranges::sort(to_owner);
  for (const auto& [vertex, user] : home.users())
    for (const Question& question : about(to_owner, vertex)) {
      Bytes& bytes = to_users[static_cast<std::size_t>(user)];
      put(bytes, home.vertices()[vertex]);
      put(bytes, question.rank);
    }
  for (const auto& [source, bytes] : send_to_ranks(exchange, std::move(to_users)))
    for (Reader reader(bytes); !reader.at_end();) {
      const auto at = std::ranges::lower_bound(home.used(), reader.get<std::int64_t>()) - home.used().begin();
      to_user.push_back({static_cast<Index>(at), reader.get<int>()});
    }
  std::ranges::sort(to_user);
  return to_user;
}

}  // namespace

Regions divide(Exchange& exchange, std::span<const MotionBox> boxes, const Regions& present,
               std::span<const double> density) {
  const std::size_t samples = std::max(kSamples, kAllSamples / static_cast<std::size_t>(exchange.size()));
  const std::size_t stride = std::max<std::size_t>(1, (boxes.size() + samples - 1) / samples);
  Random random(1);  // ids may have a pattern
  Bytes mine;
  for (std::size_t begin = 0; begin < boxes.size(); begin += stride) {
    const std::size_t count = std::min(stride, boxes.size() - begin);
    const Vec3 point = centre(boxes[begin + random.below(count)]);
    for (int axis = 0; axis < 3; ++axis) put(mine, point[axis]);
    // Elements that follow each other may be anywhere: those of the sample are taken to be where it is.
    put(mine,
        static_cast<double>(count) * (density.empty() ? 1 : density[static_cast<std::size_t>(present.at(point))]));
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

Targets::Targets(const Home& home, std::span<const MotionBox> boxes, double skin, const Regions& regions)
    : limits_(home.used().size(), inside({})) {
  const Elements& elements = home.elements();
  begins_.reserve(boxes.size() + 1);
  ranks_.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const double width = skin_width(boxes[i], skin);
    regions.meeting(with_skin(boxes[i], width), [&](int r) { ranks_.push_back(r); });
    begins_.push_back(ranks_.size());
    const std::span<const int> ranks = (*this)[i];
    for (std::size_t k = elements.offsets[i]; k < elements.offsets[i + 1]; ++k) {
      const MotionBox limit =
          ranks.size() == 1 ? inside(regions.region(ranks[0])) : with_skin(home.corner_box(k), width);
      MotionBox& limits = limits_[home.corner(k)];
      limits = {limits.low.cwiseMax(limit.low), limits.high.cwiseMin(limit.high)};
    }
  }
}

bool Targets::within_limits(const Home& home) const {
  const std::vector<MotionBox>& boxes = home.vertex_boxes();
  for (std::size_t v = 0; v < boxes.size(); ++v)
    if (!contains(limits_[v], boxes[v])) return false;
  return true;
}

bool Targets::cover(const Home& home, const Regions& regions) const {
  if (within_limits(home)) return true;
  bool covered = true;
  for (std::size_t i = 0; covered && i < size(); ++i) {
    const std::span<const int> ranks = (*this)[i];
    const MotionBox box = home.element_box(i);
    if (regions.region(ranks[0]).contains(box)) continue;
    regions.meeting(box, [&](int r) { covered = covered && std::ranges::find(ranks, r) != ranks.end(); });
  }
  return covered;
}

bool Targets::too_many(const Home& home, double skin, const Regions& regions) const {
  std::size_t present = 0, needed = 0;
  for (std::size_t i = 0; i < size(); i += 1 + size() / 256) {
    present += (*this)[i].size();
    const MotionBox box = home.element_box(i);
    regions.meeting(with_skin(box, skin_width(box, skin)), [&](int) { ++needed; });
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
                    [&](std::size_t k) { return regions.region(r).meets(home.corner_box(k)); });
    }
  }
  return exchange_elements(exchange, std::move(by_rank), seconds);
}

ReceivedElements elements_at(Exchange& exchange, const Home& home, std::span<const std::int64_t> ids,
                             std::span<const int> owners, double& seconds) {
  const std::vector<Question> questions = ask(exchange, home, ids, owners);
  std::vector<Bytes> by_rank(static_cast<std::size_t>(exchange.size()));
  {
    StageClock clock;
    const StageTimer timer(clock, seconds);
    const Elements& elements = home.elements();
    std::vector<int> askers;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      askers.clear();
      for (std::size_t k = elements.offsets[i]; k < elements.offsets[i + 1]; ++k)
        for (const Question& question : about(questions, home.corner(k))) askers.push_back(question.rank);
      sort_unique(askers);
      for (const int r : askers)
        put_element(by_rank[static_cast<std::size_t>(r)], home, i, false, [](std::size_t) { return false; });
    }
  }
  return exchange_elements(exchange, std::move(by_rank), seconds);
}

}  // namespace volccd::distributed::detail
